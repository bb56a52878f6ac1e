//! Several nodes that became one intersection, and every star whose ring does not close: the outline around a union.
//!
//! The ground of the intersection is what its inner roads and the trimmed-off stubs of its arms cover. The boundary of
//! their union, from cut to cut, is the outline; medians between the arms stay outside it.

use std::collections::BTreeMap;

use crate::builder::network::{Intersection, RoadNetwork};
use crate::geometry::polygon::{convex_hull, outside, union};
use crate::geometry::{Point, Polyline, Vector, left_of, orientation};

use super::collide::{collisions_within, crossings};
use super::ring::cut;
use super::thicken::{MITER_LIMIT, Side, ThickenedArm};
use super::{OutlineCut, OutlineOptions};

/// A stretch of an arm outside the ground longer than this, metres, ends the intersection.
const APART: f64 = 6.0;
/// A road lies beside the ground of its own intersection for at most so many metres.
const BESIDE: f64 = 60.0;
/// Neighbouring stubs closer together than this at their cuts, metres, have no island between them.
const ISLAND: f64 = 1.2;
/// The union's points lie within this distance, metres, of those that went in.
const SNAP: f64 = 1e-3;
/// Roads side by side may touch: at their cuts they overlap by less than this, metres.
const TOUCH: f64 = 0.05;
/// Points closer together than this, metres, are one.
const CLOSE: f64 = 0.02;
/// Arms whose cuts lie hidden are cut back so much further at a time, metres.
const EXPOSE_STEP: f64 = 1.0;
/// So often.
const EXPOSE_ROUNDS: usize = 20;
/// Pieces of a rounded corner.
const ROUND: usize = 4;

