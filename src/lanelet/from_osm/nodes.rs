//! Nodes become points: coordinates by the projector or by `local_x` and `local_y`, heights from `ele`.

use crate::diagnostic::Subject;
use crate::geometry::{Point as PlanePoint, Vector};
use crate::lanelet::{Attributes, Condition, LoadFault, Point, PointId, heights_by_other_names};
use crate::osm::{ElementKind, Node, OsmData, Text};
use crate::projection::{LonLat, MgrsGrid, Projector};

use super::Loader;
use crate::lanelet::inferred_projector::{FARTHEST, written_metres};

/// `local_x` and `local_y` have four decimals at best and come from editors with projections of their own; what is
/// farther from latitude and longitude than this (metres) is another place.
const LOCAL_TOLERANCE: f64 = 0.05;

/// How Lanelet2's own writer names itself.
const LANELET2: &str = "lanelet2";
/// Heights up to this (m) are near 0.
const NEAR_ZERO: f64 = 1.0;
/// From a node at 0 a bound rises by no more than this (m), and
const LEAST_STEP: f64 = 0.1;
/// this many metres for each of its own.
const STEEPEST: f64 = 0.15;

/// The value of a tag that should be a number.
enum Number {
    Absent,
    Is(f64),
    Bad,
}

fn number(node: &Node, key: &str) -> Number {
    // Lanelet2 1.2.3 takes the last value of a key that repeats, but the first ele of a node.
    let said = if key == "ele" { node.tags.first(key) } else { node.tags.get(key) };
    match said {
        None => Number::Absent,
        Some(text) => match text.trim().parse::<f64>() {
            Ok(value) if value.abs() <= FARTHEST => Number::Is(value),
            _ => Number::Bad,
        },
    }
}

impl Number {
    fn value(&self) -> Option<f64> {
        match self {
            Self::Is(value) => Some(*value),
            _ => None,
        }
    }
}

/// Where nodes lie in the plane, as the loader sees it.
pub fn positions(nodes: &[Node], projector: &Projector) -> Vec<PlanePoint> {
    if *projector == Projector::Local {
        let local = |node: &Node, key| number(node, key).value().unwrap_or(0.0);
        return nodes.iter().map(|node| PlanePoint::new(local(node, "local_x"), local(node, "local_y"))).collect();
    }
    let heights = heights(nodes, projector);
    let projected = projector.forward_each(&places(nodes), |i| heights.get(i).copied().unwrap_or(0.0));
    projected.into_iter().map(Option::unwrap_or_default).collect()
}

fn places(nodes: &[Node]) -> Vec<LonLat> {
    nodes.iter().map(|node| node.position.unwrap_or_default()).collect()
}

/// Only the projection to a tangent plane depends on heights.
fn heights(nodes: &[Node], projector: &Projector) -> Vec<f64> {
    match projector {
        Projector::LocalCartesian { .. } => nodes.iter().map(|n| number(n, "ele").value().unwrap_or(0.0)).collect(),
        _ => Vec::new(),
    }
}

/// The positions of the nodes in the order in which ways run through them, then of the others; of nodes with the same id only
/// that of the last. So the points of a line are close together in memory.
fn along_ways(osm: &OsmData) -> Vec<u32> {
    let mut waiting = vec![true; osm.nodes.len()];
    let on_ways = osm.ways.iter().flat_map(|way| &way.nodes).filter_map(|&id| osm.node_position(id));
    let others = osm.nodes.iter().enumerate().map(|(at, node)| osm.node_position(node.id).unwrap_or(at));
    let mut order = Vec::with_capacity(osm.nodes.len());
    order.extend(on_ways.chain(others).filter(|&at| std::mem::take(&mut waiting[at])).map(|at| at as u32));
    order
}

/// A point with the values that are needed only to make it.
struct Made {
    point: Point,
    /// `local_x` and `local_y` as written, each where its tag exists and is a number.
    local: [Option<f64>; 2],
    projected: Option<PlanePoint>,
    bad_ele: Option<Text>,
}

