//! Bus lanes from `lanes:bus`, `lanes:psv` and `busway`.

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::values::number_of;

use super::facts::{MAX_LANES, default_lane, tagged_count};
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
/// and the backward direction. Lists that name bus lanes take precedence.
pub(super) fn mark_bus_lanes(facts: &WayFacts<'_>, flow: Flow, lanes: [&mut Vec<Strip>; 2], lists: [&PerLane; 2]) {
    let [forward, backward] = lanes;
    if lists[0].names_buses(forward.len()) || lists[1].names_buses(backward.len()) || facts.bus_road {
        return;
    }
    if mark_counted(facts, flow, forward, backward) {
        return;
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
        match (value(key), flow) {
            (Some("lane"), Flow::TwoWay) => {
                mark(facts, if here == Travel::Forward { forward } else { backward }, Edge::Near, here);
            }
            (Some("lane"), Flow::Forward) => mark(facts, forward, edge(here, Travel::Forward), Travel::Forward),
            (Some("lane"), Flow::Backward) => mark(facts, backward, edge(here, Travel::Backward), Travel::Backward),
            (Some("opposite_lane"), _) => against(facts, flow, forward, backward),
            _ => {}
        }
    }
    match (facts.tags.get("busway"), flow) {
        (Some("lane"), Flow::Forward) => mark(facts, forward, Edge::Near, Travel::Forward),
        (Some("lane"), Flow::Backward) => mark(facts, backward, Edge::Near, Travel::Backward),
        (Some("opposite_lane"), _) => against(facts, flow, forward, backward),
        _ => {}
    }
}

/// The edge of the lanes of `travel` on the side of the road of direction `here`.
fn edge(here: Travel, travel: Travel) -> Edge {
    if here == travel { Edge::Near } else { Edge::Far }
}

/// The numbers of bus lanes forward and backward by `lanes:bus` and `lanes:psv`, with or without a direction.
pub(super) fn counted(facts: &WayFacts<'_>, flow: Flow) -> [Option<usize>; 2] {
    let count = |suffix: &str| {
        let value = ["lanes:bus", "lanes:psv"].iter().find_map(|key| facts.tags.get_joined([key, suffix]))?;
        number_of(value).filter(|n| *n >= 1.0).map(|n| (n as usize).min(MAX_LANES))
    };
    match (count(":forward"), count(":backward"), count(""), flow) {
        (None, None, Some(all), Flow::Backward) => [None, Some(all)],
        (None, None, Some(all), Flow::TwoWay) if all > 1 => [Some(all.div_ceil(2)), Some(all / 2)],
        (None, None, all, _) => [all, None],
        (ahead, back, ..) => [ahead, back],
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
    if cars < 2 {
        return add(facts, lanes, edge, travel);
    }
    let outermost = if first { lanes.first_mut() } else { lanes.last_mut() };
    if let Some(lane) = outermost {
        lane.kind = StripKind::Bus;
    }
}

/// A bus lane against a one-way street.
fn against(facts: &WayFacts<'_>, flow: Flow, forward: &mut Vec<Strip>, backward: &mut Vec<Strip>) {
    let (lanes, travel) = match flow {
        Flow::Forward => (backward, Travel::Backward),
        Flow::Backward => (forward, Travel::Forward),
        _ => return,
    };
    if lanes.is_empty() {
        lanes.push(Strip { kind: StripKind::Bus, ..default_lane(facts, travel) });
    }
}
