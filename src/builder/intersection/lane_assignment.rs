//! Lane assignment: which lanes of an arm lead to which lanes of the others. Mapped connections and arrows come first; other
//! lanes lead on in order, so that the movements of neighbours never cross.

mod arrow_targets;
mod free_lanes;
mod lane_pairs;
mod side_by_side;
#[cfg(test)]
mod tests;

use crate::builder::lanes::types::{Arm, ArmLane};
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::turn_angle::STRAIGHT_ON;
use crate::builder::tags::cross_section::{Arrows, StripKind};
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::angle_between;

use super::movement_types::{Movement, TurnTarget};
use arrow_targets::{arrow_goals, is_untold, turns_towards};
use lane_pairs::{pair_up, sideways};

pub use side_by_side::keep_to_own_side;

use std::borrow::Cow;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// The movements from all arms; where `with_arrows` is false, as if the arm had no arrows.
pub fn assign_lanes(
    side: DrivingSide,
    restrictions: &ResolvedRestrictions,
    arms: &[&Arm],
    targets: &[Vec<TurnTarget>],
    with_arrows: &[bool],
) -> Vec<Movement> {
    let mut all = Vec::new();
    for (from, arm) in arms.iter().enumerate() {
        let mut arm = Cow::Borrowed(*arm);
        if !with_arrows[from] {
            arm.to_mut().into.iter_mut().for_each(|lane| lane.arrows = Arrows::default());
        }
        let mut approach = ApproachLanes { side, from, arm: &arm, targets: &targets[from], movements: Vec::new() };
        approach.assign_bus_lanes();
        approach.assign(StripKind::Drive);
        approach.assign_bus_roads();
        approach.connect(restrictions);
        if restrictions.fan_out {
            approach.fan_out();
        }
        all.append(&mut approach.movements);
    }
    side_by_side::keep_order(restrictions, (arms, targets), &mut all);
    free_lanes::use_free_lanes(restrictions, arms, &mut all);
    reach_all(arms, &mut all, &[]);
    all.sort_unstable();
    all.dedup();
    all
}

/// The lanes that lead in over one arm, and their movements as far as they are assigned.
struct ApproachLanes<'a> {
    side: DrivingSide,
    from: usize,
    arm: &'a Arm,
    targets: &'a [TurnTarget<'a>],
    movements: Vec<Movement>,
}

