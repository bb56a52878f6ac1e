//! The movements of an intersection: which arm leads to which.

use crate::builder::lanes::types::{Arm, ArmLane, Lanes};
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::road_end::{directions, leads_in, leads_out};
use crate::builder::network::turn_angle::{STRAIGHT_ON, turn};
use crate::builder::network::{Intersection, MOST_DIRECTIONS, RoadEnd, RoadNetwork};
use crate::builder::tags::cross_section::{Arrows, StripKind};
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::pose::Pose;
use crate::geometry::{angle_between, cross, curve};

use super::lane_assignment::{assign_lanes, keep_to_own_side, lead_on, reach_all};
use super::movement_types::{Movement, Movements, TurnTarget};
use super::street_path::{RADIUS_LEAST, RADIUS_TOLD, SWAY_MOST, StreetPaths};
use super::turn_centerline::{MovementEnds, common_ground};

/// The largest curvature, 1/m, of a U-turn where there are other ways on: a car drives it with ease.
const TIGHTEST_BACK: f64 = 0.25;

/// The same for a U-turn to a lane that nothing else reaches: cuts that are set back for it give it more room.
const TIGHTEST_ONLY: f64 = 1.0 / 2.5;

/// A U-turn runs into a movement from the lane beside it if they share more ground than this, square metres.
const RUNS_INTO: f64 = 0.2;

/// At most this number of movements is drawn in one intersection; those of 16 roads with a lane for each direction all are.
const MOST_MOVEMENTS: usize = 240;

/// The movements of an intersection are held against each other. Where the pairs in all large intersections are more than this number
/// for each road of the network, or [`LEAST_PAIRS`], fewer are drawn in each.
const PAIRS_OF_ROAD: usize = 30;
/// The same for small networks.
const LEAST_PAIRS: usize = 400_000;
/// So many movements are drawn in any intersection; larger ones are large.
const LEAST_MOVEMENTS: usize = 64;

/// From this change of direction on, degrees, a turn between roads that meet at an acute angle is a hairpin ...
const HAIRPIN: f64 = 135.0;
/// ... for which this is the largest curvature, 1/m: a small car turns on a radius of 4.5 m.
const TIGHTEST_HAIRPIN: f64 = 1.0 / 3.0;
/// A smooth curve that is longer than the way along the streets by more than this factor is a detour: a semicircle is, around what
/// is wider than 13 m.
const DETOUR_MOST: f64 = 1.05;

/// How many movements are drawn in an intersection of this network at most. This depends on the whole network, so that a tile could come
/// out otherwise than the map; none of 80 extracts of real streets reaches the limit.
pub fn most_movements(network: &RoadNetwork) -> usize {
    let pairs = |at: &Intersection| {
        let count =
            |leads: fn(&RoadNetwork, RoadEnd) -> bool| at.arms.iter().filter(|arm| leads(network, **arm)).count();
        let movements = (count(leads_in) * count(leads_out)).min(MOST_MOVEMENTS);
        if movements > LEAST_MOVEMENTS { movements.pow(2) } else { 0 }
    };
    let all: usize = network.intersections.iter().map(pairs).sum();
    let most = (PAIRS_OF_ROAD * network.roads.len()).max(LEAST_PAIRS);
    if all <= most {
        return MOST_MOVEMENTS;
    }
    ((MOST_MOVEMENTS as f64 * (most as f64 / all as f64).sqrt()) as usize).max(LEAST_MOVEMENTS)
}

