//! Turns with little room: the curve swings out to the other side before or after the turn, as drivers do.

use super::pose::Pose;
use super::{Point, Vector, angle_between, cross, curve, left_of, pose, s_curve};

/// The radius, metres, from which on a turn needs no swing: a car drives it at walking pace without full lock.
const EASY_RADIUS: f64 = 4.5;
/// The largest swing on one side, degrees; swings are tried in steps of one degree.
const MAX_SWING: u32 = 40;
/// The largest sum of both swings, degrees: beyond, the curve is a slalom.
const MAX_SWINGS: f64 = 56.0;
/// The sum of swings, degrees, that passengers do not notice.
const FREE_SWING: f64 = 7.0;
/// The additional swing, degrees, that is worth widening the turn from three quarters of the easy radius to all of it.
const SWING: f64 = 7.0;
/// The weight of the square of what a radius lacks: tight turns must not become tighter.
const TIGHT: f64 = 10.0;
/// The additional length, metres, that costs as much as [`SWING`].
const LENGTH: f64 = 30.0;
/// The longest straight lines of a curve that narrows like a bottle's neck, metres: there it leaves the lanes.
const MAX_NECK: f64 = 2.0;
/// The smallest turn, degrees: a smaller one only gets an S-curve.
const MIN_TURN: f64 = 45.0;
/// Unit directions of which the cross product is smaller are parallel.
const PARALLEL: f64 = 1e-6;
/// From this change of direction on, degrees, the side of the end point decides to which side the curve turns.
const REVERSAL: f64 = 150.0;

/// A curve that swings out for a larger radius than `direct`, which is the curve of [`curve::join`]; `None` if none is better.
pub fn swing_out(from: Pose, to: Pose, direct: &[Pose]) -> Option<Vec<Pose>> {
    if direct.windows(2).all(|w| is_easy(w[0], w[1])) {
        return None;
    }
    let radius = curve::radius(direct);
    if radius >= EASY_RADIUS {
        return None;
    }
    let limit = cost(radius, swing(direct), length(direct));
    let wide = if angle_between(from.heading, to.heading).abs() < MIN_TURN.to_radians() {
        // Tangents that meet close to an end leave a corner there.
        let curves = [1.0, -1.0].into_iter().filter_map(|first| s_curve::with_radius(from, to, EASY_RADIUS, first));
        let curves = curves.map(|poses| (cost(EASY_RADIUS, swing(&poses), length(&poses)), poses));
        curves.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(cost, _)| *cost < limit).map(|(_, poses)| poses)
    } else {
        SwingOutTurn::best(from, to).filter(|turn| turn.cost() < limit).map(|turn| turn.poses())
    };
    wide.filter(|poses| poses != direct)
}

/// Whether a curve certainly has at least the easy radius between two poses: up to half a radian, an angle is at most 5 percent
/// larger than its sine.
fn is_easy(from: Pose, to: Pose) -> bool {
    let sine = cross(from.heading, to.heading).abs();
    sine < 0.47 && from.heading.dot(&to.heading) > 0.0 && (to.point - from.point).norm() > EASY_RADIUS * 1.05 * sine
}

/// The cost of a curve by its smallest radius (metres), its swings (degrees) and its length (metres).
fn cost(radius: f64, swing: f64, length: f64) -> f64 {
    let lack = (EASY_RADIUS / radius.max(f64::MIN_POSITIVE) - 1.0).max(0.0);
    lack + TIGHT * lack * lack + (swing - FREE_SWING).max(0.0) / SWING + length / LENGTH
}

fn length(poses: &[Pose]) -> f64 {
    poses.windows(2).map(|w| (w[1].point - w[0].point).norm()).sum()
}

/// The sum of turns, degrees, against the main turn of a curve.
fn swing(poses: &[Pose]) -> f64 {
    curve::sway(poses).to_degrees()
}

/// A bend away from the turn, a straight line, the turn, a straight line, a bend back. All but the turn may be empty.
struct SwingOutTurn {
    ends: [Pose; 2],
    /// The swings before and after the turn, degrees.
    swing: [f64; 2],
    /// The end of the bend away and the start of the bend back.
    inner: [Pose; 2],
    /// The start and the end of the turn.
    turn: [Point; 2],
    /// The radius of the turn, metres.
    radius: f64,
    /// 1 for a turn to the left, -1 to the right.
    side: f64,
}

