//! Which lane leads to which lane through an intersection.

use crate::geometry::{Vector, angle_between};

use super::cross_section::{Arrows, StripKind};
use super::lanes::{Arm, ArmLane, Lanes};
use super::road_network::{DrivingSide, Intersection, RoadEnd, RoadNetwork};

/// A movement up to this change of direction, degrees, goes straight on.
pub const STRAIGHT: f64 = 30.0;
/// A movement beyond this change of direction, degrees, turns back.
const TURNS_BACK: f64 = 150.0;
/// An arrow means an arm at most this far, degrees, from the arrow's own direction.
const ARROW_REACH: f64 = 70.0;

/// One movement of an intersection. Arms and lanes are indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Movement {
    /// Arm where it starts, in [`Intersection::arms`].
    pub from: usize,
    /// Arm where it ends.
    pub to: usize,
    /// Lane of [`Arm::into`].
    pub in_lane: usize,
    /// Lane of [`Arm::out`].
    pub out_lane: usize,
}

/// The movements of one intersection.
#[derive(Clone, Debug, Default)]
pub struct Movements {
    /// Sorted.
    pub all: Vec<Movement>,
    /// Pairs of arms with lanes from the first and to the second, between which there must be none.
    pub prohibited: Vec<(usize, usize)>,
}

/// An arm that one may turn into, seen from the arm where one comes from.
struct Target<'a> {
    to: usize,
    arm: &'a Arm,
    /// Change of direction in degrees, left positive.
    turn: f64,
}

impl Target<'_> {
    fn turns_back(&self) -> bool {
        self.turn.abs() > TURNS_BACK
    }
}

/// Change of direction from one heading to another in degrees, left positive. Who turns back does so across the
/// oncoming traffic, however the angle falls.
pub fn turn(side: DrivingSide, from: Vector, to: Vector) -> f64 {
    let turn = angle_between(from, to).to_degrees();
    let across = if side == DrivingSide::Right { 1.0 } else { -1.0 };
    if turn.abs() > TURNS_BACK && turn * across < 0.0 { turn + across * 360.0 } else { turn }
}

