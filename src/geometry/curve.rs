//! Smooth curves between two poses, and lines beside them.

use super::pose::{MIN_SPACING, Pose, arc, density, straight, tangents};
use super::{Point, Polyline, Vector, angle_between, cross, left_of, s_curve, segment_crossing};

/// A smooth curve from one pose to another: an arc between straight lines if the tangents meet; else an S-curve; else a cubic
/// Bézier curve.
pub fn join(from: Pose, to: Pose) -> Vec<Pose> {
    fillet(from, to).or_else(|| s_curve::join(from, to)).unwrap_or_else(|| {
        let turn = angle_between(from.heading, to.heading).abs();
        // The handle length of the cubic nearest to a circular arc.
        cubic(from, to, [1.0 / (3.0 * (turn / 4.0).cos().powi(2)); 2])
    })
}

/// The curve of [`join`] between straight lines at both ends, of these lengths in metres.
pub fn held(from: Pose, to: Pose, [before, after]: [f64; 2]) -> Vec<Pose> {
    let start = Pose { point: from.point + from.heading * before, ..from };
    let end = Pose { point: to.point - to.heading * after, ..to };
    let mut poses = straight(from.point, start.point, from.heading);
    poses.extend(join(start, end));
    poses.extend(straight(to.point, end.point, to.heading).into_iter().rev());
    poses
}

/// The lengths of the straight lines, metres, between which a turn has an arc like the lanes that people draw.
///
/// `over` are the lengths over crosswalks, which do not widen the arc. In a large intersection a turn goes straight on for longer,
/// too. `None` where the curve has no single arc, hardly turns, or would bend too tightly.
pub fn straight_ends(from: Pose, to: Pose, over: [f64; 2]) -> Option<[f64; 2]> {
    /// A smaller change of direction, degrees, is no turn.
    const LEAST_TURN: f64 = 40.0;
    /// A turn keeps this radius, metres, where it has it without straight lines, ...
    const LEAST_RADIUS: f64 = 6.0;
    /// ... and this share of the radius that it has then.
    const LEAST_SHARE: f64 = 0.66;
    /// A larger arc, metres, is cut down to this radius, but not below the share [`LARGE_SHARE`], as professionals draw it.
    const LARGE_RADIUS: f64 = 20.0;
    const LARGE_SHARE: f64 = 0.63;
    let (before, after, turn) = tangents(from, to)?;
    let radius = |[a, b]: [f64; 2]| (before - a).min(after - b) / (turn.abs() / 2.0).tan();
    let full = radius([0.0; 2]);
    let least = full.min(LEAST_RADIUS).max(LEAST_SHARE * full);
    let shares = [1.0, 0.75, 0.5, 0.25, 0.0].map(|share| over.map(|length| length * share));
    let straights = shares.into_iter().find(|straights| radius(*straights) >= least)?;
    let more = if radius(straights) > LARGE_RADIUS {
        let tangent = (before - straights[0]).min(after - straights[1]);
        tangent * (1.0 - LARGE_SHARE.max(LARGE_RADIUS / radius(straights)))
    } else {
        0.0
    };
    let straights = straights.map(|length| length + more);
    (turn.abs() > LEAST_TURN.to_radians() && straights != [0.0; 2]).then_some(straights)
}

/// The radius of the arc of [`join`], metres; `None` if it has no single arc.
pub fn join_radius(from: Pose, to: Pose) -> Option<f64> {
    let (before, after, turn) = tangents(from, to)?;
    Some(before.min(after) / (turn.abs() / 2.0).tan())
}

fn fillet(from: Pose, to: Pose) -> Option<Vec<Pose>> {
    let (before, after, turn) = tangents(from, to)?;
    let tangent = before.min(after);
    let radius = tangent / (turn.abs() / 2.0).tan();
    let start = from.point + from.heading * (before - tangent);
    let end = to.point - to.heading * (after - tangent);
    let mut poses = straight(from.point, start, from.heading);
    poses.extend(arc(Pose { point: start, heading: from.heading }, turn, radius));
    poses.extend(straight(to.point, end, to.heading).into_iter().rev());
    Some(poses)
}

/// The smooth curves from pose to pose, each as [`join`] draws it.
pub fn through(passed: &[Pose]) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::new();
    for pair in passed.windows(2) {
        poses.pop();
        poses.extend(join(pair[0], pair[1]));
    }
    poses
}

