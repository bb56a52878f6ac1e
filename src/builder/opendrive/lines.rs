//! Borders as lines of the map, each drawn once, and the lanelets between them.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::tags::marking::unpainted;
use crate::diagnostic::Severity;
use crate::geometry::{Point, Polyline};
use crate::lanelet::align::align;
use crate::lanelet::{Attributes, Bound, LineStringId, PointId};
use crate::xodr::{Lane, Place};

use super::lane_use::{LaneUse, sides};
use super::marks::{self, Beside};
use super::nodes::{BorderEnd, EndNodes, WELD};
use super::plane::Plane;
use super::sampling;
use super::scene::{Drawn, DrawnLane, Piece, Scene, note};

/// Points closer than this to the end of their line, metres, are left out: the end may have been moved a little.
const BESIDE_END: f64 = 0.05;
/// Borders of two roads between the same nodes that lie this close, metres, in the plane and in height, are one line: inside junctions, where
/// several lie almost on each other, and elsewhere.
const TWIN: [f64; 2] = [0.01, WELD];
/// A border that ends off its node is drawn to it over so many times the distance.
const DRAWN_OVER: f64 = 10.0;
/// Heights are whole tenths of millimetres, as in all maps.
const STEPS: f64 = 1e4;

/// The lanes of a stretch that become lanelets.
pub struct StretchLanes<'a> {
    /// Lanes for motor vehicles.
    pub driven: Vec<(&'a Lane, LaneUse)>,
    /// Strips beside them.
    pub sides: Vec<SideRun>,
    /// For each border the one that stands for it.
    pub stands: BTreeMap<i64, i64>,
}

/// Lanes of one use beside those that are driven, which are one lanelet.
pub struct SideRun {
    /// What it is for.
    pub used: LaneUse,
    /// The driven lane beside it, and the outermost lane of the run: both have the borders of the run for outer borders.
    pub lanes: [i64; 2],
}

impl SideRun {
    /// The border toward the driven lanes, and the other one.
    pub fn borders(&self) -> [i64; 2] {
        self.lanes
    }

    /// The driven lane beside it.
    pub fn beside(&self) -> i64 {
        self.lanes[0]
    }
}

/// A lanelet to be drawn, or two: one for each direction.
pub struct One {
    /// What it leads along.
    pub pieces: Vec<Piece>,
    /// For each piece the borders between which it lies, the left one along the road first.
    pub borders: Vec<[i64; 2]>,
    /// 1 along the road, -1 against it; with each, whether it is the second one of a lane that is driven both ways.
    pub directions: Vec<(i8, bool)>,
    /// What it is for.
    pub used: LaneUse,
    /// km/h.
    pub limit: f64,
}

/// Borders as lines, each drawn once.
pub struct Lines<'a> {
    /// The file.
    pub scene: &'a Scene<'a>,
    /// For each end of a border the first one of its node, and the node's place.
    pub ends: &'a EndNodes,
    points: BTreeMap<BorderEnd, PointId>,
    /// By stretch and border: the points of a border between its ends.
    inner: BTreeMap<(usize, i64), Vec<PointId>>,
    /// By the stretches along which they lead, each with the border there.
    lines: BTreeMap<Vec<(usize, i64)>, Vec<Bound>>,
    /// Lines that have a lanelet on their right side, and those that have one on their left side.
    taken: [BTreeSet<LineStringId>; 2],
    /// By the nodes at their ends, the smaller one first.
    between: BTreeMap<[PointId; 2], Vec<LineStringId>>,
}

impl<'a> Lines<'a> {
    /// Nothing is drawn yet.
    pub fn new(scene: &'a Scene<'a>, ends: &'a EndNodes) -> Self {
        Self {
            scene,
            ends,
            points: BTreeMap::new(),
            inner: BTreeMap::new(),
            lines: BTreeMap::new(),
            taken: [BTreeSet::new(), BTreeSet::new()],
            between: BTreeMap::new(),
        }
    }

    /// The node at the end of a border.
    fn node(&mut self, assembly: &mut MapBuilder, end: BorderEnd) -> (PointId, Place) {
        let (first, place) = self.ends.get(&end).copied().unwrap_or((end, self.scene.border_at(end.0, end.1, end.2)));
        let scene = self.scene;
        let id = *self.points.entry(first).or_insert_with(|| {
            let (stretch, far, border) = first;
            let key = scene.key("node", stretch).number(border).number(i64::from(far));
            point(assembly, scene.plane, key, place)
        });
        (id, place)
    }

