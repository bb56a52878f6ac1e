//! Bus lanes from `lanes:bus`, `lanes:psv` and `busway`.

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::values::number_of;

use super::facts::plain;
use super::flow::Flow;
use super::per_lane::PerLane;
use super::{Strip, StripKind, Travel, WayFacts};

/// One edge of a direction's lanes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Edge {
    /// Toward the own kerb.
    Near,
    /// Toward oncoming traffic.
    Far,
}

/// Makes bus lanes of lanes, or adds a lane where none would be left for cars. `lanes` and `lists` are those of
/// forward and backward travel; lists that name bus lanes themselves have the last word.
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
            (Some("lane"), Flow::TwoWay) => own(facts, if here == Travel::Forward { forward } else { backward }, here),
            (Some("lane"), Flow::Forward) => mark(facts, forward, edge(here, Travel::Forward), Travel::Forward),
            (Some("lane"), Flow::Backward) => mark(facts, backward, edge(here, Travel::Backward), Travel::Backward),
            (Some("opposite_lane"), _) => against(facts, flow, forward, backward),
            _ => {}
        }
    }
    match (facts.tags.get("busway"), flow) {
        (Some("lane"), Flow::Forward) => own(facts, forward, Travel::Forward),
        (Some("lane"), Flow::Backward) => own(facts, backward, Travel::Backward),
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

/// The side of the road where `here` would drive is the near edge for `travel` itself.
fn edge(here: Travel, travel: Travel) -> Edge {
    if here == travel { Edge::Near } else { Edge::Far }
}

fn own(facts: &WayFacts<'_>, lanes: &mut Vec<Strip>, travel: Travel) {
    mark(facts, lanes, Edge::Near, travel);
}

/// `lanes:bus` and `lanes:psv`, with or without a direction; `true` if there was one.
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

/// Makes a bus lane of the outermost lane on one edge; adds one where it is the only lane.
fn mark(facts: &WayFacts<'_>, lanes: &mut Vec<Strip>, edge: Edge, travel: Travel) {
    let first = (edge == Edge::Near) == (facts.side == DrivingSide::Left);
    let cars = lanes.iter().filter(|lane| lane.kind == StripKind::Drive).count();
    if cars < 2 {
        let lane = Strip { kind: StripKind::Bus, ..plain(facts, travel) };
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
        lanes.push(Strip { kind: StripKind::Bus, ..plain(facts, travel) });
    }
}