/// The changes of direction from pose to pose, radians, left positive.
fn bends(poses: &[Pose]) -> impl Iterator<Item = f64> {
    poses.windows(2).map(|w| angle_between(w[0].heading, w[1].heading))
}

/// The whole change of direction along a curve, radians, left positive.
pub fn turned(poses: &[Pose]) -> f64 {
    bends(poses).sum()
}

/// How much a curve bends to the other side on the way, radians.
pub fn sway(poses: &[Pose]) -> f64 {
    (bends(poses).map(f64::abs).sum::<f64>() - turned(poses).abs()) / 2.0
}

/// The length of a curve, metres.
pub fn length(poses: &[Pose]) -> f64 {
    poses.windows(2).map(|w| (w[1].point - w[0].point).norm()).sum()
}

/// The smallest radius of a curve, metres.
pub fn radius(poses: &[Pose]) -> f64 {
    let bends = poses.windows(2).map(|w| {
        let turn = angle_between(w[0].heading, w[1].heading).abs();
        (w[1].point - w[0].point).norm() / turn.max(f64::MIN_POSITIVE)
    });
    bends.fold(f64::INFINITY, f64::min)
}

/// The smallest radius of a line, metres, and where it is, measured over even steps of about this length, metres. `None` for a line
/// shorter than two steps, which has no curvature to speak of.
pub fn tightest_bend(line: &Polyline, step: f64) -> Option<(f64, Point)> {
    let even = line.resampled(step);
    let length = line.length() / (even.points().len() - 1) as f64;
    let turn = |w: &[Point]| (angle_between(w[1] - w[0], w[2] - w[1]).abs(), w[1]);
    let sharpest = even.points().windows(3).map(turn).max_by(|a, b| a.0.total_cmp(&b.0));
    sharpest.filter(|_| length > step / 2.0).map(|(turn, place)| (length / turn, place))
}

/// A cubic Bézier curve. `handles` are the lengths of its handles as parts of the chord.
pub fn cubic(from: Pose, to: Pose, handles: [f64; 2]) -> Vec<Pose> {
    let chord = (to.point - from.point).norm();
    let [a, d] = [from.point, to.point];
    let [b, c] = [a + from.heading * (chord * handles[0]), d - to.heading * (chord * handles[1])];
    let at = |t: f64| {
        let u = 1.0 - t;
        let point = a.coords * (u * u * u)
            + b.coords * (3.0 * u * u * t)
            + c.coords * (3.0 * u * t * t)
            + d.coords * (t * t * t);
        let speed = ((b - a) * (u * u) + (c - b) * (2.0 * u * t) + (d - c) * (t * t)) * 3.0;
        let change = ((c - b) - (b - a)) * (6.0 * u) + ((d - c) - (c - b)) * (6.0 * t);
        (point.into(), speed, change)
    };
    let mut poses: Vec<Pose> = parameters(at)
        .into_iter()
        .map(|t| {
            let (point, speed, _) = at(t);
            Pose { point, heading: speed.try_normalize(1e-9).unwrap_or(from.heading) }
        })
        .collect();
    poses.insert(0, from);
    poses.push(to);
    poses
}

/// The parameters between 0 and 1 at which a curve needs points: the more it bends, the closer. `at` returns the point and the
/// first and second derivatives.
fn parameters(at: impl Fn(f64) -> (Point, Vector, Vector)) -> Vec<f64> {
    /// The number of steps in which curvature is sampled.
    const STEPS: usize = 32;
    /// Reserve for the change of curvature within a step.
    const MARGIN: f64 = 1.02;
    /// No curve of a map needs more.
    const MOST_PIECES: f64 = 100_000.0;
    let mut sums = vec![0.0];
    for i in 0..STEPS {
        let (_, speed, change) = at((i as f64 + 0.5) / STEPS as f64);
        let length = speed.norm();
        // Where the speed is nearly 0, the curvature has no bound.
        let curvature = (cross(speed, change).abs() / (length * length * length)).min(1.0 / MIN_SPACING);
        sums.push(sums[i] + MARGIN * density(curvature) * length / STEPS as f64);
    }
    let pieces = sums[STEPS].ceil().clamp(1.0, MOST_PIECES);
    let mut step = 0;
    (1..pieces as usize)
        .map(|i| {
            let target = sums[STEPS] * i as f64 / pieces;
            while step + 1 < STEPS && sums[step + 1] < target {
                step += 1;
            }
            (step as f64 + (target - sums[step]) / (sums[step + 1] - sums[step])) / STEPS as f64
        })
        .collect()
}

