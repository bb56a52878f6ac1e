//! The ring of an area while it is put together: its nodes, what it covers, and rings united.

use crate::builder::ids::Key;
use crate::builder::intersection::conflict::strips_beside;
use crate::builder::intersection::turning_lanelets::{SharedBounds, TurningLanelet};
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::geometry::simple_ring::RingFault;
use crate::geometry::strip_index::StripIndex;
use crate::geometry::{Point, polygon, simple_ring};
use crate::lanelet::PointId;

use geo::{Area, BooleanOps, MultiPolygon};
use rustc_hash::FxHashMap;
use rustc_hash::FxHashSet;

/// A lane end node that a union lost is put back on its nearest edge up to this distance, metres.
pub(super) const INSERT: f64 = 0.3;

/// Part of each lanelet that must lie in the area.
pub(super) const COVERED: f64 = 0.995;
/// Vertices of a union closer than this, metres, to a known node are that node.
pub(super) const SNAP: f64 = 1e-3;
/// Another node of a cut is put back only where it lies on an edge, up to this distance, metres.
pub(super) const ON_EDGE: f64 = 0.01;
/// An outline that turns back on itself within this, degrees, has an edge on both sides of nothing: the tip of a median
/// is wider.
pub(super) const SPIKE: f64 = 1.5;

/// A node and where it lies.
pub(super) type Node = (PointId, Point);

/// The same, but that a median may lie between lanes.
pub(super) fn runs_beside(ring: &[PointId], arm: &Arm) -> bool {
    let count = ring.len();
    let at = |id: PointId| ring.iter().position(|&one| one == id);
    let side_by_side = |[a, b]: [PointId; 2]| match (at(a), at(b)) {
        (Some(a), Some(b)) => (a + 1) % count == b || (b + 1) % count == a,
        _ => false,
    };
    arm.into.iter().chain(&arm.out).all(|lane| side_by_side(lane.nodes))
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

/// Whether the ring is simple and covers every path.
pub(super) fn holds(ring: &[Node], paths: &[TurningLanelet], columns: &[Option<StripIndex>]) -> bool {
    let ring: Vec<Point> = ring.iter().map(|(_, place)| *place).collect();
    let simple = simple_ring::faults(&ring, SPIKE, 1).is_empty() && polygon::signed_area(&ring) < 0.0;
    let Some(inside) = strips_beside(paths, &ring).filter(|_| simple) else { return false };
    let covered = |path: &Option<StripIndex>| path.as_ref().map_or(0.0, |path| path.strips().common_area(&inside));
    paths.iter().zip(columns).all(|(path, columns)| covered(columns) >= COVERED * area_of(&path.outline))
}

/// Whether a ring covers every path.
pub fn covers(ring: &[Point], paths: &[TurningLanelet]) -> bool {
    paths.iter().all(|path| polygon::common_area(&path.outline, ring) >= COVERED * area_of(&path.outline))
}

pub(super) fn area_of(ring: &[Point]) -> f64 {
    polygon::signed_area(ring).abs()
}

/// The outer ring of everything together but for islands, over which ways may lie, and for what lies behind the cuts, on
/// the nodes that exist where it passes them.
pub(super) fn union_outline(
    assembly: &mut MapBuilder,
    key: Key,
    ring: &[Node],
    arms: &[&Arm],
    bounds: &SharedBounds,
    paths: &[TurningLanelet],
    [islands, behind]: [&[Vec<Point>]; 2],
) -> Vec<PointId> {
    let around: Vec<Point> = ring.iter().map(|(_, place)| *place).collect();
    let mut whole = MultiPolygon(vec![polygon::to_geo(&around)]);
    for island in islands {
        whole = whole.difference(&polygon::to_geo(island));
    }
    for path in paths {
        whole = whole.union(&polygon::to_geo(&path.outline));
    }
    for lane in behind {
        whole = whole.difference(&polygon::to_geo(lane));
    }
    let largest = whole.0.iter().max_by(|a, b| a.unsigned_area().total_cmp(&b.unsigned_area()));
    let Some(largest) = largest else { return ring.iter().map(|(id, _)| *id).collect() };
    let mut outer: Vec<Point> = largest.exterior().points().map(|p| Point::new(p.x(), p.y())).collect();
    outer.pop();
    if polygon::signed_area(&outer) > 0.0 {
        outer.reverse();
    }
    let cell = |p: Point| ((p.x / SNAP).round() as i64, (p.y / SNAP).round() as i64);
    // By cell the first point there, with its rank; and the point of the ring.
    let mut known: FxHashMap<(i64, i64), (usize, PointId)> = FxHashMap::default();
    for (rank, (id, place)) in bounds.points().chain(ring.iter().copied()).enumerate() {
        known.entry(cell(place)).or_insert((rank, id));
    }
    let on_ring: FxHashMap<(i64, i64), PointId> = ring.iter().map(|&(id, place)| (cell(place), id)).collect();
    // A vertex can come out of the union a hair off, in the next cell.
    let around = |(x, y): (i64, i64)| (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| (x + dx, y + dy)));
    let first = |at: (i64, i64)| around(at).filter_map(|cell| known.get(&cell)).min().map(|(_, id)| *id);
    let mut nodes: Vec<PointId> = Vec::new();
    let count = outer.len();
    for (i, p) in outer.into_iter().enumerate() {
        let id = on_ring.get(&cell(p)).copied().or_else(|| first(cell(p)));
        let id = id.unwrap_or_else(|| assembly.point(key.word("outline").number(i as i64), p, 0.0));
        match nodes.iter().position(|&n| n == id) {
            None => nodes.push(id),
            // The ring touches itself: the smaller of the two loops is left out.
            Some(seen) if nodes.len() - seen <= count / 2 => nodes.truncate(seen + 1),
            Some(_) => {}
        }
    }
    let nodes = without_spikes(nodes, &lane_ends(arms).collect(), |id| assembly.position(id));
    with_cuts(assembly, nodes, arms)
}

