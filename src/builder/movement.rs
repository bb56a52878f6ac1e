//! Which lane leads to which lane through an intersection.

use crate::geometry::curve::{self, Pose};
use crate::geometry::{Polyline, Vector, angle_between};
use crate::lanelet::index::turn_along;

use super::cross_section::{Arrows, StripKind};
use super::lanes::{Arm, ArmLane, Lanes};
use super::restricted::Restricted;
use super::road_network::{DrivingSide, Intersection};

/// A movement up to this change of direction, degrees, goes straight on.
pub const STRAIGHT: f64 = 30.0;
/// A movement beyond this change of direction, degrees, turns back.
const TURNS_BACK: f64 = 150.0;
/// Curvature, 1/m, beyond which nobody is led back who could go elsewhere: a car drives it with ease.
const TIGHTEST_BACK: f64 = 0.25;
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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Movements {
    /// Sorted.
    pub all: Vec<Movement>,
    /// Pairs of arms with lanes from the first and to the second, between which there must be none.
    pub prohibited: Vec<(usize, usize)>,
}

/// An arm that one may turn into, seen from the arm where one comes from.
#[derive(Clone, Copy)]
struct Target<'a> {
    to: usize,
    arm: &'a Arm,
    /// Change of direction in degrees, left positive.
    turn: f64,
    /// The same as arrows mean it: between the directions in which the roads meet, wherever they are cut off.
    shown: f64,
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

/// Change of direction along the middle of a lane in degrees, left positive: what all its bends add up to. See [`turn`].
pub fn turned(side: DrivingSide, middle: &Polyline) -> f64 {
    let turn = turn_along(middle);
    let across = if side == DrivingSide::Right { 1.0 } else { -1.0 };
    if turn.abs() > TURNS_BACK { across * turn.abs() } else { turn }
}

/// Finds the movements of an intersection.
pub fn movements(side: DrivingSide, restricted: &Restricted, lanes: &Lanes, intersection: &Intersection) -> Movements {
    let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
    let mut found = Movements::default();
    let mut targets: Vec<Vec<Target>> = Vec::new();
    for (from, arm) in arms.iter().enumerate() {
        let mut open = Vec::new();
        for (to, other) in arms.iter().enumerate() {
            if to == from || arm.into.is_empty() || other.out.is_empty() {
                continue;
            }
            if restricted.permit(intersection, arm.at, other.at) {
                let (turn, shown) = (turn(side, arm.inward, -other.inward), turn(side, arm.aim, -other.aim));
                open.push(Target { to, arm: other, turn, shown });
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
    found.all = assigned(&arms, &targets, &heed);
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
        found.all = assigned(&arms, &targets, &heed);
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

/// Leaves out the arms that one would have to turn back for, unless an arrow says so, there is no other way on, or nobody
/// else could enter that arm. What remains of them, where a median leaves room.
fn without_turning_back(side: DrivingSide, arms: &[&Arm], targets: &mut [Vec<Target>]) -> Vec<Movement> {
    let mut around = Vec::new();
    let entered: Vec<usize> = targets.iter().flatten().filter(|t| !t.turns_back()).map(|t| t.to).collect();
    for (from, open) in targets.iter_mut().enumerate() {
        let signed = arms[from].into.iter().any(|lane| lane.arrows.has(Arrows::REVERSE));
        if signed || open.iter().all(Target::turns_back) {
            continue;
        }
        open.retain(|t| {
            let kept = !t.turns_back() || !entered.contains(&t.to);
            if !kept {
                around.extend(turning_around(side, from, arms[from], t));
            }
            kept
        });
    }
    around
}

/// The way back around the end of a median, or into a road that leaves at an acute angle: from the lane on the far side to
/// the first one that is far enough from it, unless an arrow leads elsewhere.
fn turning_around(side: DrivingSide, from: usize, arm: &Arm, target: &Target) -> Option<Movement> {
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

/// The movements from all arms; those of which `heed` says no as if nothing were painted.
fn assigned(arms: &[&Arm], targets: &[Vec<Target>], heed: &[bool]) -> Vec<Movement> {
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
fn goals(lanes: &[(usize, &ArmLane)], targets: &[Target], kind: StripKind) -> Vec<Vec<usize>> {
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
fn crossing(goals: &[Vec<usize>], targets: &[Target], room: &[usize]) -> Option<(usize, usize)> {
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
fn wishes(lanes: &[(usize, &ArmLane)], targets: &[Target]) -> Vec<Vec<usize>> {
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
            let off = |t: &Target| (t.shown - angle).abs();
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
    let usable: Vec<Target> = targets.iter().filter(|t| t.arm.out.iter().any(|l| l.kind == kind)).copied().collect();
    if lanes.is_empty() || usable.is_empty() {
        return;
    }
    let goals = goals(&lanes, &usable, kind);
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

/// Where a road is for buses only, they enter it from the lane for all that lies nearest to it.
fn assign_bus_roads(from: usize, arm: &Arm, targets: &[Target], all: &mut Vec<Movement>) {
    let reserved = |t: &&Target| t.arm.out.iter().all(|lane| lane.kind == StripKind::Bus) && !t.turns_back();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    fn pose(x: f64, y: f64, degrees: f64) -> Pose {
        Pose { point: Point::new(x, y), heading: Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin()) }
    }

    /// What is drawn by poses.
    fn line(poses: Vec<Pose>) -> Polyline {
        Polyline::new(poses.into_iter().map(|pose| pose.point)).unwrap()
    }

    #[test]
    fn a_way_is_named_after_its_bends() {
        let left = line(curve::join(pose(0.0, 0.0, 0.0), pose(10.0, 10.0, 90.0)));
        assert!((turned(DrivingSide::Right, &left) - 90.0).abs() < 5.0);
        // A loop that ends 140 degrees to the right of where it began, but gets there by the left.
        let round = |i: i32| pose(f64::from(i * 10).to_radians().cos(), f64::from(i * 10).to_radians().sin(), 0.0);
        let loop_ = line((0..=23).map(round).collect());
        assert!((turned(DrivingSide::Right, &loop_) - 220.0).abs() < 1.0);
        // Who turns back does so across the oncoming traffic.
        assert!((turned(DrivingSide::Left, &loop_) + 220.0).abs() < 1.0);
    }
}
