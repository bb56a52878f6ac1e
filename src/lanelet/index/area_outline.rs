//! The outline that an intersection area would have around given lanes, over nodes that the map has.

use std::collections::BTreeSet;

use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};
use rustc_hash::{FxHashMap, FxHashSet};

use super::area_ground::{Undrawn, too_bare};
use super::filled_unions::FILLED;
use super::queries::is_road_border;
use super::thresholds;
use super::types::MapIndex;
use crate::geometry::{Point, Polyline, polygon, simple_ring};
use crate::lanelet::PointId;

/// A node of a road border this close (m) to the edge of the lanes is a vertex.
pub(super) const VERTEX_AT_EDGE: f64 = 0.3;
/// The end of a lane is a vertex even where it lies farther (m) inside: lanes of one approach do not all end on one line.
const STAGGERED: f64 = 3.0;
/// Other nodes of the lanes' bounds are vertices only where they lie on the edge (m).
const ON_EDGE: f64 = 0.05;
/// An outline that folds back within this angle (deg) has a spike.
pub(super) const SPIKE: f64 = 1.0;

/// A road border that leads from one vertex to the next is no longer than so many times their distance: it runs around a corner, and not
/// around a block.
const LONGEST_BORDER: f64 = 3.0;
/// The number of rounds after which an outline is given up that takes in more lanes each time it is drawn.
const MOST_ROUNDS: usize = 3;

/// A vertex on a bound, between two nodes that follow each other on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The place among the other vertices before which it comes.
    pub before: usize,
    /// The nodes beside it.
    pub ends: [PointId; 2],
    /// How far it is from the first to the second, 0 to 1.
    pub share: f64,
}

/// The vertices of an area: nodes that the map has, in order, and new ones between them.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Those that the map has.
    pub points: Vec<PointId>,
    /// The new ones, in order.
    pub corners: Vec<Corner>,
}

