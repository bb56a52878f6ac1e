//! Bounds that two ways through an intersection share: midway where neither would have them just there.

use rustc_hash::FxHashMap;

use crate::geometry::{Point, Polyline, curve, curve::Pose};
use crate::lanelet::PointId;

use super::course::Ends;
use super::lanes::ArmLane;

/// The bounds of a lane that follows a course.
pub fn smooth([from, to]: [&ArmLane; 2], course: &[Pose]) -> [Vec<Point>; 2] {
    [0.5, -0.5].map(|sign| curve::beside(course, sign * from.width, sign * to.width))
}

/// A bound as one way would have it.
struct Wanted<'a> {
    line: &'a Polyline,
    /// The other bound of that way.
    other: &'a Polyline,
    /// Widths of the way at its ends, metres.
    width: [f64; 2],
    /// Whether the way runs from the higher node to the lower.
    reversed: bool,
}

impl Wanted<'_> {
    /// Places on the line, evenly spread from the lower node to the higher.
    fn spread(&self, count: usize) -> Vec<Point> {
        let mut points = self.line.resampled_to(count).into_points();
        if self.reversed {
            points.reverse();
        }
        points
    }
}

/// Part of its width that a way gives up for a bound that it shares: more, and it has one of its own.
const SQUEEZED_MOST: f64 = 0.2;

/// Whether a bound is as far from the other one as the way between them is wide, or nearly so.
pub fn keeps_width(bound: &[Point], other: &Polyline, [from, to]: [f64; 2]) -> bool {
    let (low, high) = (from.min(to) * (1.0 - SQUEEZED_MOST), from.max(to) * (1.0 + SQUEEZED_MOST));
    let mut hint = 0;
    bound.iter().all(|&p| other.reaches(p, high, &mut hint)) && other.clears(bound, low)
}

/// Bounds that two ways through an intersection share although neither runs quite where the other would have it: they
/// meet midway.
pub struct Meant {
    lines: FxHashMap<(PointId, PointId), Vec<Point>>,
}

impl Meant {
    /// Bounds that differ by no more, metres, are the same.
    const SAME: f64 = 0.02;

    /// Of the ways between two ends each, with their middles.
    pub fn new(courses: &[(Ends, Vec<Pose>)]) -> Self {
        let nodes = |(_, from, to): &Ends, side: usize| {
            let (a, b) = (from.nodes[side], to.nodes[side]);
            (a.min(b), a.max(b))
        };
        // Most bounds are those of one way alone, and are not drawn here.
        let mut ways: FxHashMap<(PointId, PointId), usize> = FxHashMap::default();
        for (ends, _) in courses {
            [0, 1].into_iter().for_each(|side| *ways.entry(nodes(ends, side)).or_default() += 1);
        }
        let bounds = |(ends, course): &(Ends, Vec<Pose>)| {
            if (0..2).all(|side| ways[&nodes(ends, side)] < 2) {
                return [None, None];
            }
            smooth([ends.1, ends.2], course).map(|places| Polyline::new(curve::untangled(&places)))
        };
        let bounds: Vec<[Option<Polyline>; 2]> = courses.iter().map(bounds).collect();
        let mut wanted: FxHashMap<(PointId, PointId), Vec<Wanted>> = FxHashMap::default();
        for ((ends, _), bounds) in courses.iter().zip(&bounds) {
            let [Some(left), Some(right)] = bounds else { continue };
            for (side, [line, other]) in [[left, right], [right, left]].into_iter().enumerate() {
                let (_, from, to) = ends;
                let reversed = from.nodes[side] > to.nodes[side];
                let wanted = wanted.entry(nodes(ends, side)).or_default();
                wanted.push(Wanted { line, other, width: [from.width, to.width], reversed });
            }
        }
        let lines = wanted.into_iter().filter_map(|(ends, lines)| Some((ends, Self::midway(&lines)?))).collect();
        Self { lines }
    }

    /// The line between two; `None` where they agree, where it would squeeze either of two opposite ways, and where more
    /// have a say.
    fn midway(wanted: &[Wanted]) -> Option<Vec<Point>> {
        let [first, second] = wanted else { return None };
        let (a, b) = (first.line, second.line);
        let along = |of: &Polyline, from: &Polyline| {
            let mut hint = 0;
            let mut points = of.points().iter();
            points.all(|&p| from.reaches(p, Self::SAME, &mut hint))
        };
        if along(a, b) && along(b, a) {
            return None;
        }
        let count = a.points().len().max(b.points().len());
        let (a, b) = (first.spread(count), second.spread(count));
        let line: Vec<Point> = a.iter().zip(&b).map(|(a, b)| nalgebra::center(a, b)).collect();
        let opposite = first.reversed != second.reversed;
        (!opposite || wanted.iter().all(|way| keeps_width(&line, way.other, way.width))).then_some(line)
    }

    /// The places of a bound from one node to another; `None` where it runs as each of its ways would have it.
    pub fn get(&self, from: PointId, to: PointId) -> Option<Vec<Point>> {
        match self.lines.get(&(from, to)) {
            Some(line) => Some(line.clone()),
            None => self.lines.get(&(to, from)).map(|line| line.iter().rev().copied().collect()),
        }
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
            let way = |i: usize| Wanted { line: &lines[i], other: &others[i], width: [3.0; 2], reversed: i == 1 };
            Meant::midway(&[way(0), way(1)])
        };
        let line = midway([0.4, -0.4]).unwrap();
        assert!(line.iter().all(|p| p.y.abs() < 1e-9), "{line:?}");
        assert_eq!(midway([0.4, 0.4]), None, "what agrees needs no other line");
        assert_eq!(midway([-1.0, 1.0]), None, "neither is squeezed");
    }
}
