//! The outline that an intersection area would have around given lanes, over nodes that the map has.

use std::collections::BTreeSet;

use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};
use rustc_hash::FxHashSet;

use super::queries::is_road_border;
use super::thresholds;
use super::types::MapIndex;
use crate::geometry::{Point, Polyline, polygon, simple_ring};
use crate::lanelet::PointId;

/// Gaps between lanes up to twice this width (m) belong to the intersection: a median, a strip of paint.
const CLOSED: f64 = 2.0;
/// A node of a road border this close (m) to the edge of the lanes is a vertex.
const NEAR: f64 = 0.3;
/// The end of a lane is a vertex even where it lies farther (m) inside: lanes of one approach do not all end on one line.
const STAGGERED: f64 = 3.0;
/// Other nodes of the lanes' bounds are vertices only where they lie on the edge (m).
const ON_EDGE: f64 = 0.05;
/// An outline that folds back within this angle (deg) has a spike.
const SPIKE: f64 = 1.0;

/// The number of rounds after which an outline is given up that takes in more lanes each time it is drawn.
const MOST_ROUNDS: usize = 3;

/// Draws outlines; holds the nodes of all road borders by place.
pub struct AreaOutlines<'i, 'm> {
    map: &'i MapIndex<'m>,
    borders: FxHashSet<PointId>,
    tree: RTree<GeomWithData<[f64; 2], PointId>>,
}

/// A node that may become a vertex.
#[derive(Clone, Copy)]
struct Vertex {
    /// Where it lies along the edge, metres.
    station: f64,
    /// How far from it, metres.
    distance: f64,
    id: PointId,
    place: Point,
}

impl<'i, 'm> AreaOutlines<'i, 'm> {
    /// For a map.
    pub fn new(map: &'i MapIndex<'m>) -> Self {
        let lines = map.map.linestrings.iter().filter(|line| is_road_border(line));
        let borders: FxHashSet<PointId> = lines.flat_map(|line| line.points.iter().copied()).collect();
        let mut ids: Vec<PointId> = borders.iter().copied().collect();
        ids.sort_unstable();
        let places = ids.into_iter().filter_map(|id| {
            let place = map.map.points.get(id)?.position;
            let finite = place.x.is_finite() && place.y.is_finite();
            finite.then(|| GeomWithData::new([place.x, place.y], id))
        });
        Self { tree: RTree::bulk_load(places.collect()), borders, map }
    }

    /// The vertices, clockwise, of a simple outline that covers all of the lanes: their end nodes, nodes of road borders along
    /// their edge, and no others but where a lane would stick out. `None` if there is no such outline.
    pub fn around(&self, lanes: &[usize]) -> Option<Vec<PointId>> {
        let outlines: Vec<Vec<Point>> = lanes.iter().map(|&lane| self.map.lanes[lane].outline.clone()).collect();
        let edge = polygon::closed(&outlines, CLOSED)?;
        let edge = Polyline::new(edge.iter().chain(edge.first()).copied())?;
        let ends = self.ends(lanes, &edge);
        let on_border = self.on_border(&edge, &ends);
        [STAGGERED, NEAR].into_iter().find_map(|reach| {
            let mut vertices: Vec<Vertex> = ends.iter().filter(|one| one.distance <= reach).copied().collect();
            let fixed: FxHashSet<PointId> = vertices.iter().map(|one| one.id).collect();
            vertices.extend(&on_border);
            let ring = in_order(vertices.clone(), &fixed)?;
            let out = self.sticking_out(lanes, &ring);
            if out.is_empty() {
                return Some(ids(&ring));
            }
            vertices.extend(self.on_bounds(&out, &edge));
            let ring = in_order(vertices, &fixed)?;
            self.sticking_out(lanes, &ring).is_empty().then(|| ids(&ring))
        })
    }

    /// The outline around some lanes and around those that lie inside it, on their level and in no other area; and all of them.
    pub fn around_with_covered(&self, lanes: &[usize]) -> Option<(Vec<PointId>, Vec<usize>)> {
        let mut all = lanes.to_vec();
        for _ in 0..MOST_ROUNDS {
            let points = self.around(&all)?;
            let covered = self.covered(&all, &points);
            if covered.is_empty() {
                return Some((points, all));
            }
            all.extend(covered);
            all.sort_unstable();
        }
        None
    }

