//! A quick test whether two lines are far apart: a straight gap lies between them.

use super::Point;

/// Margin for rounding, metres.
const MARGIN: f64 = 1e-6;

/// Whether two lines are certainly more than `distance` metres apart; `false` means unknown. There is a straight gap of that
/// width between the lines, or between each half of one and each half of the other.
pub fn are_apart(a: &[Point], b: &[Point], distance: f64) -> bool {
    let (Some(&from), Some(&to)) = (a.get(a.len() / 2), b.get(b.len() / 2)) else { return false };
    let across = to - from;
    let along = |p: &Point| (p - from).dot(&across);
    let nearest = b.iter().map(along).fold(f64::INFINITY, f64::min);
    let farthest = a.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
    if nearest - farthest > (distance + MARGIN) * across.norm() {
        return true;
    }
    match (halves(a), halves(b)) {
        (None, None) => false,
        (Some(a), None) => a.iter().all(|a| are_apart(a, b, distance)),
        (None, Some(b)) => b.iter().all(|b| are_apart(a, b, distance)),
        (Some(a), Some(b)) => a.iter().all(|a| b.iter().all(|b| are_apart(a, b, distance))),
    }
}

/// The halves of a line; `None` if it has one segment.
fn halves(line: &[Point]) -> Option<[&[Point]; 2]> {
    let middle = line.len() / 2;
    (line.len() > 2).then(|| [&line[..=middle], &line[middle..]])
}

#[cfg(test)]
mod tests {
    use crate::geometry::polyline::within;

    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn lines_found_apart_are_apart(
            a in prop::collection::vec((-9.0..9.0, -9.0..9.0), 1..9),
            b in prop::collection::vec((-9.0..9.0, -9.0..9.0), 2..9),
            aside in 0.0..30.0,
            distance in 0.0..9.0,
        ) {
            let a: Vec<Point> = a.into_iter().map(|(x, y)| Point::new(x, y)).collect();
            let b: Vec<Point> = b.into_iter().map(|(x, y)| Point::new(x + aside, y)).collect();
            if are_apart(&a, &b, distance) {
                let near = |p: &Point| b.windows(2).any(|w| within((w[0], w[1]), *p, distance).is_some_and(|d| d < distance));
                prop_assert!(!a.iter().any(near));
            }
        }
    }

    #[test]
    fn lines_around_a_corner_are_apart() {
        let arc = |radius: f64| -> Vec<Point> {
            (0..=18)
                .map(|i| f64::from(5 * i).to_radians())
                .map(|t| Point::new(radius * t.cos(), radius * t.sin()))
                .collect()
        };
        assert!(are_apart(&arc(5.0), &arc(8.0), 2.4));
        assert!(!are_apart(&arc(5.0), &arc(8.0), 3.1));
    }
}