pub(super) fn lane_ends(arms: &[&Arm]) -> impl Iterator<Item = PointId> {
    arms.iter().flat_map(|arm| arm.into.iter().chain(&arm.out)).flat_map(|lane| lane.nodes)
}

/// Takes out nodes where the ring turns back on itself or crosses itself: a union whose vertices became nodes close by may
/// do so by a hair. Nodes in `fixed` stay.
pub(super) fn without_spikes(
    mut ring: Vec<PointId>,
    fixed: &FxHashSet<PointId>,
    place: impl Fn(PointId) -> Point,
) -> Vec<PointId> {
    for _ in 0..ring.len() {
        let places: Vec<Point> = ring.iter().map(|&id| place(id)).collect();
        let count = ring.len();
        let loose: Vec<usize> = match simple_ring::faults(&places, SPIKE, 1).first() {
            Some(RingFault::Spike(i)) => {
                let near = [*i, (i + count - 1) % count, (i + 1) % count];
                near.into_iter().filter(|&i| !fixed.contains(&ring[i])).take(1).collect()
            }
            // The smaller of the two loops is left out.
            Some(RingFault::Crossing(i, j, _)) => {
                let inner = i + 1..j + 1;
                let outer: Vec<usize> = (0..count).filter(|k| !inner.contains(k)).collect();
                let smaller = if inner.len() <= outer.len() { inner.collect() } else { outer };
                smaller.into_iter().filter(|&i| !fixed.contains(&ring[i])).collect()
            }
            _ => return ring,
        };
        if loose.is_empty() || count < loose.len() + 3 {
            return ring;
        }
        let mut at = 0..;
        ring.retain(|_| at.next().is_none_or(|i| !loose.contains(&i)));
    }
    ring
}

/// Puts nodes of the cuts that are missing back on the nearest edge, if it is near enough: the ends of lanes, and then those
/// between other strips, bicycle lanes among them.
pub(super) fn with_cuts(assembly: &MapBuilder, mut ring: Vec<PointId>, arms: &[&Arm]) -> Vec<PointId> {
    let others = arms.iter().flat_map(|arm| &arm.cut).map(|&id| (id, ON_EDGE));
    for (id, most) in lane_ends(arms).map(|id| (id, INSERT)).chain(others) {
        if ring.contains(&id) {
            continue;
        }
        let p = assembly.position(id);
        let count = ring.len();
        let nearest = (0..count)
            .filter_map(|i| {
                let edge = [ring[i], ring[(i + 1) % count]].map(|id| assembly.position(id));
                crate::geometry::Polyline::new(edge).map(|line| (line.distance(p), i))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let with = nearest.filter(|(distance, _)| *distance <= most).map(|(_, i)| {
            let mut with = ring.clone();
            with.insert(i + 1, id);
            with
        });
        if let Some(with) = with.filter(|with| simple_ring::faults(&places(assembly, with), SPIKE, 1).is_empty()) {
            ring = with;
        }
    }
    ring
}