/// Draws outlines; holds the nodes of all road borders by place.
pub struct AreaOutlines<'i, 'm> {
    pub(super) map: &'i MapIndex<'m>,
    /// The nodes of road borders, each with those beside it on one of them.
    pub(super) borders: FxHashMap<PointId, Vec<PointId>>,
    tree: RTree<GeomWithData<[f64; 2], PointId>>,
    /// The pieces of road borders by place.
    pub(super) pieces: RTree<Line<[f64; 2]>>,
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
        let mut borders: FxHashMap<PointId, Vec<PointId>> = FxHashMap::default();
        let mut link = |from: PointId, to: PointId| {
            let beside = borders.entry(from).or_default();
            if from != to && !beside.contains(&to) {
                beside.push(to);
            }
        };
        for line in map.map.linestrings.iter().filter(|line| is_road_border(line)) {
            for (&from, &to) in line.points.iter().zip(line.points.iter().skip(1)) {
                link(from, to);
                link(to, from);
            }
        }
        let lines = map.map.linestrings.iter().filter(|line| is_road_border(line));
        let pieces = lines.flat_map(|line| line.points.iter().zip(line.points.iter().skip(1)));
        let pieces = pieces.filter_map(|(&from, &to)| {
            let [from, to] = [from, to].map(|id| map.map.points.get(id).map(|point| point.position));
            let (from, to) = from.zip(to)?;
            let is_finite = [from, to].iter().all(|place| place.x.is_finite() && place.y.is_finite());
            is_finite.then(|| Line::new([from.x, from.y], [to.x, to.y]))
        });
        let pieces = RTree::bulk_load(pieces.collect());
        let mut ids: Vec<PointId> = borders.keys().copied().collect();
        ids.sort_unstable();
        let places = ids.into_iter().filter_map(|id| {
            let place = map.map.points.get(id)?.position;
            let finite = place.x.is_finite() && place.y.is_finite();
            finite.then(|| GeomWithData::new([place.x, place.y], id))
        });
        Self { tree: RTree::bulk_load(places.collect()), pieces, borders, map }
    }

    /// The vertices, clockwise, of a simple outline that covers all of the lanes: their end nodes, nodes of road borders along
    /// their edge and around the corners between them, and no others but where a lane would stick out.
    ///
    /// # Errors
    ///
    /// Why there is no such outline.
    pub fn around(&self, lanes: &[usize]) -> Result<Outline, Undrawn> {
        let outline = self.drawn_around(lanes).ok_or(Undrawn::Tangled)?;
        match too_bare(self.map, lanes, &self.ring_of(&outline)) {
            Some(why) => Err(why),
            None => Ok(outline),
        }
    }

    /// The places of all vertices, in order.
    fn ring_of(&self, outline: &Outline) -> Vec<Point> {
        let mut ring: Vec<Point> = outline.points.iter().filter_map(|&id| self.place(id)).collect();
        for corner in outline.corners.iter().rev() {
            let at = corner.before.min(ring.len());
            ring.splice(at..at, self.place_of_corner(corner));
        }
        ring
    }

    fn drawn_around(&self, lanes: &[usize]) -> Option<Outline> {
        let outlines: Vec<Vec<Point>> = lanes.iter().map(|&lane| self.map.lanes[lane].outline.clone()).collect();
        let edge = self.map.filled_union(&outlines)?;
        let edge = Polyline::new(edge.iter().chain(edge.first()).copied())?;
        let ends = self.ends(lanes, &edge);
        let on_border = self.on_border(&edge, &ends);
        [STAGGERED, VERTEX_AT_EDGE].into_iter().find_map(|reach| {
            let mut vertices: Vec<Vertex> = ends.iter().filter(|one| one.distance <= reach).copied().collect();
            let fixed: FxHashSet<PointId> = vertices.iter().map(|one| one.id).collect();
            vertices.extend(&on_border);
            let ring = in_order(vertices.clone(), &fixed)?;
            let out = self.sticking_out(lanes, &ring);
            if out.is_empty() {
                return Some(self.finished(lanes, &ring, &edge));
            }
            vertices.extend(self.on_bounds(&out, &edge));
            let ring = in_order(vertices, &fixed)?;
            self.sticking_out(lanes, &ring).is_empty().then(|| self.finished(lanes, &ring, &edge))
        })
    }

    /// The outline with its corners along kerbs, without pockets.
    fn finished(&self, lanes: &[usize], ring: &[Vertex], edge: &Polyline) -> Outline {
        let ring = self.without_pockets(lanes, self.around_corners(lanes, ids(ring)), edge);
        self.with_corners(lanes, ring, edge)
    }

    /// The outline, with the road border in place of each straight line between two vertices that it links: where nobody turns,
    /// the lanes leave the corner to the other side of the kerb. Where the map has no border there, the outer bound of one of the
    /// lanes takes its place: beyond it nothing is known to be a road.
    fn around_corners(&self, lanes: &[usize], mut ring: Vec<PointId>) -> Vec<PointId> {
        let mut at = 0;
        while let Some(&from) = ring.get(at) {
            at += 1;
            let to = ring.get(at).or(ring.first()).copied();
            let Some(to) = to.filter(|&to| self.is_wider_than_a_median(from, to)) else { continue };
            let corner = self.border_between(from, to, &ring).or_else(|| self.bound_between(lanes, [from, to], &ring));
            let Some(corner) = corner else { continue };
            let count = corner.len();
            let mut longer = ring.clone();
            longer.splice(at..at, corner);
            let places: Option<Vec<Point>> = longer.iter().map(|&id| self.place(id)).collect();
            let is_sound = places.is_some_and(|places| {
                simple_ring::faults(&places, SPIKE, 1).is_empty() && self.sticking_out_of(lanes, &places).is_empty()
            });
            if is_sound {
                ring = longer;
                at += count;
            }
        }
        ring
    }

    /// Whether two vertices are farther apart than a median is wide: across it an outline runs straight.
    fn is_wider_than_a_median(&self, from: PointId, to: PointId) -> bool {
        let places = self.place(from).zip(self.place(to));
        places.is_some_and(|(from, to)| (from - to).norm() > 2.0 * FILLED)
    }

    /// The nodes of the road border that leads from one vertex to another and forks nowhere; the shorter one, where two do.
    fn border_between(&self, from: PointId, to: PointId, ring: &[PointId]) -> Option<Vec<PointId>> {
        let apart = (self.place(from)? - self.place(to)?).norm();
        let walk = |&first: &PointId| {
            let mut nodes = vec![from, first];
            let mut length = 0.0;
            while let [.., before, at] = nodes[..] {
                length += (self.place(before)? - self.place(at)?).norm();
                if at == to {
                    break;
                }
                let mut ahead = self.borders.get(&at)?.iter().filter(|&&next| next != before);
                let (Some(&next), None) = (ahead.next(), ahead.next()) else { return None };
                if length > LONGEST_BORDER * apart || ring.contains(&at) {
                    return None;
                }
                nodes.push(next);
            }
            let between = nodes.get(1..nodes.len() - 1)?.to_vec();
            (!between.is_empty()).then_some((length, between))
        };
        let ways = self.borders.get(&from)?.iter().filter_map(walk);
        ways.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, nodes)| nodes)
    }

    /// The nodes between two vertices on a bound of one of the lanes beyond which no lane lies, if it leads around a corner.
    fn bound_between(&self, lanes: &[usize], [from, to]: [PointId; 2], ring: &[PointId]) -> Option<Vec<PointId>> {
        let bounds = lanes.iter().flat_map(|&lane| [0, 1].map(|side| (lane, side)));
        bounds.filter(|&(lane, side)| self.is_outermost(lane, side)).find_map(|(lane, side)| {
            let way = self.map.lanes[lane].bounds[side];
            let points = &self.map.map.linestrings.get(way)?.points;
            let at = |id: PointId| points.iter().position(|&one| one == id);
            let (first, last) = (at(from)?, at(to)?);
            let mut between = points.get(first.min(last) + 1..first.max(last))?.to_vec();
            if last < first {
                between.reverse();
            }
            let is_free = !between.iter().any(|id| ring.contains(id));
            (is_free && self.is_bent([from, to], &between)?).then_some(between)
        })
    }

    /// Whether no lane lies beyond a bound of a lane, 0 the left one, or beside the lanes before and behind it.
    fn is_outermost(&self, lane: usize, side: usize) -> bool {
        let around = self.map.predecessors(lane).iter().chain(self.map.followers(lane)).copied();
        let alone = |lane: usize| self.map.users_of(self.map.lanes[lane].bounds[side]).len() == 1;
        std::iter::once(lane).chain(around).all(alone)
    }

    /// Whether a line of these nodes leaves the straight line between two places, and leads around a corner rather than a block.
    fn is_bent(&self, [from, to]: [PointId; 2], between: &[PointId]) -> Option<bool> {
        let chord = Polyline::new([self.place(from)?, self.place(to)?])?;
        let places: Vec<Point> = between.iter().map(|&id| self.place(id)).collect::<Option<_>>()?;
        let [start, end] = [chord.points()[0], chord.points()[1]];
        let line = Polyline::new([start].into_iter().chain(places.iter().copied()).chain([end]))?;
        let leaves = places.iter().any(|&place| chord.project(place).offset.abs() > VERTEX_AT_EDGE);
        Some(leaves && line.length() <= LONGEST_BORDER * chord.length())
    }

    pub(super) fn place(&self, id: PointId) -> Option<Point> {
        Some(self.map.map.points.get(id)?.position)
    }

    /// The outline around some lanes and around those that lie inside it, on their level and in no other area; and all of them.
    ///
    /// # Errors
    ///
    /// Why there is no such outline.
    pub fn around_with_covered(&self, lanes: &[usize]) -> Result<(Outline, Vec<usize>), Undrawn> {
        let mut all = lanes.to_vec();
        for _ in 0..MOST_ROUNDS {
            let outline = self.around(&all)?;
            let covered = self.covered(&all, &outline);
            if covered.is_empty() {
                return Ok((outline, all));
            }
            all.extend(covered);
            all.sort_unstable();
        }
        Err(Undrawn::Tangled)
    }

    /// Other lanes for vehicles, buses among them, inside an outline around some lanes.
    fn covered(&self, lanes: &[usize], outline: &Outline) -> Vec<usize> {
        let map = self.map;
        let ring = self.ring_of(outline);
        let [low, high] = super::extent(&ring);
        let height = lanes.iter().map(|&lane| map.lanes[lane].heights[0]).sum::<f64>() / lanes.len().max(1) as f64;
        let is_covered = |&at: &usize| {
            let lane = &map.lanes[at];
            let is_lane = lane.is_drivable() || lane.is_for_buses();
            let is_free = is_lane && lane.simple && !map.has_area(at) && lanes.binary_search(&at).is_err();
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
        let reach = AABB::from_corners(
            [low.x - VERTEX_AT_EDGE, low.y - VERTEX_AT_EDGE],
            [high.x + VERTEX_AT_EDGE, high.y + VERTEX_AT_EDGE],
        );
        let near = self.tree.locate_in_envelope(&reach).filter(|one| !known.contains(&one.data));
        let vertices = near.map(|one| Vertex::of(edge, one.data, Point::from(*one.geom())));
        let mut found: Vec<Vertex> = vertices.filter(|one| one.distance <= VERTEX_AT_EDGE).collect();
        found.sort_by_key(|one| one.id);
        found
    }

    /// Nodes of these lanes' own bounds along the edge that are on no road border.
    fn on_bounds(&self, lanes: &[usize], edge: &Polyline) -> Vec<Vertex> {
        let bounds: BTreeSet<_> = lanes.iter().flat_map(|&lane| self.map.lanes[lane].bounds).collect();
        let lines = bounds.into_iter().filter_map(|way| self.map.map.linestrings.get(way));
        let nodes = lines.flat_map(|line| &line.points).filter(|id| !self.borders.contains_key(id));
        let vertices = nodes.filter_map(|&id| Some(Vertex::of(edge, id, self.map.map.points.get(id)?.position)));
        vertices.filter(|one| one.distance <= ON_EDGE).collect()
    }

    /// Lanes of which the outline covers too little.
    fn sticking_out(&self, lanes: &[usize], ring: &[Vertex]) -> Vec<usize> {
        self.sticking_out_of(lanes, &ring.iter().map(|one| one.place).collect::<Vec<_>>())
    }

    pub(super) fn sticking_out_of(&self, lanes: &[usize], ring: &[Point]) -> Vec<usize> {
        let sticks_out = |lane: &usize| {
            let lane = &self.map.lanes[*lane];
            polygon::common_area(&lane.outline, ring) < thresholds::COVER * lane.area
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
