//! vm-01-04: lanes of opposite directions share the line between them.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::{MapIndex, is_road_border};
use crate::lanelet::{LineStringId, TurnDirection};

use super::parallel_bounds::{ParallelBounds, Reach};
use super::{divided_lanelets, merged_borders, parallel_bounds};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    apart: f64,
    share: f64,
    even: f64,
    step: f64,
}

/// Lanes shorter than this, metres, lie beside no other.
const SHORTEST: f64 = 0.5;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let reach = Reach { apart: params.apart, share: params.share };
    // A turn belongs to an intersection, be no area drawn around it; and a stub is no stretch of road that others could be cut like.
    let is_labelled = |at: usize| matches!(map.turn_direction(at), Some(TurnDirection::Left | TurnDirection::Right));
    let turns = |at: usize| is_labelled(at) || map.turns_at_unmarked(at);
    let is_stretch = |at: usize| map.lanes[at].length() >= SHORTEST;
    let outside =
        |at: usize| map.lanes[at].is_for_cars() && map.intersections_of(at).is_empty() && !turns(at) && is_stretch(at);
    let twins = parallel_bounds::all(map, reach, outside, outside);
    // Each pair is found from both lanes; the lane with the longer border counts.
    let first = |twins: &ParallelBounds| {
        let key = |i: usize| (twins.lengths[i], std::cmp::Reverse(map.lanes[twins.lanes[i]].id));
        key(0) > key(1)
    };
    let open = |twins: &ParallelBounds| !twins.ways.iter().any(|&way| is_barrier(map, way));
    // vm-03-01 says what is to be done there.
    let in_one = |one: &ParallelBounds| map.shared_unmarked(one.lanes[0], one.lanes[1]).is_some();
    let fits = |one: &ParallelBounds| one.opposed && open(one) && first(one) && !part(map, one, params) && !in_one(one);
    let mut by_lane: BTreeMap<usize, Vec<ParallelBounds>> = BTreeMap::new();
    for one in twins.into_iter().filter(fits) {
        by_lane.entry(one.lanes[0]).or_default().push(one);
    }
    let judged = by_lane.into_iter().flat_map(|(lane, others)| {
        if others.iter().any(|one| one.lengths[1] < params.even * one.lengths[0]) {
            return vec![cut_apart(map, lane, &others)];
        }
        others.iter().map(|one| not_shared(map, one)).collect()
    });
    judged.collect()
}

/// Whether what a way stands for parts the directions: nobody drives over it.
fn is_barrier(map: &MapIndex, way: LineStringId) -> bool {
    const BARRIERS: [&str; 5] = ["guard_rail", "wall", "fence", "curbstone", "jersey_barrier"];
    map.map.linestrings.get(way).is_some_and(|line| {
        is_road_border(line) || line.attributes.get("type").is_some_and(|kind| BARRIERS.contains(&kind))
    })
}

/// Whether two borders diverge at an end, where a median or a wall begins, however narrow. They lie close together like one line,
/// but no single way could be the border of both.
fn part(map: &MapIndex, twins: &ParallelBounds, params: &Params) -> bool {
    let [mine, theirs] = twins.lanes.map(|lane| &map.lanes[lane]);
    // Lanes that run against each other touch on the same hand.
    let side = usize::from(mine.bounds[0] != twins.ways[0]);
    let [Some(own), Some(other)] = [mine, theirs].map(|lane| lane.border(side)) else { return false };
    let height = |id| map.map.points.get(id).and_then(|point| point.ele());
    let [lane, oncoming] = twins.lanes;
    let before = [map.predecessors(lane), map.followers(oncoming)];
    let behind = [map.followers(lane), map.predecessors(oncoming)];
    let walled = |lanes: &&[usize]| lanes.iter().any(|&lane| is_barrier(map, map.lanes[lane].bounds[side]));
    [(&mine.start, &theirs.end, before), (&mine.end, &theirs.start, behind)].into_iter().any(|(a, b, next)| {
        if a.ids[side] != b.ids[side] && next.iter().all(walled) {
            return true;
        }
        // If one of them ends a little earlier, its end still lies on the other.
        let across = other.project(a.points[side]).offset.abs().min(own.project(b.points[side]).offset.abs());
        let up = height(a.ids[side]).zip(height(b.ids[side])).map_or(0.0, |(a, b)| (a - b).abs());
        across > params.apart || up > params.step
    })
}

fn not_shared(map: &MapIndex, twins: &ParallelBounds) -> Finding {
    let [id, other] = twins.lanes.map(|lane| map.lanes[lane].id);
    let [way, own] = twins.ways;
    let message = format!("Lanelets {id} and {other} run against each other over two ways, {way} and {own}.");
    let finding = Finding::new("not-shared", Subject::Lanelet(id.0), message)
        .with(Subject::Lanelet(other.0), "oncoming lane")
        .with(Subject::LineString(way.0), "border")
        .with(Subject::LineString(own.0), "oncoming lane's border");
    match twins.shared(map) {
        Some(edit) => finding.fixed_by(format!("use way {way} for both"), true, vec![edit]),
        None => match merged_borders::edits(map, twins.lanes, twins.ways) {
            Some(edits) => finding.fixed_by("make one way of both, from end to end", false, edits),
            None => finding,
        },
    }
}

/// A lane beside oncoming ones that are shorter: no way can be the border of both.
fn cut_apart(map: &MapIndex, lane: usize, others: &[ParallelBounds]) -> Finding {
    let id = map.lanes[lane].id;
    let names: Vec<String> = others.iter().map(|twins| map.lanes[twins.lanes[1]].id.to_string()).collect();
    let message = format!("Lanelet {id} is cut elsewhere than the oncoming lanes beside it: {}.", names.join(", "));
    let finding = Finding::new("cut-apart", Subject::Lanelet(id.0), message);
    let finding = others.iter().fold(finding, |finding, twins| {
        finding.with(Subject::Lanelet(map.lanes[twins.lanes[1]].id.0), "oncoming lane")
    });
    let oncoming: Vec<usize> = others.iter().map(|twins| twins.lanes[1]).collect();
    divided_lanelets::beside(map, finding, lane, &oncoming)
}
