//! Corners of an area between lanes that cross: where the bounds have no node there, the outline gets a new one on a bound.

use std::collections::BTreeSet;

use geo::Area;
use rustc_hash::FxHashSet;

use super::area_outline::{AreaOutlines, Corner, Outline, SPIKE};
use super::area_pockets::LEAST_UNDER_LANES;
use crate::geometry::{Point, Polyline, polygon, simple_ring};
use crate::lanelet::PointId;

/// A corner lies at least so far (m) inside the straight line between the vertices beside it.
const LEAST_DEPTH: f64 = 0.5;
/// The edge of the lanes is round in a corner, because narrow gaps are filled: the bound lies no farther (m) from it.
const ROUNDED: f64 = 1.5;
/// Corners of an area at most.
const MOST_CORNERS: usize = 16;

/// A vertex while corners are looked for.
#[derive(Clone, Copy)]
struct Vertex {
    place: Point,
    /// The node, where the map has it.
    node: Option<PointId>,
    /// Where it is new.
    corner: Option<([PointId; 2], f64)>,
}

impl AreaOutlines<'_, '_> {
    /// The outline with corners in the deepest bays between lanes, as long as too little of it is under them.
    pub(super) fn with_corners(&self, lanes: &[usize], points: Vec<PointId>, edge: &Polyline) -> Outline {
        let vertex = |&id: &PointId| Some(Vertex { place: self.place(id)?, node: Some(id), corner: None });
        let mut ring: Vec<Vertex> = points.iter().filter_map(vertex).collect();
        let outlines: Vec<Vec<Point>> = lanes.iter().map(|&lane| self.map.lanes[lane].outline.clone()).collect();
        let under = polygon::ground(&outlines).unsigned_area();
        let stations = edge.stations();
        let mut left: FxHashSet<[u64; 2]> = FxHashSet::default();
        for _ in 0..MOST_CORNERS {
            if under >= LEAST_UNDER_LANES * polygon::signed_area(&places_of(&ring)).abs() {
                break;
            }
            let is_kerb = |at: &usize| self.is_along_border(&ring, *at);
            let bays = (0..ring.len()).filter(|at| !is_kerb(at)).filter_map(|at| deepest(&ring, at, edge, &stations));
            let open = bays.filter(|bay| !left.contains(&bits(bay.deepest)));
            let Some(bay) = open.max_by(|a, b| a.area.total_cmp(&b.area)) else { break };
            left.insert(bits(bay.deepest));
            let Some(vertex) = self.on_bound(lanes, bay.deepest) else { continue };
            let mut closer = ring.clone();
            closer.insert(bay.at + 1, vertex);
            let places = places_of(&closer);
            if simple_ring::faults(&places, SPIKE, 1).is_empty() && self.sticking_out_of(lanes, &places).is_empty() {
                ring = closer;
            }
        }
        let mut corners = Vec::new();
        let mut before = 0;
        for vertex in ring {
            match vertex.corner {
                Some((ends, share)) => corners.push(Corner { before, ends, share }),
                None => before += 1,
            }
        }
        Outline { points, corners }
    }

    /// Whether a road border leads from a vertex to the next: the area reaches as far.
    fn is_along_border(&self, ring: &[Vertex], at: usize) -> bool {
        let next = ring.get((at + 1) % ring.len().max(1));
        let nodes = ring.get(at).and_then(|one| one.node).zip(next.and_then(|one| one.node));
        nodes.is_some_and(|(from, to)| self.borders.get(&from).is_some_and(|beside| beside.contains(&to)))
    }

    /// The place of a corner.
    pub(super) fn place_of_corner(&self, corner: &Corner) -> Option<Point> {
        let [from, to] = corner.ends.map(|id| self.place(id));
        let (from, to) = from.zip(to)?;
        Some(from + (to - from) * corner.share)
    }

    /// The place on the nearest bound of one of the lanes, between two of its nodes.
    fn on_bound(&self, lanes: &[usize], place: Point) -> Option<Vertex> {
        let bounds: BTreeSet<_> = lanes.iter().flat_map(|&lane| self.map.lanes[lane].bounds).collect();
        // Beyond the bounds of one lane alone nothing is known to be a road.
        let outermost = bounds.into_iter().filter(|&way| self.map.users_of(way).len() == 1);
        let lines = outermost.filter_map(|way| self.map.map.linestrings.get(way));
        let pieces = lines.flat_map(|line| line.points.iter().zip(line.points.iter().skip(1)));
        let feet = pieces.filter_map(|(&from, &to)| {
            let line = Polyline::new([self.place(from)?, self.place(to)?])?;
            let foot = line.project(place);
            let share = foot.station / line.length();
            let is_apart = foot.station.min(line.length() - foot.station) >= LEAST_DEPTH;
            is_apart.then_some((foot.offset.abs(), [from, to], share, foot.point))
        });
        let (distance, ends, share, place) = feet.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        (distance <= ROUNDED).then_some(Vertex { place, node: None, corner: Some((ends, share)) })
    }
}

/// Ground between a straight piece of an outline and the edge of the lanes.
struct Bay {
    /// The place of the vertex before it.
    at: usize,
    area: f64,
    deepest: Point,
}

fn deepest(ring: &[Vertex], at: usize, edge: &Polyline, stations: &[f64]) -> Option<Bay> {
    let [start, end] = [ring.get(at)?.place, ring.get((at + 1) % ring.len())?.place];
    let [from, to] = [start, end].map(|place| edge.project(place).station);
    let points = || edge.points().iter().zip(stations);
    let within =
        |low: f64, high: f64| points().filter(move |(_, at)| low < **at && **at < high).map(|(point, _)| *point);
    let between: Vec<Point> = match from <= to {
        true => within(from, to).collect(),
        false => within(from, f64::INFINITY).chain(within(f64::NEG_INFINITY, to)).collect(),
    };
    let chord = Polyline::new([start, end])?;
    let depth = |place: &Point| chord.distance(*place);
    let deepest = between.iter().copied().max_by(|a, b| depth(a).total_cmp(&depth(b)))?;
    let outline: Vec<Point> = [start].into_iter().chain(between).chain([end]).collect();
    (depth(&deepest) >= LEAST_DEPTH).then(|| Bay { at, area: polygon::signed_area(&outline).abs(), deepest })
}

fn places_of(ring: &[Vertex]) -> Vec<Point> {
    ring.iter().map(|one| one.place).collect()
}

fn bits(place: Point) -> [u64; 2] {
    [place.x.to_bits(), place.y.to_bits()]
}
