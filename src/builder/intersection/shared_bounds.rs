//! Bounds that two ways through an intersection share: midway where neither would have them just there.

use rustc_hash::FxHashMap;

use crate::geometry::polyline::{clear, clears, reaches};
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, curve};
use crate::lanelet::PointId;

use super::turn_centerline::MovementEnds;

/// A way between two lanes, with its bounds as they are smoothest, left and right.
pub type Smooth<'a> = (MovementEnds<'a>, [Vec<Point>; 2]);

/// The bounds of a lane that follows a course.
pub fn smooth((_, from, to): &MovementEnds, course: &[Pose]) -> [Vec<Point>; 2] {
    curve::sides(course, 0.5 * from.width, 0.5 * to.width).map(|side| curve::untangled(&side))
}

/// A bound as one way would have it.
struct Wanted<'a> {
    line: &'a [Point],
    /// The other bound of that way.
    other: &'a [Point],
    /// Widths of the way at its ends, metres.
    width: [f64; 2],
    /// Whether the way runs from the higher node to the lower.
    reversed: bool,
}

impl Wanted<'_> {
    /// The line from the lower node to the higher.
    fn upward(&self) -> Option<Polyline> {
        let line = Polyline::new(self.line.iter().copied())?;
        Some(if self.reversed { line.reversed() } else { line })
    }
}

/// Part of its width that a way gives up for a bound that it shares: more, and it has one of its own.
const SQUEEZED_MOST: f64 = 0.2;

/// How close the bounds of a way may come to each other, and how far they may lie apart, where it is as wide as this at its ends
/// or nearly so.
fn apart_by([from, to]: [f64; 2]) -> [f64; 2] {
    [from.min(to) * (1.0 - SQUEEZED_MOST), from.max(to) * (1.0 + SQUEEZED_MOST)]
}

/// Whether every place of a bound is this close to another.
fn follows(bound: &[Point], other: &[Point], distance: f64) -> bool {
    let mut hint = 0;
    bound.iter().all(|&p| reaches(other, p, distance, &mut hint))
}

/// Whether two bounds are as far from each other as the way between them is wide, or nearly so.
pub fn keep_width([left, right]: [&[Point]; 2], width: [f64; 2]) -> bool {
    let [low, high] = apart_by(width);
    follows(left, right, high) && follows(right, left, high) && clear(left, right, low)
}

/// Whether a bound is as far from the other one as the way between them is wide, or nearly so.
fn keeps_width(bound: &[Point], other: &[Point], width: [f64; 2]) -> bool {
    let [low, high] = apart_by(width);
    follows(bound, other, high) && clears(other, bound, low)
}

/// Bounds that two ways through an intersection share although neither runs quite where the other would have it: they
/// meet midway.
pub struct PreferredBounds {
    /// By the nodes at their ends, the lower first.
    lines: FxHashMap<[PointId; 2], Vec<Point>>,
}

impl PreferredBounds {
    /// Bounds that differ by no more, metres, are the same.
    const SAME: f64 = 0.02;

    /// Of ways through one intersection.
    pub fn new(ways: &[Smooth]) -> Self {
        let long = |line: &Vec<Point>| line.windows(2).any(|w| (w[1] - w[0]).norm() > Polyline::MERGE);
        let mut wanted: Vec<([PointId; 2], usize, usize)> = Vec::with_capacity(2 * ways.len());
        for (way, ((_, from, to), sides)) in ways.iter().enumerate().filter(|(_, (_, sides))| sides.iter().all(long)) {
            let nodes = |side: usize| [from.nodes[side], to.nodes[side]];
            let lower_first = |[a, b]: [PointId; 2]| [a.min(b), a.max(b)];
            wanted.extend((0..sides.len()).map(|side| (lower_first(nodes(side)), way, side)));
        }
        wanted.sort_unstable();
        let as_wanted = |&(_, way, side): &([PointId; 2], usize, usize)| {
            let ((_, from, to), sides) = &ways[way];
            let reversed = from.nodes[side] > to.nodes[side];
            Wanted { line: &sides[side], other: &sides[1 - side], width: [from.width, to.width], reversed }
        };
        // Most bounds are those of one way alone.
        let lines = wanted.chunk_by(|a, b| a.0 == b.0).filter_map(|wanted| match wanted {
            [first, second] => Some((first.0, Self::midway(&[first, second].map(as_wanted))?)),
            _ => None,
        });
        Self { lines: lines.collect() }
    }

    /// The line between two; `None` where they agree, and where it would squeeze either of two opposite ways.
    fn midway(wanted: &[Wanted; 2]) -> Option<Vec<Point>> {
        let [first, second] = wanted;
        let (a, b) = (first.line, second.line);
        if follows(a, b, Self::SAME) && follows(b, a, Self::SAME) {
            return None;
        }
        let (a, b) = (first.upward()?, second.upward()?);
        // Points stand close where a line bends: those of the one that has more of them stay where they are along it.
        let [more, fewer] = if a.points().len() >= b.points().len() { [&a, &b] } else { [&b, &a] };
        let part = fewer.length() / more.length();
        let beside = fewer.at_each(more.stations().iter().map(|station| station * part));
        let line: Vec<Point> = more.points().iter().zip(&beside).map(|(a, b)| nalgebra::center(a, b)).collect();
        let opposite = first.reversed != second.reversed;
        (!opposite || wanted.iter().all(|way| keeps_width(&line, way.other, way.width))).then_some(line)
    }

    /// The places of a bound from one node to another; `None` where it runs as each of its ways would have it.
    pub fn get(&self, from: PointId, to: PointId) -> Option<Vec<Point>> {
        let line = self.lines.get(&[from.min(to), from.max(to)])?;
        Some(if from < to { line.clone() } else { line.iter().rev().copied().collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_ways_meet_midway_on_the_bound_that_they_share() {
        let line = |y: f64, middle: f64| {
            Polyline::new([(0.0, y), (5.0, y + middle), (10.0, y)].map(|(x, y)| Point::new(x, y))).unwrap()
        };
        // The second way runs back along the bound.
        let midway = |bends: [f64; 2]| {
            let lines = [line(0.0, bends[0]), line(0.0, bends[1]).reversed()];
            let others = [line(3.0, bends[0]), line(-3.0, bends[1]).reversed()];
            let [lines, others] = [lines, others].map(|pair| pair.map(Polyline::into_points));
            let way = |i: usize| Wanted { line: &lines[i], other: &others[i], width: [3.0; 2], reversed: i == 1 };
            PreferredBounds::midway(&[way(0), way(1)])
        };
        let line = midway([0.4, -0.4]).unwrap();
        assert!(line.iter().all(|p| p.y.abs() < 1e-9), "{line:?}");
        assert_eq!(midway([0.4, 0.4]), None, "what agrees needs no other line");
        assert_eq!(midway([-1.0, 1.0]), None, "neither is squeezed");
    }
}
