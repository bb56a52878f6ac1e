//! The lanelets of an intersection: one per movement, smooth, with bounds that neighbours share.

use rustc_hash::FxHashMap;

use crate::geometry::part::parted;
use crate::geometry::round::Rounding;
use crate::geometry::{Point, Polyline, Vector, angle_between, curve, curve::Pose};
use crate::lanelet::index::{HEADING_REACH, center_line};
use crate::lanelet::{Attributes, Bound, LaneletId, LineStringId, PointId};

use super::assembly::{Assembly, tags};
use super::course::{Ends, courses};
use super::cross_section::StripKind;
use super::ids::Key;
use super::lanes::{ADMITS_BICYCLES, Arm, ArmLane, Lanes, road_attributes};
use super::midway::{Meant, keeps_width, smooth};
use super::movement::{Movement, turned};
use super::places::Places;
use super::ring::Ring;
use super::road_network::{DrivingSide, Intersection, RoadNetwork};
use super::sound::sound;

/// One movement, drawn.
#[derive(Clone, Debug)]
pub struct Path {
    /// From where to where.
    pub movement: Movement,
    /// Its lanelet.
    pub lanelet: LaneletId,
    /// Change of direction in degrees, left positive.
    pub turn: f64,
    /// Left bound, then the right bound backwards.
    pub outline: Vec<Point>,
    /// Its bounds, left and right.
    pub bounds: [LineStringId; 2],
    /// Where it heads over its first metres, as Autoware sees it.
    pub heading: Vector,
    /// For all motor vehicles, for buses only, or for bicycles.
    pub kind: StripKind,
}

/// Lines between two nodes of an intersection, each drawn once.
#[derive(Clone, Debug, Default)]
pub struct Bounds {
    lines: FxHashMap<(PointId, PointId), Bound>,
    /// For every node where lines end, the other ends of those lines.
    ends: FxHashMap<PointId, Vec<PointId>>,
    points: Places,
}

/// How tightly a bound may bend, and how much wider a lane may become where it turns.
const BENDS: Rounding = Rounding { least: 1.25, easy: 2.0, cut: 0.6 };

impl Bounds {
    /// The line from one node to another, as a bound in that direction.
    pub fn get(&self, from: PointId, to: PointId) -> Option<Bound> {
        self.lines.get(&(from, to)).copied()
    }

    /// Every point of every line, in order of the lines' ids.
    pub fn points(&self, assembly: &Assembly) -> Vec<PointId> {
        let mut lines: Vec<LineStringId> = self.lines.values().map(|b| b.line).collect();
        lines.sort_unstable();
        lines.dedup();
        lines.into_iter().filter_map(|l| assembly.line_of(l)).flat_map(|l| l.points.clone()).collect()
    }

    /// Adds the line of a bound between two nodes that exist.
    fn draw(
        &mut self,
        assembly: &mut Assembly,
        key: Key,
        [a, b]: [PointId; 2],
        mut places: Vec<Point>,
        attributes: Attributes,
    ) -> LineStringId {
        // The curve ends at the nodes but for rounding; the nodes are the truth.
        if let Some(first) = places.first_mut() {
            *first = assembly.position(a);
        }
        if let Some(last) = places.last_mut() {
            *last = assembly.position(b);
        }
        // The pair of nodes is unordered, so that the same bound has the same id whichever way it was drawn.
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        let key = key.word("bound").number(low.0).number(high.0);
        let clean = curve::untangled(&places);
        let heights = assembly.heights_along(&clean, [a, b]);
        let inner = 1.min(clean.len())..clean.len().max(2) - 1;
        let mut points = Vec::with_capacity(clean.len().max(2));
        points.push(a);
        for (number, i) in inner.enumerate() {
            points.push(self.point(assembly, key.number(number as i64), clean[i], heights[i]));
        }
        points.push(b);
        points.dedup();
        assembly.line(key, points, attributes)
    }