impl SwingOutTurn {
    /// The turn of the lowest cost; `None` if there is no room.
    fn best(from: Pose, to: Pose) -> Option<Self> {
        let end_side = cross(from.heading, to.point - from.point).signum();
        let change = angle_between(from.heading, to.heading);
        let side = if change.abs() > REVERSAL.to_radians() { end_side } else { change.signum() };
        if side != end_side {
            return None;
        }
        let (before, after) = (swings(from, -side), swings(reversed(to), side));
        let pairs = before.iter().flat_map(|a| after.iter().map(move |b| (a, b)));
        let pairs = pairs.filter(|(a, b)| a.0 + b.0 <= MAX_SWINGS);
        let turns =
            pairs.filter_map(|(&(a, first), &(b, last))| Self::new([from, to], side, [a, b], [first, reversed(last)]));
        turns.min_by(|a, b| a.cost().total_cmp(&b.cost()))
    }

    fn new(ends: [Pose; 2], side: f64, swing: [f64; 2], inner: [Pose; 2]) -> Option<Self> {
        let [a, b] = inner;
        // The centre of a circle of radius r that touches both lines: a + s a' + r n = b + u b' + r m.
        let det = cross(a.heading, b.heading);
        if det.abs() < PARALLEL {
            return None;
        }
        let normals = inner.map(|pose| left_of(pose.heading) * side);
        let along = |v: Vector| [cross(v, b.heading) / det, cross(v, a.heading) / det];
        let (fixed, by_radius) = (along(b.point - a.point), along(normals[1] - normals[0]));
        // The length of each straight line is linear in the radius.
        let straights = [(fixed[0], by_radius[0]), (-fixed[1], -by_radius[1])];
        let neck = angle_between(a.heading, b.heading) * side < 0.0;
        let (mut least, mut most) = (pose::MIN_SPACING, f64::INFINITY);
        for (constant, slope) in straights {
            let lengths = [0.0, if neck { MAX_NECK } else { f64::INFINITY }];
            let limits = lengths.map(|length| (length - constant) / slope);
            least = least.max(limits[0].min(limits[1]));
            most = most.min(limits[0].max(limits[1]));
        }
        let radius = most.min(EASY_RADIUS.max(least));
        if !(radius >= least && radius.is_finite()) {
            return None;
        }
        let start = a.point + a.heading * (fixed[0] + by_radius[0] * radius);
        let end = b.point + b.heading * (fixed[1] + by_radius[1] * radius);
        Some(Self { ends, swing, inner, turn: [start, end], radius, side })
    }

    /// The change of direction in the turn, radians.
    fn angle(&self) -> f64 {
        let turn = angle_between(self.inner[0].heading, self.inner[1].heading);
        if turn * self.side < 0.0 { turn + self.side * std::f64::consts::TAU } else { turn }
    }

    fn cost(&self) -> f64 {
        let bends = EASY_RADIUS * (self.swing[0] + self.swing[1]).to_radians() + self.radius * self.angle().abs();
        let straights = (self.turn[0] - self.inner[0].point).norm() + (self.inner[1].point - self.turn[1]).norm();
        cost(self.radius, self.swing[0] + self.swing[1], bends + straights)
    }

    fn poses(&self) -> Vec<Pose> {
        let [from, to] = self.ends;
        let mut poses = Self::lead(from, -self.side * self.swing[0], self.turn[0]);
        let tail = Self::lead(reversed(to), self.side * self.swing[1], self.turn[1]);
        let start = Pose { point: self.turn[0], heading: self.inner[0].heading };
        poses.extend(pose::arc(start, self.angle(), self.radius).skip(1));
        poses.pop();
        poses.extend(tail.into_iter().rev().map(reversed));
        poses
    }

    /// From one end to the point at which the turn begins.
    fn lead(end: Pose, swing: f64, turn: Point) -> Vec<Pose> {
        let mut poses = if swing == 0.0 { vec![end] } else { bend(end, swing).collect() };
        let last = poses.pop().unwrap_or(end);
        poses.extend(pose::straight(last.point, turn, last.heading));
        // The end is exact, even if the turn begins slightly behind it.
        poses.push(if poses.is_empty() { end } else { Pose { point: turn, ..last } });
        poses
    }
}