/// Finds the movements of an intersection, at most this number.
pub fn movements(
    network: &RoadNetwork,
    restrictions: &ResolvedRestrictions,
    lanes: &Lanes,
    intersection: &Intersection,
    most: usize,
) -> Movements {
    let (side, paths) = (network.side, StreetPaths { network, intersection });
    let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
    let joined = joined_arms(network, intersection);
    let mut targets: Vec<Vec<TurnTarget>> =
        (0..arms.len()).map(|from| turn_targets(side, restrictions, intersection, (&arms, &joined), from)).collect();
    if intersection.signals {
        keep_to_own_side(restrictions, &arms, &mut targets);
    }
    let mut u_turns = remove_u_turns(paths, &arms, &mut targets);
    let mut with_arrows = vec![true; arms.len()];
    let mut all = assign_lanes(side, restrictions, &arms, &targets, &with_arrows);
    // If no arrow leads to an arm, the arrows of the approach that leads to it most directly belong to another intersection: lanes
    // are marked long before they diverge. They are ignored.
    let missed = (0..arms.len()).filter(|to| all.iter().all(|m| m.to != *to));
    let missed: Vec<usize> = missed.filter_map(|to| straightest_approach(&targets, to)).collect();
    if !missed.is_empty() {
        missed.into_iter().for_each(|from| with_arrows[from] = false);
        all = assign_lanes(side, restrictions, &arms, &targets, &with_arrows);
    }
    u_turns.retain(|turn| has_room_beside(paths, &arms, &all, turn));
    let tighter = u_turns.iter().filter_map(|turn| tighter_u_turn(side, &arms, &all, turn)).collect::<Vec<_>>();
    let u_turn_arms = u_turns.iter().map(|turn| (turn.from, turn.to)).collect();
    all.extend(u_turns.into_iter().chain(tighter));
    reach_all(&arms, &mut all, &[]);
    let ending = ending_centre_lanes(&arms);
    all.retain(|m| !ending[m.from][0].contains(&m.in_lane) && !ending[m.to][1].contains(&m.out_lane));
    all.sort_unstable();
    all.dedup();
    let found = all.len();
    if found > most {
        all = straightest(all, &arms, most);
    }
    let left_out = found - all.len();
    let joined: Vec<usize> = (0..arms.len()).filter(|&arm| joined[arm]).collect();
    let pairs = joined.iter().flat_map(|&from| joined.iter().map(move |&to| (from, to)));
    let could = |(from, to): &(usize, usize)| from != to && !arms[*from].into.is_empty() && !arms[*to].out.is_empty();
    let prohibited = pairs.filter(could).filter(|pair| all.iter().all(|m| (m.from, m.to) != *pair)).collect();
    Movements { all, prohibited, u_turns: u_turn_arms, left_out }
}

/// Per arm, whether other roads are joined to it: all, but of too many those of the highest classes.
pub fn joined_arms(network: &RoadNetwork, intersection: &Intersection) -> Vec<bool> {
    let mut order: Vec<usize> = (0..intersection.arms.len()).collect();
    order.sort_by_key(|&arm| network.road(intersection.arms[arm].road).class);
    let mut joined = vec![false; order.len()];
    let mut sum = 0;
    for arm in order {
        sum += directions(network, intersection.arms[arm]);
        joined[arm] = sum <= MOST_DIRECTIONS;
    }
    joined
}

/// As many movements as can be drawn: of every lane the straightest, then of every lane the next, and so on. In order.
fn straightest(all: Vec<Movement>, arms: &[&Arm], most: usize) -> Vec<Movement> {
    let turn = |m: &Movement| angle_between(arms[m.from].inward, -arms[m.to].inward).abs();
    let mut ranked: Vec<(f64, Movement)> = all.into_iter().map(|movement| (turn(&movement), movement)).collect();
    let lane = |m: &Movement| (m.from, m.in_lane);
    ranked.sort_by(|(a, x), (b, y)| lane(x).cmp(&lane(y)).then(a.total_cmp(b)).then(x.cmp(y)));
    let of_lanes = ranked.chunk_by(|(_, x), (_, y)| lane(x) == lane(y));
    let mut by_rank: Vec<(usize, Movement)> = of_lanes.flat_map(|row| (0..).zip(row.iter().map(|(_, m)| *m))).collect();
    by_rank.sort_unstable();
    by_rank.truncate(most);
    let mut kept: Vec<Movement> = by_rank.into_iter().map(|(_, movement)| movement).collect();
    kept.sort_unstable();
    kept
}

