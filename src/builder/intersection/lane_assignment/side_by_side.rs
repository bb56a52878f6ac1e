//! Approaches side by side, such as the main and the service carriageway of one street: their lanes do not cross each other.
//!
//! Lanes are assigned approach by approach. Carriageways that arrive side by side have the same light as a rule, and Autoware watches
//! nobody on a straight lanelet with a light: where their movements crossed, two vehicles would drive into each other.

use crate::builder::intersection::movement_types::{Movement, TurnTarget};
use crate::builder::lanes::types::{Arm, ArmLane};
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::turn_angle::STRAIGHT_ON;
use crate::builder::tags::cross_section::StripKind;
use crate::geometry::{angle_between, cross};

use super::lane_pairs::pair_up;

/// Approaches, and exits, whose directions differ by at most this, degrees, lie side by side.
const SIDE_BY_SIDE: f64 = 25.0;
/// Approaches nearer to each other than this, metres, touch.
const TOUCHING: f64 = 1.0;

/// Takes apart the movements that cross between approaches side by side and lead to one road: their lanes lead there in order. Mapped
/// connections of lanes stay. So do those of approaches that touch, where lanes become fewer straight on: lanelets that lead beside each
/// other from one place to another would have to share a border.
pub fn keep_order(
    restrictions: &ResolvedRestrictions,
    (arms, targets): (&[&Arm], &[Vec<TurnTarget>]),
    all: &mut Vec<Movement>,
) {
    for (left, right) in side_by_side(arms) {
        for target in &targets[left] {
            let mapped = |from: usize| restrictions.lanes(arms[from].at, target.arm.at).is_some();
            let lanes =
                |from: usize| all.iter().filter(move |m| (m.from, m.to) == (from, target.to)).map(|m| m.out_lane);
            let crosses = lanes(left).max() > lanes(right).min() && lanes(right).next().is_some();
            if crosses && !mapped(left) && !mapped(right) {
                lead_in_order(arms, target, (left, right), all);
            }
        }
    }
}

/// Where one-way approaches side by side both lead straight on to one-way roads side by side, each keeps to its own side. This is for
/// intersections with lights: without them vehicles wait for each other, and a link between carriageways is there to be used. Mapped
/// connections of lanes stay.
pub fn keep_to_own_side(restrictions: &ResolvedRestrictions, arms: &[&Arm], targets: &mut [Vec<TurnTarget>]) {
    for (left, right) in side_by_side(arms) {
        if [left, right].iter().any(|&from| !arms[from].out.is_empty()) {
            continue;
        }
        let ahead = |from: usize| -> Vec<usize> {
            let straight_on = targets[from].iter().filter(|target| target.turn.abs() <= STRAIGHT_ON);
            straight_on.map(|target| target.to).filter(|to| arms[*to].into.is_empty()).collect()
        };
        let (of_left, of_right) = (ahead(left), ahead(right));
        let both: Vec<usize> = of_left.into_iter().filter(|to| of_right.contains(to)).collect();
        let Some((&near, far)) = both.split_first() else { continue };
        let mapped = |from: usize, to: usize| restrictions.lanes(arms[from].at, arms[to].at).is_some();
        if let [.., far] = *far
            && angle(arms[near], arms[far]) <= SIDE_BY_SIDE
            && !mapped(left, far)
            && !mapped(right, near)
        {
            targets[left].retain(|target| target.to != far);
            targets[right].retain(|target| target.to != near);
        }
    }
}

/// The pairs of approaches side by side, the left one first.
fn side_by_side(arms: &[&Arm]) -> Vec<(usize, usize)> {
    let arrives = |arm: &usize| arms[*arm].into.iter().any(|lane| lane.kind == StripKind::Drive);
    let arriving: Vec<usize> = (0..arms.len()).filter(arrives).collect();
    let pairs = arriving.iter().flat_map(|&a| arriving.iter().map(move |&b| (a, b)));
    let in_order = |&(a, b): &(usize, usize)| {
        let place = |arm: usize| arms[arm].into.first().map(|lane| lane.pose.point);
        let to_the_right = place(a).zip(place(b)).is_some_and(|(a_at, b_at)| cross(arms[a].inward, b_at - a_at) < 0.0);
        a != b && to_the_right && angle(arms[a], arms[b]) <= SIDE_BY_SIDE
    };
    pairs.filter(in_order).collect()
}

/// Between the last lane of the left approach and the first lane of the right one, metres across.
fn gap(left: &Arm, right: &Arm) -> f64 {
    let Some((last, first)) = left.into.last().zip(right.into.first()) else { return f64::INFINITY };
    let across = -cross(last.pose.heading, first.pose.point - last.pose.point);
    across - 0.5 * (last.width + first.width)
}

/// Between the directions of two arms, degrees.
fn angle(one: &Arm, other: &Arm) -> f64 {
    angle_between(one.inward, other.inward).abs().to_degrees()
}

/// Pairs the lanes for cars of two approaches with those of one road as if they were one approach.
fn lead_in_order(arms: &[&Arm], target: &TurnTarget, (left, right): (usize, usize), all: &mut Vec<Movement>) {
    let for_cars = |lane: &ArmLane| lane.kind == StripKind::Drive;
    let concerns = |m: &Movement| {
        m.to == target.to
            && (m.from == left || m.from == right)
            && for_cars(&arms[m.from].into[m.in_lane])
            && for_cars(&target.arm.out[m.out_lane])
    };
    let mut leading: Vec<(bool, usize)> =
        all.iter().filter(|m| concerns(m)).map(|m| (m.from == right, m.in_lane)).collect();
    leading.sort_unstable();
    leading.dedup();
    let from = |is_right: bool| if is_right { right } else { left };
    let lanes: Vec<(usize, &ArmLane)> =
        leading.iter().map(|&(is_right, lane)| (lane, &arms[from(is_right)].into[lane])).collect();
    let ins: Vec<usize> = (0..lanes.len()).collect();
    let outs: Vec<usize> = (0..target.arm.out.len()).filter(|&out| for_cars(&target.arm.out[out])).collect();
    let is_straight = target.turn.abs() <= STRAIGHT_ON;
    if is_straight && ins.len() > outs.len() && gap(arms[left], arms[right]) < TOUCHING {
        return;
    }
    let pairs = pair_up((&ins, &outs), &lanes, target, |_| false);
    all.retain(|m| !concerns(m));
    all.extend(pairs.into_iter().map(|(i, out_lane)| {
        let (is_right, in_lane) = leading[i];
        Movement { from: from(is_right), to: target.to, in_lane, out_lane }
    }));
}
