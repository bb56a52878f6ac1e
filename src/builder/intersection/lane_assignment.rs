//! Which lanes of an arm lead to which lanes of the others: as is told, by arrows, else in order, so that neighbours never
//! cross.

use crate::builder::lanes::types::{Arm, ArmLane};
use crate::builder::network::turn::STRAIGHT;
use crate::builder::network::turn_restrictions::ResolvedRestrictions;
use crate::builder::tags::cross_section::{Arrows, StripKind};
use crate::geometry::{angle_between, cross};

use super::movement_types::{Movement, TurnTarget};

/// An arrow means an arm at most this far, degrees, from the arrow's own direction.
const ARROW_REACH: f64 = 70.0;

/// The movements from all arms; those of which `heed` says no as if nothing were painted.
pub fn assign_lanes(
    restricted: &ResolvedRestrictions,
    arms: &[&Arm],
    targets: &[Vec<TurnTarget>],
    heed: &[bool],
) -> Vec<Movement> {
    let mut all = Vec::new();
    for (from, arm) in arms.iter().enumerate() {
        let bare;
        let arm = if heed[from] {
            *arm
        } else {
            bare = without_arrows(arm);
            &bare
        };
        assign(from, arm, &targets[from], StripKind::Drive, &mut all);
        assign_bus(from, arm, &targets[from], &mut all);
        assign_bus_roads(from, arm, &targets[from], &mut all);
        connect(restricted, from, arm, &targets[from], &mut all);
        if restricted.fan_out {
            fan_out(from, arm, &targets[from], &mut all);
        }
    }
    reach_all(arms, &mut all);
    all.sort_unstable();
    all.dedup();
    all
}

fn without_arrows(arm: &Arm) -> Arm {
    let mut arm = arm.clone();
    arm.into.iter_mut().for_each(|lane| lane.arrows = Arrows::default());
    arm
}

/// The arms each lane leads to, so that no lane crosses another.
fn goals(lanes: &[(usize, &ArmLane)], targets: &[TurnTarget], kind: StripKind) -> Vec<Vec<usize>> {
    let mut goals = wishes(lanes, targets);
    let room: Vec<usize> = targets.iter().map(|t| t.arm.out.iter().filter(|l| l.kind == kind).count()).collect();
    while let Some((lane, target)) = crossing(&goals, targets, &room) {
        goals[lane].retain(|&t| t != target);
    }
    goals
}

/// A lane and a target that it had better leave to others: another lane crosses it on its way. Rather the target that
/// more lanes lead to than it takes, then the one that lies farther from straight on. `None` if nothing crosses, or
/// nothing can be spared.
fn crossing(goals: &[Vec<usize>], targets: &[TurnTarget], room: &[usize]) -> Option<(usize, usize)> {
    let users = |target: usize| goals.iter().filter(|g| g.contains(&target)).count();
    let spare = |&(lane, target): &(usize, usize)| goals[lane].len() > 1 && users(target) > 1;
    let mut crossing = Vec::new();
    for (left, for_left) in goals.iter().enumerate() {
        for (right, for_right) in goals.iter().enumerate().skip(left + 1) {
            for (&t, &u) in for_left.iter().flat_map(|t| for_right.iter().map(move |u| (t, u))) {
                if t > u {
                    crossing.extend([(left, t), (right, u)]);
                }
            }
        }
    }
    let burden = |target: usize| (users(target).saturating_sub(room[target]), targets[target].turn.abs());
    crossing.into_iter().filter(spare).max_by(|&(a, t), &(b, u)| {
        let (x, y) = (burden(t), burden(u));
        x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)).then((b, u).cmp(&(a, t)))
    })
}

/// The arms each lane leads to: by its arrows, else the outer lanes turn and all go on where they can.
fn wishes(lanes: &[(usize, &ArmLane)], targets: &[TurnTarget]) -> Vec<Vec<usize>> {
    let count = lanes.len();
    let straight: Vec<usize> = (0..targets.len()).filter(|&t| targets[t].turn.abs() <= STRAIGHT).collect();
    // Without an arrow a lane turns back only where every way on does.
    let by_itself = |t: usize| !targets[t].turns_back() || targets.iter().all(TurnTarget::turns_back);
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
fn pointed(arrows: Arrows, targets: &[TurnTarget]) -> Vec<usize> {
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
            let off = |t: &TurnTarget| (t.shown - angle).abs();
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
fn assign(from: usize, arm: &Arm, targets: &[TurnTarget], kind: StripKind, all: &mut Vec<Movement>) {
    let lanes: Vec<(usize, &ArmLane)> = arm.into.iter().enumerate().filter(|(_, l)| l.kind == kind).collect();
    let usable: Vec<TurnTarget> =
        targets.iter().filter(|t| t.arm.out.iter().any(|l| l.kind == kind)).copied().collect();
    if lanes.is_empty() || usable.is_empty() {
        return;
    }
    let mut goals = goals(&lanes, &usable, kind);
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
            // More lanes than the arm takes: those that still lead elsewhere too stay out, the far ones first.
            let spare = |&i: &usize| goals[ins[i]].len() > 1;
            let candidates = 0..ins.len();
            let out = if target.turn > 0.0 { candidates.rev().find(spare) } else { candidates.into_iter().find(spare) };
            match out {
                Some(i) => goals[ins.remove(i)].retain(|&goal| goal != t),
                None => break,
            }
        }
        for (i, o) in pair_up(&ins, &outs, &lanes, target) {
            all.push(Movement { from, to: target.to, in_lane: lanes[i].0, out_lane: o });
        }
    }
}