impl ApproachLanes<'_> {
    fn add(&mut self, to: usize, in_lane: usize, out_lane: usize) {
        self.movements.push(Movement { from: self.from, to, in_lane, out_lane });
    }

    /// Leads the lanes of one kind to the lanes of the same kind, in order, so that neighbours never cross.
    fn assign(&mut self, kind: StripKind) {
        let lanes: Vec<(usize, &ArmLane)> = self.arm.into.iter().enumerate().filter(|(_, l)| l.kind == kind).collect();
        let usable = self.targets.iter().filter(|t| t.arm.out.iter().any(|l| l.kind == kind));
        let usable: Vec<TurnTarget> = usable.copied().collect();
        if lanes.is_empty() || usable.is_empty() {
            return;
        }
        let (mut goals, given_up) = lane_goals(&lanes, &usable, kind);
        for (t, target) in usable.iter().enumerate() {
            let mut ins: Vec<usize> = (0..lanes.len()).filter(|&i| goals[i].contains(&t)).collect();
            if ins.is_empty() {
                // Nothing prohibits an arm that no arrow leads to: the outer lane takes it, unless the arrows tell for all lanes and
                // its own one points elsewhere. Cars turn off across the bus lane at the kerb.
                let told = |(_, lane): &(usize, &ArmLane)| !is_untold(lane, &usable);
                let outer = outer_lane(&goals, t, target.turn > 0.0);
                let over_buses = kind == StripKind::Drive && self.is_over_buses(target);
                let is_free = over_buses || given_up.contains(&t) || !lanes.iter().all(told);
                if target.turns_back() || !is_free && !turns_towards(lanes[outer].1.arrows, target) {
                    continue;
                }
                ins = vec![outer];
            }
            let outs: Vec<usize> = (0..target.arm.out.len()).filter(|&o| target.arm.out[o].kind == kind).collect();
            while ins.len() > outs.len() {
                // More lanes than the arm takes: those with other goals drop this one, the far ones first.
                let mut candidates = 0..ins.len();
                let has_other = |&i: &usize| goals[ins[i]].len() > 1;
                let far = if target.turn > 0.0 { candidates.rfind(has_other) } else { candidates.find(has_other) };
                let Some(far) = far else { break };
                goals[ins.remove(far)].retain(|&goal| goal != t);
            }
            let crosses = |&(i, out): &(usize, usize)| {
                let mut buses = self.movements.iter().filter(|m| m.to == target.to);
                buses.any(|m| match lanes[i].0 < m.in_lane {
                    true => out > m.out_lane,
                    false => out < m.out_lane,
                })
            };
            for (i, out_lane) in pair_up((&ins, &outs), &lanes, target, crosses) {
                self.add(target.to, lanes[i].0, out_lane);
            }
        }
    }

    /// Whether a near turn leads across the bus lane at the kerb, whose arrow points there.
    fn is_over_buses(&self, target: &TurnTarget) -> bool {
        let (kerb, is_near) = match self.side {
            DrivingSide::Right => (self.arm.into.last(), target.turn < 0.0),
            DrivingSide::Left => (self.arm.into.first(), target.turn > 0.0),
        };
        is_near && kerb.is_some_and(|lane| lane.kind == StripKind::Bus && turns_towards(lane.arrows, target))
    }

    /// Leads bus lanes to a bus lane ahead where there is one, else to the other lanes of the straightest arm.
    fn assign_bus_lanes(&mut self) {
        for (in_lane, lane) in self.arm.into.iter().enumerate().filter(|(_, l)| l.kind == StripKind::Bus) {
            let mut goals = arrow_goals(lane.arrows, self.targets);
            if goals.is_empty() {
                let straightness = |&t: &usize| self.targets[t].turn.abs();
                goals.extend((0..self.targets.len()).min_by(|a, b| straightness(a).total_cmp(&straightness(b))));
            }
            for target in goals.into_iter().map(|t| &self.targets[t]) {
                let rank = |out: &ArmLane| (out.kind != StripKind::Bus, sideways(lane, out));
                let outs = target.arm.out.iter().map(rank).enumerate();
                let best = outs.min_by(|(_, a), (_, b)| compare(*a, *b));
                if let Some((out_lane, _)) = best {
                    self.add(target.to, in_lane, out_lane);
                }
            }
        }
    }

    /// Leads the nearest lane for all vehicles to roads that are for buses only, and the nearest lane of such a road to wherever
    /// no lane leads yet, unless it has arrows.
    fn assign_bus_roads(&mut self) {
        let into = &self.arm.into;
        let busway = into.iter().all(|lane| lane.kind == StripKind::Bus && lane.arrows.is_none());
        if into.is_empty() || !busway && into.iter().any(|lane| lane.kind == StripKind::Bus) {
            return;
        }
        for target in self.targets.iter().filter(|t| !t.turns_back() && !t.arm.out.is_empty()) {
            let is_wanted = match busway {
                true => self.movements.iter().all(|movement| movement.to != target.to),
                false => target.arm.out.iter().all(|lane| lane.kind == StripKind::Bus),
            };
            if is_wanted {
                let outer = |lanes: &[ArmLane]| if target.turn > 0.0 { 0 } else { lanes.len() - 1 };
                self.add(target.to, outer(&self.arm.into), outer(&target.arm.out));
            }
        }
    }

    /// Replaces the movements between two arms by the mapped connections of lanes, if both arms have all lanes they name.
    fn connect(&mut self, restrictions: &ResolvedRestrictions) {
        for target in self.targets {
            let Some(pairs) = restrictions.lanes(self.arm.at, target.arm.at) else { continue };
            let [ins, outs] = [self.arm.into.len(), target.arm.out.len()];
            if pairs.iter().all(|[a, b]| (1..=ins).contains(a) && (1..=outs).contains(b)) {
                self.movements.retain(|m| m.to != target.to);
                pairs.iter().for_each(|[a, b]| self.add(target.to, a - 1, b - 1));
            }
        }
    }

    /// Leads the outermost lanes of each turn to all further lanes of the road it leads to.
    fn fan_out(&mut self) {
        let drive = |lane: &ArmLane| lane.kind == StripKind::Drive;
        for target in self.targets {
            let outs = &target.arm.out;
            let own = self.movements.iter().filter(|m| m.to == target.to);
            let cars = own.filter(|m| drive(&self.arm.into[m.in_lane]) && drive(&outs[m.out_lane]));
            let pairs: Vec<(usize, usize)> = cars.map(|m| (m.in_lane, m.out_lane)).collect();
            let (ins_of, outs_of) = (|| pairs.iter().map(|pair| pair.0), || pairs.iter().map(|pair| pair.1));
            let (Some(first_in), Some(last_in)) = (ins_of().min(), ins_of().max()) else { continue };
            let (Some(first), Some(last)) = (outs_of().min(), outs_of().max()) else { continue };
            let further = (0..first).map(|out| (first_in, out)).chain((last + 1..outs.len()).map(|out| (last_in, out)));
            further.filter(|(_, out)| drive(&outs[*out])).for_each(|(lane, out)| self.add(target.to, lane, out));
        }
    }
}

