//! Smooth curves between two directed places, and lines beside them.

use super::{Point, Vector, angle_between, left_of, line_crossing, segment_crossing};

/// A place and the unit direction in which a curve passes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The place.
    pub point: Point,
    /// Unit length.
    pub heading: Vector,
}

/// Longest distance between neighbours on bends, metres: Autoware's paths are resampled at one metre.
const BEND_STEP: f64 = 1.0;
/// Longest distance between neighbours on straights, metres.
const STRAIGHT_STEP: f64 = 3.0;
/// Largest change of direction between neighbours, radians (4 degrees).
const TURN_STEP: f64 = 4.0 * std::f64::consts::PI / 180.0;
/// Below this change of direction (2 degrees) two lines count as parallel, and a cubic joins them.
const PARALLEL: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Above this change of direction (150 degrees) the tangents meet too far away for an arc between them.
const REVERSAL: f64 = 150.0 * std::f64::consts::PI / 180.0;

/// A curve that leaves `from` and arrives at `to` in their headings: straight, arc, straight where the tangents meet
/// between them, else a cubic.
pub fn join(from: Pose, to: Pose) -> Vec<Pose> {
    fillet(from, to).unwrap_or_else(|| cubic(from, to))
}

/// Radius of the arc of [`join`]; `None` where it would be a cubic.
pub fn join_radius(from: Pose, to: Pose) -> Option<f64> {
    let (before, after, turn) = tangents(from, to)?;
    Some(before.min(after) / (turn.abs() / 2.0).tan())
}

/// How far the tangents run from `from` and to `to` until they meet, and the change of direction.
pub fn tangents(from: Pose, to: Pose) -> Option<(f64, f64, f64)> {
    let turn = angle_between(from.heading, to.heading);
    if turn.abs() < PARALLEL || turn.abs() > REVERSAL {
        return None;
    }
    let (before, after, _) = line_crossing(from.point, from.heading, to.point, to.heading)?;
    (before > 0.0 && after < 0.0).then_some((before, -after, turn))
}

fn fillet(from: Pose, to: Pose) -> Option<Vec<Pose>> {
    let (before, after, turn) = tangents(from, to)?;
    let tangent = before.min(after);
    let radius = tangent / (turn.abs() / 2.0).tan();
    let start = from.point + from.heading * (before - tangent);
    let end = to.point - to.heading * (after - tangent);
    let centre = start + left_of(from.heading) * radius * turn.signum();
    let mut poses = straight(from.point, start, from.heading);
    let pieces = (radius * turn.abs() / BEND_STEP).max(turn.abs() / TURN_STEP).ceil().max(1.0) as usize;
    for i in 0..=pieces {
        let rotation = nalgebra::Rotation2::new(turn * i as f64 / pieces as f64);
        poses.push(Pose { point: centre + rotation * (start - centre), heading: rotation * from.heading });
    }
    let tail = straight(to.point, end, to.heading);
    poses.extend(tail.into_iter().rev());
    Some(poses)
}

/// Places from `from` toward `to`, without `to`.
fn straight(from: Point, to: Point, heading: Vector) -> Vec<Pose> {
    let length = (to - from).norm();
    let pieces = (length / STRAIGHT_STEP).ceil() as usize;
    if length < MIN_SPACING {
        return Vec::new();
    }
    (0..pieces).map(|i| Pose { point: from + (to - from) * (i as f64 / pieces as f64), heading }).collect()
}

fn cubic(from: Pose, to: Pose) -> Vec<Pose> {
    let chord = (to.point - from.point).norm();
    let turn = angle_between(from.heading, to.heading).abs();
    // The handle of the cubic nearest to a circular arc over this chord; a shift sideways wants a longer one.
    let handle = chord * (1.0 / (3.0 * (turn / 4.0).cos().powi(2))).max(0.4);
    let [a, d] = [from.point, to.point];
    let [b, c] = [a + from.heading * handle, d - to.heading * handle];
    let bend = angle_between(from.heading, d - a).abs() + angle_between(d - a, to.heading).abs();
    // Places at even steps of the parameter lie a little further apart in the middle of the curve.
    const EASE: f64 = 1.25;
    let step = if bend < PARALLEL { STRAIGHT_STEP / EASE } else { BEND_STEP };
    let pieces = (chord / step).max(1.5 * bend / TURN_STEP).ceil().max(1.0) as usize;
    (0..=pieces)
        .map(|i| {
            let t = i as f64 / pieces as f64;
            let u = 1.0 - t;
            let point = a.coords * (u * u * u)
                + b.coords * (3.0 * u * u * t)
                + c.coords * (3.0 * u * t * t)
                + d.coords * (t * t * t);
            let speed = (b - a) * (u * u) + (c - b) * (2.0 * u * t) + (d - c) * (t * t);
            let heading = if i == 0 {
                from.heading
            } else if i == pieces {
                to.heading
            } else {
                speed.try_normalize(1e-9).unwrap_or(from.heading)
            };
            Pose { point: point.into(), heading }
        })
        .collect()
}

