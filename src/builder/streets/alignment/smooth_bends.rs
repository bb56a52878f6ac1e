//! Eases the bends of a line for a road of some width.

use crate::geometry::{Point, Polyline, angle_between, left_of};

/// The largest turn at one point, radians: 10 degrees. Offsets of the line then keep their shape.
const STEP: f64 = 0.1746;
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
        let room = room(&points, i + 1);
        eased.extend(arc(w[0], w[1], w[2], room, tightest.max(half + INNER_RADIUS)));
    }
    eased.push(points[points.len() - 1]);
    Polyline::new(with_inner_edges(eased, half)).unwrap_or_else(|| line.clone())
}

/// Merges points whose bends leave nothing of the inner edge between them.
fn with_inner_edges(mut points: Vec<Point>, half: f64) -> Vec<Point> {
    points.dedup_by(|a, b| (*a - *b).norm() <= Polyline::MERGE);
    let mut i = 0;
    while i + 1 < points.len() {
        // How much of the segment's left edge the bend at a point takes, metres.
        let bend = |k: usize| match k {
            0 => 0.0,
            _ if k + 1 == points.len() => 0.0,
            _ => half * (angle_between(points[k] - points[k - 1], points[k + 1] - points[k]) / 2.0).tan(),
        };
        let taken = (bend(i) + bend(i + 1)).abs();
        if taken <= (points[i + 1] - points[i]).norm() * (1.0 - INNER) || points.len() == 2 {
            i += 1;
            continue;
        }
        match (i, i + 2 == points.len()) {
            (0, _) => drop(points.remove(1)),
            (_, true) => drop(points.remove(i)),
            _ => {
                points[i] = nalgebra::center(&points[i], &points[i + 1]);
                points.remove(i + 1);
            }
        }
        i = i.saturating_sub(2);
    }
    points
}

/// Drops corners until each has room for the tightest arc.
fn merge_close_corners(mut points: Vec<Point>, tightest: f64) -> Vec<Point> {
    loop {
        // The corner whose arc lacks the most room.
        let worst = (1..points.len() - 1)
            .map(|i| {
                let needed = tangent(points[i - 1], points[i], points[i + 1], tightest);
                (i, needed - room(&points, i))
            })
            .filter(|(_, lack)| *lack > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((i, _)) = worst else { return points };
        let (before, after) = ((points[i] - points[i - 1]).norm(), (points[i + 1] - points[i]).norm());
        let other = if before < after { i - 1 } else { i + 1 };
        if other == 0 || other == points.len() - 1 {
            points.remove(i);
        } else {
            let (low, high) = (i.min(other), i.max(other));
            points[low] = nalgebra::center(&points[low], &points[high]);
            points.remove(high);
        }
        points.dedup_by(|a, b| (*a - *b).norm() <= Polyline::MERGE);
        if points.len() < 3 {
            return points;
        }
    }
}

/// How far the arc at corner `i` may reach along its segments, metres.
fn room(points: &[Point], i: usize) -> f64 {
    let share = |at_end: bool| if at_end { 1.0 } else { SHARE };
    let before = (points[i] - points[i - 1]).norm() * share(i == 1);
    let after = (points[i + 1] - points[i]).norm() * share(i + 2 == points.len());
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
    if half_turn * 2.0 <= STEP {
        return vec![b];
    }
    let off_corner = 1.0 / half_turn.cos() - 1.0;
    let radius = COMFORT.min(DEVIATION / off_corner).max(wanted).min(room / half_turn.tan());
    let (u, v) = ((b - a).normalize(), (c - b).normalize());
    let begin = b - u * (radius * half_turn.tan());
    let centre = begin + left_of(u) * (radius * turn.signum());
    let pieces = (turn.abs() / STEP).ceil().max(1.0) as usize;
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
        assert!(sharpest(&bend) <= STEP + 1e-9);
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
        assert!(sharpest(&spike) <= STEP + 1e-9);
        assert!(spike.length() < 41.0);
    }
}
