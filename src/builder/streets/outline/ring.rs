//! Joins cuts and corners clockwise into one ring.

use crate::geometry::{Point, Polyline, orientation};

use super::OutlineCut;
use super::thicken::{Side, ThickenedArm};

/// Least distance of neighbouring points of a corner, metres.
const CLOSE: f64 = 0.02;
/// Number of segments of a rounded corner.
const ROUND: usize = 6;

/// The corner between an arm and the next one clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Corner {
    /// Their edges collide at a point, `along` metres along the right edge of the first and the left edge of the second. A
    /// curve rounds the corner, which begins on both edges `tangent` metres from the point.
    Collision { point: Point, along: [f64; 2], tangent: f64 },
    /// Their edges do not collide: the arms are half a turn or more apart.
    Open,
    /// A straight line from cut to cut.
    Chord,
}

/// The cuts across the arms at these stations, metres.
pub fn cuts(arms: &[ThickenedArm], stations: &[f64]) -> Vec<OutlineCut> {
    let cut = |(arm, station): (&ThickenedArm, &f64)| {
        let [left, right] = [Side::Right, Side::Left].map(|side| arm.corner(*station, side));
        OutlineCut { at: arm.road_end, left, right }
    };
    arms.iter().zip(stations).map(cut).collect()
}

/// The kerb from the cut of `a` at station `trims[0]`, metres, to that of `b`, the next arm clockwise. `first` and `last` are the
/// ends of the cuts.
pub fn corner(
    a: &ThickenedArm,
    b: &ThickenedArm,
    trims: [f64; 2],
    [first, last]: [Point; 2],
    corner: Corner,
) -> Vec<Point> {
    let mut inner = match corner {
        Corner::Collision { point, along, tangent } => {
            let start = a.right.at(along[0] + tangent);
            let end = b.left.at(along[1] + tangent);
            let reach = [a.line.project(start).station, b.line.project(end).station];
            let mut points = stub(a, Side::Right, reach[0], trims[0]);
            points.reverse();
            points.extend(bezier(start, point, end, if tangent > CLOSE { ROUND } else { 0 }));
            points.extend(stub(b, Side::Left, reach[1], trims[1]));
            points
        }
        Corner::Chord => Vec::new(),
        Corner::Open => {
            let mut points = stub(a, Side::Right, 0.0, trims[0]);
            points.reverse();
            points.extend(stub(b, Side::Left, 0.0, trims[1]));
            let hull = outer_hull(&[&[first], &points[..], &[last]].concat());
            hull[1..hull.len().max(2) - 1].to_vec()
        }
    };
    inner.retain(|p| (p - first).norm() > CLOSE && (p - last).norm() > CLOSE);
    inner.dedup_by(|p, q| (*p - *q).norm() <= CLOSE);
    [&[first], &inner[..], &[last]].concat()
}

/// The edge of the arm between two stations, metres, without its last point, which belongs to the cut.
fn stub(arm: &ThickenedArm, side: Side, from: f64, to: f64) -> Vec<Point> {
    let edge = arm.line.cut(from, to).and_then(|line| line.offset(side.sign() * arm.half, super::thicken::MITER_LIMIT));
    let mut points = edge.as_ref().map_or_else(Vec::new, |edge: &Polyline| edge.points().to_vec());
    points.pop();
    points
}

/// Points of the quadratic Bézier curve from `start` to `end` with the control point `corner`; only that for no pieces.
pub fn bezier(start: Point, corner: Point, end: Point, pieces: usize) -> Vec<Point> {
    if pieces == 0 {
        return vec![corner];
    }
    (0..=pieces)
        .map(|i| {
            let t = i as f64 / pieces as f64;
            let (a, b) = (start + (corner - start) * t, corner + (end - corner) * t);
            a + (b - a) * t
        })
        .collect()
}

/// The outer convex hull of a clockwise chain, by Graham's scan.
fn outer_hull(chain: &[Point]) -> Vec<Point> {
    let mut hull: Vec<Point> = Vec::new();
    for &p in chain {
        while hull.len() >= 2 && orientation(hull[hull.len() - 2], hull[hull.len() - 1], p) >= 0.0 {
            hull.pop();
        }
        hull.push(p);
    }
    hull
}

/// The clockwise ring of cuts and corners.
pub fn ring(cuts: &[OutlineCut], corners: &[Vec<Point>]) -> Vec<Point> {
    let mut ring = Vec::new();
    for (cut, corner) in cuts.iter().zip(corners) {
        ring.push(cut.right);
        ring.push(cut.left);
        if corner.len() > 2 {
            ring.extend(&corner[1..corner.len() - 1]);
        }
    }
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    ring
}