/// The line beside a curve whose offset (left positive) goes linearly from `start` to `end` metres.
pub fn beside(curve: &[Pose], start: f64, end: f64) -> Vec<Point> {
    let mut stations = Vec::with_capacity(curve.len());
    let mut sum = 0.0;
    for (i, pose) in curve.iter().enumerate() {
        if i > 0 {
            sum += (pose.point - curve[i - 1].point).norm();
        }
        stations.push(sum);
    }
    let total = sum.max(f64::MIN_POSITIVE);
    curve
        .iter()
        .zip(stations)
        .map(|(pose, s)| pose.point + left_of(pose.heading) * (start + (end - start) * s / total))
        .collect()
}

/// Neighbours on a line are at least this far apart, metres.
pub const MIN_SPACING: f64 = 0.1;

/// How many segments ahead a line is searched for crossings with itself; loops of an offset line are local.
const LOOP_REACH: usize = 64;

/// A line without loops and without neighbours closer than [`MIN_SPACING`]; first and last points stay.
#[must_use]
pub fn untangled(line: &[Point]) -> Vec<Point> {
    spaced(&without_loops(line))
}

fn without_loops(line: &[Point]) -> Vec<Point> {
    let mut out: Vec<Point> = Vec::with_capacity(line.len());
    let mut i = 0;
    let Some(&first) = line.first() else { return out };
    out.push(first);
    let mut from = first;
    while i + 1 < line.len() {
        let far = (i + 2..line.len().saturating_sub(1).min(i + LOOP_REACH))
            .rev()
            .find_map(|j| segment_crossing(from, line[i + 1], line[j], line[j + 1]).map(|(_, _, p)| (j, p)));
        match far {
            Some((j, p)) => {
                out.push(p);
                from = p;
                i = j;
            }
            None => {
                from = line[i + 1];
                out.push(from);
                i += 1;
            }
        }
    }
    out
}

fn spaced(line: &[Point]) -> Vec<Point> {
    let (Some(&first), Some(&last)) = (line.first(), line.last()) else { return Vec::new() };
    let mut out = vec![first];
    let mut previous = first;
    for &p in &line[1..line.len().max(2) - 1] {
        if (p - previous).norm() >= MIN_SPACING && (p - last).norm() >= MIN_SPACING {
            out.push(p);
            previous = p;
        }
    }
    out.push(last);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(x: f64, y: f64, degrees: f64) -> Pose {
        Pose { point: Point::new(x, y), heading: Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin()) }
    }

    #[test]
    fn a_right_angle_is_a_circle_with_parallel_bounds() {
        let curve = join(pose(0.0, -8.0, 90.0), pose(-8.0, 0.0, 180.0));
        for p in &curve {
            assert!(((p.point - Point::new(-8.0, -8.0)).norm() - 8.0).abs() < 1e-9);
        }
        for p in beside(&curve, 1.5, 1.5) {
            assert!(((p - Point::new(-8.0, -8.0)).norm() - 6.5).abs() < 1e-9);
        }
        assert_eq!(join_radius(pose(0.0, -8.0, 90.0), pose(-8.0, 0.0, 180.0)).map(f64::round), Some(8.0));
    }

    #[test]
    fn curves_start_and_end_where_they_must_and_never_bend_sharply() {
        for to in [pose(20.0, 3.0, 0.0), pose(20.0, 0.0, 0.0), pose(15.0, 9.0, 60.0), pose(0.0, 6.0, 180.0)] {
            let from = pose(0.0, 0.0, 0.0);
            let curve = join(from, to);
            let ends = [curve.first(), curve.last()].map(|p| p.map(|p| p.point));
            assert!((ends[0].unwrap() - from.point).norm() < 1e-9 && (ends[1].unwrap() - to.point).norm() < 1e-9);
            for w in curve.windows(3) {
                let turn = angle_between(w[1].point - w[0].point, w[2].point - w[1].point).abs();
                assert!(turn < 8f64.to_radians(), "{turn} on the way to {to:?}");
            }
            for w in curve.windows(2) {
                assert!((w[1].point - w[0].point).norm() <= STRAIGHT_STEP + 1e-9);
            }
        }
    }

    #[test]
    fn loops_are_cut_off() {
        let line = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, -2.0), (9.0, -2.0)];
        let line: Vec<Point> = line.iter().map(|&(x, y)| Point::new(x, y)).collect();
        let clean = untangled(&line);
        assert_eq!(clean, [(0.0, 0.0), (2.0, 0.0), (2.0, -2.0), (9.0, -2.0)].map(|(x, y)| Point::new(x, y)));
    }
}
