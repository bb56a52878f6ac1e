//! Rings of an intersection area: their nodes, what they cover, and their unions.

use crate::builder::ids::Key;
use crate::builder::intersection::conflict::strips_beside;
use crate::builder::intersection::turning_lanelets::{SharedBounds, TurningLanelet};
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::geometry::polyline::within;
use crate::geometry::strip_index::StripIndex;
use crate::geometry::{Point, Polyline, polygon, simple_ring};
use crate::lanelet::PointId;

use geo::{Area, BooleanOps, MultiPolygon};
use rustc_hash::{FxHashMap, FxHashSet};

/// A lane end node that a union lost is inserted into its nearest edge up to this distance, metres.
const INSERT: f64 = 0.3;
/// Part of each lanelet that must lie in the area.
const COVERED: f64 = 0.995;
/// Vertices of a union closer than this, metres, to a known node are that node.
const SNAP: f64 = 1e-3;
/// Any other node of a cut is inserted only where it lies on an edge, up to this distance, metres.
const ON_EDGE: f64 = 0.01;
/// An outline that turns back on itself within this angle, degrees, has a spike; the tip of a median is wider.
const SPIKE: f64 = 1.5;

/// More rings than this are joined before they are joined to the ground, or taken off it. Few real intersections have so many
/// lanelets, and none is drawn otherwise, but for corners that move by a hair.
const MOST_APART: usize = 64;

/// A node and its place.
pub(super) type Node = (PointId, Point);

/// Whether both ends of each of an arm's lanes are neighbours on the ring; a median may lie between lanes.
pub(super) fn runs_beside(ring: &[PointId], arm: &Arm) -> bool {
    let count = ring.len();
    arm.into.iter().chain(&arm.out).all(|lane| {
        let [a, b] = lane.nodes.map(|id| ring.iter().position(|&one| one == id));
        a.zip(b).is_some_and(|(a, b)| (a + 1) % count == b || (b + 1) % count == a)
    })
}

pub(super) fn places(assembly: &MapBuilder, ring: &[PointId]) -> Vec<Point> {
    ring.iter().map(|&id| assembly.position(id)).collect()
}

pub(super) fn nodes(assembly: &MapBuilder, ids: &[PointId]) -> Vec<Node> {
    ids.iter().copied().zip(assembly.positions(ids)).collect()
}

pub(super) fn is_simple(assembly: &MapBuilder, ring: &[PointId]) -> bool {
    simple_ring::faults(&places(assembly, ring), SPIKE, 1).is_empty()
}

/// Whether a ring neither crosses nor touches itself, and has no spike.
pub(super) fn is_simple_ring(ring: &[Node]) -> bool {
    let ring: Vec<Point> = ring.iter().map(|(_, place)| *place).collect();
    simple_ring::faults(&ring, SPIKE, 1).is_empty()
}

/// Whether a simple ring runs clockwise and covers every lanelet, whose `indices` these are.
pub(super) fn holds(ring: &[Node], paths: &[TurningLanelet], indices: &[Option<StripIndex>]) -> bool {
    let ring: Vec<Point> = ring.iter().map(|(_, place)| *place).collect();
    let clockwise = polygon::signed_area(&ring) < 0.0;
    let Some(inside) = strips_beside(paths, &ring).filter(|_| clockwise) else { return false };
    let covered = |index: &Option<StripIndex>| index.as_ref().map_or(0.0, |index| index.strips().common_area(&inside));
    paths.iter().zip(indices).all(|(path, index)| covered(index) >= COVERED * area_of(&path.outline))
}

/// Whether a ring covers every lanelet.
pub fn covers(ring: &[Point], paths: &[TurningLanelet]) -> bool {
    paths.iter().all(|path| polygon::common_area(&path.outline, ring) >= COVERED * area_of(&path.outline))
}

pub(super) fn area_of(ring: &[Point]) -> f64 {
    polygon::signed_area(ring).abs()
}

/// The ground that an outline encloses: a ring without islands, with lanelets, without what lies behind the cuts.
#[derive(Clone, Copy)]
pub(super) struct RingUnion<'a> {
    pub(super) ring: &'a [Node],
    pub(super) islands: &'a [Vec<Point>],
    pub(super) paths: &'a [TurningLanelet],
    pub(super) behind: &'a [Vec<Point>],
}

impl RingUnion<'_> {
    /// The outer ring of the largest polygon, clockwise, not closed.
    fn outer(&self) -> Option<Vec<Point>> {
        let ring: Vec<Point> = self.ring.iter().map(|(_, place)| *place).collect();
        let mut ground = MultiPolygon(vec![polygon::to_geo(&ring)]);
        for island in self.islands {
            ground = ground.difference(&polygon::to_geo(island));
        }
        let paths = self.paths.iter().map(|path| path.outline.as_slice());
        joined(paths).iter().for_each(|path| ground = ground.union(path));
        let behind = self.behind.iter().map(Vec::as_slice);
        joined(behind).iter().for_each(|lane| ground = ground.difference(lane));
        let largest = ground.0.iter().max_by(|a, b| a.unsigned_area().total_cmp(&b.unsigned_area()))?;
        let mut outer: Vec<Point> = largest.exterior().points().map(|p| Point::new(p.x(), p.y())).collect();
        outer.pop();
        if polygon::signed_area(&outer) > 0.0 {
            outer.reverse();
        }
        Some(outer)
    }
}

