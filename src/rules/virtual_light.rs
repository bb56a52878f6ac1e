//! What vm-03-16, 17 and 18 have in common: virtual traffic lights, and the sections of road that they guard.

use std::collections::VecDeque;

use rustc_hash::FxHashSet;

use crate::geometry::{Point, Polyline, line_crossing, polygon, segment_crossing};
use crate::lanelet::index::{Lane, MapIndex};
use crate::lanelet::{LaneletId, LineStringId, RegulatoryElement};

/// What a virtual traffic light of an intersection refers to.
pub const ANCHOR: &str = "intersection_coordination";

/// A line may end this much (m) before the middle of the lane that it crosses, or lie this far outside the way's ends.
const EXTRA: f64 = 0.5;

/// The largest distance (m) of the start line before the intersection: within it vehicles and infrastructure reach each other.
const START_LINE_WITHIN: f64 = 200.0;

/// The virtual traffic lights of intersections. Others hold back vehicles at shutters and gates, and are free in form.
pub fn lights<'m>(map: &'m MapIndex) -> impl Iterator<Item = &'m RegulatoryElement> + 'm {
    let all = map.map.regulatory_elements.iter().filter(|element| element.subtype == "virtual_traffic_light");
    all.filter(|light| at_intersection(map, light))
}

/// By what it refers to, or else by the lanelets that refer to it: those turn, or are part of an intersection.
fn at_intersection(map: &MapIndex, light: &RegulatoryElement) -> bool {
    let anchor = |way| map.map.linestrings.get(way).is_some_and(|line| line.attributes.is("type", ANCHOR));
    let mut lanes = map.referrers(light.id).iter().filter_map(|&id| map.lane(id));
    light.linestrings("refers").any(anchor)
        || lanes.any(|lane| map.movement(lane).is_some() || map.turn_direction(lane).is_some())
}

/// Whether a virtual traffic light of an intersection rules a lanelet.
pub fn is_coordinated(map: &MapIndex, lanelet: LaneletId) -> bool {
    map.elements(lanelet, "virtual_traffic_light").any(|light| at_intersection(map, light))
}

/// The way through one lanelet that a light guards: from its start line to its end line.
#[derive(Debug)]
pub struct Section<'m> {
    /// The light.
    pub light: &'m RegulatoryElement,
    /// The lanes from the start line to the lanelet that refers to the light, by position.
    pub path: Vec<usize>,
    /// Where along the path (m) the start line lies ...
    pub start: f64,
    /// ... the stop line, if the light has one ...
    pub stop: Option<f64>,
    /// ... and the end line.
    pub end: f64,
}

/// Why a light guards no section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// No end line crosses the lanelet.
    NoEnd,
    /// The start line touches this lanelet, which refers to the light.
    StartInside(LineStringId, LaneletId),
    /// No lane leads from the start line to the lanelet.
    NoWay(LineStringId),
    /// The stop line does not cross the way.
    StopOff(LineStringId),
}

/// The sections of a light through one of the lanelets that refer to it, one for each way there; none if it has no start
/// line, which keeps it from loading.
pub fn sections<'m>(map: &MapIndex, light: &'m RegulatoryElement, lane: usize) -> Result<Vec<Section<'m>>, Broken> {
    let first = |role| light.linestrings(role).next().and_then(|way| Some((way, ends(map, way)?)));
    let (Some((start_line, start)), Some(center)) = (first("start_line"), &map.lanes[lane].center) else {
        return Ok(Vec::new());
    };
    let inside = map.referrers(light.id).iter().filter_map(|&id| map.lane_of(id));
    if let Some(touched) = inside.filter(|lane| touches(start, lane)).map(|lane| lane.id).min() {
        return Err(Broken::StartInside(start_line, touched));
    }
    let crossing = light.linestrings("end_line").filter_map(|way| {
        let points = ends(map, way)?;
        station(center, points).map(|_| points)
    });
    // Lines of neighbouring exits may reach over this lanelet; the line of this lanelet has its middle on it.
    let off = |[a, b]: &[Point; 2]| center.distance(nalgebra::center(a, b));
    let end = crossing.min_by(|a, b| off(a).total_cmp(&off(b))).ok_or(Broken::NoEnd)?;
    let ways = ways_from(map, start, lane);
    if ways.is_empty() {
        return Err(Broken::NoWay(start_line));
    }
    let mut sections = Vec::new();
    for path in ways {
        let centers = path.iter().filter_map(|&at| map.lanes[at].center.as_ref());
        let Some(line) = Polyline::new(centers.flat_map(|center| center.points().iter().copied())) else { continue };
        let stop = first("ref_line").map(|(way, points)| station(&line, points).ok_or(Broken::StopOff(way)));
        let (Some(start), Some(end)) = (station(&line, start), station(&line, end)) else { continue };
        sections.push(Section { light, path, start, stop: stop.transpose()?, end });
    }
    Ok(sections)
}

/// From every lane that a line crosses the shortest way, by lanes, to this one, both included.
fn ways_from(map: &MapIndex, line: [Point; 2], lane: usize) -> Vec<Vec<usize>> {
    // Each lane with the one ahead of it, and the distance between its end and the last lane.
    let mut seen: Vec<(usize, Option<usize>, f64)> = vec![(lane, None, 0.0)];
    let mut known = FxHashSet::from_iter([lane]);
    let mut open = VecDeque::from([0]);
    let mut ways = Vec::new();
    while let Some(at) = open.pop_front() {
        let (current, _, ahead) = seen[at];
        let center = map.lanes[current].center.as_ref();
        if at > 0 && center.is_some_and(|center| station(center, line).is_some()) {
            ways.push(std::iter::successors(Some(at), |&at| seen[at].1).map(|at| seen[at].0).collect());
            continue;
        }
        let ahead = if at > 0 { ahead + map.lanes[current].length() } else { 0.0 };
        for &before in map.predecessors(current).iter().filter(|_| ahead <= START_LINE_WITHIN) {
            if known.insert(before) {
                seen.push((before, Some(at), ahead));
                open.push_back(seen.len() - 1);
            }
        }
    }
    ways
}

/// Both ends of a line.
fn ends(map: &MapIndex, way: LineStringId) -> Option<[Point; 2]> {
    map.stop_line(way).map(|line| line.ends)
}

/// Where along a centre line (m) a line across crosses it, both a little prolonged.
fn station(center: &Polyline, [a, b]: [Point; 2]) -> Option<f64> {
    let segments = center.segments();
    let last = segments.len() - 1;
    let across = b - a;
    let beyond = EXTRA / across.norm();
    let mut driven = 0.0;
    for (at, (from, to)) in segments.enumerate() {
        let length = (to - from).norm();
        let before = if at == 0 { EXTRA / length } else { 0.0 };
        let behind = if at == last { EXTRA / length } else { 0.0 };
        if let Some((s, t, _)) = line_crossing(from, to - from, a, across)
            && (-before..=1.0 + behind).contains(&s)
            && (-beyond..=1.0 + beyond).contains(&t)
        {
            return Some(driven + s * length);
        }
        driven += length;
    }
    None
}

/// Whether a line lies on a lane, at least in part.
fn touches([a, b]: [Point; 2], lane: &Lane) -> bool {
    let ring = &lane.outline;
    let mut edges = ring.iter().zip(ring.iter().cycle().skip(1));
    polygon::contains(ring, a)
        || polygon::contains(ring, b)
        || edges.any(|(&c, &d)| segment_crossing(a, b, c, d).is_some())
}