/// The targets of each lane, so that no lane crosses another; and those that a lane gave up because it crossed several others.
fn lane_goals(lanes: &[(usize, &ArmLane)], targets: &[TurnTarget], kind: StripKind) -> (Vec<Vec<usize>>, Vec<usize>) {
    let mut goals = single_goals(lanes, targets);
    let room: Vec<usize> = targets.iter().map(|t| t.arm.out.iter().filter(|l| l.kind == kind).count()).collect();
    go_straight_on_to_all(&mut goals, lanes, targets, &room);
    let untold: Vec<bool> = lanes.iter().map(|(_, lane)| is_untold(lane, targets)).collect();
    while let Some((lane, target)) = crossing_goal(&goals, targets, &room, &untold) {
        goals[lane].retain(|&t| t != target);
    }
    let mut given_up = Vec::new();
    for _ in 0..goals.len() {
        let Some((lane, beside)) = lane_across(&goals) else { break };
        given_up.append(&mut goals[lane]);
        goals[lane].push(beside);
    }
    (goals, given_up)
}

/// Where several roads go straight on, and the lanes marked to do so are more than the nearest of them takes, they are for those to which
/// no arrow leads, too. `room` is the number of lanes of each target.
fn go_straight_on_to_all(
    goals: &mut [Vec<usize>],
    lanes: &[(usize, &ArmLane)],
    targets: &[TurnTarget],
    room: &[usize],
) {
    let ahead = |t: usize| targets[t].arrow_turn.abs();
    let Some(nearest) = (0..targets.len()).min_by(|a, b| ahead(*a).total_cmp(&ahead(*b))) else { return };
    let through = |i: &usize| lanes[*i].1.arrows.has(Arrows::THROUGH) && goals[*i].contains(&nearest);
    let through: Vec<usize> = (0..lanes.len()).filter(through).collect();
    let is_untold = |t: &usize| goals.iter().all(|of| !of.contains(t));
    let others = (0..targets.len()).filter(|&t| t != nearest && ahead(t) <= STRAIGHT_ON && !targets[t].turns_back());
    let others: Vec<usize> = others.filter(is_untold).collect();
    if through.len() > room[nearest] {
        for lane in through {
            goals[lane].extend(&others);
            goals[lane].sort_unstable();
        }
    }
}

/// A lane that crosses several others, and the target to which the one beside it leads: the arrow of such a lane is meant for another
/// intersection, and what it seems to lead to lies beyond the others.
fn lane_across(goals: &[Vec<usize>]) -> Option<(usize, usize)> {
    let across = |lane: usize| {
        let own = &goals[lane];
        let over_left = goals[..lane].iter().filter(|left| left.iter().any(|t| own.iter().any(|u| t > u))).count();
        let over_right =
            goals[lane + 1..].iter().filter(|right| right.iter().any(|t| own.iter().any(|u| t < u))).count();
        let left = goals[..lane].iter().flatten().max().filter(|_| over_left > 1 && over_right == 0);
        let right = goals[lane + 1..].iter().flatten().min().filter(|_| over_right > 1 && over_left == 0);
        Some((lane, *left.or(right)?))
    };
    (0..goals.len()).find_map(across)
}

