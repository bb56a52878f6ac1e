//! Whether a lanelet uses its bounds in file order or inverted, as Lanelet2's `geometry::align` decides it on loading.

use crate::geometry::simple_ring::crosses_itself;
use crate::geometry::{Point, cross};
use crate::lanelet::index::view::Spot;

/// Whether the left and the right bound (points in file order) are turned around on loading.
///
/// The left bound stays if the middle of the right one lies to the right of it; then the right bound stays if the
/// middle of the left one, as it now runs, lies to the left of it. A bound of fewer than two points stays.
pub fn align(left: &[Point], right: &[Point]) -> (bool, bool) {
    let Some(right_middle) = middle(right, false) else { return (false, false) };
    let left_inverted = left.len() > 1 && side(left, right_middle) >= 0.0;
    let Some(left_middle) = middle(left, left_inverted) else { return (false, false) };
    let right_inverted = right.len() > 1 && side(right, left_middle) <= 0.0;
    (left_inverted, right_inverted)
}

/// [`align`] of bounds in space, as the loader does it: heights count in the distance to a bound, and alone tell bounds apart
/// that lie above each other.
pub fn align_in_space(left: &[Spot], right: &[Spot]) -> (bool, bool) {
    if left.is_empty() || right.is_empty() || (left.len() == 1 && right.len() == 1) {
        return (false, false);
    }
    let mut left = left.to_vec();
    let left_inverted = left.len() > 1 && side_in_space(&left, middle_in_space(right)) >= 0.0;
    if left_inverted {
        left.reverse();
    }
    let right_inverted = right.len() > 1 && side_in_space(right, middle_in_space(&left)) <= 0.0;
    (left_inverted, right_inverted)
}

fn middle_in_space(line: &[Spot]) -> Spot {
    match line {
        [first, .., last] if line.len() == 2 => nalgebra::center(first, last),
        _ => line.get(line.len() / 2).or(line.first()).copied().unwrap_or_default(),
    }
}

/// Distance in space, signed by the side in the plane on which `p` lies of the nearest segment.
fn side_in_space(line: &[Spot], p: Spot) -> f64 {
    let mut nearest: Option<(usize, f64, Spot)> = None;
    for (at, pair) in line.windows(2).enumerate() {
        let (along, to) = (pair[1] - pair[0], p - pair[0]);
        let (part, whole) = (to.dot(&along), along.norm_squared());
        let foot = match part {
            _ if part <= 0.0 => pair[0],
            _ if whole <= part => pair[1],
            _ => pair[0] + along * (part / whole),
        };
        let found = (foot - p).norm();
        if nearest.is_none_or(|(_, best, _)| found < best) {
            nearest = Some((at, found, foot));
        }
        if found == 0.0 {
            break;
        }
    }
    let Some((at, distance, foot)) = nearest else { return 0.0 };
    let is_left = |a: Spot, b: Spot, p: Spot| cross((b - a).xy(), (p - a).xy()) > 0.0;
    let (a, b) = (line[at], line[at + 1]);
    let mut left = is_left(a, b, p);
    // At a corner, the next segment counts, too.
    if b == foot
        && let Some(&next) = line.iter().position(|spot| *spot == b).and_then(|found| line.get(found + 1))
        && left != is_left(b, next, p)
        && left == is_left(a, b, next)
    {
        left = !left;
    }
    if left { distance } else { -distance }
}

/// Whether two bounds, each in the direction in which it is used, run against each other: `align` has chosen wrongly, and the
/// outline of the lanelet crosses itself.
pub fn opposed(left: &[Point], right: &[Point]) -> bool {
    let (Some((a, b)), Some((c, d))) = (ends(left), ends(right)) else { return false };
    (a - c).norm() + (b - d).norm() > (a - d).norm() + (b - c).norm()
}

/// Whether the outline of a lanelet crosses itself, and would not if one of its bounds were turned around.
pub fn crosses_only_as_used(left: &[Point], right: &[Point]) -> bool {
    let used: Vec<Point> = left.iter().chain(right.iter().rev()).copied().collect();
    let turned: Vec<Point> = left.iter().chain(right).copied().collect();
    crosses_itself(&used) && !crosses_itself(&turned)
}

