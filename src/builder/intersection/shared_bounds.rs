//! The bounds that two turning lanelets would rather share: midway between those that each would have by itself.

use rustc_hash::FxHashMap;

use crate::geometry::polyline::{clear, clears, reaches};
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, curve};
use crate::lanelet::PointId;

use super::turn_centerline::MovementEnds;

/// A movement with its smoothest bounds, left and right.
pub type SmoothBounds<'a> = (MovementEnds<'a>, [Vec<Point>; 2]);

/// The bounds of a lane along a centre line.
pub fn smooth_bounds((_, from, to): &MovementEnds, centerline: &[Pose]) -> [Vec<Point>; 2] {
    curve::sides(centerline, 0.5 * from.width, 0.5 * to.width).map(|side| curve::untangled(&side))
}

/// A bound as one movement would have it.
struct PreferredBound<'a> {
    line: &'a [Point],
    /// The opposite bound of that movement.
    opposite: &'a [Point],
    /// Widths of the lane at its ends, metres.
    widths: [f64; 2],
    /// Whether the movement runs from the higher node to the lower.
    reversed: bool,
}

impl<'a> PreferredBound<'a> {
    fn new(((_, from, to), sides): &'a SmoothBounds, side: usize) -> Self {
        let reversed = from.nodes[side] > to.nodes[side];
        Self { line: &sides[side], opposite: &sides[1 - side], widths: [from.width, to.width], reversed }
    }

    /// The line from the lower node to the higher.
    fn upward(&self) -> Option<Polyline> {
        let line = Polyline::new(self.line.iter().copied())?;
        Some(if self.reversed { line.reversed() } else { line })
    }
}

/// The part of its width that a lane gives up for a shared bound; where it is more, the lane has its own.
const SQUEEZED_MOST: f64 = 0.2;

/// The least and the largest distance, metres, between the bounds of a lane with these widths at its ends.
fn distance_range([from, to]: [f64; 2]) -> [f64; 2] {
    [from.min(to) * (1.0 - SQUEEZED_MOST), from.max(to) * (1.0 + SQUEEZED_MOST)]
}

/// Whether every place of a bound is within this distance, metres, of another.
fn follows(bound: &[Point], other: &[Point], distance: f64) -> bool {
    let mut hint = 0;
    bound.iter().all(|&p| reaches(other, p, distance, &mut hint))
}

/// Whether a lane keeps nearly its widths, metres, between two bounds, measured from both.
pub fn keep_width([left, right]: [&[Point]; 2], widths: [f64; 2]) -> bool {
    let [low, high] = distance_range(widths);
    follows(left, right, high) && follows(right, left, high) && clear(left, right, low)
}

/// Whether a lane keeps nearly its widths, metres, between two bounds, measured from the first.
fn keeps_width(bound: &[Point], opposite: &[Point], widths: [f64; 2]) -> bool {
    let [low, high] = distance_range(widths);
    follows(bound, opposite, high) && clears(opposite, bound, low)
}

/// The bounds midway between those that two movements would have between the same nodes.
pub struct PreferredBounds {
    /// By the nodes at their ends, the lower first.
    lines: FxHashMap<[PointId; 2], Vec<Point>>,
}

impl PreferredBounds {
    /// Bounds that differ by no more than this, metres, are the same.
    const SAME_BOUND: f64 = 0.02;

    /// Of the movements of one intersection.
    pub fn new(movements: &[SmoothBounds]) -> Self {
        let long = |line: &Vec<Point>| line.windows(2).any(|w| (w[1] - w[0]).norm() > Polyline::MERGE);
        let mut sides: Vec<([PointId; 2], usize, usize)> = Vec::with_capacity(2 * movements.len());
        for (i, ((_, from, to), lines)) in movements.iter().enumerate() {
            if lines.iter().all(long) {
                let nodes = [0, 1].map(|side| [from.nodes[side], to.nodes[side]]).map(|[a, b]| [a.min(b), a.max(b)]);
                sides.extend([(nodes[0], i, 0), (nodes[1], i, 1)]);
            }
        }
        sides.sort_unstable();
        // Most bounds are those of one movement alone.
        let lines = sides.chunk_by(|a, b| a.0 == b.0).filter_map(|sides| {
            let [first, second] = sides else { return None };
            Some((
                first.0,
                Self::midway(&[first, second].map(|(_, i, side)| PreferredBound::new(&movements[*i], *side)))?,
            ))
        });
        Self { lines: lines.collect() }
    }

    /// The line midway between two; `None` where they agree, and where it would squeeze one of two opposite lanes.
    fn midway(both: &[PreferredBound; 2]) -> Option<Vec<Point>> {
        let [first, second] = both;
        let (a, b) = (first.line, second.line);
        if follows(a, b, Self::SAME_BOUND) && follows(b, a, Self::SAME_BOUND) {
            return None;
        }
        let (a, b) = (first.upward()?, second.upward()?);
        // Points are dense where a line bends: the line with more of them keeps its stations.
        let [more, fewer] = if a.points().len() >= b.points().len() { [&a, &b] } else { [&b, &a] };
        let part = fewer.length() / more.length();
        let beside = fewer.at_each(more.stations().iter().map(|station| station * part));
        let line: Vec<Point> = more.points().iter().zip(&beside).map(|(a, b)| nalgebra::center(a, b)).collect();
        let opposite = first.reversed != second.reversed;
        (!opposite || both.iter().all(|one| keeps_width(&line, one.opposite, one.widths))).then_some(line)
    }

    /// The places of a shared bound from one node to another; `None` where the movements keep their own.
    pub fn get(&self, from: PointId, to: PointId) -> Option<Vec<Point>> {
        let line = self.lines.get(&[from.min(to), from.max(to)])?;
        Some(if from < to { line.clone() } else { line.iter().rev().copied().collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_lanelets_share_a_bound_midway() {
        let line = |y: f64, middle: f64| {
            Polyline::new([(0.0, y), (5.0, y + middle), (10.0, y)].map(|(x, y)| Point::new(x, y))).unwrap()
        };
        // The second movement runs back along the bound.
        let midway = |bends: [f64; 2]| {
            let lines = [line(0.0, bends[0]), line(0.0, bends[1]).reversed()];
            let others = [line(3.0, bends[0]), line(-3.0, bends[1]).reversed()];
            let [lines, others] = [lines, others].map(|pair| pair.map(Polyline::into_points));
            let bound =
                |i: usize| PreferredBound { line: &lines[i], opposite: &others[i], widths: [3.0; 2], reversed: i == 1 };
            PreferredBounds::midway(&[bound(0), bound(1)])
        };
        let line = midway([0.4, -0.4]).unwrap();
        assert!(line.iter().all(|p| p.y.abs() < 1e-9), "{line:?}");
        assert_eq!(midway([0.4, 0.4]), None, "what agrees needs no other line");
        assert_eq!(midway([-1.0, 1.0]), None, "neither is squeezed");
    }
}
