//! The outline of merged intersections, and of those that the general method does not close: the boundary of a union.
//!
//! The union of the inner roads and the stubs of the arms before their cuts is the ground of the intersection. Its boundary,
//! from cut to cut, is the outline; medians between the arms stay outside it.

use std::collections::BTreeMap;

use crate::builder::network::{Intersection, RoadNetwork};
use crate::geometry::polygon::{convex_hull, outside, union};
use crate::geometry::{Point, Polyline, Vector, left_of, orientation};

use super::OutlineCut;
use super::collide::{collisions_within, crossings};
use super::ring::{bezier, cuts};
use super::sizes::{MARGIN, MOST_TRIM};
use super::thicken::{MITER_LIMIT, Side, ThickenedArm};

/// Least length of an arm outside the ground that ends the intersection, metres.
const LEAST_GAP: f64 = 6.0;
/// Length of the roads beyond their cuts that is subtracted from the ground, metres.
const ROAD_REACH: f64 = 60.0;
/// Least distance of the cuts of neighbouring arms with an island between them, metres.
const ISLAND: f64 = 1.2;
/// The largest distance of the union's vertices from the points of its parts, metres.
const SNAP: f64 = 1e-3;
/// The largest overlap of roads side by side at their cuts, metres.
pub const TOUCH: f64 = 0.05;
/// Least distance of neighbouring points, metres.
const CLOSE: f64 = 0.02;
/// How far a covered cut is moved in one round, metres.
const UNCOVER_STEP: f64 = 1.0;
/// The largest number of rounds.
const UNCOVER_ROUNDS: usize = 20;
/// Number of segments of a rounded corner.
const ROUND: usize = 4;

/// The ground inside: the inner roads, and around each node the convex hull of the road ends.
pub fn ground(network: &RoadNetwork, intersection: &Intersection, arms: &[ThickenedArm]) -> Vec<Vec<Point>> {
    let mut caps: BTreeMap<i64, Vec<Point>> = BTreeMap::new();
    let mut ground = Vec::new();
    let mut cap = |node: i64, end: Point, direction: Vector, half: f64| {
        let side = left_of(direction) * half;
        caps.entry(node).or_default().extend([end + side, end - side]);
    };
    for arm in arms {
        let node = network.road(arm.road_end.road).node(arm.road_end.end);
        cap(node, arm.line.first(), arm.line.direction(0.0), arm.half);
    }
    for inner in &intersection.inner {
        let half = inner.section.width() / 2.0;
        let length = inner.line.length();
        cap(inner.key.first, inner.line.first(), inner.line.direction(0.0), half);
        cap(inner.key.last, inner.line.last(), inner.line.direction(length), half);
        ground.extend(ribbon(&inner.line, half));
    }
    ground.extend(caps.into_values().map(convex_hull).filter(|hull| hull.len() > 2));
    ground
}

/// The ring around a line, `half` metres to either side.
pub fn ribbon(line: &Polyline, half: f64) -> Option<Vec<Point>> {
    let mut ring = line.offset(half, MITER_LIMIT)?.points().to_vec();
    ring.extend(line.offset(-half, MITER_LIMIT)?.points().iter().rev());
    Some(ring)
}

/// How far each arm must be cut back to leave the ground and the other arms, metres; at least `at_least`.
pub fn trims(arms: &[ThickenedArm], ground: &[Vec<Point>], at_least: &[f64]) -> Vec<f64> {
    let widest = arms.iter().map(|arm| arm.half * 2.0).fold(0.0, f64::max);
    let mut trims: Vec<f64> = arms
        .iter()
        .zip(at_least)
        .map(|(arm, least)| least.max(exit_station(arm, ground, MOST_TRIM * widest) + MARGIN))
        .collect();
    for i in 0..arms.len() {
        for j in i + 1..arms.len() {
            let reach = MOST_TRIM * arms[i].half.max(arms[j].half) * 2.0;
            for c in collisions_within(&arms[i], &arms[j], reach) {
                trims[i] = trims[i].max(c.stations[0] + MARGIN);
                trims[j] = trims[j].max(c.stations[1] + MARGIN);
            }
        }
    }
    uncover_cuts(arms, ground, &mut trims, MOST_TRIM * widest);
    trims
}