impl Loader<'_> {
    pub(super) fn nodes(&mut self, projector: &Projector) {
        let nodes = &self.osm.nodes;
        if let Some(metres) = written_metres(self.osm) {
            self.in_metres(metres);
            return;
        }
        let (places, heights) = (places(nodes), heights(nodes, projector));
        let (projected, squares) = match projector {
            Projector::Mgrs(_) => Projector::in_squares(&places).into_iter().map(Option::unzip).unzip(),
            _ => (projector.forward_each(&places, |i| heights.get(i).copied().unwrap_or(0.0)), Vec::new()),
        };
        let any_local = nodes.iter().any(|n| n.tags.has("local_x") || n.tags.has("local_y"));
        let mut shift = Shift::default();
        let mut points = Vec::with_capacity(nodes.len());
        for (node, projected) in nodes.iter().zip(projected) {
            let made = self.made(node, projected);
            self.node_faults(node, &made, any_local, &mut shift);
            points.push(Some(made.point));
        }
        self.keep(points);
        shift.settle(&mut self.loaded.faults);
        if shift.explained() {
            self.place_the_lost(projector);
        }
        if let Projector::Mgrs(grid) = projector {
            self.squares(&squares, *grid);
        }
    }

    /// Keeps the points in the order of the ways.
    fn keep(&mut self, mut points: Vec<Option<Point>>) {
        let mut along = Vec::with_capacity(points.len());
        along.extend(along_ways(self.osm).into_iter().filter_map(|at| points[at as usize].take()));
        self.loaded.map.points = along.into();
        self.heights_left_out();
    }

    /// The points where latitudes and longitudes are metres: they lie where these say, so that all else can be judged.
    fn in_metres(&mut self, metres: Vec<PlanePoint>) {
        let mut points = Vec::with_capacity(metres.len());
        let first = metres.first().map(|at| [at.y, at.x]).unwrap_or_default();
        let exchanged = from_exchanged(&metres);
        let condition = match exchanged {
            Some(_) => Condition::ExchangedDegrees { first },
            None => Condition::MetresAsDegrees { first },
        };
        let metres = exchanged.unwrap_or(metres);
        for (node, place) in self.osm.nodes.iter().zip(metres) {
            let made = self.made(node, Some(place));
            self.id(ElementKind::Node, node.id, Subject::Point(node.id), &node.span);
            self.height_fault(node, &made);
            let mut point = made.point.with_lonlat(None);
            point.position = place;
            points.push(Some(point));
        }
        self.keep(points);
        self.loaded.faults.push(LoadFault { subject: Subject::Map, span: None, condition });
    }

    /// Replaces the faults of nodes without height by one of the map, where all of them lie at height 0: Lanelet2's own writer leaves
    /// `ele` out there.
    fn heights_left_out(&mut self) {
        let is_absent = |fault: &LoadFault| fault.condition == Condition::NoElevation;
        let nodes = self.loaded.faults.iter().filter(|fault| is_absent(fault)).count();
        if nodes > 0 && self.lie_at_zero() {
            self.loaded.faults.retain(|fault| !is_absent(fault));
            let condition = Condition::ElevationLeftOut { nodes };
            self.loaded.faults.push(LoadFault { subject: Subject::Map, span: None, condition });
        }
    }

    /// Whether the nodes without height lie at 0: no way leads from one of them to a node much higher or lower. Unless Lanelet2 wrote
    /// the file, half of the heights that are written have to be near 0, too.
    fn lie_at_zero(&self) -> bool {
        let is_written_so = self.osm.generator.as_deref() == Some(LANELET2);
        let points = &self.loaded.map.points;
        let written: Vec<f64> = points.iter().filter_map(Point::ele).collect();
        let low = written.iter().filter(|ele| ele.abs() <= NEAR_ZERO).count();
        let fits = |pair: &[i64]| {
            let [Some(a), Some(b)] = [points.get(PointId(pair[0])), points.get(PointId(pair[1]))] else { return true };
            let step = match (a.ele(), b.ele()) {
                (Some(ele), None) | (None, Some(ele)) => ele.abs(),
                _ => return true,
            };
            step <= LEAST_STEP + STEEPEST * (a.position - b.position).norm()
        };
        let absent = points.iter().filter(|point| point.ele().is_none()).map(|point| point.id).collect();
        let is_said_elsewhere =
            heights_by_other_names(points, &absent).into_iter().any(|(_, height)| height.abs() > NEAR_ZERO);
        !is_said_elsewhere
            && (is_written_so || 2 * low >= written.len())
            && self.osm.ways.iter().all(|way| way.nodes.windows(2).all(fits))
    }

    fn made(&self, node: &Node, projected: Option<PlanePoint>) -> Made {
        let local = [number(node, "local_x").value(), number(node, "local_y").value()];
        let ele = number(node, "ele");
        let bad_ele = match ele {
            Number::Bad => node.tags.first("ele").map(Text::from),
            _ => None,
        };
        let position = if self.local {
            PlanePoint::new(local[0].unwrap_or(0.0), local[1].unwrap_or(0.0))
        } else {
            projected.unwrap_or_default()
        };
        let own = |key: &str| !matches!(key, "ele" | "local_x" | "local_y");
        let attributes: Attributes = node.tags.iter().filter(|(k, _)| own(k)).collect();
        let point = Point::new(PointId(node.id), position, ele.value())
            .with_attributes(attributes)
            .with_lonlat(node.position)
            .read(local.map(|number| number.is_some()), node.span.clone());
        Made { point, local, projected: if self.local { None } else { projected }, bad_ele }
    }

    fn node_faults(&mut self, node: &Node, made: &Made, any_local: bool, shift: &mut Shift) {
        let subject = Subject::Point(node.id);
        self.id(ElementKind::Node, node.id, subject, &node.span);
        let [x, y] = made.local;
        match (node.position, made.projected) {
            _ if self.local => {}
            (None, _) => {
                let said = self.off_earth.get(&node.id).copied();
                self.fault(subject, &node.span, Condition::BadCoordinate { said, meant: None });
            }
            (Some(_), None) => self.fault(subject, &node.span, Condition::Unprojectable),
            (Some(_), Some(projected)) => {
                if let [Some(x), Some(y)] = [x, y] {
                    shift.add(PlanePoint::new(x, y) - projected);
                    let distance = (PlanePoint::new(x, y) - projected).norm();
                    if distance > LOCAL_TOLERANCE {
                        self.fault(subject, &node.span, Condition::LocalMismatch { distance });
                    }
                }
            }
        }
        if any_local && (x.is_none() || y.is_none()) {
            let condition = Condition::PartialLocal { x: x.is_some(), y: y.is_some() };
            self.fault(subject, &node.span, condition);
        }
        self.height_fault(node, made);
    }

    fn height_fault(&mut self, node: &Node, made: &Made) {
        let subject = Subject::Point(node.id);
        match (&made.bad_ele, made.point.ele()) {
            (Some(found), _) => {
                let found = found.clone();
                self.fault(subject, &node.span, Condition::BadElevation { found });
            }
            (None, None) => self.fault(subject, &node.span, Condition::NoElevation),
            (None, Some(_)) => {}
        }
    }

    /// Adds the place of the local coordinates to the faults of nodes without latitude and longitude.
    fn place_the_lost(&mut self, projector: &Projector) {
        for at in 0..self.loaded.faults.len() {
            let fault = &self.loaded.faults[at];
            let (Subject::Point(id), Condition::BadCoordinate { .. }) = (fault.subject, &fault.condition) else {
                continue;
            };
            let Some(node) = self.osm.node(id) else { continue };
            let [x, y] = ["local_x", "local_y"].map(|key| number(node, key).value());
            let local = x.zip(y).map(|(x, y)| PlanePoint::new(x, y));
            let ele = number(node, "ele").value().unwrap_or(0.0);
            let place = local.and_then(|local| projector.inverse_each(&[local], |_| ele).pop().flatten());
            if let Condition::BadCoordinate { meant, .. } = &mut self.loaded.faults[at].condition {
                *meant = place;
            }
        }
    }

    /// Names each 100 km square other than the projector's once, with its first node.
    fn squares(&mut self, squares: &[Option<MgrsGrid>], expected: MgrsGrid) {
        let mut others: Vec<(MgrsGrid, usize, usize)> = Vec::new();
        for (at, &square) in squares.iter().enumerate() {
            let Some(square) = square.filter(|s| !s.same_square(&expected)) else { continue };
            if self.osm.nodes[at].position.is_none() {
                continue;
            }
            match others.iter_mut().find(|(s, ..)| s.same_square(&square)) {
                Some((_, nodes, _)) => *nodes += 1,
                None => others.push((square, 1, at)),
            }
        }
        for (square, nodes, first) in others {
            let node = &self.osm.nodes[first];
            let condition = Condition::OtherSquare { square, expected, nodes };
            self.fault(Subject::Point(node.id), &node.span, condition);
        }
    }
}