/// Per arm the lanes for both directions, among others of each direction, that end where the road only goes on as one without such
/// a lane: those that lead in, and those that lead out. Vehicles turn from such a lane in the middle, and leave it before it ends.
pub fn ending_centre_lanes(arms: &[&Arm]) -> Vec<[Vec<usize>; 2]> {
    let &[a, b] = arms else { return vec![Default::default(); arms.len()] };
    let centre_lanes = |arm: &Arm| {
        let goes_both_ways = |lane: &ArmLane| {
            let [left, right] = lane.nodes;
            arm.into.iter().chain(&arm.out).any(|other| other.nodes == [right, left])
        };
        [&arm.into, &arm.out].map(|lanes| (0..lanes.len()).filter(|&i| goes_both_ways(&lanes[i])).collect::<Vec<_>>())
    };
    let [of_a, of_b] = [a, b].map(centre_lanes);
    let ends = |arm: &Arm, [into, out]: &[Vec<usize>; 2], on: &[Vec<usize>; 2]| {
        into.len() < arm.into.len() && out.len() < arm.out.len() && on[0].is_empty()
    };
    let [a_ends, b_ends] = [ends(a, &of_a, &of_b), ends(b, &of_b, &of_a)];
    [(of_a, a_ends), (of_b, b_ends)].map(|(of, ends)| if ends { of } else { Default::default() }).to_vec()
}

/// The movements without those for which there is no room. A lane to which no movement is left is reached by a movement beside it,
/// which fans out; a lane from which none is left leads to where the lane beside it leads. `None` if all lanes have a movement without
/// that, or if none gets one.
pub fn movements_instead(
    lanes: &Lanes,
    intersection: &Intersection,
    all: &[Movement],
    no_room: &[Movement],
) -> Option<Vec<Movement>> {
    if no_room.is_empty() {
        return None;
    }
    let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
    let mut instead: Vec<Movement> = all.iter().filter(|movement| !no_room.contains(movement)).copied().collect();
    let left = instead.len();
    lead_on(&arms, &mut instead, no_room);
    reach_all(&arms, &mut instead, no_room);
    instead.sort_unstable();
    (instead.len() > left).then_some(instead)
}

/// The arms to which the restrictions allow to go from an arm, from left to right as one drives in.
fn turn_targets<'a>(
    side: DrivingSide,
    restrictions: &ResolvedRestrictions,
    intersection: &Intersection,
    (arms, joined): (&[&'a Arm], &[bool]),
    from: usize,
) -> Vec<TurnTarget<'a>> {
    if !joined[from] {
        return Vec::new();
    }
    let (arm, count) = (arms[from], arms.len());
    // Arms are clockwise, whatever their angles.
    let others = (1..count)
        .map(|step| (from + step) % count)
        .filter(|&to| joined[to] && !arm.into.is_empty() && !arms[to].out.is_empty());
    let permitted = others.filter(|&to| restrictions.permit(intersection, arm.at, arms[to].at));
    let target = |to: usize| {
        let other = arms[to];
        let (turn, arrow_turn) = (turn(side, arm.inward, -other.inward), turn(side, arm.aim, -other.aim));
        TurnTarget { to, arm: other, turn, arrow_turn }
    };
    permitted.map(target).collect()
}

/// The arm from which the way to another is straightest.
fn straightest_approach(targets: &[Vec<TurnTarget>], to: usize) -> Option<usize> {
    let turns = targets.iter().enumerate().filter_map(|(from, open)| {
        let target = open.iter().find(|target| target.to == to)?;
        Some((target.turn.abs(), from))
    });
    turns.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, from)| from)
}

/// Removes the targets of U-turns, of hairpins without room, and of turns that lead around a loop again. A target stays if an arrow
/// leads there, if it is the best of an arm that has only such targets, or if no other arm leads there. Gives the U-turns for which a
/// median leaves room.
fn remove_u_turns(paths: StreetPaths, arms: &[&Arm], targets: &mut [Vec<TurnTarget>]) -> Vec<Movement> {
    let mut u_turns = Vec::new();
    let closed = |from: usize, target: &TurnTarget| {
        target.turns_back() || is_tight_hairpin(arms[from], target) || is_around_again(arms[from], target)
    };
    let entered = targets.iter().enumerate().flat_map(|(from, open)| open.iter().filter(move |t| !closed(from, t)));
    let entered: Vec<usize> = entered.map(|target| target.to).collect();
    for (from, open) in targets.iter_mut().enumerate() {
        if arms[from].into.iter().any(|lane| lane.arrows.has(Arrows::REVERSE)) {
            continue;
        }
        if open.iter().all(|target| closed(from, target)) {
            keep_gentlest(arms[from], open, |target| entered.contains(&target.to));
            continue;
        }
        let back = open.iter().filter(|target| {
            target.turns_back()
                || closed(from, target) && entered.contains(&target.to) && !is_around_again(arms[from], target)
        });
        u_turns.extend(back.filter_map(|target| u_turn(paths, from, arms[from], open, target)));
        open.retain(|target| !(closed(from, target) && entered.contains(&target.to)));
    }
    u_turns
}

