//! Poses: points with a direction. Arcs and straight lines between them.

use super::{Point, Vector, angle_between, left_of, line_crossing};

/// The largest distance of a polyline from the curve that it approximates, metres: a fifth of a wide painted line (15 cm). On
/// turns that professionals draw, one point in twenty is farther off, by 3 to 10 cm.
pub(crate) const SAGITTA: f64 = 0.03;
/// The largest distance between neighbours on a straight line, metres; people put a point each 5 to 20 m.
pub(crate) const STRAIGHT_STEP: f64 = 10.0;
/// The largest change of direction between neighbours, radians (10 degrees); on hand-drawn turns, one in twenty exceeds 8 to 21.
pub(crate) const TURN_STEP: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Directions that differ by less, radians (2 degrees), are parallel: no arc joins them.
pub(crate) const PARALLEL: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// The largest change of direction of an arc, radians (150 degrees): beyond, the tangents meet too far away.
pub(crate) const REVERSAL: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// The smallest distance between neighbours, metres.
pub const MIN_SPACING: f64 = 0.1;
/// The distance, metres, from the middle of a lane to its outer bound, which needs as many points on a longer arc.
pub(crate) const OUTSIDE: f64 = 2.0;

/// A point of a curve and its unit direction there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The point.
    pub point: Point,
    /// The unit direction.
    pub heading: Vector,
}

/// The lengths of the tangents, metres, from `from` and from `to` to where they meet, and the change of direction, radians;
/// `None` if they do not meet ahead of `from` and behind `to`.
pub fn tangents(from: Pose, to: Pose) -> Option<(f64, f64, f64)> {
    crossing(from, to).filter(|(before, after, turn)| *before > 0.0 && *after > 0.0 && turn.abs() <= REVERSAL)
}

/// [`tangents`] wherever their lines meet: a length is negative on the other side.
pub fn crossing(from: Pose, to: Pose) -> Option<(f64, f64, f64)> {
    let turn = angle_between(from.heading, to.heading);
    if turn.abs() < PARALLEL {
        return None;
    }
    let (before, after, _) = line_crossing(from.point, from.heading, to.point, to.heading)?;
    Some((before, -after, turn))
}

/// Poses on an arc from a pose, both ends included. `turn` is in radians, left positive; `radius` in metres. The first and the
/// last step are half as long as the others, so that the polyline begins nearly along the tangent.
pub(crate) fn arc(from: Pose, turn: f64, radius: f64) -> impl DoubleEndedIterator<Item = Pose> {
    let centre = from.point + left_of(from.heading) * radius * turn.signum();
    let steps = (radius * turn.abs() * density(1.0 / radius)).ceil().max(1.0);
    (0..=steps as usize + 1).map(move |i| {
        let rotation = nalgebra::Rotation2::new(turn * ((i as f64 - 0.5) / steps).clamp(0.0, 1.0));
        Pose { point: centre + rotation * (from.point - centre), heading: rotation * from.heading }
    })
}

/// The number of points per metre that a curve of this curvature (1 / radius, 1/m) needs.
pub(crate) fn density(curvature: f64) -> f64 {
    let arc = (curvature * (1.0 + OUTSIDE * curvature) / (8.0 * SAGITTA)).sqrt();
    arc.max(curvature / TURN_STEP).max(1.0 / STRAIGHT_STEP)
}

/// Poses on the straight line from `from` to `to`, without `to`.
pub(crate) fn straight(from: Point, to: Point, heading: Vector) -> Vec<Pose> {
    let length = (to - from).norm();
    let pieces = (length / STRAIGHT_STEP).ceil() as usize;
    if length < MIN_SPACING {
        return Vec::new();
    }
    (0..pieces).map(|i| Pose { point: from + (to - from) * (i as f64 / pieces as f64), heading }).collect()
}

/// A pose for tests: position in metres, heading in degrees from east.
#[cfg(test)]
pub(crate) fn pose(x: f64, y: f64, degrees: f64) -> Pose {
    Pose { point: Point::new(x, y), heading: Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin()) }
}
