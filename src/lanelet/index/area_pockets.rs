//! Ground beside the lanes that a straight line of an area's outline takes in: where it is much, or a road border runs through it, the
//! outline follows the bounds of the lanes instead.

use std::collections::BTreeSet;

use geo::Area;
use rstar::AABB;
use rstar::primitives::Line;
use rustc_hash::FxHashSet;

use super::area_outline::{AreaOutlines, SPIKE, VERTEX_AT_EDGE};
use super::extent;
use crate::geometry::{Point, Polyline, polygon, simple_ring};
use crate::lanelet::{LineString, PointId};

/// The least share of an area that lies under its lanes, if nodes of their bounds can make it so.
pub(super) const LEAST_UNDER_LANES: f64 = 0.92;
/// A node of a bound that is a vertex lies so close (m) to the edge of the lanes.
const ON_EDGE: f64 = 0.1;
/// Ground of less (m2) is no pocket: a vertex for it would say nothing.
const LEAST_POCKET: f64 = 0.2;
/// Road borders are looked at every so many metres.
const BORDER_STEP: f64 = 0.5;

/// A node of a bound along the edge of the lanes.
struct Candidate {
    station: f64,
    id: PointId,
    place: Point,
}

/// The ground between two vertices, one after the other, and the edge of the lanes.
struct Pocket {
    /// The place of the second vertex in the outline.
    at: usize,
    nodes: Vec<PointId>,
    area: f64,
    has_border: bool,
}

impl AreaOutlines<'_, '_> {
    /// The outline without pockets through which a road border runs, and without the largest others while too little of it is under the
    /// lanes. `edge` is that of the lanes, closed.
    pub(super) fn without_pockets(&self, lanes: &[usize], mut ring: Vec<PointId>, edge: &Polyline) -> Vec<PointId> {
        let outlines: Vec<Vec<Point>> = lanes.iter().map(|&lane| self.map.lanes[lane].outline.clone()).collect();
        let under = polygon::ground(&outlines).unsigned_area();
        let candidates = self.candidates(lanes, edge);
        let mut left: FxHashSet<[PointId; 2]> = FxHashSet::default();
        loop {
            let Some(places) = self.places(&ring) else { return ring };
            let is_enough = under >= LEAST_UNDER_LANES * polygon::signed_area(&places).abs();
            let pockets = self.pockets(&ring, &places, edge, &candidates);
            let open = pockets.into_iter().filter(|one| !left.contains(&ends(&ring, one.at)));
            let wanted = open.filter(|one| one.has_border || !is_enough);
            let order = |a: &Pocket, b: &Pocket| a.has_border.cmp(&b.has_border).then(a.area.total_cmp(&b.area));
            let Some(pocket) = wanted.max_by(order) else { return ring };
            let mut closer = ring.clone();
            closer.splice(pocket.at..pocket.at, pocket.nodes.iter().copied());
            let is_sound = self.places(&closer).is_some_and(|places| {
                simple_ring::faults(&places, SPIKE, 1).is_empty() && self.sticking_out_of(lanes, &places).is_empty()
            });
            match is_sound {
                true => ring = closer,
                false => _ = left.insert(ends(&ring, pocket.at)),
            }
        }
    }

    fn places(&self, ring: &[PointId]) -> Option<Vec<Point>> {
        ring.iter().map(|&id| self.place(id)).collect()
    }

    /// The nodes of the bounds of lanes that lie on their edge, in the order in which they lie there.
    fn candidates(&self, lanes: &[usize], edge: &Polyline) -> Vec<Candidate> {
        let bounds: BTreeSet<_> = lanes.iter().flat_map(|&lane| self.map.lanes[lane].bounds).collect();
        let lines = bounds.into_iter().filter_map(|way| self.map.map.linestrings.get(way));
        let is_outermost = |line: &LineString| self.map.users_of(line.id).len() == 1;
        // Beyond the bounds of one lane alone nothing is known to be a road.
        let nodes = lines.flat_map(|line| line.points.iter().map(move |&id| (id, is_outermost(line))));
        let nodes = nodes.filter(|(id, is_outermost)| *is_outermost || self.borders.contains_key(id));
        let ids: BTreeSet<PointId> = nodes.map(|(id, _)| id).collect();
        let candidates = ids.into_iter().filter_map(|id| {
            let place = self.place(id)?;
            let foot = edge.project(place);
            (foot.offset.abs() <= ON_EDGE).then_some(Candidate { station: foot.station, id, place })
        });
        let mut candidates: Vec<Candidate> = candidates.collect();
        candidates.sort_by(|a, b| a.station.total_cmp(&b.station).then(a.id.cmp(&b.id)));
        candidates
    }

    /// What lies between the outline and the edge, vertex by vertex.
    fn pockets(&self, ring: &[PointId], places: &[Point], edge: &Polyline, nodes: &[Candidate]) -> Vec<Pocket> {
        let known: FxHashSet<PointId> = ring.iter().copied().collect();
        let stations: Vec<f64> = places.iter().map(|&place| edge.project(place).station).collect();
        let next = |at: usize| (at + 1) % ring.len().max(1);
        let pocket = |at: usize| {
            let (from, to) = (*stations.get(at)?, *stations.get(next(at))?);
            let is_free = |one: &&Candidate| !known.contains(&one.id);
            let within = |low: f64, high: f64| {
                nodes.iter().filter(move |one| low < one.station && one.station < high).filter(is_free)
            };
            let between: Vec<&Candidate> = match from <= to {
                true => within(from, to).collect(),
                false => within(from, f64::INFINITY).chain(within(f64::NEG_INFINITY, to)).collect(),
            };
            let [start, end] = [*places.get(at)?, *places.get(next(at))?];
            let outline: Vec<Point> =
                [start].into_iter().chain(between.iter().map(|one| one.place)).chain([end]).collect();
            let area = polygon::signed_area(&outline).abs();
            let has_border = area > LEAST_POCKET && self.has_border(&outline, [start, end]);
            let nodes = between.into_iter().map(|one| one.id).collect();
            (area > LEAST_POCKET).then_some(Pocket { at: at + 1, nodes, area, has_border })
        };
        (0..ring.len()).filter_map(pocket).collect()
    }

    /// Whether a road border runs through a pocket, and not only along the line that it lies on.
    fn has_border(&self, outline: &[Point], [start, end]: [Point; 2]) -> bool {
        let [low, high] = extent(outline);
        let near = AABB::from_corners([low.x, low.y], [high.x, high.y]);
        let Some(line) = Polyline::new([start, end]) else { return false };
        let runs_through = |piece: &Line<[f64; 2]>| {
            let piece = Polyline::new([Point::from(piece.from), Point::from(piece.to)]);
            let is_inside = |place: Point| polygon::contains(outline, place) && line.distance(place) > VERTEX_AT_EDGE;
            piece.is_some_and(|piece| piece.places(BORDER_STEP).any(is_inside))
        };
        self.pieces.locate_in_envelope_intersecting(&near).any(runs_through)
    }
}

/// The vertices before and at a place of an outline.
fn ends(ring: &[PointId], at: usize) -> [PointId; 2] {
    let of = |at: usize| ring.get(at % ring.len().max(1)).copied().unwrap_or(PointId(0));
    [of(at + ring.len().saturating_sub(1)), of(at)]
}
