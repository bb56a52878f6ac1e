//! Roads that are merged or left out: too little of them is left between the lanelets at their ends, or no turn leads to them.

use std::cmp::Reverse;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::intersection::movement::joined_arms;
use crate::builder::intersection::street_path::RADIUS_TOLD;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::road_cut::VEHICLE;
use crate::builder::network::turn_angle::TURNS_BACK;
use crate::builder::network::{IntersectionIx, Road, RoadEnd, RoadIx, RoadKey, RoadNetwork};
use crate::builder::streets::consolidate::MergeNote;
use crate::diagnostic::{Finding, Severity, Subject};

use super::map_layout::{IntersectionLanelets, Layout};
use super::short_links::{roads_of_tight_turns, short_links};

/// The roads that are too short to be cut back behind the lanelets over their ends, or for the turns there; in order.
pub fn roads_inside(layout: &Layout, refused: &FxHashSet<RoadKey>) -> Vec<RoadIx> {
    let network = &layout.network;
    let no_room = |road: &RoadIx| {
        let Some(one) = network.roads.get(road.position()) else { return false };
        layout.left(*road) < VEHICLE && one.from != one.to && !refused.contains(&one.key)
    };
    let leads_on = |road: &RoadIx| !ends_here(network, network.road(*road));
    let short = short_links(layout).into_iter().filter(leads_on);
    let mut roads: Vec<RoadIx> = layout.overrun().map(|at| at.road).chain(short).filter(no_room).collect();
    roads.sort_unstable();
    roads.dedup();
    roads
}

/// The roads of which just a waiting vehicle is left, though lanelets run over their ends or turns there need more; in order.
pub fn roads_to_cut_farther(layout: &Layout) -> Vec<RoadIx> {
    let overrun = layout.overrun().map(|at| at.road);
    let lacking = overrun.chain(short_links(layout)).chain(roads_of_tight_turns(layout));
    let mut roads: Vec<RoadIx> = lacking.filter(|road| layout.keeps_room(*road)).collect();
    roads.sort_unstable();
    roads.dedup();
    roads
}

/// Those of these roads, in ascending order, that join the same two intersections as another of them. Without room they lie over each
/// other, so that nothing can be built between the intersections, however large these are.
pub fn roads_abreast(network: &RoadNetwork, roads: &[RoadIx]) -> Vec<RoadIx> {
    let ends = |road: RoadIx| {
        let road = network.road(road);
        [road.from.min(road.to), road.from.max(road.to)]
    };
    let mut counts: FxHashMap<[IntersectionIx; 2], usize> = FxHashMap::default();
    roads.iter().for_each(|road| *counts.entry(ends(*road)).or_default() += 1);
    roads.iter().copied().filter(|road| counts[&ends(*road)] > 1).collect()
}

/// The end of a road at an intersection with lanelets, and which of its directions have turns.
struct ServedEnd {
    at: RoadEnd,
    /// Whether its lanes lead in, and whether they lead out.
    has: [bool; 2],
    /// Whether a lanelet leads from them, and whether one leads to them.
    joined: [bool; 2],
    /// The same without those on which a car would have to turn back too tightly.
    drivable: [bool; 2],
}

/// Whether a lanelet leads from an arm, and whether one leads to it.
fn joined<'a>(paths: impl Iterator<Item = &'a TurningLanelet>, arm: usize) -> [bool; 2] {
    paths.fold([false; 2], |[from, to], path| [from || path.movement.from == arm, to || path.movement.to == arm])
}

/// Whether a car does not have to turn back on a lanelet more tightly than at full lock.
fn is_drivable(path: &&TurningLanelet) -> bool {
    path.turn.abs() <= TURNS_BACK || path.radius >= RADIUS_TOLD
}

/// The ends of all roads at intersections where some are joined.
fn served_ends(layout: &Layout) -> impl Iterator<Item = ServedEnd> {
    let drawn = layout.network.intersections.iter().zip(&layout.turning);
    let drawn = drawn.filter_map(|(at, turning)| Some((at, &turning.as_ref()?.drawn.paths)));
    drawn.filter(|(_, paths)| !paths.is_empty()).flat_map(move |(at, paths)| {
        at.arms.iter().enumerate().map(move |(arm, end)| {
            let lanes = layout.lanes.arm(*end);
            let (joined, drivable) = (joined(paths.iter(), arm), joined(paths.iter().filter(is_drivable), arm));
            ServedEnd { at: *end, has: [!lanes.into.is_empty(), !lanes.out.is_empty()], joined, drivable }
        })
    })
}

