//! A joint: the borders of a lane that ends and of a lane that starts are pulled to common points.

use crate::geometry::{Point, Vector, line_crossing, segment_crossing};

/// Borders that end closer together than this, metres, meet.
const TOUCH: f64 = 1e-3;
/// The longest miter as a multiple of the larger half width.
const MITER_LIMIT: f64 = 3.0;
/// The cosine of the turn, 120 degrees, from which on a longer miter is clamped. Below, a bevel replaces it.
const CLAMPED: f64 = -0.5;
/// A border of more points than this is a curve: it is not trimmed to where it crosses the other border.
const MAX_SPARSE: usize = 6;

/// A border seen from a joint: point 0 lies at the joint.
#[derive(Clone, Copy, Debug)]
pub struct Strand<'a> {
    points: &'a [Point],
    /// Whether the points are in reverse order.
    reversed: bool,
}

impl<'a> Strand<'a> {
    /// A border of the lane that ends at the joint.
    pub fn ending(points: &'a [Point]) -> Self {
        Self { points, reversed: true }
    }

    /// A border of the lane that starts at the joint.
    pub fn starting(points: &'a [Point]) -> Self {
        Self { points, reversed: false }
    }

    /// The end at the joint.
    pub fn tip(&self) -> Point {
        self.at(0)
    }

    fn at(&self, i: usize) -> Point {
        self.points[if self.reversed { self.points.len() - 1 - i } else { i }]
    }

    fn len(&self) -> usize {
        self.points.len()
    }

    /// The unit direction from one point to another; zero if they coincide.
    fn toward(&self, from: usize, to: usize) -> Vector {
        (self.at(to) - self.at(from)).try_normalize(0.0).unwrap_or_default()
    }

    /// The length from the joint to a point, metres.
    fn length_to(&self, point: usize) -> f64 {
        (0..point).map(|i| (self.at(i + 1) - self.at(i)).norm()).sum()
    }

    fn is_sparse(&self) -> bool {
        self.len() <= MAX_SPARSE
    }

    /// The length, metres, that this joint may trim: half, so that the joint at the other end may trim as much.
    fn spare(&self) -> f64 {
        self.length_to(self.len() - 1) / 2.0
    }

    /// The number of points that lie beyond the new end of the border: with them it would run back to it.
    fn points_beyond(&self, place: Point, spare: f64) -> usize {
        let beyond = |i: &usize| (place - self.at(*i)).dot(&self.toward(*i + 1, *i)) <= TOUCH;
        1 + (1..self.len() - 1).take_while(|i| beyond(i) && self.length_to(*i) < spare).count()
    }
}

/// How a border ends at a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// The common point of both borders.
    pub place: Point,
    /// The number of points at the joint that the common point replaces; at least 1.
    pub lost: usize,
}

/// Pulls the border that ends at a joint and the border that starts there, on the same side, to one point. `half` is the larger
/// of both half widths on that side, metres.
pub fn meet(borders: [Strand; 2], joint: Point, half: f64) -> [Pull; 2] {
    let spare = borders.map(|border| border.spare());
    if let Some(pulls) = crossing(borders, spare, half) {
        return pulls;
    }
    let bevel = || nalgebra::center(&borders[0].at(0), &borders[1].at(0));
    let place = miter(borders, spare, joint, half).unwrap_or_else(bevel);
    [0, 1].map(|i| Pull { place, lost: borders[i].points_beyond(place, spare[i]) })
}

/// On the inside of a bend the borders cross: they end there. Only sparse borders lose points.
fn crossing(borders: [Strand; 2], spare: [f64; 2], half: f64) -> Option<[Pull; 2]> {
    let [a, b] = borders;
    let [deep_a, deep_b] = borders.map(|border| if border.is_sparse() { border.len() - 1 } else { 1 });
    // Pairs of segments, the nearest to the joint first.
    let pairs = (0..deep_a + deep_b - 1).flat_map(|sum| (0..=sum).map(move |i| (i, sum - i)));
    let mut crossings = pairs.filter(|&(i, j)| i < deep_a && j < deep_b).filter_map(|(i, j)| {
        let (s, t, place) = segment_crossing(a.at(i), a.at(i + 1), b.at(j), b.at(j + 1))?;
        let [a, b] = [(a, i, s), (b, j, t)].map(|(border, segment, part)| {
            let [from, to] = [segment, segment + 1].map(|point| border.length_to(point));
            // A point at the crossing is replaced too.
            let on_next = segment + 2 < border.len() && (1.0 - part) * (to - from) <= TOUCH;
            (from + part * (to - from), Pull { place, lost: segment + 1 + usize::from(on_next) })
        });
        let near = (i, j) == (0, 0) || a.0.max(b.0) <= MITER_LIMIT * half;
        (near && a.0 < spare[0] && b.0 < spare[1]).then_some([a.1, b.1])
    });
    crossings.next()
}

/// On the outside of a bend the borders are extended to their miter, if it is not too long; `None` if a bevel joins them.
fn miter([a, b]: [Strand; 2], spare: [f64; 2], joint: Point, half: f64) -> Option<Point> {
    let [from, to] = [a.at(0), b.at(0)];
    if (to - from).norm() <= TOUCH {
        return None;
    }
    let (into, out) = (a.toward(1, 0), b.toward(0, 1));
    let (ahead, behind, place) = line_crossing(from, into, to, out)?;
    let (cap, far) = (MITER_LIMIT * half, (place - joint).norm());
    if far <= cap {
        // A miter may not trim a border by more than its end segment.
        let holds = |border: Strand, back: f64, spare: f64| back < spare.min(border.length_to(1));
        return (holds(a, -ahead, spare[0]) && holds(b, behind, spare[1])).then_some(place);
    }
    let outside = ahead >= 0.0 && behind <= 0.0;
    (outside && into.dot(&out) <= CLAMPED).then(|| joint + (place - joint) * (cap / far))
}
