//! Turns for which there is little room: the curve swings out to the other side before it turns, or behind, as drivers do.

use super::pose::Pose;
use super::{Point, Vector, angle_between, cross, curve, left_of, pose, s_curve};

/// Radius, metres, from which on a turn needs no swing: a car takes it at walking pace without turning the wheel fully.
const EASY: f64 = 4.5;
/// The curve swings out by at most so many degrees on either side, in steps of one, ...
const SWING_MOST: u32 = 40;
/// ... and by at most so many on both: beyond, it is a slalom.
const SWINGS_MOST: f64 = 56.0;
/// A swing of so many degrees in all is none that a passenger feels; ...
const FREE: f64 = 7.0;
/// ... and so many beyond are worth it where they widen the turn from three quarters of the easy radius to all of it.
const SWING: f64 = 7.0;
/// What a radius lacks to the easy one counts once by its share, and so many times by the square of that: what is tight
/// anyway must not become tighter.
const TIGHT: f64 = 10.0;
/// So many metres of way are as bad as [`SWING`]: of two curves alike, the shorter.
const WAY: f64 = 30.0;
/// A turn that narrows to a bottle's neck has no straights longer than this, metres: there it leaves the roads.
const NECK: f64 = 2.0;
/// Changes of direction below this, degrees, are no turns: who swings out there weaves, but for a bend to either side.
const TURN_LEAST: f64 = 45.0;
/// Unit directions whose cross product is below this are parallel: next to them there is another swing.
const PARALLEL: f64 = 1e-6;
/// From this change of direction on, degrees, it is where the end lies that tells to which side the curve turns.
const BACK: f64 = 150.0;

/// Where the curve of [`curve::join`] between two places is tight, one that swings out for a wider radius.
pub fn swing_out(from: Pose, to: Pose, plain: &[Pose]) -> Option<Vec<Pose>> {
    if plain.windows(2).all(|w| easy(w[0], w[1])) {
        return None;
    }
    let radius = curve::radius(plain);
    if radius >= EASY {
        return None;
    }
    let worst = cost(radius, bent_back(plain), length(plain));
    let wide = if angle_between(from.heading, to.heading).abs() < TURN_LEAST.to_radians() {
        // Where the tangents meet all but at an end, the arc between them is a corner.
        let bent = [1.0, -1.0].into_iter().filter_map(|first| s_curve::bent_twice(from, to, EASY, first));
        let bent = bent.map(|poses| (cost(EASY, bent_back(&poses), length(&poses)), poses));
        bent.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(cost, _)| *cost < worst).map(|(_, poses)| poses)
    } else {
        swung(from, to).filter(|swing| swing.cost() < worst).map(|swing| swing.poses())
    };
    wide.filter(|poses| poses != plain)
}

/// Whether a curve surely bends no more tightly than the easy radius from one place to the next: up to half a radian, an angle
/// is hardly larger than its sine.
fn easy(from: Pose, to: Pose) -> bool {
    let sine = cross(from.heading, to.heading).abs();
    sine < 0.47 && from.heading.dot(&to.heading) > 0.0 && (to.point - from.point).norm() > EASY * 1.05 * sine
}

/// How little one likes a curve of a least radius (metres) that bends back by so many degrees and is so long (metres).
fn cost(radius: f64, back: f64, length: f64) -> f64 {
    let lack = (EASY / radius.max(f64::MIN_POSITIVE) - 1.0).max(0.0);
    lack + TIGHT * lack * lack + (back - FREE).max(0.0) / SWING + length / WAY
}

fn length(poses: &[Pose]) -> f64 {
    poses.windows(2).map(|w| (w[1].point - w[0].point).norm()).sum()
}

/// By how many degrees a curve bends to the side that it does not turn to.
fn bent_back(poses: &[Pose]) -> f64 {
    let turns = || poses.windows(2).map(|w| angle_between(w[0].heading, w[1].heading).to_degrees());
    (turns().map(f64::abs).sum::<f64>() - turns().sum::<f64>().abs()) / 2.0
}