/// Moves the cuts that other roads cover outwards, up to `reach` metres.
fn uncover_cuts(arms: &[ThickenedArm], ground: &[Vec<Point>], trims: &mut [f64], reach: f64) {
    for _ in 0..UNCOVER_ROUNDS {
        let area = CutArea::new(arms, trims, ground);
        let Some(boundary) = area.boundary() else { return };
        let moves = |((arm, cut), trim): ((&ThickenedArm, &OutlineCut), &f64)| {
            !lies_on(&boundary, cut, SNAP) && trim + UNCOVER_STEP < reach.min(arm.length)
        };
        let moves: Vec<bool> = arms.iter().zip(&area.cuts).zip(trims.iter()).map(moves).collect();
        if !moves.contains(&true) {
            return;
        }
        trims.iter_mut().zip(moves).filter(|(_, moves)| *moves).for_each(|(trim, _)| *trim += UNCOVER_STEP);
    }
}

/// The last station at which an arm leaves the ground, metres.
fn exit_station(arm: &ThickenedArm, ground: &[Vec<Point>], reach: f64) -> f64 {
    let mut stations: Vec<f64> = Vec::new();
    for ring in ground {
        let Some(ring) = Polyline::new(ring.iter().chain(ring.first()).copied()) else { continue };
        for line in [&arm.left, &arm.line, &arm.right] {
            stations.extend(crossings(line, &ring).into_iter().map(|(_, _, p)| arm.line.project(p).station));
        }
    }
    stations.sort_by(f64::total_cmp);
    let mut exit = 0.0;
    for station in stations {
        if station - exit > LEAST_GAP || station > reach {
            break;
        }
        exit = station;
    }
    exit
}

/// What an intersection covers if its arms are cut at some stations.
pub struct CutArea<'a> {
    arms: &'a [ThickenedArm],
    trims: &'a [f64],
    pub cuts: Vec<OutlineCut>,
    ground: &'a [Vec<Point>],
}

impl<'a> CutArea<'a> {
    /// The area with the arms cut at the stations `trims`, metres.
    pub fn new(arms: &'a [ThickenedArm], trims: &'a [f64], ground: &'a [Vec<Point>]) -> Self {
        Self { arms, trims, cuts: cuts(arms, trims), ground }
    }

    /// The arms whose cuts other roads cover; all arms if none do and the cuts only lie in a wrong order. `far` as for
    /// [`Self::corners`].
    pub fn covered_arms(&self, far: &[f64]) -> Vec<usize> {
        let boundary = self.without_own_roads(far);
        let is_covered = |cut| boundary.as_ref().is_none_or(|boundary| !lies_on(boundary, cut, TOUCH));
        let covered: Vec<usize> = (0..self.arms.len()).filter(|i| is_covered(&self.cuts[*i])).collect();
        if covered.is_empty() { (0..self.arms.len()).collect() } else { covered }
    }

    /// The corners from cut to cut along the boundary; `None` if a cut does not lie on it. If ground or a stub covers a cut, the
    /// remaining roads are subtracted from the area. `far` has the stations at which the arms end at their other intersections.
    pub fn corners(&self, far: &[f64]) -> Option<CutsAndCorners> {
        let boundary = self.boundary()?;
        let corners = split_at_cuts(&boundary, &self.cuts, SNAP);
        corners.or_else(|| split_at_cuts(&self.without_roads(&boundary, far)?, &self.cuts, TOUCH))
    }

    /// The boundary of the area without the roads beyond their cuts.
    pub fn without_own_roads(&self, far: &[f64]) -> Option<Vec<Point>> {
        self.without_roads(&self.boundary()?, far)
    }

    /// The area inside a boundary without the roads beyond their cuts.
    fn without_roads(&self, boundary: &[Point], far: &[f64]) -> Option<Vec<Point>> {
        let remaining = |(arm, (trim, far)): (&ThickenedArm, (&f64, &f64))| {
            ribbon(&arm.line.cut(*trim, far.min(trim + ROAD_REACH))?, arm.half)
        };
        let roads: Vec<Vec<Point>> = self.arms.iter().zip(self.trims.iter().zip(far)).filter_map(remaining).collect();
        outside(boundary, &roads)
    }

    /// The boundary of the union of ground and stubs.
    fn boundary(&self) -> Option<Vec<Point>> {
        let Self { arms, trims, cuts, ground } = self;
        let mut pieces: Vec<Vec<Point>> = ground.to_vec();
        for ((arm, trim), cut) in arms.iter().zip(*trims).zip(cuts) {
            pieces.extend(stub(arm, *trim, cut));
        }
        for (i, arm) in arms.iter().enumerate() {
            let next = (i + 1) % arms.len();
            if next != i && (cuts[i].left - cuts[next].right).norm() < ISLAND {
                pieces.push(strip_between(arm, &arms[next], [trims[i], trims[next]], [cuts[i].left, cuts[next].right]));
            }
        }
        union(&pieces)
    }
}