    /// Adds the lanelets.
    pub fn lanelets(&mut self, assembly: &mut MapBuilder, drawn: &mut Drawn, lanes: &[StretchLanes], one: One) {
        let One { pieces, borders, directions, used, limit } = one;
        let Some(first) = pieces.first().copied() else { return };
        let along: [Vec<(usize, i64)>; 2] = [0, 1].map(|side| {
            let stands = |(piece, borders): (&Piece, &[i64; 2])| {
                let border = borders[side];
                (piece.stretch, lanes[piece.stretch].stands.get(&border).copied().unwrap_or(border))
            };
            pieces.iter().zip(&borders).map(stands).collect()
        });
        if along[0].iter().zip(&along[1]).any(|(high, low)| high == low) {
            return;
        }
        let [high, low] = along;
        let points = [self.points(assembly, &high), self.points(assembly, &low)];
        let road = self.scene.road(first.stretch);
        if points.iter().any(|points| points.first() == points.last()) {
            let message = format!(
                "lane {} of road {} turns on the spot: a border of it begins and ends at one place; it is left out",
                first.lane, road.id
            );
            drawn.notes.push(note("opendrive-turn", road.line, message).graded(Severity::Warning));
            return;
        }
        let Upright { points, cut_short } = match upright(assembly, points, &directions) {
            Some(found) => found,
            None => {
                let message =
                    format!("the borders of lane {} of road {} cross each other: it is left out", first.lane, road.id);
                drawn.notes.push(note("opendrive-turn", road.line, message).graded(Severity::Warning));
                return;
            }
        };
        let [of_high, of_low] = points;
        let high = self.draw(assembly, (high, of_high), true, lanes);
        let low = self.draw(assembly, (low, of_low), false, lanes);
        let turned = |bound: Bound| Bound { inverted: !bound.inverted, ..bound };
        for (direction, back) in directions {
            let bounds = if direction < 0 { [turned(low), turned(high)] } else { [high, low] };
            let key = self.scene.key("lane", first.stretch).number(first.lane);
            let key = pieces.iter().skip(1).fold(key, |key, piece| key.number(piece.lane));
            let key = if back { key.word("back") } else { key };
            let lanelet = assembly.lanelet(key, bounds[0], bounds[1], used.tags(limit));
            let ends = bounds.map(|bound| assembly.bound_ids(bound));
            let nodes = [false, true].map(|last| {
                ends.each_ref().map(|ids| if last { ids.last() } else { ids.first() }.copied().unwrap_or(PointId(0)))
            });
            drawn.push(DrawnLane { pieces: pieces.clone(), direction, used, lanelet, bounds, nodes });
        }
        if cut_short {
            let name = drawn.name(self.scene, first);
            let message = format!(
                "{name} turns more tightly than it is wide: its inner border runs back, and is cut short there"
            );
            drawn.notes.push(note("opendrive-turn", road.line, message).graded(Severity::Warning));
        }
    }

    /// The line that leads along these borders, each of a stretch, in order along the road; the lanelet lies on its right side, or on its
    /// left one. Two lanelets on one side of a line would be taken for each other's neighbours.
    fn draw(
        &mut self,
        assembly: &mut MapBuilder,
        (along, points): (Vec<(usize, i64)>, Vec<PointId>),
        rightward: bool,
        lanes: &[StretchLanes],
    ) -> Bound {
        let ends = [points[0], points[points.len() - 1]];
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let known = self.lines.get(&along).cloned().unwrap_or_default();
        let side = |bound: &Bound| usize::from(rightward == bound.inverted);
        let free = |bound: &Bound| !self.taken[side(bound)].contains(&bound.line);
        let [inside, outside] = TWIN;
        let apart = if self.scene.connecting[self.scene.stretches[along[0].0].road] { inside } else { outside };
        let bound = known.iter().copied().find(free).or_else(|| self.twin(assembly, ends, &points, (apart, free)));
        let bound = bound.unwrap_or_else(|| {
            let (stretch, border) = along[0];
            let key = self.scene.key("border", stretch).number(border);
            let key = along.iter().skip(1).fold(key, |key, (_, border)| key.number(*border));
            let key = if known.is_empty() { key } else { key.word("again").number(known.len() as i64) };
            Bound { line: assembly.line(key, points, self.tags(stretch, border, &lanes[stretch])), inverted: false }
        });
        self.taken[side(&bound)].insert(bound.line);
        let between = self.between.entry(ends).or_default();
        if !between.contains(&bound.line) {
            between.push(bound.line);
        }
        let known = self.lines.entry(along).or_default();
        if !known.contains(&bound) {
            known.push(bound);
        }
        bound
    }

