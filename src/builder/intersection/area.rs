//! The `intersection_area`: kerb chains between the roads, straight cuts across them, clockwise.

mod cut_out;

use geo::{Area, BooleanOps, MultiPolygon};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::ids::Key;
use crate::builder::lanes::types::{Arm, Lanes};
use crate::builder::map::assembly::Assembly;
use crate::builder::network::Island;
use crate::geometry::columns::Columns;
use crate::geometry::curve::Pose;
use crate::geometry::ring::RingFault;
use crate::geometry::{Point, curve, polygon, ring};
use crate::lanelet::{Attributes, LineStringId, PointId};

use super::conflict::strips_beside;
use super::paths::{Bounds, Path};
use cut_out::cut_out;

/// Part of each lanelet that must lie in the area.
const COVERED: f64 = 0.995;
/// Vertices of a union closer than this, metres, to a known node are that node.
const SNAP: f64 = 1e-3;
/// A lane end node that a union lost is put back on its nearest edge up to this distance, metres.
const INSERT: f64 = 0.3;
/// Another node of a cut is put back only where it lies on an edge, up to this distance, metres.
const ON_EDGE: f64 = 0.01;
/// An outline that turns back on itself within this, degrees, has an edge on both sides of nothing: the tip of a median
/// is wider.
const SPIKE: f64 = 1.5;

/// The outline of an intersection as nodes.
#[derive(Clone, Debug, Default)]
pub struct AreaOutline {
    /// Clockwise, not closed.
    pub ring: Vec<PointId>,
    /// Where these lie.
    pub places: Vec<Point>,
    /// The kerbs between the roads, in ring order.
    pub kerbs: Vec<LineStringId>,
    /// Arms, by index, over whose cuts some path runs, so that the outline around all paths does not lead along them.
    pub overrun: Vec<usize>,
    /// Arms, by index, whose lanes do not end on the outline side by side.
    pub lost: Vec<usize>,
    /// Whether it gives way to the lanes of roads.
    pub yields: bool,
    /// The ways around islands on which the outline lies all the same.
    pub covered: Vec<i64>,
}

impl AreaOutline {
    /// Whether no more ways run over cuts, and no more lanes end inside, than with another outline.
    pub fn fits_as_well(&self, other: &Self) -> bool {
        self.overrun.len() <= other.overrun.len() && self.lost.len() <= other.lost.len()
    }
}

/// Walks the arms clockwise: cut, kerb, cut, kerb. `paths` come with the columns of their outlines. Where a path leaves
/// that ring, it is widened to hold the path; where it then swallows the end of a road, it gives way to the lanes of that
/// road. Islands that reach into it are cut out.
pub fn area_outline(
    assembly: &mut Assembly,
    key: Key,
    lanes: &Lanes,
    arms: &[&Arm],
    bounds: &Bounds,
    paths: (&[Path], &[Option<Columns>]),
    islands: &[Island],
) -> AreaOutline {
    let walked = walked(assembly, key, arms, bounds);
    let mut ring: Vec<PointId> = walked.iter().map(|(id, _)| *id).collect();
    let apart = |ring: &[PointId]| -> Vec<usize> { (0..arms.len()).filter(|&i| !runs_along(ring, arms[i])).collect() };
    let (mut overrun, mut yields) = (apart(&ring), false);
    let (paths, columns) = paths;
    if !holds(&walked, paths, columns) {
        ring = united(assembly, key, &walked, arms, bounds, paths, [&[], &[]]);
        overrun = apart(&ring);
        yields = !overrun.is_empty() || !is_simple(assembly, &ring);
        if yields {
            let behind: Vec<Vec<Point>> = arms.iter().flat_map(|arm| own_lanes(assembly, lanes, arm)).collect();
            let key = key.word("beside lanes");
            let beside = united(assembly, key, &walked, arms, bounds, paths, [&[], &behind]);
            if is_simple(assembly, &beside) && apart(&beside).len() <= overrun.len() {
                ring = beside;
            }
        }
    }
    let (ring, covered) = cut_out(assembly, key, ring, (arms, bounds, paths), islands);
    let as_walked = ring.iter().eq(walked.iter().map(|(id, _)| id));
    let places = if as_walked { walked.iter().map(|node| node.1).collect() } else { places(assembly, &ring) };
    let kerbs = kerbs(assembly, key, &ring, arms);
    let lost = (0..arms.len()).filter(|&i| !runs_beside(&ring, arms[i])).collect();
    AreaOutline { ring, places, kerbs, overrun, lost, yields, covered }
}

/// A node and where it lies.
type Node = (PointId, Point);