/// The lines to the left and to the right of a curve. Their distance from it changes from `start` to `end` metres: mostly where
/// the curve bends, because other lanes may lie beside it before and after; evenly on a nearly straight curve.
pub fn sides(curve: &[Pose], start: f64, end: f64) -> [Vec<Point>; 2] {
    /// The change of direction, radians, that counts as much as the whole length.
    const EVEN_TURN: f64 = 0.2;
    let step = |w: &[Pose]| [(w[1].point - w[0].point).norm(), (w[1].heading - w[0].heading).norm()];
    let [length, turned] = curve.windows(2).map(step).fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
    let share =
        |[ahead, turn]: [f64; 2]| (EVEN_TURN * ahead / length.max(f64::MIN_POSITIVE) + turn) / (EVEN_TURN + turned);
    let parts = std::iter::once(0.0).chain(curve.windows(2).map(|w| share(step(w))));
    let mut sides = [Vec::with_capacity(curve.len()), Vec::with_capacity(curve.len())];
    let mut sum = 0.0;
    for (pose, part) in curve.iter().zip(parts) {
        sum += part;
        let aside = left_of(pose.heading) * (start + (end - start) * sum);
        sides[0].push(pose.point + aside);
        sides[1].push(pose.point - aside);
    }
    sides
}

/// The number of segments within which a line is searched for crossings with itself: loops of an offset line are local.
const LOOP_REACH: usize = 64;

/// A line without loops and without neighbours closer than [`MIN_SPACING`]; first and last points stay.
#[must_use]
pub fn untangled(line: &[Point]) -> Vec<Point> {
    let (Some(&first), Some(&last)) = (line.first(), line.last()) else { return Vec::new() };
    // A line that never turns back does not cross itself.
    if line.windows(2).all(|w| (w[1] - w[0]).dot(&(last - first)) > 0.0) {
        return spaced(line);
    }
    spaced(&without_loops(line, first))
}

fn without_loops(line: &[Point], first: Point) -> Vec<Point> {
    let mut out = vec![first];
    let (mut i, mut from) = (0, first);
    while i + 1 < line.len() {
        let far = (i + 2..line.len().saturating_sub(1).min(i + LOOP_REACH))
            .rev()
            .find_map(|j| segment_crossing(from, line[i + 1], line[j], line[j + 1]).map(|(_, _, p)| (j, p)));
        (i, from) = far.unwrap_or((i + 1, line[i + 1]));
        out.push(from);
    }
    out
}

