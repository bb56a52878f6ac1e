//! Eases the bends of a line for a road of some width.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::iter::successors;

use crate::geometry::{Point, Polyline, angle_between, left_of};

/// The largest turn at one point, radians: 10 degrees. Offsets of the line then keep their shape.
const TURN_AT_POINT: f64 = 0.1746;
/// Radius of a bend if the line has room for it, metres.
const COMFORT: f64 = 12.0;
/// The largest distance of an eased line from the drawn corner, metres, unless the road's width needs more.
const DEVIATION: f64 = 0.8;
/// Least radius as a multiple of half the road's width: the inner edge keeps a radius of its own.
pub const TIGHTEST: f64 = 1.1;
/// Least radius of the inner edge of a bend, metres, if the line has room for it: Lanelet2's own checks want one metre.
pub const INNER_RADIUS: f64 = 1.25;
/// Share of a segment that each of its two corners may use.
const SHARE: f64 = 0.5;
/// Least length of an inner edge as a share of its segment.
const INNER: f64 = 0.05;

/// The line with every corner replaced by an arc, for a road of `half` metres to either side. Corners closer together than
/// the road is wide are merged first. The ends stay.
#[must_use]
pub fn eased(line: &Polyline, half: f64) -> Polyline {
    let tightest = half * TIGHTEST;
    let points = merge_close_corners(line.points().to_vec(), tightest);
    let mut eased = vec![points[0]];
    for (i, w) in points.windows(3).enumerate() {
        let room = room([w[0], w[1], w[2]], [i == 0, i + 3 == points.len()]);
        eased.extend(arc(w[0], w[1], w[2], room, tightest.max(half + INNER_RADIUS)));
    }
    eased.push(points[points.len() - 1]);
    Polyline::new(with_inner_edges(eased, half)).unwrap_or_else(|| line.clone())
}

/// Merges points whose bends leave nothing of the inner edge between them.
fn with_inner_edges(mut points: Vec<Point>, half: f64) -> Vec<Point> {
    points.dedup_by(|a, b| (*a - *b).norm() <= Polyline::MERGE);
    let mut chain = Chain::new(points);
    let mut at = Some(0);
    while let Some(i) = at
        && let Some(next) = chain.next(i)
    {
        // How much of the segment's left edge the bend at a point takes, metres.
        let bend = |corner: usize| {
            let around = chain.around(corner);
            around.map_or(0.0, |[a, b, c]| half * (angle_between(b - a, c - b) / 2.0).tan())
        };
        let taken = (bend(i) + bend(next)).abs();
        if taken <= (chain.points[next] - chain.points[i]).norm() * (1.0 - INNER) || chain.len == 2 {
            at = Some(next);
            continue;
        }
        // The merged bends take from the edges before them, too.
        let again = chain.before(i).and_then(|before| chain.before(before)).unwrap_or(0);
        match (chain.before(i), chain.next(next)) {
            (None, _) => chain.remove(next),
            (_, None) => chain.remove(i),
            _ => {
                chain.points[i] = nalgebra::center(&chain.points[i], &chain.points[next]);
                chain.remove(next);
            }
        }
        at = Some(again);
    }
    chain.into_points()
}

/// Drops corners until each has room for the tightest arc.
fn merge_close_corners(points: Vec<Point>, tightest: f64) -> Vec<Point> {
    let mut chain = Chain::new(points);
    let mut lacks = BinaryHeap::new();
    for i in 0..chain.points.len() {
        lacks.extend(chain.lack(i, tightest));
    }
    // The corner whose arc lacks the most room; of those that lack the same, the last.
    while let Some(lack) = lacks.pop() {
        let i = lack.corner;
        // A corner that has changed since stands in the heap once more.
        if chain.lack(i, tightest).as_ref() != Some(&lack) {
            continue;
        }
        let (Some(before), Some(after)) = (chain.before(i), chain.next(i)) else { continue };
        let to = |other: usize| (chain.points[i] - chain.points[other]).norm();
        let other = if to(before) < to(after) { before } else { after };
        let kept = if chain.around(other).is_none() {
            chain.remove(i);
            before
        } else {
            let (low, high) = (i.min(other), i.max(other));
            chain.points[low] = nalgebra::center(&chain.points[low], &chain.points[high]);
            chain.remove(high);
            chain.before(low).unwrap_or(low)
        };
        // What lies at one place now is one point.
        let mut at = kept;
        for _ in 0..2 {
            while let Some(next) = chain.next(at)
                && (chain.points[next] - chain.points[at]).norm() <= Polyline::MERGE
            {
                chain.remove(next);
            }
            let Some(next) = chain.next(at) else { break };
            at = next;
        }
        if chain.len < 3 {
            break;
        }
        let first = chain.before(kept).unwrap_or(kept);
        lacks.extend(
            successors(Some(first), |&one| chain.next(one)).take(5).filter_map(|one| chain.lack(one, tightest)),
        );
    }
    chain.into_points()
}

/// The points of a line while some are taken out.
struct Chain {
    points: Vec<Point>,
    /// For each point the ones before and after it; a point that was taken out has neither.
    links: Vec<[Option<usize>; 2]>,
    len: usize,
}

impl Chain {
    fn new(points: Vec<Point>) -> Self {
        let len = points.len();
        let links = (0..len).map(|i| [i.checked_sub(1), Some(i + 1).filter(|&next| next < len)]).collect();
        Self { points, links, len }
    }

    fn before(&self, i: usize) -> Option<usize> {
        self.links[i][0]
    }

    fn next(&self, i: usize) -> Option<usize> {
        self.links[i][1]
    }

    /// A corner between its neighbours; `None` for the ends.
    fn around(&self, i: usize) -> Option<[Point; 3]> {
        let [before, next] = self.links[i];
        Some([self.points[before?], self.points[i], self.points[next?]])
    }