/// The outermost lane that reaches a target and crosses no other lane on the way, else the outermost of all.
fn outer_lane(goals: &[Vec<usize>], target: usize, leftmost: bool) -> usize {
    let keeps_order = |lane: &usize| {
        let mut left = goals.iter().take(*lane).flatten();
        let mut right = goals.iter().skip(lane + 1).flatten();
        left.all(|goal| *goal <= target) && right.all(|goal| *goal >= target)
    };
    let mut lanes = (0..goals.len()).filter(keeps_order);
    match leftmost {
        true => lanes.next().unwrap_or(0),
        false => lanes.next_back().unwrap_or(goals.len() - 1),
    }
}

/// A lane and a target that it gives up, because its movement there crosses that of another lane. The target is the one with the
/// most lanes too many, and among equal ones the one that is farthest from straight on; the lane is the one that crosses the most
/// others. A lane for which no arrow tells the target gives up one that no other lane has, too. `None` if no movements cross, or if
/// every lane and target that cross would be left without another.
fn crossing_goal(
    goals: &[Vec<usize>],
    targets: &[TurnTarget],
    room: &[usize],
    untold: &[bool],
) -> Option<(usize, usize)> {
    let users: Vec<usize> = (0..targets.len()).map(|t| goals.iter().filter(|of| of.contains(&t)).count()).collect();
    let excess = |target: usize| (users[target].saturating_sub(room[target]), targets[target].turn.abs());
    let mut crossings: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (left, right) in (0..goals.len()).flat_map(|left| (left + 1..goals.len()).map(move |right| (left, right))) {
        let both = goals[left].iter().flat_map(|&t| goals[right].iter().map(move |&u| (t, u)));
        for (t, u) in both.filter(|(t, u)| t > u) {
            *crossings.entry((left, t)).or_default() += 1;
            *crossings.entry((right, u)).or_default() += 1;
        }
    }
    let is_spare = |lane: usize, target: usize| goals[lane].len() > 1 && (users[target] > 1 || untold[lane]);
    let spare = crossings.into_iter().filter(|&((lane, target), _)| is_spare(lane, target));
    let most = spare
        .max_by(|(a, of_a), (b, of_b)| compare(excess(a.1), excess(b.1)).then_with(|| of_a.cmp(of_b)).then(b.cmp(a)));
    most.map(|(goal, _)| goal)
}

/// The targets of each lane by itself: those of its arrows; without arrows the outer lanes turn, and all go straight on.
fn single_goals(lanes: &[(usize, &ArmLane)], targets: &[TurnTarget]) -> Vec<Vec<usize>> {
    let count = lanes.len();
    // Without an arrow a lane makes a U-turn only where all targets are U-turns.
    let only_u_turns = targets.iter().all(TurnTarget::turns_back);
    let towards = |turns: fn(f64) -> bool| -> Vec<usize> {
        (0..targets.len()).filter(|&t| turns(targets[t].turn) && (only_u_turns || !targets[t].turns_back())).collect()
    };
    let [straight, lefts, rights] =
        [|t: f64| t.abs() <= STRAIGHT_ON, |t| t > STRAIGHT_ON, |t| t < -STRAIGHT_ON].map(towards);
    let goals = |(i, (_, lane)): (usize, &(usize, &ArmLane))| {
        let mut goals = arrow_goals(lane.arrows, targets);
        if goals.is_empty() {
            let (leftmost, rightmost) = match (straight.is_empty(), lefts.is_empty(), rights.is_empty()) {
                (true, false, false) => (i < count.div_ceil(2), i >= count / 2),
                (true, _, _) => (true, true),
                _ => (i == 0, i + 1 == count),
            };
            goals.clone_from(&straight);
            goals.extend(lefts.iter().filter(|_| leftmost));
            goals.extend(rights.iter().filter(|_| rightmost));
            goals.sort_unstable();
        }
        goals
    };
    lanes.iter().enumerate().map(goals).collect()
}