    /// The point at a place, at a height if it is not there already.
    fn point(&mut self, assembly: &mut Assembly, key: Key, place: Point, height: f64) -> PointId {
        self.points.at(place, || assembly.point_at(key, place, height, Attributes::new()))
    }

    /// Keeps the places of a line that is to be drawn from one node to another beside the lines that end on either node.
    fn beside_others(&self, assembly: &Assembly, [from, to]: [PointId; 2], mut places: Vec<Point>) -> Vec<Point> {
        for node in [from, to] {
            let mut own = None;
            for &end in self.ends.get(&node).into_iter().flatten().filter(|end| ![from, to].contains(end)) {
                let other = self.get(node, end).and_then(|bound| Polyline::new(assembly.bound_line(bound)));
                own = own.or_else(|| Polyline::new(places.iter().copied()));
                let (Some(line), Some(other)) = (&own, other) else { continue };
                if let Some(apart) = parted(line, &other) {
                    (places, own) = (apart, None);
                }
            }
            places.reverse();
        }
        places
    }

    fn insert(&mut self, from: PointId, to: PointId, line: LineStringId) -> Bound {
        self.ends.entry(from).or_default().push(to);
        self.ends.entry(to).or_default().push(from);
        self.lines.insert((to, from), Bound { line, inverted: true });
        let bound = Bound { line, inverted: false };
        self.lines.insert((from, to), bound);
        bound
    }
}

/// How the bounds of paths are tagged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// `virtual`: nothing is painted across an intersection.
    None,
    /// As the bounds of the lane that leads in: the road merely goes on.
    AsBefore,
}

/// What [`paths`] made.
#[derive(Clone, Debug, Default)]
pub struct Drawn {
    /// Sorted by movement.
    pub paths: Vec<Path>,
    /// The lines they share.
    pub bounds: Bounds,
    /// Movements for which there is no room: their lanes end too close together or side by side.
    pub dropped: Vec<Movement>,
}

/// Draws the movements of one intersection, the tightest turns first: where two share a bound, the tighter one needs it
/// exact.
pub fn paths(
    assembly: &mut Assembly,
    network: &RoadNetwork,
    lanes: &Lanes,
    intersection: &Intersection,
    movements: &[Movement],
    paint: Paint,
) -> Drawn {
    let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
    let key = intersection_key("path", intersection);
    let ends = |m: &Movement| Some((arms.get(m.from)?.into.get(m.in_lane)?, arms.get(m.to)?.out.get(m.out_lane)?));
    let all: Vec<Ends> = movements.iter().filter_map(|m| ends(m).map(|(from, to)| (*m, from, to))).collect();
    let ring = Ring::of(intersection);
    let mut all: Vec<(Ends, Vec<Pose>)> = all.iter().copied().zip(courses(&all)).collect();
    for ((movement, from, to), course) in &mut all {
        let roads = [movement.from, movement.to].map(|arm| network.road(arms[arm].at.road).place(arms[arm].at.end));
        let around = ring.as_ref().and_then(|ring| ring.around(roads, [from.pose, to.pose], course));
        *course = around.unwrap_or_else(|| std::mem::take(course));
    }
    let mut drawn = Drawn::default();
    let lanelet = |assembly: &Assembly, (movement, from, _): &Ends, kind| {
        let road = network.road(arms[movement.from].at.road);
        let speed = assembly
            .lanelet_of(lanes.lanes[from.lane].lanelet)
            .and_then(|l| l.attributes.get("speed_limit")?.parse().ok())
            .unwrap_or(road.speed[0]);
        let mut attributes = road_attributes(road, kind, speed);
        let before = assembly.lanelet_of(lanes.lanes[from.lane].lanelet).map(|lanelet| &lanelet.attributes);
        if kind == StripKind::Bus && before.is_some_and(|before| before.is(ADMITS_BICYCLES, "yes")) {
            attributes.push(ADMITS_BICYCLES, "yes");
        }
        attributes
    };
    let bound = |assembly: &Assembly, from: &ArmLane, side| bound_attributes(assembly, lanes, from, side, paint);
    drawn.add(assembly, network.side, key, all, &Tagged { bound: &bound, lanelet: &lanelet });
    drawn
}