/// The swing that one likes best; `None` where nothing turns or there is no room for any.
fn swung(from: Pose, to: Pose) -> Option<SwingOutTurn> {
    let across = cross(from.heading, to.point - from.point).signum();
    let change = angle_between(from.heading, to.heading);
    let side = if change.abs() > BACK.to_radians() { across } else { change.signum() };
    if side != across {
        return None;
    }
    let bends = |place: Pose, side: f64| -> Vec<(f64, Pose)> {
        let end = |by: f64| if by == 0.0 { None } else { arc(place, side * by).next_back() };
        (0..=SWING_MOST).map(f64::from).map(|by| (by, end(by).unwrap_or(place))).collect()
    };
    let (before, behind) = (bends(from, -side), bends(reversed(to), side));
    let pairs = before.iter().flat_map(|a| behind.iter().map(move |b| (a, b)));
    let pairs = pairs.filter(|(a, b)| a.0 + b.0 <= SWINGS_MOST);
    let all = pairs
        .filter_map(|(&(a, first), &(b, last))| SwingOutTurn::new([from, to], side, [a, b], [first, reversed(last)]));
    all.min_by(|a, b| a.cost().total_cmp(&b.cost()))
}

/// A bend away from the turn, a straight, the turn, a straight, a bend back: any of them but the turn may be nothing.
struct SwingOutTurn {
    ends: [Pose; 2],
    /// Degrees by which it swings out before and behind the turn.
    swing: [f64; 2],
    /// Where the bend away ends and where the bend back begins.
    inner: [Pose; 2],
    /// Where the turn begins and ends.
    turn: [Point; 2],
    /// Of the turn, metres.
    radius: f64,
    /// 1 for a turn to the left, -1 for one to the right.
    side: f64,
}

impl SwingOutTurn {
    fn new(ends: [Pose; 2], side: f64, swing: [f64; 2], inner: [Pose; 2]) -> Option<Self> {
        let [a, b] = inner;
        // Centre of a circle that touches both lines: a + s a' + r n = b + u b' + r m.
        let det = cross(a.heading, b.heading);
        if det.abs() < PARALLEL {
            return None;
        }
        let normals = inner.map(|pose| left_of(pose.heading) * side);
        let along = |way: Vector| [cross(way, b.heading) / det, cross(way, a.heading) / det];
        let (fixed, by_radius) = (along(b.point - a.point), along(normals[1] - normals[0]));
        // Both straights are what they are at no radius, and so much longer by metre of radius.
        let straights = [(fixed[0], by_radius[0]), (-fixed[1], -by_radius[1])];
        let neck = angle_between(a.heading, b.heading) * side < 0.0;
        let (mut least, mut most) = (pose::MIN_SPACING, f64::INFINITY);
        for (none, by) in straights {
            let limits = if neck { [0.0, NECK] } else { [0.0, f64::INFINITY] }.map(|length| (length - none) / by);
            least = least.max(limits[0].min(limits[1]));
            most = most.min(limits[0].max(limits[1]));
        }
        let radius = most.min(EASY.max(least));
        if !(radius >= least && radius.is_finite()) {
            return None;
        }
        let start = a.point + a.heading * (fixed[0] + by_radius[0] * radius);
        let end = b.point + b.heading * (fixed[1] + by_radius[1] * radius);
        Some(Self { ends, swing, inner, turn: [start, end], radius, side })
    }

    /// Change of direction in the turn, radians.
    fn turned(&self) -> f64 {
        let turn = angle_between(self.inner[0].heading, self.inner[1].heading);
        if turn * self.side < 0.0 { turn + self.side * std::f64::consts::TAU } else { turn }
    }

    fn cost(&self) -> f64 {
        let bends = EASY * (self.swing[0] + self.swing[1]).to_radians() + self.radius * self.turned().abs();
        let straights = (self.turn[0] - self.inner[0].point).norm() + (self.inner[1].point - self.turn[1]).norm();
        cost(self.radius, self.swing[0] + self.swing[1], bends + straights)
    }