    /// The points along borders, each of a stretch, in order along the road.
    fn points(&mut self, assembly: &mut MapBuilder, along: &[(usize, i64)]) -> Vec<PointId> {
        let mut points: Vec<PointId> = Vec::new();
        for &(stretch, border) in along {
            let (first, last) = self.border(assembly, stretch, border);
            points.extend(if points.is_empty() { Some(first) } else { None });
            points.extend(self.inner.get(&(stretch, border)).into_iter().flatten());
            points.push(last);
        }
        points
    }

    /// A line that is drawn already and lies where these points lie: the border of another road.
    fn twin(
        &self,
        assembly: &MapBuilder,
        ends: [PointId; 2],
        points: &[PointId],
        (apart, free): (f64, impl Fn(&Bound) -> bool),
    ) -> Option<Bound> {
        let place = |ids: &[PointId]| Polyline::new(assembly.positions(ids));
        let own = place(points)?;
        let as_high = |ids: &[PointId], line: &Polyline, other: &[PointId]| {
            let (stations, heights) =
                (line.stations(), ids.iter().map(|id| assembly.height(*id)).collect::<Vec<f64>>());
            stations.len() == heights.len()
                && other.iter().all(|id| {
                    let station = line.project(assembly.position(*id)).station;
                    (height_at(&stations, &heights, station) - assembly.height(*id)).abs() <= apart
                })
        };
        self.between.get(&ends)?.iter().find_map(|&line| {
            let ids = assembly.bound_ids(Bound { line, inverted: false });
            let other = place(&ids)?;
            let near = |a: &Polyline, b: &Polyline| a.points().iter().all(|at| b.distance(*at) <= apart);
            let bound = Bound { line, inverted: ids.first() != points.first() };
            let near = near(&own, &other) && near(&other, &own);
            let high = || as_high(points, &own, &ids) && as_high(&ids, &other, points);
            (ends[0] != ends[1] && free(&bound) && near && high()).then_some(bound)
        })
    }

    /// The nodes at the ends of a border of a stretch; adds the points between.
    fn border(&mut self, assembly: &mut MapBuilder, stretch: usize, border: i64) -> (PointId, PointId) {
        let scene = self.scene;
        let (first, from) = self.node(assembly, (stretch, false, border));
        let (last, to) = self.node(assembly, (stretch, true, border));
        if self.inner.contains_key(&(stretch, border)) {
            return (first, last);
        }
        let places = drawn_to(sampling::border(scene, stretch, border), [from, to]);
        let far_from_ends =
            |at: &Place| [from, to].iter().all(|end| (at[0] - end[0]).hypot(at[1] - end[1]) > BESIDE_END);
        let end = places.len().saturating_sub(1);
        let inner = places.into_iter().enumerate().filter(|(i, at)| (1..end).contains(i) && far_from_ends(at));
        let inner: Vec<Place> = inner.map(|(_, at)| at).collect();
        let key = scene.key("border", stretch).number(border);
        let mut points = Vec::with_capacity(inner.len());
        for ((at, height), number) in scene.plane.to_map(&inner).into_iter().zip(0..) {
            points.push(assembly.point_at(key.number(number), at, rounded(height), Attributes::new()));
        }
        self.inner.insert((stretch, border), points);
        (first, last)
    }

    fn tags(
        &self,
        stretch: usize,
        border: i64,
        StretchLanes { driven, sides: runs, stands }: &StretchLanes,
    ) -> Attributes {
        let scene = self.scene;
        let road = scene.road(stretch);
        let stands_for = |side: i64| stands.get(&side).copied().unwrap_or(side);
        let beside_it = driven.iter().filter(|(lane, used)| {
            used.is_driven() && sides(lane.id).iter().any(|side| stands.get(side) == Some(&border))
        });
        let beside_it: Vec<&Lane> = beside_it.map(|(lane, _)| *lane).collect();
        let beside = match beside_it[..] {
            [a, b] if road.directions(a) == road.directions(b) && !a.both_ways => Beside::SameWay,
            [_, _] => Beside::Opposed,
            [_] if runs.iter().any(|run| stands_for(run.borders()[0]) == border) => Beside::Strip,
            [_] => Beside::Edge,
            [] if runs.iter().any(|run| stands_for(run.borders()[1]) == border) => Beside::Kerb,
            _ => Beside::Nothing,
        };
        if scene.connecting[scene.stretches[stretch].road] {
            return unpainted();
        }
        // Of borders that are one, the outermost paint counts.
        let one: Vec<i64> = stands.iter().filter(|(_, stands)| **stands == border).map(|(border, _)| *border).collect();
        let section = scene.section(stretch);
        let marks = one.iter().filter_map(|border| section.mark(*border, scene.middle(stretch)));
        let painted = marks.clone().find(|mark| mark.kind != "none");
        marks::border(painted.or(marks.clone().next()), beside)
    }
}