/// Pairs lanes with lanes in order.
fn pair_up(ins: &[usize], outs: &[usize], lanes: &[(usize, &ArmLane)], target: &TurnTarget) -> Vec<(usize, usize)> {
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
                    cross(a.heading, b.point - a.point).abs()
                })
                .sum()
        };
        (0..=n - k).min_by(|&a, &b| sideways(a).total_cmp(&sideways(b))).unwrap_or(0)
    };
    ins.iter().enumerate().map(|(j, &i)| (i, outs[j + shift])).collect()
}

/// Buses keep to their own lane where there is one ahead, and else join the others on the straightest way.
fn assign_bus(from: usize, arm: &Arm, targets: &[TurnTarget], all: &mut Vec<Movement>) {
    for (in_lane, lane) in arm.into.iter().enumerate().filter(|(_, l)| l.kind == StripKind::Bus) {
        let aimed = pointed(lane.arrows, targets);
        let ahead = (0..targets.len())
            .min_by(|&a, &b| targets[a].turn.abs().total_cmp(&targets[b].turn.abs()))
            .into_iter()
            .collect();
        for target in if aimed.is_empty() { ahead } else { aimed }.into_iter().map(|t: usize| &targets[t]) {
            let sideways = |o: &usize| {
                let out = &target.arm.out[*o];
                let off = cross(lane.pose.heading, out.pose.point - lane.pose.point).abs();
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

/// Where a road is for buses only, they enter it from the lane for all that lies nearest to it.
fn assign_bus_roads(from: usize, arm: &Arm, targets: &[TurnTarget], all: &mut Vec<Movement>) {
    let reserved = |t: &&TurnTarget| t.arm.out.iter().all(|lane| lane.kind == StripKind::Bus) && !t.turns_back();
    for target in targets.iter().filter(reserved) {
        if arm.into.is_empty() || target.arm.out.is_empty() || arm.into.iter().any(|l| l.kind == StripKind::Bus) {
            continue;
        }
        let leftmost = target.turn > 0.0;
        let in_lane = if leftmost { 0 } else { arm.into.len() - 1 };
        let out_lane = if leftmost { 0 } else { target.arm.out.len() - 1 };
        all.push(Movement { from, to: target.to, in_lane, out_lane });
    }
}

/// Where it is told which lanes lead to which, those do and no others; a road with other lanes than are spoken of is not meant.
fn connect(restricted: &ResolvedRestrictions, from: usize, arm: &Arm, targets: &[TurnTarget], all: &mut Vec<Movement>) {
    for target in targets {
        let Some(told) = restricted.lanes(arm.at, target.arm.at) else { continue };
        let there = |&[a, b]: &[usize; 2]| (1..=arm.into.len()).contains(&a) && (1..=target.arm.out.len()).contains(&b);
        if !told.iter().all(there) {
            continue;
        }
        all.retain(|m| (m.from, m.to) != (from, target.to));
        all.extend(told.iter().map(|[a, b]| Movement { from, to: target.to, in_lane: a - 1, out_lane: b - 1 }));
    }
}

/// Leads the outermost lanes of each turn to all lanes of the road beyond those that the turn takes.
fn fan_out(from: usize, arm: &Arm, targets: &[TurnTarget], all: &mut Vec<Movement>) {
    for target in targets {
        let drive = |lane: &ArmLane| lane.kind == StripKind::Drive;
        let own = all.iter().filter(|m| (m.from, m.to) == (from, target.to));
        let cars = own.filter(|m| drive(&arm.into[m.in_lane]) && drive(&target.arm.out[m.out_lane]));
        let (ins, outs): (Vec<usize>, Vec<usize>) = cars.map(|m| (m.in_lane, m.out_lane)).unzip();
        let ends = |lanes: &[usize]| lanes.iter().min().copied().zip(lanes.iter().max().copied());
        let (Some((first_in, last_in)), Some((first, last))) = (ends(&ins), ends(&outs)) else { continue };
        let open = |out: &usize| drive(&target.arm.out[*out]);
        let led = |in_lane: usize| move |out_lane: usize| Movement { from, to: target.to, in_lane, out_lane };
        all.extend((0..first).filter(open).map(led(first_in)));
        all.extend((last + 1..target.arm.out.len()).filter(open).map(led(last_in)));
    }
}

/// Leads somebody to every lane out that nobody reaches yet: the movement beside it fans out.
fn reach_all(arms: &[&Arm], all: &mut Vec<Movement>) {
    for (to, arm) in arms.iter().enumerate() {
        // Outward from the lanes that are reached, so that each new one has a neighbour to follow.
        for _ in 0..arm.out.len() {
            for out in 0..arm.out.len() {
                if all.iter().any(|m| (m.to, m.out_lane) == (to, out)) {
                    continue;
                }
                // None that goes the same way may be crossed.
                let crosses = |m: &Movement| {
                    all.iter().filter(|o| (o.from, o.to) == (m.from, m.to)).any(|o| match out > m.out_lane {
                        true => o.in_lane > m.in_lane && o.out_lane < out,
                        false => o.in_lane < m.in_lane && o.out_lane > out,
                    })
                };
                let beside =
                    all.iter().copied().filter(|m| m.to == to && m.out_lane.abs_diff(out) == 1 && !crosses(m)).min_by(
                        |a, b| {
                            let turn = |m: &Movement| angle_between(arms[m.from].inward, -arm.inward).abs();
                            let other_kind = |m: &Movement| arms[m.from].into[m.in_lane].kind != arm.out[out].kind;
                            other_kind(a).cmp(&other_kind(b)).then(turn(a).total_cmp(&turn(b))).then(a.cmp(b))
                        },
                    );
                if let Some(movement) = beside {
                    all.push(Movement { out_lane: out, ..movement });
                }
            }
        }
    }
}