    /// Other lanes for vehicles inside an outline around some lanes.
    fn covered(&self, lanes: &[usize], points: &[PointId]) -> Vec<usize> {
        let map = self.map;
        let places = points.iter().filter_map(|&id| Some(map.map.points.get(id)?.position));
        let ring: Vec<Point> = places.collect();
        let [low, high] = super::extent(&ring);
        let height = lanes.iter().map(|&lane| map.lanes[lane].heights[0]).sum::<f64>() / lanes.len().max(1) as f64;
        let is_covered = |&at: &usize| {
            let lane = &map.lanes[at];
            let is_free = lane.is_drivable() && lane.simple && !map.has_area(at) && lanes.binary_search(&at).is_err();
            is_free
                && (lane.heights[0] - height).abs() <= thresholds::GRADE_SEPARATION
                && polygon::common_area(&lane.outline, &ring) >= thresholds::COVER * lane.area
        };
        map.lanes_near(low, high).into_iter().filter(is_covered).collect()
    }

    /// The end nodes of lanes that are not inside, where one lane follows another.
    fn ends(&self, lanes: &[usize], edge: &Polyline) -> Vec<Vertex> {
        let of = |lane: &usize| {
            let lane = &self.map.lanes[*lane];
            [(lane.start, true), (lane.end, false)]
        };
        let all: Vec<_> = lanes.iter().flat_map(of).collect();
        let sides = |start: bool| -> FxHashSet<[PointId; 2]> {
            all.iter().filter(|one| one.1 == start).map(|one| one.0.ids).collect()
        };
        let [starts, ends] = [sides(true), sides(false)];
        let outer = all.iter().filter(|(end, start)| !if *start { &ends } else { &starts }.contains(&end.ids));
        let nodes = outer.flat_map(|(end, _)| end.ids.into_iter().zip(end.points));
        let mut seen = FxHashSet::default();
        nodes.filter(|(id, _)| seen.insert(*id)).map(|(id, place)| Vertex::of(edge, id, place)).collect()
    }

    /// Nodes of road borders along the edge.
    fn on_border(&self, edge: &Polyline, ends: &[Vertex]) -> Vec<Vertex> {
        let known: FxHashSet<PointId> = ends.iter().map(|one| one.id).collect();
        let [low, high] = super::extent(edge.points());
        let reach = AABB::from_corners([low.x - NEAR, low.y - NEAR], [high.x + NEAR, high.y + NEAR]);
        let near = self.tree.locate_in_envelope(&reach).filter(|one| !known.contains(&one.data));
        let vertices = near.map(|one| Vertex::of(edge, one.data, Point::from(*one.geom())));
        let mut found: Vec<Vertex> = vertices.filter(|one| one.distance <= NEAR).collect();
        found.sort_by_key(|one| one.id);
        found
    }

    /// Nodes of these lanes' own bounds along the edge that are on no road border.
    fn on_bounds(&self, lanes: &[usize], edge: &Polyline) -> Vec<Vertex> {
        let bounds: BTreeSet<_> = lanes.iter().flat_map(|&lane| self.map.lanes[lane].bounds).collect();
        let lines = bounds.into_iter().filter_map(|way| self.map.map.linestrings.get(way));
        let nodes = lines.flat_map(|line| &line.points).filter(|id| !self.borders.contains(id));
        let vertices = nodes.filter_map(|&id| Some(Vertex::of(edge, id, self.map.map.points.get(id)?.position)));
        vertices.filter(|one| one.distance <= ON_EDGE).collect()
    }

    /// Lanes of which the outline covers too little.
    fn sticking_out(&self, lanes: &[usize], ring: &[Vertex]) -> Vec<usize> {
        let ring: Vec<Point> = ring.iter().map(|one| one.place).collect();
        let sticks_out = |lane: &usize| {
            let lane = &self.map.lanes[*lane];
            polygon::common_area(&lane.outline, &ring) < thresholds::COVER * lane.area
        };
        lanes.iter().copied().filter(sticks_out).collect()
    }
}

impl Vertex {
    fn of(edge: &Polyline, id: PointId, place: Point) -> Self {
        let foot = edge.project(place);
        Self { station: foot.station, distance: foot.offset.abs(), id, place }
    }
}

/// The vertices along the edge, each once, without those that make the outline cross itself; `None` if it does all the same.
fn in_order(mut vertices: Vec<Vertex>, fixed: &FxHashSet<PointId>) -> Option<Vec<Vertex>> {
    vertices
        .sort_by(|a, b| a.station.total_cmp(&b.station).then(a.distance.total_cmp(&b.distance)).then(a.id.cmp(&b.id)));
    let mut seen = FxHashSet::default();
    vertices.retain(|one| seen.insert(one.id));
    let places: Vec<Point> = vertices.iter().map(|one| one.place).collect();
    let kept = simple_ring::without_faults(&places, SPIKE, |at| fixed.contains(&vertices[at].id));
    let ring: Vec<Vertex> = kept.into_iter().map(|at| vertices[at]).collect();
    let places: Vec<Point> = ring.iter().map(|one| one.place).collect();
    simple_ring::faults(&places, SPIKE, 1).is_empty().then_some(ring)
}

fn ids(ring: &[Vertex]) -> Vec<PointId> {
    ring.iter().map(|one| one.id).collect()
}
