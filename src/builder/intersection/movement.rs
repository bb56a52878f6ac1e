//! Which arm leads to which through an intersection, and what a turn is called.

use crate::builder::lanes::types::{Arm, ArmLane, Lanes};
use crate::builder::network::Intersection;
use crate::builder::network::turn::turn;
use crate::builder::network::turn_restrictions::ResolvedRestrictions;
use crate::builder::tags::cross_section::{Arrows, StripKind};
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::pose::Pose;
use crate::geometry::{angle_between, curve};

use super::lane_assignment::assign_lanes;
use super::movement_types::{Movement, Movements, TurnTarget};

/// Curvature, 1/m, beyond which nobody is led back who could go elsewhere: a car drives it with ease.
const TIGHTEST_BACK: f64 = 0.25;

/// From this change of direction on, degrees, a turn between roads that meet at an acute angle is a hairpin ...
const HAIRPIN: f64 = 135.0;
/// ... which no car gets around at once beyond this curvature, 1/m: a small one turns on a radius of 4.5 m.
const TIGHTEST_HAIRPIN: f64 = 1.0 / 3.0;

/// Finds the movements of an intersection.
pub fn movements(
    side: DrivingSide,
    restricted: &ResolvedRestrictions,
    lanes: &Lanes,
    intersection: &Intersection,
) -> Movements {
    let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
    let mut found = Movements::default();
    let mut targets: Vec<Vec<TurnTarget>> = Vec::new();
    for (from, arm) in arms.iter().enumerate() {
        let mut open = Vec::new();
        for (to, other) in arms.iter().enumerate() {
            if to == from || arm.into.is_empty() || other.out.is_empty() {
                continue;
            }
            if restricted.permit(intersection, arm.at, other.at) {
                let (turn, shown) = (turn(side, arm.inward, -other.inward), turn(side, arm.aim, -other.aim));
                open.push(TurnTarget { to, arm: other, turn, shown });
            } else {
                found.prohibited.push((from, to));
            }
        }
        // Arms are clockwise: from left to right as one drives in, whatever the angles say.
        let count = arms.len();
        open.sort_by_key(|t| (t.to + count - from) % count);
        targets.push(open);
    }
    let around = without_turning_back(side, &arms, &mut targets);
    let mut heed = vec![true; arms.len()];
    found.all = assign_lanes(restricted, &arms, &targets, &heed);
    // Where all arrows lead past a road, they are not meant for this place: lanes are marked long before they part.
    let missed: Vec<usize> = (0..arms.len())
        .filter(|to| !found.all.iter().any(|m| m.to == *to))
        .filter_map(|to| {
            let leads = |from: &usize| targets[*from].iter().find(|t| t.to == to).map(|t| (t.turn.abs(), *from));
            (0..arms.len()).filter_map(|from| leads(&from)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
        })
        .collect();
    if !missed.is_empty() {
        missed.into_iter().for_each(|from| heed[from] = false);
        found.all = assign_lanes(restricted, &arms, &targets, &heed);
    }
    found.all.extend(around);
    found.all.sort_unstable();
    found.all.dedup();
    for (from, arm) in arms.iter().enumerate() {
        for (to, other) in arms.iter().enumerate() {
            let lanes = from != to && !arm.into.is_empty() && !other.out.is_empty();
            let missing = !found.all.iter().any(|m| (m.from, m.to) == (from, to));
            if lanes && missing && !found.prohibited.contains(&(from, to)) {
                found.prohibited.push((from, to));
            }
        }
    }
    found.prohibited.sort_unstable();
    found
}

/// Takes away the arms that one would have to turn back for, or around a hairpin without room, unless an arrow says so, there
/// is no other way on, or nobody else could enter that arm. Gives the ways back for which a median leaves room.
fn without_turning_back(side: DrivingSide, arms: &[&Arm], targets: &mut [Vec<TurnTarget>]) -> Vec<Movement> {
    let mut around = Vec::new();
    let closed = |from: usize, t: &TurnTarget| t.turns_back() || is_cramped(arms[from], t);
    let entered = targets.iter().enumerate().flat_map(|(from, open)| open.iter().filter(move |t| !closed(from, t)));
    let entered: Vec<usize> = entered.map(|t| t.to).collect();
    for (from, open) in targets.iter_mut().enumerate() {
        let signed = arms[from].into.iter().any(|lane| lane.arrows.has(Arrows::REVERSE));
        if signed || open.iter().all(|t| closed(from, t)) {
            continue;
        }
        open.retain(|t| {
            let kept = !closed(from, t) || !entered.contains(&t.to);
            if !kept {
                around.extend(turning_around(side, from, arms[from], t));
            }
            kept
        });
    }
    around
}

/// Whether the way into an arm is a hairpin for which there is no room, whatever the lanes.
fn is_cramped(arm: &Arm, target: &TurnTarget) -> bool {
    let mut pairs = arm.into.iter().flat_map(|into| target.arm.out.iter().map(move |out| (into.pose, out.pose)));
    target.turn.abs() > HAIRPIN && !pairs.any(|(into, out)| gentle(&curve::join(into, out), TIGHTEST_HAIRPIN))
}

/// The way back around the end of a median, or into a road that leaves at an acute angle: from the lane on the far side to
/// the first one that is far enough from it, unless an arrow leads elsewhere.
fn turning_around(side: DrivingSide, from: usize, arm: &Arm, target: &TurnTarget) -> Option<Movement> {
    let (far, turns) = match side {
        DrivingSide::Right => (1.0, Arrows::LEFT),
        DrivingSide::Left => (-1.0, Arrows::RIGHT),
    };
    let driven = |lanes: &[ArmLane]| -> Vec<(usize, ArmLane)> {
        let mut found: Vec<_> = lanes.iter().copied().enumerate().filter(|(_, l)| l.kind == StripKind::Drive).collect();
        if side == DrivingSide::Left {
            found.reverse();
        }
        found
    };
    let (in_lane, into) = driven(&arm.into).first().copied()?;
    let room = |out: &ArmLane| {
        let across = far * crate::geometry::cross(into.pose.heading, out.pose.point - into.pose.point);
        across > 0.0 && gentle(&curve::join(into.pose, out.pose), TIGHTEST_BACK)
    };
    let (out_lane, _) = driven(&target.arm.out).into_iter().find(|(_, out)| room(out))?;
    let free = into.arrows.is_none() || into.arrows.has(turns);
    (free && arm.at.road != target.arm.at.road).then_some(Movement { from, to: target.to, in_lane, out_lane })
}

/// Whether a course bends nowhere more than by the curvature, 1/m.
fn gentle(course: &[Pose], most: f64) -> bool {
    let bend = |w: &[Pose]| angle_between(w[0].heading, w[1].heading).abs();
    course.windows(2).all(|w| bend(w) <= most * (w[1].point - w[0].point).norm() + 1e-3)
}