/// Whether both ends of a cut are vertices of the boundary, within `snap` metres.
fn lies_on(boundary: &[Point], cut: &OutlineCut, snap: f64) -> bool {
    [cut.left, cut.right].iter().all(|p| vertex_at(boundary, *p, snap).is_some())
}

/// The boundary's vertex at `p`, within `snap` metres.
fn vertex_at(boundary: &[Point], p: Point, snap: f64) -> Option<usize> {
    let distance = |i: &usize| (boundary[*i] - p).norm();
    let nearest = (0..boundary.len()).min_by(|i, j| distance(i).total_cmp(&distance(j)))?;
    (distance(&nearest) < snap).then_some(nearest)
}

/// The part of an arm before its cut.
fn stub(arm: &ThickenedArm, trim: f64, cut: &OutlineCut) -> Option<Vec<Point>> {
    let line = arm.line.cut(0.0, trim)?;
    let mut ring = line.offset(arm.half, MITER_LIMIT)?.points().to_vec();
    let mut right = line.offset(-arm.half, MITER_LIMIT)?.points().to_vec();
    if let (Some(l), Some(r)) = (ring.last_mut(), right.last_mut()) {
        (*l, *r) = (cut.right, cut.left);
    }
    ring.extend(right.into_iter().rev());
    Some(ring)
}

/// The strip between the stubs of two neighbours side by side.
fn strip_between(a: &ThickenedArm, b: &ThickenedArm, trims: [f64; 2], ends: [Point; 2]) -> Vec<Point> {
    let corners = [a.corner(0.0, Side::Right), b.corner(0.0, Side::Left)];
    let middles = [a.line.at(trims[0] / 2.0), b.line.at(trims[1] / 2.0)];
    convex_hull([ends, corners, middles].concat())
}

/// The cuts by index in the order in which they lie on the boundary, and the corner after each.
pub type CutsAndCorners = (Vec<usize>, Vec<Vec<Point>>);

/// Splits the boundary at the cuts, whose ends are vertices of it within `snap` metres; `None` if some are not.
pub fn split_at_cuts(boundary: &[Point], cuts: &[OutlineCut], snap: f64) -> Option<CutsAndCorners> {
    let n = boundary.len();
    let start = vertex_at(boundary, cuts.first()?.right, snap)?;
    let from_start = |p: Point| Some((vertex_at(boundary, p, snap)? + n - start) % n);
    let marks = cuts.iter().map(|cut| Some([from_start(cut.right)?, from_start(cut.left)?]));
    let marks = marks.collect::<Option<Vec<[usize; 2]>>>()?;
    let mut order: Vec<usize> = (0..cuts.len()).collect();
    order.sort_by_key(|&i| marks[i]);
    if !order.iter().flat_map(|&i| marks[i]).is_sorted() {
        return None;
    }
    let corner = |i: usize| {
        let (cut, next) = (order[i], order[(i + 1) % order.len()]);
        let to = if next == order[0] { n } else { marks[next][0] };
        let mut chain = vec![cuts[cut].left];
        for k in marks[cut][1] + 1..to {
            let p = boundary[(k + start) % n];
            let last = chain[chain.len() - 1];
            if (p - last).norm() > CLOSE && (p - cuts[next].right).norm() > CLOSE {
                chain.push(p);
            }
        }
        chain.push(cuts[next].right);
        chain
    };
    let corners = (0..cuts.len()).map(corner).collect();
    Some((order, corners))
}

/// The chain with its inward corners rounded by curves that begin at most `reach` metres from them.
pub fn rounded(chain: &[Point], reach: f64) -> Vec<Point> {
    let mut smooth = vec![chain[0]];
    for w in chain.windows(3) {
        let (a, b, c) = (w[0], w[1], w[2]);
        if orientation(a, b, c) <= 0.0 {
            smooth.push(b);
            continue;
        }
        let from = b + (a - b).normalize() * reach.min((a - b).norm() * 0.45);
        let to = b + (c - b).normalize() * reach.min((c - b).norm() * 0.45);
        smooth.extend(bezier(from, b, to, ROUND));
    }
    smooth.extend(chain.last());
    smooth
}