/// How what is drawn is tagged.
pub struct Tagged<'a> {
    /// Tags of a bound, from the lane that leads in and its side: 0 left, 1 right.
    pub bound: &'a dyn Fn(&Assembly, &ArmLane, usize) -> Attributes,
    /// Tags of a lanelet.
    pub lanelet: &'a dyn Fn(&Assembly, &Ends, StripKind) -> Attributes,
}

impl Drawn {
    /// Draws ways, each with its middle, beside those that are there, with which they share bounds.
    pub fn add(
        &mut self,
        assembly: &mut Assembly,
        side: DrivingSide,
        key: Key,
        mut order: Vec<(Ends, Vec<Pose>)>,
        tagged: &Tagged,
    ) {
        let Self { paths, bounds, dropped } = self;
        let radius = |(_, from, to): &Ends| curve::join_radius(from.pose, to.pose).unwrap_or(f64::INFINITY);
        order.sort_by(|(a, _), (b, _)| radius(a).total_cmp(&radius(b)).then(a.0.cmp(&b.0)));
        let meant = Meant::new(&order);
        for ((movement, from, to), course) in order {
            if from.nodes[0] == to.nodes[0] || from.nodes[1] == to.nodes[1] {
                continue;
            }
            let known = [0, 1].map(|i| bounds.get(from.nodes[i], to.nodes[i]));
            let Some((shape, known)) = shape(assembly, [from, to], &course, known, &meant) else {
                dropped.push(movement);
                continue;
            };
            let mut sides = [0, 1].into_iter().zip(shape).map(|(i, places)| {
                known[i].unwrap_or_else(|| {
                    let attributes = (tagged.bound)(assembly, from, i);
                    let (a, b) = (from.nodes[i], to.nodes[i]);
                    let places = bounds.beside_others(assembly, [a, b], places);
                    let line = bounds.draw(assembly, key, [a, b], places, attributes);
                    bounds.insert(a, b, line)
                })
            });
            let (Some(left), Some(right)) = (sides.next(), sides.next()) else { continue };
            drop(sides);
            let kind = if from.kind == to.kind { from.kind } else { StripKind::Bus };
            let attributes = (tagged.lanelet)(assembly, &(movement, from, to), kind);
            let lanelet = assembly.lanelet(path_key(key, from, to), left, right, attributes);
            // As whoever reads the map sees it, not as it was meant: what bounds are shared moves the middle.
            let [left_line, right_line] = [left, right].map(|bound| assembly.bound_line(bound));
            let center = center_line(&left_line, &right_line);
            paths.push(Path {
                movement,
                lanelet,
                bounds: [left.line, right.line],
                heading: center.as_ref().and_then(heading).unwrap_or(from.pose.heading),
                turn: center.map_or(0.0, |center| turned(side, &center)),
                outline: left_line.into_iter().chain(right_line.into_iter().rev()).collect(),
                kind,
            });
        }
        paths.sort_by_key(|p| p.movement);
        dropped.sort_unstable();
    }
}

/// Where a lanelet heads over its first metres.
fn heading(center: &Polyline) -> Option<Vector> {
    (center.at(HEADING_REACH) - center.first()).try_normalize(f64::EPSILON)
}

/// Places of both bounds, and the bounds among the known ones that serve.
type Shape = ([Vec<Point>; 2], [Option<Bound>; 2]);

/// Whether a way takes the bounds that others have drawn between the same nodes.
#[derive(Clone, Copy, PartialEq)]
enum Share {
    /// Where it keeps its width between them.
    Evenly,
    /// Wherever it fits between them.
    Anyhow,
    Not,
}