fn spaced(line: &[Point]) -> Vec<Point> {
    let (Some(&first), Some(&last)) = (line.first(), line.last()) else { return Vec::new() };
    let mut out = Vec::with_capacity(line.len().max(2));
    out.push(first);
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
    use crate::geometry::pose::{SAGITTA, STRAIGHT_STEP, TURN_STEP, pose};

    #[test]
    fn turns_go_straight_on_over_crosswalks_and_in_large_intersections() {
        let right_angle = |size: f64| (pose(0.0, -size, 90.0), pose(-size, 0.0, 180.0));
        let straights = |size: f64, over| {
            let (from, to) = right_angle(size);
            straight_ends(from, to, over)
        };
        assert_eq!(straights(15.0, [0.0; 2]), None);
        // All of the crosswalk, three quarters of it where only then two thirds of the radius are left, nothing where the turn is tight.
        assert_eq!(straights(15.0, [5.0, 3.0]), Some([5.0, 3.0]));
        assert_eq!(straights(10.0, [4.0, 4.0]), Some([3.0, 3.0]));
        assert_eq!(straights(6.0, [4.0, 0.0]), None);
        // Far beyond 20 m the arc is 0.63 of what it could be.
        let more = straights(40.0, [0.0; 2]).unwrap()[0];
        assert!((more - 40.0 * 0.37).abs() < 1e-9, "{more}");
        let (from, to) = right_angle(15.0);
        let curve = held(from, to, [5.0, 3.0]);
        assert!((radius(&curve) - 10.0).abs() < 0.1 && curve[1].point.x.abs() < 1e-9);
        // Straight on there is no arc.
        assert_eq!(straight_ends(pose(0.0, 0.0, 90.0), pose(0.0, 30.0, 90.0), [5.0, 5.0]), None);
    }

    #[test]
    fn a_right_angle_is_a_circle_with_parallel_bounds() {
        let curve = join(pose(0.0, -8.0, 90.0), pose(-8.0, 0.0, 180.0));
        for p in &curve {
            assert!(((p.point - Point::new(-8.0, -8.0)).norm() - 8.0).abs() < 1e-9);
        }
        for p in &sides(&curve, 1.5, 1.5)[0] {
            assert!(((p - Point::new(-8.0, -8.0)).norm() - 6.5).abs() < 1e-9);
        }
        assert_eq!(join_radius(pose(0.0, -8.0, 90.0), pose(-8.0, 0.0, 180.0)).map(f64::round), Some(8.0));
    }

    #[test]
    fn a_lane_widens_where_it_bends() {
        let straight = (0..10).map(|i| pose(f64::from(i), 0.0, 0.0));
        let turn = join(pose(10.0, 0.0, 0.0), pose(16.0, 6.0, 90.0));
        let curve: Vec<Pose> = straight.chain(turn).chain((7..=16).map(|i| pose(16.0, f64::from(i), 90.0))).collect();
        let [left, right] = sides(&curve, 1.5, 1.9);
        assert!(right[..=10].iter().all(|p| (-1.53..=-1.5).contains(&p.y)), "before the bend");
        assert!(left[left.len() - 10..].iter().all(|p| (14.1..14.13).contains(&p.x)), "behind it");
        let straight: Vec<Pose> = (0..=20).map(|i| pose(f64::from(i), 0.0, 0.0)).collect();
        assert!((sides(&straight, 1.5, 1.9)[0][10].y - 1.7).abs() < 1e-9, "half the way");
    }

    #[test]
    fn curves_meet_their_ends_and_never_bend_sharply() {
        for to in [pose(20.0, 3.0, 0.0), pose(20.0, 0.0, 0.0), pose(15.0, 9.0, 60.0), pose(0.0, 6.0, 180.0)] {
            let from = pose(0.0, 0.0, 0.0);
            let curve = join(from, to);
            let ends = [curve.first(), curve.last()].map(|p| p.map(|p| p.point));
            assert!((ends[0].unwrap() - from.point).norm() < 1e-9 && (ends[1].unwrap() - to.point).norm() < 1e-9);
            for w in curve.windows(3) {
                let turn = angle_between(w[1].point - w[0].point, w[2].point - w[1].point).abs();
                assert!(turn < 1.01 * TURN_STEP, "{turn} on the way to {to:?}");
            }
            for w in curve.windows(2) {
                assert!((w[1].point - w[0].point).norm() <= STRAIGHT_STEP + 1e-9);
            }
        }
    }

    #[test]
    fn a_curve_needs_few_points() {
        let gentle = join(pose(0.0, 0.0, 0.0), pose(60.0, 20.0, 37.0));
        assert!(gentle.len() < 30, "{}", gentle.len());
        for w in sides(&gentle, 1.75, 1.75)[1].windows(3) {
            let turn = angle_between(w[1] - w[0], w[2] - w[1]).abs();
            let sagitta = (w[1] - w[0]).norm() * turn / 8.0;
            assert!(sagitta < 1.2 * SAGITTA, "{sagitta}");
        }
        let straight = join(pose(0.0, 0.0, 0.0), pose(30.0, 0.0, 0.0));
        assert!(straight.len() <= 12, "{}", straight.len());
    }

    #[test]
    fn loops_are_cut_off() {
        let line = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, -2.0), (9.0, -2.0)];
        let line: Vec<Point> = line.iter().map(|&(x, y)| Point::new(x, y)).collect();
        let clean = untangled(&line);
        assert_eq!(clean, [(0.0, 0.0), (2.0, 0.0), (2.0, -2.0), (9.0, -2.0)].map(|(x, y)| Point::new(x, y)));
    }
}