/// Keeps of targets, all of which turn back, those that a car reaches with ease, else the one that it reaches most easily; and those
/// to which no other arm leads.
fn keep_gentlest(arm: &Arm, open: &mut Vec<TurnTarget>, is_entered: impl Fn(&TurnTarget) -> bool) {
    let radius = |target: &TurnTarget| {
        let pairs = arm.into.iter().flat_map(|into| target.arm.out.iter().map(move |out| (into.pose, out.pose)));
        pairs.map(|(into, out)| curve::radius(&curve::join(into, out))).fold(0.0, f64::max)
    };
    let widest = open.iter().map(radius).fold(0.0, f64::max);
    open.retain(|target| !is_entered(target) || radius(target) >= widest.min(1.0 / TIGHTEST_BACK));
}

/// Whether the movement to an arm is a hairpin for which no pair of lanes leaves room.
fn is_tight_hairpin(arm: &Arm, target: &TurnTarget) -> bool {
    let mut pairs = arm.into.iter().flat_map(|into| target.arm.out.iter().map(move |out| (into.pose, out.pose)));
    target.turn.abs() > HAIRPIN && !pairs.any(|(into, out)| is_gentle(&curve::join(into, out), TIGHTEST_HAIRPIN))
}

/// Whether the movement to an arm leads around a two-way loop again. Vehicles on such a loop can also go back.
fn is_around_again(arm: &Arm, target: &TurnTarget) -> bool {
    arm.at.road == target.arm.at.road && !arm.out.is_empty() && !target.arm.into.is_empty()
}

/// The U-turn around the end of a median or over a link, or the turn into a road that leaves at an acute angle: across the oncoming
/// traffic if there is room, else to the near side.
fn u_turn(paths: StreetPaths, from: usize, arm: &Arm, open: &[TurnTarget], target: &TurnTarget) -> Option<Movement> {
    let mut sides = [(1.0, Arrows::LEFT), (-1.0, Arrows::RIGHT)];
    if paths.network.side == DrivingSide::Left {
        sides.reverse();
    }
    // If every lane has arrows, a lane from which vehicles may turn back has an arrow for that, or one to a side where no other road is.
    let told = arm.into.iter().all(|lane| !lane.arrows.is_none());
    let is_meant = |(toward, _): &(f64, Arrows)| {
        !open.iter().any(|other| !other.turns_back() && toward * other.arrow_turn > STRAIGHT_ON)
    };
    let may_turn = sides.into_iter().filter(|side| arm.at.road != target.arm.at.road && (!told || is_meant(side)));
    let mut turns = may_turn.filter_map(|side| u_turn_toward(paths, side, told, arm, target));
    turns.next().map(|[in_lane, out_lane]| Movement { from, to: target.to, in_lane, out_lane })
}