/// The ends of roads from and to which no lanelet leads, at intersections where some join others.
pub fn ends_without_turns(layout: &Layout) -> Vec<RoadEnd> {
    served_ends(layout).filter(|end| end.joined == [false; 2]).map(|end| end.at).collect()
}

/// The ends of roads with lanes of both directions at which lanelets join those of one direction only; with `true` where no lanelet
/// leads to the lanes that lead away, and `false` where none leads from those that arrive. Where three roads or more meet, lanelets on which
/// no car can turn back join nothing.
pub fn half_served_ends(layout: &Layout) -> Vec<(RoadEnd, bool)> {
    let half = served_ends(layout).filter(|end| end.has == [true; 2]);
    let network = &layout.network;
    let at_lanelets = half.filter_map(|end| {
        let goes_on = network.intersection(network.intersection_at(end.at)).arms.len() == 2;
        only_one(if goes_on { end.joined } else { end.drivable }).map(|away| (end.at, away))
    });
    at_lanelets.chain(half_served_joints(layout)).collect()
}

/// The same where two roads meet face to face, and the other road has lanes of one direction only.
fn half_served_joints(layout: &Layout) -> impl Iterator<Item = (RoadEnd, bool)> {
    let has = |end: RoadEnd| {
        let lanes = layout.lanes.arm(end);
        [!lanes.into.is_empty(), !lanes.out.is_empty()]
    };
    let network = &layout.network;
    let joints = IntersectionIx::all(network.intersections.len()).filter(|ix| layout.meet_face_to_face(*ix));
    let pairs = joints.flat_map(|ix| match network.intersection(ix).arms[..] {
        [a, b] => vec![(a, b), (b, a)],
        _ => Vec::new(),
    });
    pairs.filter(move |(end, _)| has(*end) == [true; 2]).filter_map(move |(end, other)| {
        let [into, out] = has(other);
        only_one([out, into]).map(|away| (end, away))
    })
}

/// `true` if only the second is missing, `false` if only the first.
fn only_one(joined: [bool; 2]) -> Option<bool> {
    match joined {
        [true, false] => Some(true),
        [false, true] => Some(false),
        _ => None,
    }
}

/// Whether a road is a dead end at one of its ends.
fn ends_here(network: &RoadNetwork, road: &Road) -> bool {
    [road.from, road.to].iter().any(|&at| network.intersection(at).arms.len() < 2)
}

/// The roads to leave out, in order: dead ends that no car can turn into, loops inside their intersection, and short pieces without
/// turns. Roads in `apart` stay.
pub fn roads_to_leave_out(layout: &Layout, apart: &FxHashSet<RoadKey>) -> Vec<RoadIx> {
    let mut roads = short_dead_ends(layout, apart);
    roads.extend(loops_inside(layout, apart));
    roads.extend(pieces_without_turns(layout, apart));
    roads.sort_unstable();
    roads.dedup();
    roads
}

/// Dead ends that are too short for a turn that a car can take, at intersections where two longer roads meet. If all roads of an
/// intersection are short, they stay.
fn short_dead_ends(layout: &Layout, apart: &FxHashSet<RoadKey>) -> Vec<RoadIx> {
    let is_left_out = |road: &RoadIx| {
        let one = layout.network.road(*road);
        ends_here(&layout.network, one) && !apart.contains(&one.key) && is_beside_longer(&layout.network, one)
    };
    short_links(layout).into_iter().filter(is_left_out).collect()
}

/// Loops of which less is left than the length of a vehicle: cars turn on such a place at the end of a drive, but it has no lanes.
fn loops_inside(layout: &Layout, apart: &FxHashSet<RoadKey>) -> Vec<RoadIx> {
    let is_inside = |ix: &RoadIx| {
        let road = layout.network.road(*ix);
        road.from == road.to && !road.roundabout && layout.left(*ix) < VEHICLE && !apart.contains(&road.key)
    };
    RoadIx::all(layout.network.roads.len()).filter(is_inside).collect()
}