    fn remove(&mut self, i: usize) {
        let [before, next] = std::mem::take(&mut self.links[i]);
        if let Some(before) = before {
            self.links[before][1] = next;
        }
        if let Some(next) = next {
            self.links[next][0] = before;
        }
        self.len -= 1;
    }

    /// What a corner lacks of the room for its arc; `None` if that has room.
    fn lack(&self, corner: usize, tightest: f64) -> Option<Lack> {
        let [a, b, c] = self.around(corner)?;
        let is_end = |at: Option<usize>| at.is_some_and(|at| self.around(at).is_none());
        let [before, next] = self.links[corner];
        let metres = tangent(a, b, c, tightest) - room([a, b, c], [is_end(before), is_end(next)]);
        (metres > 0.0).then_some(Lack { metres, corner })
    }

    fn into_points(self) -> Vec<Point> {
        // The first point is never taken out.
        let row = successors((self.len > 0).then_some(0), |&i| self.next(i));
        row.map(|i| self.points[i]).collect()
    }
}

/// How much room the arc of a corner lacks; the larger lack is greater, of equal ones that of the later corner.
#[derive(PartialEq)]
struct Lack {
    metres: f64,
    corner: usize,
}

impl Eq for Lack {}

impl Ord for Lack {
    fn cmp(&self, other: &Self) -> Ordering {
        self.metres.total_cmp(&other.metres).then(self.corner.cmp(&other.corner))
    }
}

impl PartialOrd for Lack {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// How far the arc at corner `b` may reach along its segments, metres; `ends` says which of them end the line.
fn room([a, b, c]: [Point; 3], ends: [bool; 2]) -> f64 {
    let share = |at_end: bool| if at_end { 1.0 } else { SHARE };
    let before = (b - a).norm() * share(ends[0]);
    let after = (c - b).norm() * share(ends[1]);
    before.min(after)
}

/// Distance from corner `b` at which an arc of this radius begins, metres.
fn tangent(a: Point, b: Point, c: Point, radius: f64) -> f64 {
    radius * (angle_between(b - a, c - b).abs() / 2.0).tan()
}

/// The points of the arc at corner `b`, a fillet.
fn arc(a: Point, b: Point, c: Point, room: f64, wanted: f64) -> Vec<Point> {
    let turn = angle_between(b - a, c - b);
    let half_turn = turn.abs() / 2.0;
    if half_turn * 2.0 <= TURN_AT_POINT {
        return vec![b];
    }
    let off_corner = 1.0 / half_turn.cos() - 1.0;
    let radius = COMFORT.min(DEVIATION / off_corner).max(wanted).min(room / half_turn.tan());
    let (u, v) = ((b - a).normalize(), (c - b).normalize());
    let begin = b - u * (radius * half_turn.tan());
    let centre = begin + left_of(u) * (radius * turn.signum());
    let pieces = (turn.abs() / TURN_AT_POINT).ceil().max(1.0) as usize;
    let end = b + v * (radius * half_turn.tan());
    let spoke = begin - centre;
    (0..=pieces)
        .map(|i| match i {
            0 => begin,
            _ if i == pieces => end,
            _ => centre + nalgebra::Rotation2::new(turn * i as f64 / pieces as f64) * spoke,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[(f64, f64)]) -> Polyline {
        Polyline::new(points.iter().map(|(x, y)| Point::new(*x, *y))).unwrap()
    }

    fn sharpest(line: &Polyline) -> f64 {
        line.points().windows(3).map(|w| angle_between(w[1] - w[0], w[2] - w[1]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_straight_line_stays() {
        let straight = line(&[(0.0, 0.0), (10.0, 0.5), (20.0, 0.0)]);
        assert_eq!(eased(&straight, 3.0), straight);
    }

    #[test]
    fn a_right_angle_becomes_an_arc() {
        let bend = eased(&line(&[(0.0, 0.0), (30.0, 0.0), (30.0, 30.0)]), 4.0);
        assert!(sharpest(&bend) <= TURN_AT_POINT + 1e-9);
        assert!(bend.distance(Point::new(30.0, 0.0)) < (4.0 + INNER_RADIUS) * 0.42);
        let inner = bend.offset(4.0, 2.0).unwrap();
        assert!(inner.points().windows(2).all(|w| (w[1] - w[0]).dot(&(w[1] - w[0])) > 0.0));
        assert_eq!((bend.first(), bend.last()), (Point::new(0.0, 0.0), Point::new(30.0, 30.0)));
    }

    #[test]
    fn the_inner_edge_of_a_bend_has_a_radius_of_its_own() {
        for (half, turned) in [(1.5, 90.0_f64), (3.0, 90.0), (3.0, 140.0), (6.0, 120.0)] {
            let onward = nalgebra::Rotation2::new(turned.to_radians()) * crate::geometry::Vector::new(60.0, 0.0);
            let corner = Point::new(60.0, 0.0);
            let bend = eased(&Polyline::new([Point::origin(), corner, corner + onward]).unwrap(), half);
            let radius = |w: &[Point]| (w[1] - w[0]).norm() / angle_between(w[1] - w[0], w[2] - w[1]).abs();
            let tightest = bend.points()[1..].windows(3).map(radius).fold(f64::INFINITY, f64::min);
            assert!(tightest - half > 1.0, "{half} m: {tightest} m");
        }
    }

    #[test]
    fn a_spike_is_removed() {
        let spike = eased(&line(&[(0.0, 0.0), (20.0, 0.0), (18.0, 0.1), (40.0, 0.0)]), 3.0);
        assert!(sharpest(&spike) <= TURN_AT_POINT + 1e-9);
        assert!(spike.length() < 41.0);
    }
}
