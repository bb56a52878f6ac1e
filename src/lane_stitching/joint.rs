//! A joint: where the borders of a lane that ends and of one that starts are pulled to one point.

use crate::geometry::{Point, Vector, line_crossing, segment_crossing};

/// Borders that end closer together than this, metres, meet already.
const TOUCH: f64 = 1e-3;
/// A miter lies no farther from the joint than so many times the larger half width.
const MITER_MOST: f64 = 3.0;
/// Cosine of the turn, 120 degrees, from which on a miter that would lie farther is clamped; below, it is a bevel.
const CLAMPED: f64 = -0.5;
/// A border of more points than this is a curve: it is not trimmed back to where it crosses the other one.
const SPARSE: usize = 6;

/// One border at a joint, seen from there: its points from the joint on.
#[derive(Clone, Copy, Debug)]
pub struct Strand<'a> {
    points: &'a [Point],
    /// Whether the points stand the other way round.
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

    /// Where the border ends.
    pub fn tip(&self) -> Point {
        self.at(0)
    }

    fn at(&self, i: usize) -> Point {
        self.points[if self.reversed { self.points.len() - 1 - i } else { i }]
    }

    fn len(&self) -> usize {
        self.points.len()
    }

    /// Unit direction from one of its points to another; zero if they lie on each other.
    fn toward(&self, from: usize, to: usize) -> Vector {
        (self.at(to) - self.at(from)).try_normalize(0.0).unwrap_or_default()
    }

    /// The length of its segments before a point, metres.
    fn length_to(&self, point: usize) -> f64 {
        (0..point).map(|i| (self.at(i + 1) - self.at(i)).norm()).sum()
    }

    fn is_sparse(&self) -> bool {
        self.len() <= SPARSE
    }

    /// How many metres may fall away so that as much is left for the joint at the other end.
    fn spare(&self) -> f64 {
        self.length_to(self.len() - 1) / 2.0
    }

    /// How many of its points lie behind the place where it is to end, as seen along itself: with them it would run
    /// back to there.
    fn behind(&self, place: Point, spare: f64) -> usize {
        let passed = |i: &usize| (place - self.at(*i)).dot(&self.toward(*i + 1, *i)) <= TOUCH;
        1 + (1..self.len() - 1).take_while(|i| passed(i) && self.length_to(*i) < spare).count()
    }
}

/// How a border ends at a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// The point that it shares with the other border.
    pub place: Point,
    /// How many of its own points, from the joint on, make way for that point; at least its end.
    pub lost: usize,
}

/// Pulls two borders of one side to one point: the one that ends at the joint and the one that starts there. `half` is
/// the larger of both lanes' widths, metres, from the joint to that side.
pub fn meet(borders: [Strand; 2], joint: Point, half: f64) -> [Pull; 2] {
    let spare = borders.map(|border| border.spare());
    if let Some(crossed) = crossed(borders, spare, half) {
        return crossed;
    }
    let bevel = || nalgebra::center(&borders[0].at(0), &borders[1].at(0));
    let place = reached(borders, spare, joint, half).unwrap_or_else(bevel);
    [0, 1].map(|i| Pull { place, lost: borders[i].behind(place, spare[i]) })
}

/// Inside of a bend the borders cross: they end there. Only of sparse borders points fall away for that.
fn crossed(borders: [Strand; 2], spare: [f64; 2], half: f64) -> Option<[Pull; 2]> {
    let [a, b] = borders;
    let [deep_a, deep_b] = borders.map(|border| if border.is_sparse() { border.len() - 1 } else { 1 });
    // The nearest to the joint first.
    let pairs = (0..deep_a + deep_b - 1).flat_map(|sum| (0..=sum).map(move |i| (i, sum - i)));
    let mut crossings = pairs.filter(|&(i, j)| i < deep_a && j < deep_b).filter_map(|(i, j)| {
        let (s, t, place) = segment_crossing(a.at(i), a.at(i + 1), b.at(j), b.at(j + 1))?;
        let [a, b] = [(a, i, s), (b, j, t)].map(|(border, segment, part)| {
            let [from, to] = [segment, segment + 1].map(|point| border.length_to(point));
            // A point that all but lies there is that place.
            let on_next = segment + 2 < border.len() && (1.0 - part) * (to - from) <= TOUCH;
            (from + part * (to - from), Pull { place, lost: segment + 1 + usize::from(on_next) })
        });
        let near = (i, j) == (0, 0) || a.0.max(b.0) <= MITER_MOST * half;
        (near && a.0 < spare[0] && b.0 < spare[1]).then_some([a.1, b.1])
    });
    crossings.next()
}

/// Outside of a bend the borders are drawn out to their miter, if that is not too far; `None` where a bevel joins them.
fn reached([a, b]: [Strand; 2], spare: [f64; 2], joint: Point, half: f64) -> Option<Point> {
    let [from, to] = [a.at(0), b.at(0)];
    if (to - from).norm() <= TOUCH {
        return None;
    }
    let (into, out) = (a.toward(1, 0), b.toward(0, 1));
    let (ahead, behind, place) = line_crossing(from, into, to, out)?;
    let (cap, far) = (MITER_MOST * half, (place - joint).norm());
    if far <= cap {
        // Where a border would have to go back past its end segment, that segment is no part of the miter.
        let holds = |border: Strand, back: f64, spare: f64| back < spare.min(border.length_to(1));
        return (holds(a, -ahead, spare[0]) && holds(b, behind, spare[1])).then_some(place);
    }
    let outside = ahead >= 0.0 && behind <= 0.0;
    (outside && into.dot(&out) <= CLAMPED).then(|| joint + (place - joint) * (cap / far))
}
