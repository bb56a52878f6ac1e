//! Bus lanes from `lanes:bus`, `lanes:psv` and `busway`.

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::values::number_of;

use super::facts::default_lane;
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
            DrivingSide::Left => opposite(right_hand),
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

fn opposite(travel: Travel) -> Travel {
    match travel {
        Travel::Forward => Travel::Backward,
        Travel::Backward => Travel::Forward,
        Travel::Both => Travel::Both,
    }
}

/// The edge of the lanes of `travel` on the side of the road of direction `here`.
fn edge(here: Travel, travel: Travel) -> Edge {
    if here == travel { Edge::Near } else { Edge::Far }
}

/// Applies `lanes:bus` and `lanes:psv`, with or without a direction. Returns whether there was one.
fn mark_counted(facts: &WayFacts<'_>, flow: Flow, forward: &mut [Strip], backward: &mut [Strip]) -> bool {
    let count = |suffix: &str| {
        let value = ["lanes:bus", "lanes:psv"].iter().find_map(|key| facts.tags.get_joined([key, suffix]))?;
        number_of(value).filter(|n| *n >= 1.0).map(|n| n as usize)
    };
    let (mut ahead, mut back) = (count(":forward"), count(":backward"));
    if let (None, None, Some(all)) = (ahead, back, count("")) {
        match flow {
            Flow::Backward => back = Some(all),
            Flow::TwoWay if all > 1 => (ahead, back) = (Some(all.div_ceil(2)), Some(all / 2)),
            _ => ahead = Some(all),
        }
    }
    for (lanes, count) in [(forward, ahead), (backward, back)] {
        let near_first = facts.side == DrivingSide::Left;
        let count = count.unwrap_or(0).min(lanes.len());
        let skip = if near_first { 0 } else { lanes.len() - count };
        lanes.iter_mut().skip(skip).take(count).for_each(|lane| lane.kind = StripKind::Bus);
    }
    ahead.is_some() || back.is_some()
}

/// Turns the outermost lane on one edge into a bus lane, or adds a bus lane if there is only one lane.
fn mark(facts: &WayFacts<'_>, lanes: &mut Vec<Strip>, edge: Edge, travel: Travel) {
    let first = (edge == Edge::Near) == (facts.side == DrivingSide::Left);
    let cars = lanes.iter().filter(|lane| lane.kind == StripKind::Drive).count();
    if cars < 2 {
        let lane = Strip { kind: StripKind::Bus, ..default_lane(facts, travel) };
        lanes.insert(if first { 0 } else { lanes.len() }, lane);
        return;
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