/// The ring of cuts and the kerbs between them.
fn walked(assembly: &mut Assembly, key: Key, arms: &[&Arm], bounds: &Bounds) -> Vec<Node> {
    let cuts: Vec<Vec<Node>> = arms.iter().map(|arm| nodes(assembly, &arm.cut)).collect();
    let mut ring: Vec<Node> = Vec::new();
    for (i, arm) in arms.iter().enumerate() {
        let next = (i + 1) % arms.len();
        ring.extend(&cuts[i]);
        let (Some(&from), Some(&to)) = (cuts[i].last(), cuts[next].first()) else { continue };
        ring.extend(match bounds.line(from.0, to.0) {
            Some(line) => line.inner(from.0),
            None => corner(assembly, key, [from, to], [arm, arms[next]]),
        });
    }
    ring.dedup_by_key(|(id, _)| *id);
    while ring.len() > 1 && ring.first().map(|(id, _)| id) == ring.last().map(|(id, _)| id) {
        ring.pop();
    }
    ring
}

/// The ground of the lanes that end at an arm.
fn own_lanes(assembly: &Assembly, lanes: &Lanes, arm: &Arm) -> Vec<Vec<Point>> {
    let ends = arm.into.iter().chain(&arm.out);
    ends.map(|end| assembly.outline(lanes.lanes[end.lane].lanelet)).collect()
}

/// Whether the ends of an arm's lanes are a run of the ring, in their order across the road.
fn runs_along(ring: &[PointId], arm: &Arm) -> bool {
    let is_end = |id: PointId| arm.into.iter().chain(&arm.out).any(|lane| lane.nodes.contains(&id));
    let mut line = arm.cut.iter().filter(|id| is_end(**id));
    let Some(start) = line.next().map(|first| ring.iter().position(|id| id == first)) else { return true };
    start.is_some_and(|start| ring.iter().cycle().skip(start + 1).zip(line).all(|(a, b)| a == b))
}

/// The same, but that a median may lie between lanes.
fn runs_beside(ring: &[PointId], arm: &Arm) -> bool {
    let count = ring.len();
    let at = |id: PointId| ring.iter().position(|&one| one == id);
    let side_by_side = |[a, b]: [PointId; 2]| match (at(a), at(b)) {
        (Some(a), Some(b)) => (a + 1) % count == b || (b + 1) % count == a,
        _ => false,
    };
    arm.into.iter().chain(&arm.out).all(|lane| side_by_side(lane.nodes))
}

/// A rounded kerb between the ends of two cuts, which keeps clear of none and touches both.
fn corner(assembly: &mut Assembly, key: Key, [from, to]: [Node; 2], [arm, next]: [&Arm; 2]) -> Vec<Node> {
    let start = Pose { point: from.1, heading: arm.inward };
    let end = Pose { point: to.1, heading: -next.inward };
    if (start.point - end.point).norm() < curve::MIN_SPACING {
        return Vec::new();
    }
    let line: Vec<Point> = curve::join(start, end).into_iter().map(|p| p.point).collect();
    let line = curve::untangled(&line);
    let key = key.word("kerb").number(from.0.0).number(to.0.0);
    let inner = &line[1.min(line.len())..line.len().max(2) - 1];
    inner.iter().enumerate().map(|(i, p)| (assembly.point(key.number(i as i64), *p, 0.0), *p)).collect()
}

fn places(assembly: &Assembly, ring: &[PointId]) -> Vec<Point> {
    ring.iter().map(|&id| assembly.position(id)).collect()
}

fn nodes(assembly: &Assembly, ids: &[PointId]) -> Vec<Node> {
    ids.iter().copied().zip(assembly.positions(ids)).collect()
}

fn is_simple(assembly: &Assembly, ring: &[PointId]) -> bool {
    ring::faults(&places(assembly, ring), SPIKE, 1).is_empty()
}

/// Whether the ring is simple and covers every path.
fn holds(ring: &[Node], paths: &[Path], columns: &[Option<Columns>]) -> bool {
    let ring: Vec<Point> = ring.iter().map(|(_, place)| *place).collect();
    let simple = ring::faults(&ring, SPIKE, 1).is_empty() && polygon::signed_area(&ring) < 0.0;
    let Some(inside) = strips_beside(paths, &ring).filter(|_| simple) else { return false };
    let covered = |path: &Option<Columns>| path.as_ref().map_or(0.0, |path| path.strips().common_area(&inside));
    paths.iter().zip(columns).all(|(path, columns)| covered(columns) >= COVERED * area_of(&path.outline))
}

/// Whether a ring covers every path.
pub fn covers(ring: &[Point], paths: &[Path]) -> bool {
    paths.iter().all(|path| polygon::common_area(&path.outline, ring) >= COVERED * area_of(&path.outline))
}

fn area_of(ring: &[Point]) -> f64 {
    polygon::signed_area(ring).abs()
}