/// The box around all differences between local and projected coordinates.
#[derive(Default)]
struct Shift {
    spread: Option<(Vector, Vector)>,
    near: usize,
    far: usize,
    /// The largest difference, metres.
    most: f64,
}

impl Shift {
    fn add(&mut self, difference: Vector) {
        let (low, high) = self.spread.unwrap_or((difference, difference));
        self.spread = Some((low.inf(&difference), high.sup(&difference)));
        let count = if difference.norm() <= LOCAL_TOLERANCE { &mut self.near } else { &mut self.far };
        *count += 1;
        self.most = self.most.max(difference.norm());
    }

    /// Whether the projector explains the local coordinates of nearly all nodes.
    fn explained(&self) -> bool {
        self.near > 10 * self.far
    }

    /// Replaces the faults of single nodes by one fault of the map if all nodes are shifted alike, or most lie elsewhere.
    fn settle(&self, faults: &mut Vec<LoadFault>) {
        let Some((low, high)) = self.spread else { return };
        let middle = (low + high) / 2.0;
        let is_moved = (high - low).norm() <= 2.0 * LOCAL_TOLERANCE && middle.norm() > LOCAL_TOLERANCE;
        let condition = match is_moved {
            true => Condition::LocalShifted { east: middle.x, north: middle.y },
            // Two nodes that differ do not tell about the others.
            false if self.far > self.near.max(2) => Condition::LocalUnexplained { nodes: self.far, most: self.most },
            false => return,
        };
        let before = faults.len();
        faults.retain(|f| !matches!(f.condition, Condition::LocalMismatch { .. }));
        if faults.len() < before {
            faults.push(LoadFault { subject: Subject::Map, span: None, condition });
        }
    }
}

/// The places in metres from the first of nodes that have longitudes as latitudes (y), and latitudes as longitudes (x): all of them are
/// degrees, no latitude is one, and they lie within a degree. `None` where they are something else.
fn from_exchanged(said: &[PlanePoint]) -> Option<Vec<PlanePoint>> {
    const METRES_A_DEGREE: f64 = 111_320.0;
    let first = *said.first()?;
    let is_exchanged = |at: &PlanePoint| {
        let [lon, lat] = [at.y, at.x];
        (90.0..=180.0).contains(&lon.abs()) && lat.abs() <= 90.0 && (at - first).abs().max() < 1.0
    };
    let shrunk = first.x.to_radians().cos();
    said.iter().all(is_exchanged).then(|| {
        let place = |at: &PlanePoint| PlanePoint::new((at.y - first.y) * shrunk, at.x - first.x) * METRES_A_DEGREE;
        said.iter().map(place).collect()
    })
}