fn ends(line: &[Point]) -> Option<(Point, Point)> {
    Some((*line.first()?, *line.last()?))
}

/// The middle of a line as Lanelet2 takes it: a vertex, or the point midway between two. With an even number of vertices it
/// depends on the direction.
fn middle(line: &[Point], inverted: bool) -> Option<Point> {
    let half = line.len() / 2;
    match line {
        [] => None,
        [a, b] => Some(nalgebra::center(a, b)),
        _ if inverted => line.get(line.len() - 1 - half).copied(),
        _ => line.get(half).copied(),
    }
}

/// Signed distance of `p` from `line`, left positive. At a corner, where two segments are equally near, Lanelet2 asks
/// whether `p` is left of both in a left bend, or of either in a right bend.
fn side(line: &[Point], p: Point) -> f64 {
    let distance = |segment: &[Point]| {
        let d = segment[1] - segment[0];
        let t =
            if d.norm_squared() > 0.0 { ((p - segment[0]).dot(&d) / d.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
        ((p - (segment[0] + d * t)).norm(), t)
    };
    let mut nearest: Option<(usize, f64, f64)> = None;
    for (at, segment) in line.windows(2).enumerate() {
        let (found, t) = distance(segment);
        if nearest.is_none_or(|(_, best, _)| found < best) {
            nearest = Some((at, found, t));
        }
    }
    let Some((at, distance, t)) = nearest else { return 0.0 };
    let is_left = |segment: &[Point]| cross(segment[1] - segment[0], p - segment[0]) > 0.0;
    let here = &line[at..at + 2];
    let left = match line.get(at + 1..at + 3) {
        Some(next) if t >= 1.0 => {
            let bends_left = cross(here[1] - here[0], next[1] - next[0]) > 0.0;
            if bends_left { is_left(here) && is_left(next) } else { is_left(here) || is_left(next) }
        }
        _ => is_left(here),
    };
    if left { distance } else { -distance }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[(f64, f64)]) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn order_in_the_file_does_not_matter() {
        let left = line(&[(0.0, 3.0), (5.0, 3.1), (10.0, 3.0)]);
        let right = line(&[(0.0, 0.0), (10.0, 0.0)]);
        let turned = |l: &[Point]| l.iter().rev().copied().collect::<Vec<_>>();
        assert_eq!(align(&left, &right), (false, false));
        assert_eq!(align(&turned(&left), &right), (true, false));
        assert_eq!(align(&left, &turned(&right)), (false, true));
        assert_eq!(align(&turned(&left), &turned(&right)), (true, true));
    }

    #[test]
    fn exchanged_roles_turn_both() {
        let left = line(&[(0.0, 0.0), (10.0, 0.0)]);
        let right = line(&[(0.0, 3.0), (10.0, 3.0)]);
        assert_eq!(align(&left, &right), (true, true));
    }

    #[test]
    fn a_corner_between_two_segments_is_judged_by_both() {
        // The middle of the right bound lies behind the corner of the left one, right of both its arms.
        let left = line(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]);
        let right = line(&[(-1.0, -4.0), (13.0, -4.0), (14.0, 11.0)]);
        assert_eq!(align(&left, &right), (false, false));
    }

    #[test]
    fn a_long_curl_leads_it_astray() {
        // The middle vertex of the left bound lies on the wrong side of the right one.
        let left = line(&[(0.0, 3.0), (4.0, 3.0), (5.0, -9.0), (6.0, 3.0), (30.0, 3.0)]);
        let right = line(&[(0.0, 0.0), (30.0, 0.0)]);
        let (l, r) = align(&left, &right);
        assert_eq!((l, r), (false, true));
        let turned: Vec<Point> = right.iter().rev().copied().collect();
        assert!(opposed(&left, &turned) && !opposed(&left, &right));
    }

    #[test]
    fn broken_lines_stay_as_they_are() {
        assert_eq!(align(&[], &line(&[(0.0, 0.0)])), (false, false));
        assert!(!opposed(&[], &[]));
        let dot = line(&[(1.0, 1.0), (1.0, 1.0)]);
        let _ = align(&dot, &dot);
    }
}
