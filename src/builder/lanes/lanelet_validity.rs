//! Whether two bounds make a valid lanelet that Autoware's loader reads as it is drawn.

use crate::geometry::polyline::all_clear;
use crate::geometry::separation::are_apart;
use crate::geometry::{Point, Vector, cross, left_of, polygon, simple_ring};

/// The part of its width that a lane keeps everywhere.
const WIDTH_LEFT: f64 = 0.4;
/// No bound turns more sharply than this at a point, degrees: that is a leftover of a loop.
const KINK_MOST: f64 = 75.0;
/// No bound is shorter than this, metres: it would have no direction.
const LENGTH_LEAST: f64 = 0.2;
/// Segments whose distances to a point differ by less than this, metres, are equally near.
const EQUALLY_NEAR: f64 = 1e-6;
/// An outline that turns back on itself within this, degrees, encloses nothing there.
const SPIKE: f64 = 1e-6;
/// A point this far, metres, to one side of a line lies there in spite of rounding, and is no spike across it.
const SURE: f64 = 1e-4;

/// Whether a lane of this width, metres, has a simple outline, bounds without kinks on their own sides, and is nowhere
/// pinched.
pub fn is_valid<L: AsRef<[Point]>>(bounds: &[L; 2], width: f64) -> bool {
    let bounds = bounds.each_ref().map(AsRef::as_ref);
    let [left, right] = bounds;
    let long = |line: &[Point]| line.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>() >= LENGTH_LEAST;
    let least = WIDTH_LEFT * width;
    let apart = are_apart(left, right, least);
    let wide = || apart || all_clear(left, right, least) && all_clear(right, left, least);
    bounds.iter().all(|line| long(line) && !has_kink(line))
        && wide()
        && are_read_as_drawn(&bounds)
        && has_simple_outline(&bounds, apart)
}

/// Whether the outline between the bounds is simple, with the left bound on the left.
pub fn is_simple<L: AsRef<[Point]>>(bounds: &[L; 2]) -> bool {
    let bounds = bounds.each_ref().map(AsRef::as_ref);
    has_simple_outline(&bounds, are_apart(bounds[0], bounds[1], 0.0))
}

/// As [`is_simple`], for bounds that are known to lie `apart` or not.
fn has_simple_outline(bounds: &[&[Point]; 2], apart: bool) -> bool {
    let outline = bounds[0].iter().chain(bounds[1].iter().rev());
    polygon::area_around(outline.clone()) < 0.0
        && (apart && runs_straight_on(bounds)
            || simple_ring::faults(&outline.copied().collect::<Vec<Point>>(), SPIKE, 1).is_empty())
}

/// A quick sufficient test that bounds which lie apart have a simple outline: neither bound turns back, and the whole lane lies
/// between its two ends.
fn runs_straight_on([left, right]: &[&[Point]; 2]) -> bool {
    let onward = |line: &[Point]| {
        let chord = line[line.len() - 1] - line[0];
        let least = SURE * chord.norm();
        line.windows(2).all(|w| (w[1] - w[0]).dot(&chord) > least)
    };
    let behind = |end: Point, out: Vector, lines: [&[Point]; 2]| {
        let least = SURE * out.norm();
        lines.iter().all(|line| line.iter().all(|p| (p - end).dot(&out) < -least))
    };
    let (l, r) = (left.len() - 1, right.len() - 1);
    onward(left)
        && onward(right)
        && behind(left[0], -left_of(right[0] - left[0]), [&left[1..], &right[1..]])
        && behind(left[l], left_of(right[r] - left[l]), [&left[..l], &right[..r]])
}

/// Whether the loader keeps the directions of both bounds: it looks at one point of each, and on which side of the other this
/// lies.
pub fn are_read_as_drawn<L: AsRef<[Point]>>(bounds: &[L; 2]) -> bool {
    let [left, right] = bounds.each_ref().map(AsRef::as_ref);
    is_left_of(left, middle(right)) == Some(false) && is_left_of(right, middle(left)) == Some(true)
}

/// Whether a point lies on the left of a line; `None` where its nearest segments disagree, as beside a corner.
fn is_left_of(line: &[Point], p: Point) -> Option<bool> {
    let offset = |w: &[Point]| {
        let along = w[1] - w[0];
        let t = ((p - w[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        p - (w[0] + along * t)
    };
    let nearest = line.windows(2).map(|w| offset(w).norm_squared()).fold(f64::INFINITY, f64::min).sqrt();
    let near = line.windows(2).filter(|w| offset(w).norm() <= nearest + EQUALLY_NEAR);
    let mut sides = near.map(|w| cross(w[1] - w[0], p - w[0]) > 0.0);
    let left = sides.next()?;
    sides.all(|other| other == left).then_some(left)
}

/// The point of a bound that the loader looks at.
fn middle(line: &[Point]) -> Point {
    match line {
        [a, b] => nalgebra::center(a, b),
        _ => line[line.len() / 2],
    }
}

fn has_kink(line: &[Point]) -> bool {
    let least = KINK_MOST.to_radians().cos();
    line.windows(3).any(|w| {
        let (before, after) = (w[1] - w[0], w[2] - w[1]);
        before.dot(&after) < least * (before.norm_squared() * after.norm_squared()).sqrt()
    })
}

/// The line with more points, so that the one the loader looks at lies in the middle of its longest segment: beside a corner
/// of the other bound its side could be ambiguous.
#[must_use]
pub fn with_centred_middle(line: &[Point]) -> Vec<Point> {
    let longest = |range: std::ops::Range<usize>, line: &[Point]| {
        let length = |i: &usize| (line[i + 1] - line[*i]).norm();
        range.max_by(|a, b| length(a).total_cmp(&length(b)))
    };
    let mut line = line.to_vec();
    let Some(segment) = longest(0..line.len().max(1) - 1, &line) else { return line };
    let mut target = segment + 1;
    line.insert(target, nalgebra::center(&line[segment], &line[segment + 1]));
    while line.len() / 2 != target {
        let before = line.len() / 2 > target;
        let range = if before { 0..target } else { target..line.len() - 1 };
        let Some(split) = longest(range, &line) else { break };
        line.insert(split + 1, nalgebra::center(&line[split], &line[split + 1]));
        target += usize::from(before);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[(f64, f64)]) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn a_lane_runs_between_its_bounds() {
        let (left, right) = (line(&[(0.0, 3.0), (10.0, 3.0)]), line(&[(0.0, 0.0), (10.0, 0.0)]));
        assert!(is_valid(&[left.clone(), right.clone()], 3.0));
        assert!(!is_valid(&[right.clone(), left.clone()], 3.0), "sides swapped");
        assert!(!is_valid(&[left.clone(), line(&[(0.0, 0.0), (5.0, 2.5), (10.0, 0.0)])], 3.0), "pinched");
        assert!(!is_valid(&[left, line(&[(0.0, 0.0), (5.0, 0.0), (4.9, 0.1), (10.0, 0.0)])], 3.0), "kinked");
    }

    #[test]
    fn the_middle_point_comes_to_lie_on_the_longest_segment() {
        let bent = line(&[(0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (2.0, 2.0), (3.0, 3.0), (30.0, 3.0)]);
        let centred = with_centred_middle(&bent);
        assert_eq!(centred[centred.len() / 2], Point::new(16.5, 3.0));
        assert!(bent.iter().all(|p| centred.contains(p)));
    }
}