    fn poses(&self) -> Vec<Pose> {
        let [from, to] = self.ends;
        let mut poses = Self::led_up(from, -self.side * self.swing[0], self.turn[0]);
        let tail = Self::led_up(reversed(to), self.side * self.swing[1], self.turn[1]);
        let start = Pose { point: self.turn[0], heading: self.inner[0].heading };
        poses.extend(pose::arc(start, self.turned(), self.radius).skip(1));
        poses.pop();
        poses.extend(tail.into_iter().rev().map(reversed));
        poses
    }

    /// From one end to where the turn begins, seen from there.
    fn led_up(end: Pose, swing: f64, turn: Point) -> Vec<Pose> {
        let mut poses = bend(end, swing);
        let last = poses.pop().unwrap_or(end);
        poses.extend(pose::straight(last.point, turn, last.heading));
        // The end is where it is; where the turn begins a hair behind it, it begins there.
        poses.push(if poses.is_empty() { end } else { Pose { point: turn, ..last } });
        poses
    }
}

fn reversed(pose: Pose) -> Pose {
    Pose { heading: -pose.heading, ..pose }
}

/// A bend of the easy radius from a place on, by so many degrees, left positive; at least that place.
fn bend(from: Pose, degrees: f64) -> Vec<Pose> {
    if degrees == 0.0 { vec![from] } else { arc(from, degrees).collect() }
}

/// Places on an arc of the easy radius from a place on, by so many degrees.
fn arc(from: Pose, degrees: f64) -> impl DoubleEndedIterator<Item = Pose> {
    pose::arc(from, degrees.to_radians(), EASY)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(x: f64, y: f64, degrees: f64) -> Pose {
        Pose { point: Point::new(x, y), heading: Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin()) }
    }

    /// The curve, swung out where that makes it wider.
    fn turn(from: Pose, to: Pose) -> Vec<Pose> {
        let plain = curve::join(from, to);
        swing_out(from, to, &plain).unwrap_or(plain)
    }

    fn smooth(poses: &[Pose], from: Pose, to: Pose) {
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
    fn a_corner_close_before_one_lane_is_taken_in_a_wider_sweep() {
        for (ahead, aside) in [(3.6, 12.0), (12.0, 3.6), (3.9, 4.6)] {
            for side in [1.0, -1.0] {
                let (from, to) = (pose(0.0, 0.0, 0.0), pose(ahead, side * aside, side * 90.0));
                let poses = turn(from, to);
                smooth(&poses, from, to);
                assert!(curve::radius(&poses) > 3.9, "{ahead} {aside}: {}", curve::radius(&poses));
                assert!(bent_back(&poses) < FREE + 0.1, "{ahead} {aside}: {}", bent_back(&poses));
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
            smooth(&poses, from, to);
            assert!(curve::radius(&poses) > curve::radius(&curve::join(from, to)), "{}", curve::radius(&poses));
            assert!(curve::radius(&poses) > 2.1, "{}", curve::radius(&poses));
        }
    }

    #[test]
    fn no_corner_is_left_where_a_lane_leads_on_right_beside_its_tangent() {
        for (ahead, aside) in [(20.0, -14.0), (20.0, -14.3), (16.4, -11.0)] {
            for side in [1.0, -1.0] {
                let (from, to) = (pose(0.0, 0.0, 0.0), pose(ahead, side * aside, side * -35.0));
                for (from, to) in [(from, to), (reversed(to), reversed(from))] {
                    let poses = turn(from, to);
                    smooth(&poses, from, to);
                    assert!(curve::radius(&poses) > 4.0, "{ahead} {aside}: {}", curve::radius(&poses));
                }
            }
        }
    }

    #[test]
    fn what_is_easy_stays_as_it_is() {
        for to in [pose(8.0, 8.0, 90.0), pose(20.0, 1.0, 0.0), pose(1.0, 12.0, 180.0)] {
            let from = pose(0.0, 0.0, 0.0);
            assert_eq!(turn(from, to), curve::join(from, to));
        }
    }
}