/// The lanes of a U-turn to one side, left positive, unless an arrow leads elsewhere than these: from the lane on that side to the first
/// lane that is far enough from it, or along the streets to the first lane. Where arrows have `told` it, only along the streets.
fn u_turn_toward(
    paths: StreetPaths,
    (toward, turns): (f64, Arrows),
    told: bool,
    arm: &Arm,
    target: &TurnTarget,
) -> Option<[usize; 2]> {
    let driven = |lanes: &[ArmLane]| -> Vec<(usize, ArmLane)> {
        let mut found: Vec<_> = lanes.iter().copied().enumerate().filter(|(_, l)| l.kind == StripKind::Drive).collect();
        if toward < 0.0 {
            found.reverse();
        }
        found
    };
    let (in_lane, into) = driven(&arm.into).first().copied()?;
    let aside = |out: &ArmLane| toward * cross(into.pose.heading, out.pose.point - into.pose.point) > 0.0;
    let room = |out: &ArmLane| {
        let poses = curve::join(into.pose, out.pose);
        !told && is_gentle(&poses, TIGHTEST_BACK) && curve::sway(&poses) <= SWAY_MOST
    };
    let radius = if into.arrows.has(turns) { RADIUS_TOLD } else { RADIUS_LEAST };
    let out: Vec<(usize, ArmLane)> = driven(&target.arm.out).into_iter().filter(|(_, out)| aside(out)).collect();
    let along = || {
        let first = out.first().filter(|(_, out)| {
            let poses = paths.between([arm.at, target.arm.at], [into.pose, out.pose], radius);
            poses.is_some_and(|poses| toward * curve::turned(&poses) > 0.0)
        });
        first.copied()
    };
    let (out_lane, _) = out.iter().find(|(_, out)| room(out)).copied().or_else(along)?;
    (into.arrows.is_none() || into.arrows.has(turns)).then_some([in_lane, out_lane])
}

/// The same U-turn to the lane beside it at the median, if no movement leads to that lane: such a U-turn may be tighter.
fn tighter_u_turn(side: DrivingSide, arms: &[&Arm], all: &[Movement], turn: &Movement) -> Option<Movement> {
    let out_lane = if side == DrivingSide::Right { turn.out_lane.checked_sub(1)? } else { turn.out_lane + 1 };
    let (into, out) = (arms[turn.from].into.get(turn.in_lane)?, arms[turn.to].out.get(out_lane)?);
    let is_reached = all.iter().any(|other| (other.to, other.out_lane) == (turn.to, out_lane));
    let fits = out.kind == StripKind::Drive && is_gentle(&curve::join(into.pose, out.pose), TIGHTEST_ONLY);
    (fits && !is_reached).then_some(Movement { out_lane, ..*turn })
}

/// Whether a U-turn keeps clear of the movements from the lanes beside it.
fn has_room_beside(paths: StreetPaths, arms: &[&Arm], all: &[Movement], turn: &Movement) -> bool {
    let ends = |m: &Movement| (*m, &arms[m.from].into[m.in_lane], &arms[m.to].out[m.out_lane]);
    let beside = |m: &&Movement| m.from == turn.from && m.in_lane.abs_diff(turn.in_lane) == 1;
    let around = |ends: &MovementEnds, direct: &[Pose]| along_streets(paths, arms, ends, direct);
    all.iter().filter(beside).all(|other| common_ground([ends(turn), ends(other)], around) <= RUNS_INTO)
}

/// The way of a movement along the streets where its direct centre line is too tight, or sways, or is a detour.
pub fn along_streets(
    paths: StreetPaths,
    arms: &[&Arm],
    (movement, from, to): &MovementEnds,
    direct: &[Pose],
) -> Option<Vec<Pose>> {
    let roads = [movement.from, movement.to].map(|arm| arms[arm].at);
    let along = |radius: f64| paths.between(roads, [from.pose, to.pose], radius);
    if is_gentle(direct, TIGHTEST_BACK) && curve::sway(direct) <= SWAY_MOST {
        // From one street to another beside it a smooth curve can swing out far beyond the road that joins them.
        let short_enough = |shortest: f64| curve::length(direct) <= DETOUR_MOST * shortest;
        if paths.intersection.inner.is_empty() || short_enough((to.pose.point - from.pose.point).norm()) {
            return None;
        }
        return along(RADIUS_LEAST).filter(|way| !short_enough(curve::length(way)));
    }
    let told = !from.arrows.is_none() && !is_gentle(direct, TIGHTEST_HAIRPIN);
    along(RADIUS_LEAST).or_else(|| along(RADIUS_TOLD).filter(|_| told))
}

/// Whether a line of poses has at most this curvature, 1/m.
fn is_gentle(poses: &[Pose], most: f64) -> bool {
    let bend = |w: &[Pose]| angle_between(w[0].heading, w[1].heading).abs();
    poses.windows(2).all(|w| bend(w) <= most * (w[1].point - w[0].point).norm() + 1e-3)
}
