//! The change of direction from one road to another, in degrees, and what counts as straight on or as turning back.

use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::{Polyline, Vector, angle_between};
use crate::lanelet::index::turn_along;

/// A movement up to this change of direction, degrees, goes straight on.
pub const STRAIGHT_ON: f64 = 30.0;
/// A movement beyond this change of direction, degrees, turns back.
pub const TURNS_BACK: f64 = 150.0;

/// Change of direction from one heading to another, degrees, left positive. Beyond [`TURNS_BACK`] it has the sign of a turn
/// across the oncoming traffic: left where people drive on the right.
pub fn turn(side: DrivingSide, from: Vector, to: Vector) -> f64 {
    let turn = angle_between(from, to).to_degrees();
    let across = if side == DrivingSide::Right { 1.0 } else { -1.0 };
    if turn.abs() > TURNS_BACK && turn * across < 0.0 { turn + across * 360.0 } else { turn }
}

/// The sum of all changes of direction along a lane's centre line, degrees, left positive. Its sign follows the rule of [`turn`].
pub fn turned(side: DrivingSide, middle: &Polyline) -> f64 {
    let turn = turn_along(middle);
    let across = if side == DrivingSide::Right { 1.0 } else { -1.0 };
    if turn.abs() > TURNS_BACK { across * turn.abs() } else { turn }
}

#[cfg(test)]
mod tests {
    use crate::geometry::pose::Pose;
    use crate::geometry::{Point, Polyline, curve};

    use super::*;

    fn pose(x: f64, y: f64, degrees: f64) -> Pose {
        Pose { point: Point::new(x, y), heading: Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin()) }
    }

    /// The line through these poses.
    fn line(poses: Vec<Pose>) -> Polyline {
        Polyline::new(poses.into_iter().map(|pose| pose.point)).unwrap()
    }

    #[test]
    fn the_turn_of_a_lane_is_the_sum_of_its_bends() {
        let left = line(curve::join(pose(0.0, 0.0, 0.0), pose(10.0, 10.0, 90.0)));
        assert!((turned(DrivingSide::Right, &left) - 90.0).abs() < 5.0);
        // A loop that ends 140 degrees to the right of where it began, but gets there by the left.
        let round = |i: i32| pose(f64::from(i * 10).to_radians().cos(), f64::from(i * 10).to_radians().sin(), 0.0);
        let loop_ = line((0..=23).map(round).collect());
        assert!((turned(DrivingSide::Right, &loop_) - 220.0).abs() < 1.0);
        // On the left, a U-turn is to the right.
        assert!((turned(DrivingSide::Left, &loop_) + 220.0).abs() < 1.0);
    }
}
