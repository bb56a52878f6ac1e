//! A place and a direction there, and the arcs and straight lines between two of them.

use super::{Point, Vector, angle_between, left_of, line_crossing};

/// A line leaves the curve it stands for by at most this, metres: a fifth of a wide painted line.
pub(crate) const SAGITTA: f64 = 0.02;
/// Longest distance between neighbours on straights, metres.
pub(crate) const STRAIGHT_STEP: f64 = 3.0;
/// Largest change of direction between neighbours, radians (8 degrees).
pub(crate) const TURN_STEP: f64 = 8.0 * std::f64::consts::PI / 180.0;
/// Below this change of direction (2 degrees) two lines count as parallel, and a cubic joins them.
pub(crate) const PARALLEL: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Above this change of direction (150 degrees) the tangents meet too far away for an arc between them.
pub(crate) const REVERSAL: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// Neighbours on a line are at least this far apart, metres.
pub const MIN_SPACING: f64 = 0.1;
/// The outer bound of a lane lies this far, metres, outside the curve in its middle; it bends as much and is longer.
pub(crate) const OUTSIDE: f64 = 2.0;

/// A place and the unit direction in which a curve passes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The place.
    pub point: Point,
    /// Unit length.
    pub heading: Vector,
}

/// How far the tangents run from `from` and to `to` until they meet, and the change of direction.
pub fn tangents(from: Pose, to: Pose) -> Option<(f64, f64, f64)> {
    crossing(from, to).filter(|(before, after, turn)| *before > 0.0 && *after > 0.0 && turn.abs() <= REVERSAL)
}

/// The same wherever the tangents' lines meet: a length is negative where they have met already.
pub fn crossing(from: Pose, to: Pose) -> Option<(f64, f64, f64)> {
    let turn = angle_between(from.heading, to.heading);
    if turn.abs() < PARALLEL {
        return None;
    }
    let (before, after, _) = line_crossing(from.point, from.heading, to.point, to.heading)?;
    Some((before, -after, turn))
}

/// Places on an arc from a pose, both ends among them. The first and the last step are half as long as the others: the line
/// sets out along the tangent, or nearly.
pub(crate) fn arc(from: Pose, turn: f64, radius: f64) -> impl DoubleEndedIterator<Item = Pose> {
    let centre = from.point + left_of(from.heading) * radius * turn.signum();
    let steps = (radius * turn.abs() * density(1.0 / radius)).ceil().max(1.0);
    (0..=steps as usize + 1).map(move |i| {
        let rotation = nalgebra::Rotation2::new(turn * ((i as f64 - 0.5) / steps).clamp(0.0, 1.0));
        Pose { point: centre + rotation * (from.point - centre), heading: rotation * from.heading }
    })
}

/// How many places a metre a curve needs where it bends this much (1 / radius).
pub(crate) fn density(curvature: f64) -> f64 {
    let arc = (curvature * (1.0 + OUTSIDE * curvature) / (8.0 * SAGITTA)).sqrt();
    arc.max(curvature / TURN_STEP).max(1.0 / STRAIGHT_STEP)
}

/// Places from `from` toward `to`, without `to`.
pub(crate) fn straight(from: Point, to: Point, heading: Vector) -> Vec<Pose> {
    let length = (to - from).norm();
    let pieces = (length / STRAIGHT_STEP).ceil() as usize;
    if length < MIN_SPACING {
        return Vec::new();
    }
    (0..pieces).map(|i| Pose { point: from + (to - from) * (i as f64 / pieces as f64), heading }).collect()
}
