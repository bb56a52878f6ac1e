//! S-curves: a bend, a straight line, and a bend to the other side.

use super::pose::{MIN_SPACING, PARALLEL, Pose, REVERSAL, arc, straight, tangents};
use super::{Vector, angle_between, left_of};

/// Two bends of the same radius with a straight line between them.
struct SCurve {
    /// Metres.
    radius: f64,
    /// The change of direction in each bend, radians, left positive.
    turns: [f64; 2],
    /// The unit direction of the straight line.
    along: Vector,
}

impl SCurve {
    /// The S-curve of this radius, metres, of which the first bend is to the left (1) or to the right (-1); `None` if there is
    /// no room for it.
    fn new(from: Pose, to: Pose, radius: f64, first: f64) -> Option<Self> {
        let centres =
            [from.point + left_of(from.heading) * radius * first, to.point - left_of(to.heading) * radius * first];
        let between = centres[1] - centres[0];
        let sine = 2.0 * radius / between.norm();
        if sine.is_nan() || sine > 1.0 {
            return None;
        }
        let along = (nalgebra::Rotation2::new(first * sine.asin()) * between).normalize();
        let turns = [angle_between(from.heading, along), angle_between(along, to.heading)];
        let opposite = turns[0] * first >= -NO_TURN && turns[1] * first <= NO_TURN;
        let gentle = turns.iter().all(|turn| turn.abs() <= MAX_TURN);
        (opposite && gentle).then_some(Self { radius, turns, along })
    }

    /// The S-curve with the smallest turns of which the bends are not sharp.
    fn find(from: Pose, to: Pose) -> Option<Self> {
        let sharp = [1.0, -1.0].into_iter().filter_map(|first| Some((first, Self::new(from, to, MIN_SPACING, first)?)));
        let (first, _) = sharp.min_by(|a, b| a.1.turned().total_cmp(&b.1.turned()))?;
        let (mut fits, mut fails) = (MIN_SPACING, RADIUS_MOST);
        for _ in 0..HALVINGS {
            let middle = (fits * fails).sqrt();
            *(if Self::new(from, to, middle, first).is_some() { &mut fits } else { &mut fails }) = middle;
        }
        Self::new(from, to, (fits * BEND_SHARE).max(RADIUS_LEAST.min(fits * BEND_SHARE_MOST)), first)
    }

    fn turned(&self) -> f64 {
        self.turns[0].abs() + self.turns[1].abs()
    }
}

/// The smallest radius of the bends where there is room, metres: cars drive it easily.
pub(super) const RADIUS_LEAST: f64 = 4.5;
/// The largest radius that is tried, metres: a wider bend is nearly straight.
const RADIUS_MOST: f64 = 4096.0;
/// The number of halvings in the search for the largest radius that fits.
const HALVINGS: usize = 24;
/// The radius as a part of the largest that fits: the longer the straight line, the smaller both turns.
const BEND_SHARE: f64 = 0.35;
/// The same at most, where even the smallest radius hardly fits.
const BEND_SHARE_MOST: f64 = 0.7;
/// The largest turn of a bend, radians: beyond a right angle the curve is a loop.
const MAX_TURN: f64 = std::f64::consts::FRAC_PI_2;
/// Smaller changes of direction, radians, count as none.
const NO_TURN: f64 = 1e-9;

/// The S-curve between two poses; `None` if the direction reverses or there is no room.
pub(super) fn join(from: Pose, to: Pose) -> Option<Vec<Pose>> {
    if angle_between(from.heading, to.heading).abs() > REVERSAL {
        return None;
    }
    poses(from, to, &SCurve::find(from, to)?)
}

/// The S-curve of this radius, metres, of which the first bend is to the left (1) or to the right (-1).
pub(super) fn with_radius(from: Pose, to: Pose, radius: f64, first: f64) -> Option<Vec<Pose>> {
    poses(from, to, &SCurve::new(from, to, radius, first)?)
}

