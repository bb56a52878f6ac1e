//! Walks the cuts and the corners between them clockwise into one ring.

use crate::geometry::{Point, Polyline, orientation};

use super::OutlineCut;
use super::thicken::{Side, ThickenedArm};

/// Points of a corner closer together than this, metres, are one.
const CLOSE: f64 = 0.02;
/// Pieces of a rounded corner.
const ROUND: usize = 6;

/// The corner between an arm and the next one clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Corner {
    /// Their edges collide at a point, so far along the first one's right and the second one's left edge; the corner
    /// is rounded off by a curve that leaves both edges `tangent` metres from the point.
    Collision { point: Point, along: [f64; 2], tangent: f64 },
    /// Their edges never collide: the arms lie more than a half turn apart.
    Open,
    /// Straight from cut to cut.
    Chord,
}

/// The cut across an arm at a station.
pub fn cut(arm: &ThickenedArm, station: f64) -> OutlineCut {
    OutlineCut { at: arm.at, left: arm.corner(station, Side::Right), right: arm.corner(station, Side::Left) }
}

/// The kerb from the cut of `a` at station `trims[0]` to that of `b`, the next arm clockwise; `first` and `last` are the ends
/// of the cuts.
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
            points.extend(rounded(start, point, end, if tangent > CLOSE { ROUND } else { 0 }));
            points.extend(stub(b, Side::Left, reach[1], trims[1]));
            points
        }
        Corner::Chord => Vec::new(),
        Corner::Open => {
            let mut points = stub(a, Side::Right, 0.0, trims[0]);
            points.reverse();
            points.extend(stub(b, Side::Left, 0.0, trims[1]));
            let mut chain = vec![first];
            chain.extend(points);
            chain.push(last);
            let hull = outer_hull(&chain);
            hull[1..hull.len().max(2) - 1].to_vec()
        }
    };
    inner.retain(|p| (p - first).norm() > CLOSE && (p - last).norm() > CLOSE);
    inner.dedup_by(|p, q| (*p - *q).norm() <= CLOSE);
    let mut chain = vec![first];
    chain.extend(inner);
    chain.push(last);
    chain
}

/// The edge of the arm between two stations, outwards, without its last point, which is the cut's.
fn stub(arm: &ThickenedArm, side: Side, from: f64, to: f64) -> Vec<Point> {
    let edge = arm.line.cut(from, to).and_then(|line| line.offset(side.sign() * arm.half, super::thicken::MITER_LIMIT));
    let mut points = edge.as_ref().map_or_else(Vec::new, |edge: &Polyline| edge.points().to_vec());
    points.pop();
    points
}

/// Points of a curve that leaves the edges at `start` and `end` tangentially toward `corner`.
fn rounded(start: Point, corner: Point, end: Point, pieces: usize) -> Vec<Point> {
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

/// The part of a clockwise chain that remains when a string is drawn tight around its outside.
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

/// The ring of cuts and corners, clockwise.
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