/// The points of a lane's two borders, so that Lanelet2 reads them in their directions.
struct Upright {
    /// Of the left border along the road, and of the right one.
    points: [Vec<PointId>; 2],
    /// Whether points had to be left out.
    cut_short: bool,
}

/// Lanelet2 tells the direction of a lanelet from where its bounds lie. Where an inner border runs back at an end, points of it are left
/// out there until that is right; `None` if it never is.
fn upright(assembly: &MapBuilder, points: [Vec<PointId>; 2], directions: &[(i8, bool)]) -> Option<Upright> {
    /// So many parts of a border are tried.
    const PARTS: usize = 64;
    let places = points.each_ref().map(|ids| assembly.positions(ids));
    let reads = |high: &[Point], low: &[Point]| {
        directions.iter().all(|(direction, _)| match direction {
            1 => align(high, low) == (false, false),
            _ => align(low, high) == (true, true),
        })
    };
    if reads(&places[0], &places[1]) {
        return Some(Upright { points, cut_short: false });
    }
    let length = |line: &[Point]| line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    let inner = usize::from(length(&places[1]) < length(&places[0]));
    let last = places[inner].len() - 1;
    let step = (last / PARTS).max(1);
    let cuts = (1..last).step_by(step).chain([last]).flat_map(|count| [(1, count), (last + 1 - count, last)]);
    for (from, to) in cuts {
        let keep = |at: usize| !(from..to).contains(&at);
        let mut tried = places.clone();
        let mut at = 0..;
        tried[inner].retain(|_| at.next().is_some_and(keep));
        if reads(&tried[0], &tried[1]) {
            let mut points = points;
            let mut at = 0..;
            points[inner].retain(|_| at.next().is_some_and(keep));
            return Some(Upright { points, cut_short: true });
        }
    }
    None
}

/// The places of a border that ends at these nodes. Where a node lies off the border's own end, as at a gap in the file, the border is drawn
/// to it little by little: it would run back there, or bend.
fn drawn_to(mut places: Vec<Place>, nodes: [Place; 2]) -> Vec<Place> {
    let flat = |a: Place, b: Place| (a[0] - b[0]).hypot(a[1] - b[1]);
    let length: f64 = places.windows(2).map(|pair| flat(pair[0], pair[1])).sum();
    for node in nodes {
        let Some(own) = places.first().copied() else { return places };
        let shift: Place = std::array::from_fn(|i| node[i] - own[i]);
        let reach = (DRAWN_OVER * flat(node, own)).min(length / 3.0);
        if flat(node, own) > WELD && reach > WELD {
            // The place up to which it is drawn off.
            if let Some(beyond) = places.iter().position(|place| flat(*place, own) > reach) {
                let [a, b] = [places[beyond - 1], places[beyond]];
                let part = ((reach - flat(a, own)) / flat(a, b)).clamp(0.0, 1.0);
                places.insert(beyond, std::array::from_fn(|i| a[i] + (b[i] - a[i]) * part));
            }
            for place in &mut places {
                let share = (1.0 - flat(*place, own) / reach).max(0.0);
                place.iter_mut().zip(shift).for_each(|(at, shift)| *at += shift * share);
            }
        }
        places.reverse();
    }
    places
}

/// Adds a point of the file.
pub fn point(assembly: &mut MapBuilder, plane: &Plane, key: Key, place: Place) -> PointId {
    let (at, height) = plane.to_map(&[place]).pop().unwrap_or_default();
    assembly.point_at(key, at, rounded(height), Attributes::new())
}

/// The height at a station of a line, whose points lie at these stations and heights, metres.
fn height_at(stations: &[f64], heights: &[f64], station: f64) -> f64 {
    let behind = stations.partition_point(|it| *it <= station).clamp(1, stations.len() - 1);
    let [from, to] = [stations[behind - 1], stations[behind]];
    let part = ((station - from) / (to - from).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    heights[behind - 1] + (heights[behind] - heights[behind - 1]) * part
}

fn rounded(height: f64) -> f64 {
    (height * STEPS).round() / STEPS
}