/// The outer ring of everything together but for islands, over which ways may lie, and for what lies behind the cuts, on
/// the nodes that exist where it passes them.
fn united(
    assembly: &mut Assembly,
    key: Key,
    ring: &[Node],
    arms: &[&Arm],
    bounds: &Bounds,
    paths: &[Path],
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
    let nodes = tidied(nodes, &lane_ends(arms).collect(), |id| assembly.position(id));
    with_cuts(assembly, nodes, arms)
}

fn lane_ends(arms: &[&Arm]) -> impl Iterator<Item = PointId> {
    arms.iter().flat_map(|arm| arm.into.iter().chain(&arm.out)).flat_map(|lane| lane.nodes)
}

/// Takes out nodes where the ring turns back on itself or crosses itself: a union whose vertices became nodes close by may
/// do so by a hair. Nodes in `fixed` stay.
fn tidied(mut ring: Vec<PointId>, fixed: &FxHashSet<PointId>, place: impl Fn(PointId) -> Point) -> Vec<PointId> {
    for _ in 0..ring.len() {
        let places: Vec<Point> = ring.iter().map(|&id| place(id)).collect();
        let count = ring.len();
        let loose: Vec<usize> = match ring::faults(&places, SPIKE, 1).first() {
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
fn with_cuts(assembly: &Assembly, mut ring: Vec<PointId>, arms: &[&Arm]) -> Vec<PointId> {
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
        if let Some(with) = with.filter(|with| ring::faults(&places(assembly, with), SPIKE, 1).is_empty()) {
            ring = with;
        }
    }
    ring
}

/// One `road_border` for every stretch of the ring that is not a cut.
fn kerbs(assembly: &mut Assembly, key: Key, ring: &[PointId], arms: &[&Arm]) -> Vec<LineStringId> {
    let is_cut = |a: PointId, b: PointId| arms.iter().any(|arm| arm.cut.contains(&a) && arm.cut.contains(&b));
    let count = ring.len();
    let Some(start) = (0..count).find(|&i| is_cut(ring[(i + count - 1) % count], ring[i])) else { return Vec::new() };
    let mut lines = Vec::new();
    let mut chain = vec![ring[start]];
    for step in 1..=count {
        let (a, b) = (ring[(start + step - 1) % count], ring[(start + step) % count]);
        if is_cut(a, b) {
            if chain.len() > 1 {
                lines.push(kerb(assembly, key, std::mem::take(&mut chain)));
            }
            chain = vec![b];
        } else {
            chain.push(b);
        }
    }
    if chain.len() > 1 {
        lines.push(kerb(assembly, key, chain));
    }
    lines
}

fn kerb(assembly: &mut Assembly, key: Key, chain: Vec<PointId>) -> LineStringId {
    let ends = [chain.first(), chain.last()].map(|id| id.map_or(0, |id| id.0));
    assembly.line(
        key.word("kerb line").number(ends[0]).number(ends[1]),
        chain,
        Attributes::of(&[("type", "road_border")]),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left of a ring of nodes 0, 1, 2, ... of which some are fixed.
    fn left(places: &[(f64, f64)], fixed: &[i64]) -> Vec<i64> {
        let ring = (0..places.len() as i64).map(PointId).collect();
        let place = |id: PointId| Point::new(places[id.0 as usize].0, places[id.0 as usize].1);
        tidied(ring, &fixed.iter().copied().map(PointId).collect(), place).into_iter().map(|id| id.0).collect()
    }

    #[test]
    fn a_spike_is_taken_off_but_not_the_end_of_a_lane() {
        let spike = [(0.0, 0.0), (0.0, 9.0), (5.0, 9.0), (5.0, 12.0), (5.0, 9.0), (9.0, 9.0), (9.0, 0.0)];
        assert_eq!(left(&spike, &[]), [0, 1, 2, 4, 5, 6]);
        assert_eq!(left(&spike, &[3]), [0, 1, 3, 4, 5, 6]);
    }

    #[test]
    fn a_small_loop_is_left_out() {
        let looped = [(0.0, 0.0), (0.0, 9.0), (4.0, 9.0), (5.0, 8.9), (3.9, 8.8), (4.1, 9.1), (9.0, 9.0), (9.0, 0.0)];
        let places =
            |ids: &[i64]| ids.iter().map(|&i| Point::new(looped[i as usize].0, looped[i as usize].1)).collect();
        let kept = left(&looped, &[]);
        let shape: Vec<Point> = places(&kept);
        assert!(ring::is_simple(&shape), "{kept:?}");
        assert!([0, 1, 6, 7].iter().all(|corner| kept.contains(corner)), "{kept:?}");
    }

    #[test]
    fn a_simple_ring_stays() {
        assert_eq!(left(&[(0.0, 0.0), (0.0, 1.0), (1.0, 1.0)], &[]), [0, 1, 2]);
    }
}