/// Roads of which less is left than the length of a vehicle and that lack turns at an end: if the road goes on at its other end, all
/// turns of that end; if it is a dead end, those of one direction.
fn pieces_without_turns(layout: &Layout, apart: &FxHashSet<RoadKey>) -> Vec<RoadIx> {
    let leads_nowhere = |end: &ServedEnd| {
        let road = layout.network.road(end.at.road);
        let closed = end.has.iter().zip(end.joined).filter(|(has, joined)| **has && !joined).count();
        let is_closed =
            if ends_here(&layout.network, road) { closed > 0 } else { closed > 0 && end.joined == [false; 2] };
        is_closed && layout.left(end.at.road) < VEHICLE && !apart.contains(&road.key)
    };
    served_ends(layout).filter(leads_nowhere).map(|end| end.at.road).collect()
}

/// Whether two longer roads meet at an end of a road.
fn is_beside_longer(network: &RoadNetwork, road: &Road) -> bool {
    let longer = |arm: &&RoadEnd| network.road(arm.road).line.length() > road.line.length();
    [road.from, road.to].iter().any(|&at| network.intersection(at).arms.iter().filter(longer).count() > 1)
}

/// The note that a road is not built.
pub fn left_out(road: &Road) -> Finding {
    let RoadKey { way, first, last, .. } = road.key;
    let kind = if road.from == road.to { "loop" } else { "road" };
    let message = format!(
        "way {way} is not built between nodes {first} and {last}: too little is left of this {kind} for a car to turn into it"
    );
    Finding::new("way-skipped", Subject::Way(way), message).graded(Severity::Info)
}

/// The note that a road lies inside an intersection.
pub fn road_inside(MergeNote { key, left, .. }: &MergeNote) -> Finding {
    let message = format!(
        "Of way {} between nodes {} and {} there are {left:.1} m left, too few for the ways at its ends: it lies inside an intersection.",
        key.way, key.first, key.last
    );
    Finding::new("road-inside", Subject::Way(key.way), message).graded(Severity::Info)
}

/// The intersections where more roads meet than can be joined: their first node, how many roads, and how many of them are joined.
pub fn crowded_intersections(network: &RoadNetwork) -> Vec<(i64, [usize; 2])> {
    let counted = network.intersections.iter().filter_map(|at| {
        let joined = joined_arms(network, at).into_iter().filter(|joined| *joined).count();
        Some((*at.nodes.first()?, [at.arms.len(), joined]))
    });
    counted.filter(|(_, [all, joined])| joined < all).collect()
}

/// Says that only some of the roads at a node are joined.
pub fn too_many_roads(node: i64, [count, joined]: [usize; 2]) -> Finding {
    let message = format!(
        "{count} roads meet at node {node}: too many for one intersection; {joined} of them are joined, the others end before it."
    );
    Finding::new("too-many-roads", Subject::Node(node), message).graded(Severity::Warning)
}

/// Says that the roads lie too close to each other to be laid out to the end, at the intersection with the most lanelets.
pub fn ended_early(layout: &Layout) -> Option<Finding> {
    let count = |turning: &Option<Box<IntersectionLanelets>>| turning.as_ref().map_or(0, |one| one.drawn.paths.len());
    let drawn = layout.network.intersections.iter().zip(&layout.turning);
    let (at, turning) = drawn.max_by_key(|(at, turning)| (count(turning), Reverse(at.nodes.first())))?;
    let node = *at.nodes.first()?;
    let message = format!(
        "Around node {node}, where {} lanes cross an intersection, roads lie too close to each other to be laid out to the end: lanes \
         may run over the ends of others.",
        count(turning)
    );
    Some(Finding::new("too-many-rounds", Subject::Node(node), message).graded(Severity::Warning))
}

/// Says where lanes are not joined because there are too many.
pub fn left_out_movements(layout: &Layout) -> Vec<Finding> {
    let drawn = layout.network.intersections.iter().zip(&layout.turning);
    let of_each = drawn.filter_map(|(at, turning)| {
        let plan = &turning.as_ref().filter(|turning| turning.plan.left_out > 0)?.plan;
        let (node, kept) = (*at.nodes.first()?, plan.all.len());
        let message = format!(
            "At node {node} there are {} ways from lane to lane: too many to draw; the straightest {kept} are drawn.",
            kept + plan.left_out
        );
        Some(Finding::new("too-many-turns", Subject::Node(node), message).graded(Severity::Warning))
    });
    of_each.collect()
}