/// The ground inside: the inner roads, and around each node what lies between the roads that end there.
pub fn ground(network: &RoadNetwork, intersection: &Intersection, arms: &[ThickenedArm]) -> Vec<Vec<Point>> {
    let mut caps: BTreeMap<i64, Vec<Point>> = BTreeMap::new();
    let mut ground = Vec::new();
    let mut cap = |node: i64, at: Point, along: Vector, half: f64| {
        let side = left_of(along) * half;
        caps.entry(node).or_default().extend([at + side, at - side]);
    };
    for arm in arms {
        let node = network.road(arm.at.road).node(arm.at.end);
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

/// The ring around a line of some width.
pub fn ribbon(line: &Polyline, half: f64) -> Option<Vec<Point>> {
    let mut ring = line.offset(half, MITER_LIMIT)?.points().to_vec();
    ring.extend(line.offset(-half, MITER_LIMIT)?.points().iter().rev());
    Some(ring)
}

/// How far each arm must be cut back to come out of the ground and of the other arms.
pub fn trims(arms: &[ThickenedArm], ground: &[Vec<Point>], at_least: &[f64], options: &OutlineOptions) -> Vec<f64> {
    let widest = arms.iter().map(|arm| arm.half * 2.0).fold(0.0, f64::max);
    let mut trims: Vec<f64> = arms
        .iter()
        .zip(at_least)
        .map(|(arm, least)| least.max(way_out(arm, ground, options.reach * widest) + options.margin))
        .collect();
    for i in 0..arms.len() {
        for j in i + 1..arms.len() {
            let reach = options.reach * arms[i].half.max(arms[j].half) * 2.0;
            for c in collisions_within(&arms[i], &arms[j], reach) {
                trims[i] = trims[i].max(c.stations[0] + options.margin);
                trims[j] = trims[j].max(c.stations[1] + options.margin);
            }
        }
    }
    expose(arms, ground, &mut trims, options.reach * widest);
    trims
}

/// The arms whose cuts something covers, even where ground and stubs give way to what remains of the roads. All, where the
/// cuts lie on the boundary but among each other. `far` as for [`corners`].
pub fn hidden(
    arms: &[ThickenedArm],
    [trims, far]: [&[f64]; 2],
    cuts: &[OutlineCut],
    ground: &[Vec<Point>],
) -> Vec<usize> {
    let all = || (0..arms.len()).collect();
    let boundary = boundary(arms, trims, cuts, ground);
    let Some(boundary) = boundary.and_then(|boundary| beside_roads(&boundary, arms, [trims, far])) else {
        return all();
    };
    let seen = |cut: &OutlineCut| [cut.left, cut.right].iter().all(|p| find(&boundary, *p, TOUCH).is_some());
    let hidden: Vec<usize> = (0..arms.len()).filter(|i| !seen(&cuts[*i])).collect();
    if hidden.is_empty() { all() } else { hidden }
}

/// Cuts those arms back further whose cuts other roads still cover.
fn expose(arms: &[ThickenedArm], ground: &[Vec<Point>], trims: &mut [f64], reach: f64) {
    for _ in 0..EXPOSE_ROUNDS {
        let cuts: Vec<OutlineCut> = arms.iter().zip(trims.iter()).map(|(arm, trim)| cut(arm, *trim)).collect();
        let Some(boundary) = boundary(arms, trims, &cuts, ground) else { return };
        let mut hidden = false;
        for ((arm, cut), trim) in arms.iter().zip(&cuts).zip(trims.iter_mut()) {
            let seen = find(&boundary, cut.left, SNAP).is_some() && find(&boundary, cut.right, SNAP).is_some();
            if !seen && *trim + EXPOSE_STEP < reach.min(arm.length) {
                *trim += EXPOSE_STEP;
                hidden = true;
            }
        }
        if !hidden {
            return;
        }
    }
}

/// The station where an arm leaves the ground for good.
fn way_out(arm: &ThickenedArm, ground: &[Vec<Point>], reach: f64) -> f64 {
    let mut stations: Vec<f64> = Vec::new();
    for ring in ground {
        let Some(ring) = Polyline::new(ring.iter().chain(ring.first()).copied()) else { continue };
        for line in [&arm.left, &arm.line, &arm.right] {
            stations.extend(crossings(line, &ring).into_iter().map(|(_, _, p)| arm.line.project(p).station));
        }
    }
    stations.sort_by(f64::total_cmp);
    let mut out = 0.0;
    for station in stations {
        if station - out > APART || station > reach {
            break;
        }
        out = station;
    }
    out
}

/// The corners from cut to cut along the boundary of ground and stubs; `None` if a cut does not lie on it. The arms come
/// in the order of their nodes' roads, which is not that of the cuts where roads cross each other behind a node. `far` gives the stations where the arms end at their other intersections: where ground or a stub covers
/// a cut, what remains of the roads is taken out of the ground.
pub fn corners(
    arms: &[ThickenedArm],
    trims: &[f64],
    far: &[f64],
    cuts: &[OutlineCut],
    ground: &[Vec<Point>],
) -> Option<Threaded> {
    let boundary = boundary(arms, trims, cuts, ground)?;
    thread(&boundary, cuts, SNAP).or_else(|| thread(&beside_roads(&boundary, arms, [trims, far])?, cuts, TOUCH))
}

/// A boundary of ground and stubs without what remains of the roads behind their cuts.
fn beside_roads(boundary: &[Point], arms: &[ThickenedArm], [trims, far]: [&[f64]; 2]) -> Option<Vec<Point>> {
    let remains = |(arm, (trim, far)): (&ThickenedArm, (&f64, &f64))| {
        ribbon(&arm.line.cut(*trim, far.min(trim + BESIDE))?, arm.half)
    };
    let roads: Vec<Vec<Point>> = arms.iter().zip(trims.iter().zip(far)).filter_map(remains).collect();
    outside(boundary, &roads)
}

/// The boundary of ground and stubs.
fn boundary(arms: &[ThickenedArm], trims: &[f64], cuts: &[OutlineCut], ground: &[Vec<Point>]) -> Option<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = ground.to_vec();
    for ((arm, trim), cut) in arms.iter().zip(trims).zip(cuts) {
        pieces.extend(stub(arm, *trim, cut));
    }
    for (i, arm) in arms.iter().enumerate() {
        let next = (i + 1) % arms.len();
        if next != i && (cuts[i].left - cuts[next].right).norm() < ISLAND {
            pieces.push(between(arm, &arms[next], [trims[i], trims[next]], [cuts[i].left, cuts[next].right]));
        }
    }
    union(&pieces)
}

/// The boundary's vertex at `p`, within `snap` metres.
fn find(boundary: &[Point], p: Point, snap: f64) -> Option<usize> {
    let distance = |i: &usize| (boundary[*i] - p).norm();
    let nearest = (0..boundary.len()).min_by(|i, j| distance(i).total_cmp(&distance(j)))?;
    (distance(&nearest) < snap).then_some(nearest)
}

/// The part of an arm that is cut off.
fn stub(arm: &ThickenedArm, trim: f64, cut: &OutlineCut) -> Option<Vec<Point>> {
    let line = arm.line.cut(0.0, trim)?;
    let mut ring = line.offset(arm.half, MITER_LIMIT)?.points().to_vec();
    let mut right = line.offset(-arm.half, MITER_LIMIT)?.points().to_vec();
    if let (Some(l), Some(r)) = (ring.last_mut(), right.last_mut()) {
        *l = cut.right;
        *r = cut.left;
    }
    ring.extend(right.into_iter().rev());
    Some(ring)
}

/// The strip between the stubs of two neighbours that lie side by side.
fn between(a: &ThickenedArm, b: &ThickenedArm, trims: [f64; 2], ends: [Point; 2]) -> Vec<Point> {
    let mut points = ends.to_vec();
    points.push(a.corner(0.0, Side::Right));
    points.push(b.corner(0.0, Side::Left));
    points.push(a.line.at(trims[0] / 2.0));
    points.push(b.line.at(trims[1] / 2.0));
    convex_hull(points)
}

/// The cuts in the order in which they lie on the boundary, by index from the first, and the corner behind each.
pub type Threaded = (Vec<usize>, Vec<Vec<Point>>);

/// Cuts the boundary at the cuts.
fn thread(boundary: &[Point], cuts: &[OutlineCut], snap: f64) -> Option<Threaded> {
    let n = boundary.len();
    let start = find(boundary, cuts.first()?.right, snap)?;
    let along = |p: Point| Some((find(boundary, p, snap)? + n - start) % n);
    let marks: Option<Vec<[usize; 2]>> = cuts.iter().map(|cut| Some([along(cut.right)?, along(cut.left)?])).collect();
    let marks = marks?;
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

/// The chain with its inward corners rounded off by curves that leave the edges at most `reach` metres from them.
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
        smooth.extend((0..=ROUND).map(|i| {
            let t = i as f64 / ROUND as f64;
            let (p, q) = (from + (b - from) * t, b + (to - b) * t);
            p + (q - p) * t
        }));
    }
    smooth.extend(chain.last());
    smooth
}
