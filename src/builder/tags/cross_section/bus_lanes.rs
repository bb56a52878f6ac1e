//! Bus lanes from `lanes:bus`, `lanes:psv` and `busway`.

use crate::builder::tags::road_class::DrivingSide;

use super::bus_tags::{count, counted_against, leads_against};
use super::facts::{default_lane, tagged_count};
use super::flow::Flow;
use super::per_lane::PerLane;
use super::{Strip, StripKind, Travel, WayFacts};

/// An edge of the lanes of one direction.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Edge {
    /// At the kerb.
    Near,
    /// At the oncoming traffic.
    Far,
}

/// Turns lanes into bus lanes, or adds a bus lane where none would be left for cars. `lanes` and `lists` are those of the forward
/// and the backward direction. Lists that name bus lanes take precedence. Lanes against a one-way road are bus lanes already.
pub(super) fn mark_bus_lanes(facts: &WayFacts<'_>, flow: Flow, lanes: [&mut Vec<Strip>; 2], lists: [&PerLane; 2]) {
    let [forward, backward] = lanes;
    let named = [
        flow.against() != Some(Travel::Forward) && lists[0].names_buses(forward.len()),
        flow.against() != Some(Travel::Backward) && lists[1].names_buses(backward.len()),
    ];
    if named.contains(&true) || facts.bus_road || mark_counted(facts, flow, forward, backward) {
        return;
    }
    for (lanes, list) in [(&mut *forward, lists[0]), (&mut *backward, lists[1])] {
        let [first, last] = list.bus_lanes_at_edges(lanes.len());
        let cars = lanes.iter().filter(|lane| lane.kind == StripKind::Drive).count();
        if cars < 2 || first == last {
            continue;
        }
        if let Some(lane) = if first { lanes.first_mut() } else { lanes.last_mut() } {
            lane.kind = StripKind::Bus;
            return;
        }
    }
    let sides = [("busway:left", Travel::Backward), ("busway:right", Travel::Forward)];
    let value = |key| {
        let on_side = facts.tags.get(key).or_else(|| facts.tags.get("busway:both"));
        on_side.or_else(|| facts.tags.get("busway").filter(|_| !flow.is_oneway()))
    };
    for (key, right_hand) in sides {
        let here = match facts.side {
            DrivingSide::Right => right_hand,
            DrivingSide::Left => right_hand.reversed(),
        };
        if flow.against().is_some_and(|against| leads_against(facts, key, against)) {
            continue;
        }
        match (value(key), flow) {
            (Some("lane"), Flow::TwoWay) => {
                mark(facts, if here == Travel::Forward { forward } else { backward }, Edge::Near, here);
            }
            (Some("lane"), Flow::Forward) => mark(facts, forward, edge(here, Travel::Forward), Travel::Forward),
            (Some("lane"), Flow::Backward) => mark(facts, backward, edge(here, Travel::Backward), Travel::Backward),
            _ => {}
        }
    }
    match (facts.tags.get("busway"), flow) {
        (Some("lane"), Flow::Forward) => mark(facts, forward, Edge::Near, Travel::Forward),
        (Some("lane"), Flow::Backward) => mark(facts, backward, Edge::Near, Travel::Backward),
        _ => {}
    }
}

/// Whether a two-way road has a bus lane of its own, forward and backward, by `busway` on one side.
pub(super) fn on_sides(facts: &WayFacts<'_>) -> [bool; 2] {
    let [left, right] = ["busway:left", "busway:right"].map(|key| facts.tags.is(key, "lane"));
    if facts.side == DrivingSide::Right { [right, left] } else { [left, right] }
}

/// The edge of the lanes of `travel` on the side of the road of direction `here`.
fn edge(here: Travel, travel: Travel) -> Edge {
    if here == travel { Edge::Near } else { Edge::Far }
}

/// The numbers of bus lanes forward and backward by `lanes:bus` and `lanes:psv`, with or without a direction; of a one-way road
/// those in its direction.
pub(super) fn counted(facts: &WayFacts<'_>, flow: Flow) -> [Option<usize>; 2] {
    let [ahead, back, all] = [":forward", ":backward", ""].map(|suffix| count(facts, suffix));
    if let Some(against) = flow.against() {
        let rest = |all| match counted_against(facts, against) {
            Some(n) => Some(all - n).filter(|rest| *rest > 0),
            None => Some(all),
        };
        return match against {
            Travel::Forward => [None, back.or(all.filter(|_| ahead.is_none()).and_then(rest))],
            _ => [ahead.or(all.filter(|_| back.is_none()).and_then(rest)), None],
        };
    }
    match (ahead, back, all) {
        (None, None, Some(all)) if flow == Flow::TwoWay && all > 1 => [Some(all.div_ceil(2)), Some(all / 2)],
        (None, None, all) => [all, None],
        (ahead, back, _) => [ahead, back],
    }
}

/// Applies `lanes:bus` and `lanes:psv`. Returns whether there was one.
///
/// They count among the lanes of their direction, unless `lanes` is the sum of both or no lane would be left for cars.
fn mark_counted(facts: &WayFacts<'_>, flow: Flow, forward: &mut Vec<Strip>, backward: &mut Vec<Strip>) -> bool {
    let counts = counted(facts, flow);
    let of_buses: usize = counts.iter().flatten().sum();
    let total = tagged_count(facts, "lanes");
    let besides = total == Some(forward.len() + backward.len() + of_buses);
    for (lanes, count, travel) in [(forward, counts[0], Travel::Forward), (backward, counts[1], Travel::Backward)] {
        let Some(count) = count.filter(|_| !lanes.is_empty()) else { continue };
        if besides || count >= lanes.len() {
            (0..count).for_each(|_| add(facts, lanes, Edge::Near, travel));
        } else {
            let skip = if facts.side == DrivingSide::Left { 0 } else { lanes.len() - count };
            lanes.iter_mut().skip(skip).take(count).for_each(|lane| lane.kind = StripKind::Bus);
        }
    }
    of_buses > 0
}

/// Adds a bus lane at an edge.
fn add(facts: &WayFacts<'_>, lanes: &mut Vec<Strip>, edge: Edge, travel: Travel) {
    let first = (edge == Edge::Near) == (facts.side == DrivingSide::Left);
    let lane = Strip { kind: StripKind::Bus, ..default_lane(facts, travel) };
    lanes.insert(if first { 0 } else { lanes.len() }, lane);
}

/// Turns the outermost lane on one edge into a bus lane, or adds a bus lane if there is only one lane.
fn mark(facts: &WayFacts<'_>, lanes: &mut Vec<Strip>, edge: Edge, travel: Travel) {
    let first = (edge == Edge::Near) == (facts.side == DrivingSide::Left);
    let cars = lanes.iter().filter(|lane| lane.kind == StripKind::Drive).count();
    if cars == 0 && lanes.iter().any(|lane| lane.kind == StripKind::Bus) {
        return;
    }
    if cars < 2 {
        return add(facts, lanes, edge, travel);
    }
    let outermost = if first { lanes.first_mut() } else { lanes.last_mut() };
    if let Some(lane) = outermost {
        lane.kind = StripKind::Bus;
    }
}