fn poses(from: Pose, to: Pose, &SCurve { radius, turns, along }: &SCurve) -> Option<Vec<Pose>> {
    let bends = turns.map(|turn| turn.abs() > NO_TURN);
    let mut poses = if bends[0] { arc(from, turns[0], radius).collect() } else { vec![from] };
    // The second bend is computed backwards, so that both ends are exact.
    let back = Pose { point: to.point, heading: -to.heading };
    let mut last: Vec<Pose> = if bends[1] { arc(back, -turns[1], radius).collect() } else { vec![back] };
    last.iter_mut().for_each(|pose| pose.heading = -pose.heading);
    let (start, end) = (poses.last()?.point, last.last()?.point);
    let between = straight(start, end, along);
    if between.is_empty() && last.len() > 1 {
        last.pop();
    }
    poses.extend(between.into_iter().skip(1));
    poses.extend(last.into_iter().rev());
    Some(poses)
}

/// How much the curve of [`super::curve::join`] turns to and fro, radians: the sum of its turns minus its change of direction.
pub fn to_and_fro(from: Pose, to: Pose) -> f64 {
    if tangents(from, to).is_some() {
        return 0.0;
    }
    let bent = |[a, b]: [f64; 2]| a.abs() + b.abs() - (a + b).abs();
    SCurve::find(from, to).map_or_else(
        || {
            // Bends to one side that are too small for an arc.
            let chord = to.point - from.point;
            let turns = [angle_between(from.heading, chord), angle_between(chord, to.heading)];
            let slight = chord.norm() > MIN_SPACING && turns.iter().all(|turn| turn.abs() < PARALLEL);
            if slight { bent(turns) } else { std::f64::consts::TAU }
        },
        |bends| bent(bends.turns),
    )
}

#[cfg(test)]
mod tests {
    use crate::geometry::curve;
    use crate::geometry::pose::pose;

    use super::*;

    #[test]
    fn a_lane_that_shifts_bends_once_to_each_side() {
        for (length, aside, degrees) in [(20.0, 3.0, 0.0), (22.0, -8.0, 0.0), (16.0, 4.0, 5.0), (20.0, 9.0, -23.0)] {
            let (from, to) = (pose(0.0, 0.0, 0.0), pose(length, aside, degrees));
            let curve = curve::join(from, to);
            let turns: Vec<f64> = curve.windows(2).map(|w| angle_between(w[0].heading, w[1].heading)).collect();
            let weave = turns.iter().map(|turn| turn.abs()).sum::<f64>() - turns.iter().sum::<f64>().abs();
            assert!((weave - to_and_fro(from, to)).abs() < 1e-6);
            let straight = (to.point - from.point).normalize();
            let least = [(from.heading, straight), (straight, to.heading)].map(|(a, b)| angle_between(a, b));
            let least = least[0].abs() + least[1].abs() - (least[0] + least[1]).abs();
            assert!(weave < 1.4 * least, "{weave} of {least}");
            let sides: Vec<f64> = turns.iter().filter(|turn| turn.abs() > 1e-6).map(|turn| turn.signum()).collect();
            assert_eq!(sides.windows(2).filter(|w| w[0] != w[1]).count(), 1);
            for w in curve.windows(2) {
                let turn = angle_between(w[0].heading, w[1].heading).abs();
                assert!(turn < 1e-6 || (w[1].point - w[0].point).norm() / turn > 0.9 * RADIUS_LEAST);
            }
        }
    }

    #[test]
    fn a_slight_bend_to_one_side_is_no_s_curve() {
        for (aside, degrees) in [(0.0, 0.0), (1e-5, 1e-4), (0.1, 0.6), (-0.3, -1.9), (0.2, 0.4)] {
            let there = to_and_fro(pose(0.0, 0.0, 0.0), pose(20.0, aside, degrees));
            assert!(there < 0.5_f64.to_radians(), "{aside} {degrees}: {there}");
        }
        let weave = to_and_fro(pose(0.0, 0.0, 0.0), pose(20.0, 1.0, 0.0));
        assert!(weave > 5.0_f64.to_radians(), "{weave}");
    }
}