/// Rings as polygons; of more than [`MOST_APART`] their union, joined in pairs: the ground would grow corners with each, which all others
/// are held against.
fn joined<'a>(rings: impl Iterator<Item = &'a [Point]>) -> Vec<MultiPolygon> {
    let mut all: Vec<MultiPolygon> = rings.map(|ring| MultiPolygon(vec![polygon::to_geo(ring)])).collect();
    let least = if all.len() > MOST_APART { 1 } else { all.len() };
    while all.len() > least {
        let join = |pair: &[MultiPolygon]| pair.iter().skip(1).fold(pair[0].clone(), |a, b| a.union(b));
        all = all.chunks(2).map(join).collect();
    }
    all
}

/// A square of [`SNAP`] metres.
type Cell = (i64, i64);

fn cell(p: Point) -> Cell {
    ((p.x / SNAP).round() as i64, (p.y / SNAP).round() as i64)
}

/// The nodes that exist on the ring and on bounds, by cells.
struct KnownNodes {
    on_ring: FxHashMap<Cell, PointId>,
    /// The first node in a cell, with its rank.
    first: FxHashMap<Cell, (usize, PointId)>,
}

impl KnownNodes {
    fn new(ring: &[Node], bounds: &SharedBounds) -> Self {
        let mut first = FxHashMap::default();
        for (rank, (id, place)) in bounds.points().chain(ring.iter().copied()).enumerate() {
            first.entry(cell(place)).or_insert((rank, id));
        }
        Self { on_ring: ring.iter().map(|&(id, place)| (cell(place), id)).collect(), first }
    }

    /// The node at a place: one of the ring, else the first in its cell or in one beside it, since unions are not exact.
    fn at(&self, place: Point) -> Option<PointId> {
        let (x, y) = cell(place);
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (x + dx, y + dy)));
        let first = || around.filter_map(|cell| self.first.get(&cell)).min().map(|(_, id)| *id);
        self.on_ring.get(&(x, y)).copied().or_else(first)
    }
}

/// The outer ring of a union, on the nodes that exist where it passes them.
pub(super) fn union_outline(
    assembly: &mut MapBuilder,
    key: Key,
    union: &RingUnion,
    arms: &[&Arm],
    bounds: &SharedBounds,
) -> Vec<PointId> {
    let Some(outer) = union.outer() else { return union.ring.iter().map(|(id, _)| *id).collect() };
    let known = KnownNodes::new(union.ring, bounds);
    let mut nodes: Vec<PointId> = Vec::new();
    let count = outer.len();
    for (i, p) in outer.into_iter().enumerate() {
        let id = known.at(p).unwrap_or_else(|| assembly.point(key.word("outline").number(i as i64), p, 0.0));
        match nodes.iter().position(|&n| n == id) {
            None => nodes.push(id),
            // The ring touches itself: the smaller of the two loops is left out.
            Some(seen) if nodes.len() - seen <= count / 2 => nodes.truncate(seen + 1),
            Some(_) => {}
        }
    }
    let nodes = without_spikes(nodes, &lane_ends(arms).collect(), |id| assembly.position(id));
    with_cut_nodes(assembly, nodes, arms)
}

fn lane_ends(arms: &[&Arm]) -> impl Iterator<Item = PointId> {
    arms.iter().flat_map(|arm| arm.into.iter().chain(&arm.out)).flat_map(|lane| lane.nodes)
}

/// Removes nodes where the ring turns back on itself or crosses itself by a hair, which happens when vertices of a union become
/// nodes nearby. Nodes in `fixed` stay.
pub(super) fn without_spikes(
    ring: Vec<PointId>,
    fixed: &FxHashSet<PointId>,
    place: impl Fn(PointId) -> Point,
) -> Vec<PointId> {
    let places: Vec<Point> = ring.iter().map(|&id| place(id)).collect();
    let kept = simple_ring::without_faults(&places, SPIKE, |i| fixed.contains(&ring[i]));
    kept.into_iter().map(|i| ring[i]).collect()
}

/// Inserts missing nodes of the cuts into the nearest edge if it is near enough: the ends of lanes, then those between other
/// strips, for example bicycle lanes.
fn with_cut_nodes(assembly: &MapBuilder, mut ring: Vec<PointId>, arms: &[&Arm]) -> Vec<PointId> {
    let mut places = places(assembly, &ring);
    let mut on_ring: FxHashSet<PointId> = ring.iter().copied().collect();
    let mut simple = simple_ring::faults(&places, SPIKE, 1).is_empty();
    let others = arms.iter().flat_map(|arm| &arm.cut).map(|&id| (id, ON_EDGE));
    for (id, most) in lane_ends(arms).map(|id| (id, INSERT)).chain(others) {
        if !on_ring.insert(id) {
            continue;
        }
        let fits = nearest_edge(&places, assembly.position(id), most).is_some_and(|i| {
            places.insert(i + 1, assembly.position(id));
            let fits = if simple {
                simple_ring::stays_simple(&places, SPIKE, i + 1)
            } else {
                simple_ring::faults(&places, SPIKE, 1).is_empty()
            };
            if fits {
                ring.insert(i + 1, id);
            } else {
                places.remove(i + 1);
            }
            simple |= fits;
            fits
        });
        if !fits {
            on_ring.remove(&id);
        }
    }
    ring
}

/// The edge of a ring, by its first vertex, that is nearest to a place and at most this far, metres, from it.
fn nearest_edge(ring: &[Point], place: Point, most: f64) -> Option<usize> {
    let distance = |i: usize| {
        let edge = [ring[i], ring[(i + 1) % ring.len()]];
        // Almost all edges are far away.
        within((edge[0], edge[1]), place, 2.0 * most)?;
        Some((Polyline::new(edge)?.distance(place), i))
    };
    let nearest = (0..ring.len()).filter_map(distance).min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.filter(|(distance, _)| *distance <= most).map(|(_, i)| i)
}