/// The shape of a lane between two ends; `None` if there is no room for one.
fn shape(
    assembly: &Assembly,
    [from, to]: [&ArmLane; 2],
    course: &[Pose],
    known: [Option<Bound>; 2],
    meant: &Meant,
) -> Option<Shape> {
    let smooth = smooth([from, to], course).map(|line| curve::untangled(&line));
    let meant = [0, 1].map(|side| meant.get(from.nodes[side], to.nodes[side]).map(|line| curve::untangled(&line)));
    let midway = [0, 1].map(|side| meant[side].as_ref().unwrap_or(&smooth[side]));
    let straight = [0, 1].map(|side| vec![assembly.position(from.nodes[side]), assembly.position(to.nodes[side])]);
    // Where the turn is tighter than half the lane, its inner bound is a straight line.
    let left_turn = angle_between(from.pose.heading, to.pose.heading) > 0.0;
    let tight = if left_turn { [&straight[0], &smooth[1]] } else { [&smooth[0], &straight[1]] };
    let (smooth, straight) = (smooth.each_ref(), straight.each_ref());
    let old = known.map(|bound| bound.map(|b| assembly.bound_line(b)));
    let width = [from.width, to.width];
    let even = |[left, right]: &[Vec<Point>; 2]| {
        let lines = [left, right].map(|line| Polyline::new(line.iter().copied()));
        let [Some(a), Some(b)] = lines else { return false };
        keeps_width(left, &b, width) && keeps_width(right, &a, width)
    };
    // Rather a bound of its own than one shared that squeezes it, and rather that than a corner.
    let shapes = [
        (midway, Share::Evenly),
        (smooth, Share::Evenly),
        (smooth, Share::Not),
        (midway, Share::Anyhow),
        (smooth, Share::Anyhow),
        (tight, Share::Anyhow),
        (tight, Share::Not),
        (straight, Share::Not),
    ];
    let mut unsound: Vec<[Vec<Point>; 2]> = Vec::new();
    for (shape, share) in shapes {
        let known = if share == Share::Not { [None, None] } else { known };
        let lines = [0, 1].map(|side| old[side].as_ref().filter(|_| known[side].is_some()).unwrap_or(shape[side]));
        // Where nothing is shared, several come to the same.
        if unsound.iter().any(|tried| tried.each_ref() == lines) {
            continue;
        }
        let lines = lines.map(Vec::clone);
        if !sound(&lines, from.width.min(to.width)) {
            unsound.push(lines);
            continue;
        }
        // Ways side by side share whatever comes: they must not overlap.
        let with_opposite = known.iter().flatten().any(|bound| bound.inverted);
        if share != Share::Evenly || !with_opposite || even(&lines) {
            let round =
                [0, 1].map(|side| if known[side].is_some() { lines[side].clone() } else { BENDS.of(&lines[side]) });
            let serves = round == lines || sound(&round, from.width.min(to.width));
            return Some((if serves { round } else { lines }, known));
        }
    }
    None
}

/// The key of an intersection.
pub fn intersection_key(part: &str, intersection: &Intersection) -> Key {
    intersection.nodes.iter().fold(Key::new(part), |key, &node| key.number(node))
}

fn path_key(key: Key, from: &ArmLane, to: &ArmLane) -> Key {
    [from.nodes[0], from.nodes[1], to.nodes[0], to.nodes[1]].into_iter().fold(key, |key, node| key.number(node.0))
}

fn bound_attributes(assembly: &Assembly, lanes: &Lanes, from: &ArmLane, side: usize, paint: Paint) -> Attributes {
    match paint {
        Paint::None => tags(&[("type", "virtual")]),
        Paint::AsBefore => {
            let lane = &lanes.lanes[from.lane];
            let bound = [lane.left, lane.right][side];
            assembly.line_of(bound.line).map(|l| l.attributes.clone()).unwrap_or_default()
        }
    }
}