/// Finds the movements of an intersection.
pub fn movements(network: &RoadNetwork, lanes: &Lanes, intersection: &Intersection) -> Movements {
    let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
    let mut found = Movements::default();
    for (from, arm) in arms.iter().enumerate() {
        let mut targets = Vec::new();
        for (to, other) in arms.iter().enumerate() {
            if to == from || arm.into.is_empty() || other.out.is_empty() {
                continue;
            }
            if passable(intersection, arm.at, other.at) && permitted(network, arm.at, other.at) {
                let turn = turn(network.side, arm.inward, -other.inward);
                targets.push(Target { to, arm: other, turn });
            } else {
                found.prohibited.push((from, to));
            }
        }
        // Nobody turns back unless an arrow says so, or there is no other way on.
        let signed = arm.into.iter().any(|lane| lane.arrows.has(Arrows::REVERSE));
        if !signed && targets.iter().any(|t| !t.turns_back()) {
            targets.retain(|t| !t.turns_back());
        }
        // Arms are clockwise: from left to right as one drives in, whatever the angles say.
        let count = arms.len();
        targets.sort_by_key(|t| (t.to + count - from) % count);
        assign(from, arm, &targets, StripKind::Drive, &mut found.all);
        assign_bus(from, arm, &targets, &mut found.all);
    }
    reach_all(&arms, &mut found);
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

/// Whether the roads inside a merged intersection lead from one arm to the other.
fn passable(intersection: &Intersection, from: RoadEnd, to: RoadEnd) -> bool {
    intersection.passages.as_ref().is_none_or(|p| p.contains(&(from, to)))
}

/// Whether the turn restrictions let one go from one arm to the other.
fn permitted(network: &RoadNetwork, from: RoadEnd, to: RoadEnd) -> bool {
    let mut only = false;
    for r in network.restrictions.iter().filter(|r| r.from == from && r.via.is_empty()) {
        match (r.only, r.to == to) {
            (false, true) => return false,
            (true, true) => return true,
            (true, false) => only = true,
            (false, false) => {}
        }
    }
    !only
}

/// The arms each lane leads to: by its arrows, else the outer lanes turn and all go on where they can.
fn goals(lanes: &[(usize, &ArmLane)], targets: &[Target]) -> Vec<Vec<usize>> {
    let count = lanes.len();
    let straight: Vec<usize> = (0..targets.len()).filter(|&t| targets[t].turn.abs() <= STRAIGHT).collect();
    // Without an arrow a lane turns back only where every way on does.
    let by_itself = |t: usize| !targets[t].turns_back() || targets.iter().all(Target::turns_back);
    let lefts: Vec<usize> = (0..targets.len()).filter(|&t| targets[t].turn > STRAIGHT && by_itself(t)).collect();
    let rights: Vec<usize> = (0..targets.len()).filter(|&t| targets[t].turn < -STRAIGHT && by_itself(t)).collect();
    lanes
        .iter()
        .enumerate()
        .map(|(i, (_, lane))| {
            let pointed = pointed(lane.arrows, targets);
            if !pointed.is_empty() {
                return pointed;
            }
            let mut goals = straight.clone();
            let (leftmost, rightmost) = match (straight.is_empty(), lefts.is_empty(), rights.is_empty()) {
                (true, false, false) => (i < count.div_ceil(2), i >= count / 2),
                (true, _, _) => (true, true),
                _ => (i == 0, i + 1 == count),
            };
            if leftmost {
                goals.extend(&lefts);
            }
            if rightmost {
                goals.extend(&rights);
            }
            goals.sort_unstable();
            goals
        })
        .collect()
}

/// The arms that a lane's arrows mean.
fn pointed(arrows: Arrows, targets: &[Target]) -> Vec<usize> {
    const MEANING: [(Arrows, f64); 7] = [
        (Arrows::SHARP_LEFT, 135.0),
        (Arrows::LEFT, 90.0),
        (Arrows::SLIGHT_LEFT, 40.0),
        (Arrows::THROUGH, 0.0),
        (Arrows::SLIGHT_RIGHT, -40.0),
        (Arrows::RIGHT, -90.0),
        (Arrows::SHARP_RIGHT, -135.0),
    ];
    let back = arrows.has(Arrows::REVERSE).then(|| (0..targets.len()).filter(|&t| targets[t].turns_back()));
    let mut goals: Vec<usize> = MEANING
        .iter()
        .filter(|(arrow, _)| arrows.has(*arrow))
        .filter_map(|(_, angle)| {
            let off = |t: &Target| (t.turn - angle).abs();
            let best = (0..targets.len()).min_by(|&a, &b| off(&targets[a]).total_cmp(&off(&targets[b])))?;
            (off(&targets[best]) <= ARROW_REACH).then_some(best)
        })
        .chain(back.into_iter().flatten())
        .collect();
    goals.sort_unstable();
    goals.dedup();
    goals
}

/// Leads the lanes of one kind to the lanes of the same kind, in order, so that neighbours never cross.
fn assign(from: usize, arm: &Arm, targets: &[Target], kind: StripKind, all: &mut Vec<Movement>) {
    let lanes: Vec<(usize, &ArmLane)> = arm.into.iter().enumerate().filter(|(_, l)| l.kind == kind).collect();
    let usable: Vec<&Target> = targets.iter().filter(|t| t.arm.out.iter().any(|l| l.kind == kind)).collect();
    let usable: Vec<Target> = usable.iter().map(|t| Target { to: t.to, arm: t.arm, turn: t.turn }).collect();
    if lanes.is_empty() || usable.is_empty() {
        return;
    }
    let goals = goals(&lanes, &usable);
    for (t, target) in usable.iter().enumerate() {
        let mut ins: Vec<usize> = (0..lanes.len()).filter(|&i| goals[i].contains(&t)).collect();
        if ins.is_empty() {
            // Arrows leave this arm out although nothing prohibits it: the lane at its side takes it, unless every
            // lane has arrows and so means it.
            if target.turns_back() || lanes.iter().all(|(_, l)| !l.arrows.is_none()) {
                continue;
            }
            ins = vec![if target.turn > 0.0 { 0 } else { lanes.len() - 1 }];
        }
        let outs: Vec<usize> = (0..target.arm.out.len()).filter(|&o| target.arm.out[o].kind == kind).collect();
        while ins.len() > outs.len() {
            // More lanes than the arm takes: those that lead elsewhere too stay out, the far ones first.
            let spare = |&i: &usize| goals[ins[i]].len() > 1;
            let candidates = 0..ins.len();
            let out = if target.turn > 0.0 { candidates.rev().find(spare) } else { candidates.into_iter().find(spare) };
            match out {
                Some(i) => ins.remove(i),
                None => break,
            };
        }
        for (i, o) in pair_up(&ins, &outs, &lanes, target) {
            all.push(Movement { from, to: target.to, in_lane: lanes[i].0, out_lane: o });
        }
    }
}

/// Pairs lanes with lanes in order.
fn pair_up(ins: &[usize], outs: &[usize], lanes: &[(usize, &ArmLane)], target: &Target) -> Vec<(usize, usize)> {
    let (k, n) = (ins.len(), outs.len());
    if k > n {
        return ins.iter().enumerate().map(|(j, &i)| (i, outs[j * n / k])).collect();
    }
    let shift = if target.turn > STRAIGHT {
        0
    } else if target.turn < -STRAIGHT {
        n - k
    } else {
        // Straight on: the shift with the least way sideways.
        let sideways = |shift: usize| -> f64 {
            ins.iter()
                .enumerate()
                .map(|(j, &i)| {
                    let (a, b) = (lanes[i].1.pose, target.arm.out[outs[j + shift]].pose);
                    crate::geometry::cross(a.heading, b.point - a.point).abs()
                })
                .sum()
        };
        (0..=n - k).min_by(|&a, &b| sideways(a).total_cmp(&sideways(b))).unwrap_or(0)
    };
    ins.iter().enumerate().map(|(j, &i)| (i, outs[j + shift])).collect()
}

/// Buses keep to their own lane where there is one ahead, and else join the others on the straightest way.
fn assign_bus(from: usize, arm: &Arm, targets: &[Target], all: &mut Vec<Movement>) {
    for (in_lane, lane) in arm.into.iter().enumerate().filter(|(_, l)| l.kind == StripKind::Bus) {
        let aimed = pointed(lane.arrows, targets);
        let ahead = (0..targets.len())
            .min_by(|&a, &b| targets[a].turn.abs().total_cmp(&targets[b].turn.abs()))
            .into_iter()
            .collect();
        for target in if aimed.is_empty() { ahead } else { aimed }.into_iter().map(|t: usize| &targets[t]) {
            let sideways = |o: &usize| {
                let out = &target.arm.out[*o];
                let off = crate::geometry::cross(lane.pose.heading, out.pose.point - lane.pose.point).abs();
                (out.kind != StripKind::Bus, off)
            };
            let best = (0..target.arm.out.len()).min_by(|a, b| {
                let (a, b) = (sideways(a), sideways(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            });
            if let Some(out_lane) = best {
                all.push(Movement { from, to: target.to, in_lane, out_lane });
            }
        }
    }
}

/// Leads somebody to every lane out that nobody reaches yet: the movement beside it fans out.
fn reach_all(arms: &[&Arm], found: &mut Movements) {
    for (to, arm) in arms.iter().enumerate() {
        let reached = |all: &[Movement], out: usize| all.iter().any(|m| (m.to, m.out_lane) == (to, out));
        // Outward from the lanes that are reached, so that each new one has a neighbour to follow.
        for _ in 0..arm.out.len() {
            for out in 0..arm.out.len() {
                if reached(&found.all, out) {
                    continue;
                }
                let beside = found
                    .all
                    .iter()
                    .copied()
                    .filter(|m| m.to == to && m.out_lane.abs_diff(out) == 1)
                    .filter(|m| {
                        // The lane at this side of all that go the same way, so that none is crossed.
                        !found.all.iter().any(|o| {
                            (o.from, o.to) == (m.from, m.to)
                                && if out > m.out_lane { o.in_lane > m.in_lane } else { o.in_lane < m.in_lane }
                        })
                    })
                    .min_by(|a, b| {
                        let turn = |m: &Movement| angle_between(arms[m.from].inward, -arm.inward).abs();
                        turn(a).total_cmp(&turn(b)).then(a.cmp(b))
                    });
                if let Some(movement) = beside {
                    found.all.push(Movement { out_lane: out, ..movement });
                }
            }
        }
    }
}