/// All swings to a side (1 left, -1 right) from a pose: degrees, and the pose behind the bend.
fn swings(pose: Pose, side: f64) -> Vec<(f64, Pose)> {
    let end = |degrees: f64| if degrees == 0.0 { None } else { bend(pose, side * degrees).next_back() };
    (0..=MAX_SWING).map(f64::from).map(|degrees| (degrees, end(degrees).unwrap_or(pose))).collect()
}

fn reversed(pose: Pose) -> Pose {
    Pose { heading: -pose.heading, ..pose }
}

/// Poses on an arc of the easy radius; `degrees` are left positive.
fn bend(from: Pose, degrees: f64) -> impl DoubleEndedIterator<Item = Pose> {
    pose::arc(from, degrees.to_radians(), EASY_RADIUS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::pose::pose;

    /// The curve, with a swing if that makes it wider.
    fn turn(from: Pose, to: Pose) -> Vec<Pose> {
        let direct = curve::join(from, to);
        swing_out(from, to, &direct).unwrap_or(direct)
    }

    fn assert_smooth(poses: &[Pose], from: Pose, to: Pose) {
        let ends = [poses[0].point - from.point, poses[poses.len() - 1].point - to.point];
        assert!(ends.iter().all(|gap| gap.norm() < 1e-6), "{ends:?}");
        for w in poses.windows(2) {
            let way = w[1].point - w[0].point;
            assert!(way.norm() > 1e-3, "{w:?}");
            for heading in [w[0].heading, w[1].heading] {
                assert!(angle_between(heading, way).abs() < 6f64.to_radians(), "{w:?}");
            }
        }
    }

    #[test]
    fn a_corner_close_to_one_lane_becomes_wider() {
        for (ahead, aside) in [(3.6, 12.0), (12.0, 3.6), (3.9, 4.6)] {
            for side in [1.0, -1.0] {
                let (from, to) = (pose(0.0, 0.0, 0.0), pose(ahead, side * aside, side * 90.0));
                let poses = turn(from, to);
                assert_smooth(&poses, from, to);
                assert!(curve::radius(&poses) > 3.9, "{ahead} {aside}: {}", curve::radius(&poses));
                assert!(swing(&poses) < FREE_SWING + 0.1, "{ahead} {aside}: {}", swing(&poses));
            }
        }
    }

    #[test]
    fn a_hairpin_swings_out_until_a_car_can_drive_it() {
        for (from, to) in [
            (pose(0.0, 0.0, 90.0), pose(-3.3, 0.0, -90.0)),
            (pose(0.0, 0.0, 90.0), pose(-3.3, 0.3, -85.0)),
            (pose(7.7, 0.0, 180.0), pose(-7.7 * 0.9, 7.7 * 0.42, 25.0)),
        ] {
            let poses = turn(from, to);
            assert_smooth(&poses, from, to);
            assert!(curve::radius(&poses) > curve::radius(&curve::join(from, to)), "{}", curve::radius(&poses));
            assert!(curve::radius(&poses) > 2.1, "{}", curve::radius(&poses));
        }
    }

    #[test]
    fn tangents_that_meet_at_an_end_leave_no_corner() {
        for (ahead, aside) in [(20.0, -14.0), (20.0, -14.3), (16.4, -11.0)] {
            for side in [1.0, -1.0] {
                let (from, to) = (pose(0.0, 0.0, 0.0), pose(ahead, side * aside, side * -35.0));
                for (from, to) in [(from, to), (reversed(to), reversed(from))] {
                    let poses = turn(from, to);
                    assert_smooth(&poses, from, to);
                    assert!(curve::radius(&poses) > 4.0, "{ahead} {aside}: {}", curve::radius(&poses));
                }
            }
        }
    }

    #[test]
    fn an_easy_curve_stays() {
        for to in [pose(8.0, 8.0, 90.0), pose(20.0, 1.0, 0.0), pose(1.0, 12.0, 180.0)] {
            let from = pose(0.0, 0.0, 0.0);
            assert_eq!(turn(from, to), curve::join(from, to));
        }
    }
}