/// Leads a lane to every lane out that no movement reaches yet: the movement to the lane beside it fans out, unless there is no room
/// for that.
pub fn reach_all(arms: &[&Arm], all: &mut Vec<Movement>, no_room: &[Movement]) {
    for (to, arm) in arms.iter().enumerate() {
        // Outward from the lanes that are reached: each lane follows a neighbour, at the latest in the last round.
        for out in (0..arm.out.len()).cycle().take(arm.out.len() * arm.out.len()) {
            let reached = all.iter().any(|m| (m.to, m.out_lane) == (to, out));
            if !reached && let Some(movement) = neighbour_movement(arms, all, no_room, (to, out)) {
                all.push(movement);
            }
        }
    }
}

/// Leads the lanes in from which there was no room for a movement, and that have no other, to where the lanes beside them lead, if they
/// can to the same arm as before: two lanes become one.
pub fn lead_on(arms: &[&Arm], all: &mut Vec<Movement>, no_room: &[Movement]) {
    for lost in no_room.iter().cycle().take(no_room.len() * no_room.len()) {
        let leads_on = all.iter().any(|m| (m.from, m.in_lane) == (lost.from, lost.in_lane));
        if !leads_on && let Some(movement) = beside_movement(arms, all, no_room, lost) {
            all.push(movement);
        }
    }
}

/// The movement of a lane in that led to where a lane of the same kind beside it leads: on the arm of the lost movement if it can, and
/// else to the arm and lane nearest to its own side, so that the two lanes keep their order.
fn beside_movement(arms: &[&Arm], all: &[Movement], no_room: &[Movement], lost: &Movement) -> Option<Movement> {
    let kind = |lane: usize| arms[lost.from].into[lane].kind;
    let alike = all.iter().filter(|m| {
        m.from == lost.from && m.in_lane.abs_diff(lost.in_lane) == 1 && kind(m.in_lane) == kind(lost.in_lane)
    });
    let rank = |m: &&Movement| {
        // Arms are clockwise: the first after this one lies to the left.
        let place = ((m.to + arms.len() - m.from) % arms.len(), m.out_lane);
        let from_own_side = if lost.in_lane < m.in_lane { place } else { (arms.len() - place.0, usize::MAX - place.1) };
        (m.to != lost.to, from_own_side, m.in_lane)
    };
    let possible = alike.filter(|m| !no_room.contains(&Movement { in_lane: lost.in_lane, ..**m }));
    possible.min_by_key(rank).map(|m| Movement { in_lane: lost.in_lane, ..*m })
}

/// The movement to a lane out that fans out from one to a lane beside it without crossing others: rather from a lane of the same kind,
/// then the straightest.
fn neighbour_movement(
    arms: &[&Arm],
    all: &[Movement],
    no_room: &[Movement],
    (to, out): (usize, usize),
) -> Option<Movement> {
    let rank = |m: &Movement| {
        let other_kind = arms[m.from].into[m.in_lane].kind != arms[to].out[out].kind;
        (other_kind, angle_between(arms[m.from].inward, -arms[to].inward).abs())
    };
    let neighbours = all.iter().filter(|m| m.to == to && m.out_lane.abs_diff(out) == 1 && !would_cross(all, m, out));
    let possible = neighbours.filter(|m| !no_room.contains(&Movement { out_lane: out, ..**m }));
    let best = possible.min_by(|a, b| compare(rank(a), rank(b)).then(a.cmp(b)))?;
    Some(Movement { out_lane: out, ..*best })
}

/// Whether a movement would cross another between the same arms if it led to this lane out instead.
fn would_cross(all: &[Movement], movement: &Movement, out: usize) -> bool {
    let mut others = all.iter().filter(|other| (other.from, other.to) == (movement.from, movement.to));
    others.any(|other| match out > movement.out_lane {
        true => other.in_lane > movement.in_lane && other.out_lane < out,
        false => other.in_lane < movement.in_lane && other.out_lane > out,
    })
}

/// Compares by the first, then by the second.
fn compare<T: Ord>((a, x): (T, f64), (b, y): (T, f64)) -> Ordering {
    a.cmp(&b).then(x.total_cmp(&y))
}
