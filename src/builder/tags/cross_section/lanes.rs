//! The lanes for motor vehicles: how many each way, and what the `:lanes` tags say of each.

use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::builder::tags::values::{metres_under, number_of};
use crate::diagnostic::{Finding, Severity};
use crate::osm::Tags;

use super::bus_lanes::mark_bus_lanes;
use super::facts::{MAX_SINGLE_TRACK, plain};
use super::flow::Flow;
use super::per_lane::{PerLane, per_lane};
use super::{Lane, Strip, StripKind, Travel, WayFacts, minimum_lane_width};

/// The lanes of a way from left to right along it.
pub(super) type Lanes = Vec<Strip>;

/// More lanes than this in one direction are a slip of the keyboard: the widest toll plazas have fewer.
const MOST_LANES: usize = 24;

/// Without a `lanes` tag, two-way traffic shares one lane where the carriageway is narrower than this, metres: two
/// cars of 2 m with their mirrors.
const TWO_LANES_FIT: f64 = 4.8;

/// With `lanes=1`, a carriageway at least this wide (metres) has a lane each way without markings.
const SURELY_TWO_LANES: f64 = 5.5;

/// How many lanes each way, and how many in the middle for both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counts {
    forward: usize,
    backward: usize,
    both: usize,
}

/// Reads the lanes of a way; `beside` is what parked cars and bicycle lanes take of its carriageway, metres.
pub(super) fn lanes(facts: &WayFacts<'_>, flow: Flow, beside: f64, notes: &mut Vec<Finding>) -> Lanes {
    let room = metres_under(facts.tags, ["width:carriageway", "width", "est_width"]).map(|width| width - beside);
    if let Some(lanes) = facts.continued.filter(|lanes| !tells_lanes(facts.tags) && fit(facts.class, lanes, room)) {
        let what = "no lanes tag; as many as the road has before and behind are assumed";
        notes.push(facts.note("lanes-guessed", Severity::Info, what));
        return lanes.iter().map(|&(kind, travel)| Strip { kind, ..plain(facts, travel) }).collect();
    }
    let forward_list = per_lane(facts, Travel::Forward, flow, said(facts, "lanes:forward"), notes);
    let backward_list = per_lane(facts, Travel::Backward, flow, said(facts, "lanes:backward"), notes);
    let both_list = per_lane(facts, Travel::Both, flow, said(facts, "lanes:both_ways"), notes);
    let counts = match flow {
        Flow::TwoWay => two_way(facts, [&forward_list, &backward_list, &both_list], room, notes),
        Flow::Reversible => Counts { forward: 0, backward: 0, both: one_way(facts, flow, &both_list, notes) },
        Flow::Forward => Counts { forward: one_way(facts, flow, &forward_list, notes), backward: 0, both: 0 },
        Flow::Backward => Counts { forward: 0, backward: one_way(facts, flow, &backward_list, notes), both: 0 },
    };
    let strips = |count, travel, list: &PerLane| -> Vec<Strip> {
        let mut strips = vec![plain(facts, travel); count];
        list.apply(&mut strips, &facts.usual);
        strips
    };
    let mut forward = strips(counts.forward, Travel::Forward, &forward_list);
    let mut backward = strips(counts.backward, Travel::Backward, &backward_list);
    let both = strips(counts.both, Travel::Both, &both_list);
    mark_bus_lanes(facts, flow, [&mut forward, &mut backward], [&forward_list, &backward_list]);
    keep_drivable(facts, [&mut forward, &mut backward], &both, notes);
    backward.reverse();
    let (left, right) = match facts.side {
        DrivingSide::Right => (backward, forward),
        DrivingSide::Left => (forward, backward),
    };
    [left, both, right].concat()
}

/// Whether any tag tells how many lanes a way has, or what for.
pub(crate) fn tells_lanes(tags: &Tags) -> bool {
    let tells =
        |key: &str| key == "lanes" || key.starts_with("lanes:") || key.contains(":lanes") || key.starts_with("busway");
    tags.iter().any(|(key, _)| tells(key))
}

/// Whether lanes fill a carriageway so wide, metres; one of unknown width holds any.
fn fit(class: RoadClass, lanes: &[Lane], room: Option<f64>) -> bool {
    let each = minimum_lane_width(class)..=MAX_SINGLE_TRACK;
    room.is_none_or(|width| each.contains(&(width / lanes.len() as f64)))
}

/// The number under `key`: `1.5` counts as 1, the first of a list counts.
fn said(facts: &WayFacts<'_>, key: &str) -> Option<usize> {
    let value = facts.tags.get(key)?;
    let number = number_of(value.split(';').next().unwrap_or(value))?;
    (number >= 0.0 && number.is_finite()).then(|| (number as usize).min(MOST_LANES))
}

fn one_way(facts: &WayFacts<'_>, flow: Flow, list: &PerLane, notes: &mut Vec<Finding>) -> usize {
    let tagged = said(facts, "lanes").filter(|n| *n > 0);
    let directed = match flow {
        Flow::Forward => said(facts, "lanes:forward"),
        Flow::Backward => said(facts, "lanes:backward"),
        _ => said(facts, "lanes:both_ways"),
    };
    if let Some(slots) = list.agreed(directed.or(tagged)) {
        return slots.min(MOST_LANES);
    }
    if let Some(n) = directed.or(tagged).filter(|n| *n > 0) {
        return n;
    }
    if let Some(slots) = list.longest() {
        return slots.min(MOST_LANES);
    }
    let great = facts.class <= RoadClass::Trunk && !facts.link && flow != Flow::Reversible;
    let n = facts.usual.lanes.unwrap_or(if great { 2 } else { 1 });
    notes.push(facts.note("lanes-guessed", Severity::Info, &format!("no lanes tag; {n} one-way assumed")));
    n
}

fn two_way(facts: &WayFacts<'_>, lists: [&PerLane; 3], room: Option<f64>, notes: &mut Vec<Finding>) -> Counts {
    let [forward, backward] = [(lists[0], "lanes:forward"), (lists[1], "lanes:backward")].map(|(list, key)| {
        let tagged = said(facts, key).filter(|n| *n > 0);
        list.agreed(tagged).or(tagged).or(list.longest()).map(|n| n.min(MOST_LANES))
    });
    let both = said(facts, "lanes:both_ways").or(lists[2].longest()).unwrap_or(0).min(MOST_LANES);
    let Some(total) = said(facts, "lanes").filter(|n| *n > 0) else {
        return without_total(facts, [forward, backward], both, room, notes);
    };
    // Lists may hold bicycle lanes, which `lanes` does not count, and bus lanes, which some mappers leave out.
    let cars = |list: &PerLane, count: usize| count.saturating_sub(list.special_lanes(count));
    let motor = |list: &PerLane, count: usize| count.saturating_sub(list.bicycle_lanes(count));
    let rest = |taken: usize| total.saturating_sub(both + taken);
    let contradiction = match (forward, backward) {
        (Some(f), Some(b)) => {
            let least = cars(lists[0], f) + cars(lists[1], b) + both;
            let most = motor(lists[0], f) + motor(lists[1], b) + both;
            !(least..=most).contains(&total)
        }
        (Some(f), None) => rest(motor(lists[0], f)) == 0,
        (None, Some(b)) => rest(motor(lists[1], b)) == 0,
        (None, None) => total <= both,
    };
    if contradiction {
        let what = format!("lanes={total} contradicts the lanes of each direction, which are taken");
        notes.push(facts.note("lanes-contradict", Severity::Warning, &what));
    }
    match (forward, backward) {
        (Some(forward), Some(backward)) => Counts { forward, backward, both },
        (Some(f), None) => Counts { forward: f, backward: rest(motor(lists[0], f)).max(1), both },
        (None, Some(b)) => Counts { forward: rest(motor(lists[1], b)).max(1), backward: b, both },
        (None, None) => split(facts, total.saturating_sub(both), both, room, notes),
    }
}

/// Two-way traffic on `total` lanes besides those for both, where no tag tells the direction of each.
fn split(facts: &WayFacts<'_>, total: usize, both: usize, room: Option<f64>, notes: &mut Vec<Finding>) -> Counts {
    if total <= 1 && both == 0 {
        let wide = room.is_some_and(|width| width >= SURELY_TWO_LANES);
        if !wide {
            return Counts { forward: 0, backward: 0, both: 1 };
        }
        let what = "lanes=1 on a wide two-way road; a lane each way is assumed";
        notes.push(facts.note("lanes-guessed", Severity::Info, what));
        return Counts { forward: 1, backward: 1, both };
    }
    if total % 2 == 1 {
        let what = format!("no tag tells the direction of the middle one of {total} lanes; forward is assumed");
        notes.push(facts.note("lanes-guessed", Severity::Info, &what));
    }
    Counts { forward: total.div_ceil(2).max(1), backward: (total / 2).max(1), both }
}

fn without_total(
    facts: &WayFacts<'_>,
    [forward, backward]: [Option<usize>; 2],
    both: usize,
    room: Option<f64>,
    notes: &mut Vec<Finding>,
) -> Counts {
    if let (Some(forward), Some(backward)) = (forward, backward) {
        return Counts { forward, backward, both };
    }
    let nothing_said = forward.is_none() && backward.is_none() && both == 0;
    let counts = if nothing_said && is_single_track(facts, room) {
        Counts { forward: 0, backward: 0, both: 1 }
    } else {
        let usual = facts.usual.lanes.unwrap_or(1);
        Counts { forward: forward.unwrap_or(usual), backward: backward.unwrap_or(usual), both }
    };
    let what = match counts {
        Counts { both: 1, forward: 0, .. } => "no lanes tag; a single track for both directions is assumed".to_owned(),
        Counts { forward, backward, .. } => format!("no lanes tag; {forward} forward and {backward} backward assumed"),
    };
    notes.push(facts.note("lanes-guessed", Severity::Info, &what));
    counts
}

/// Whether two-way traffic shares one lane where no `lanes` tag tells it.
fn is_single_track(facts: &WayFacts<'_>, room: Option<f64>) -> bool {
    match room {
        Some(width) => width < TWO_LANES_FIT,
        None => {
            let narrow = facts.class == RoadClass::Track
                || matches!(facts.tags.get("service"), Some("driveway" | "alley" | "drive-through"));
            narrow && facts.usual.lanes.is_none()
        }
    }
}

/// A road that is open to motor vehicles keeps a lane for them, whatever its lists say.
fn keep_drivable(facts: &WayFacts<'_>, lanes: [&mut Vec<Strip>; 2], both: &[Strip], notes: &mut Vec<Finding>) {
    let driven = |strips: &[Strip]| strips.iter().any(|s| matches!(s.kind, StripKind::Drive | StripKind::Bus));
    if driven(both) || lanes.iter().any(|strips| driven(strips)) {
        return;
    }
    notes.push(facts.note("lanes-contradict", Severity::Warning, "its lane tags leave no lane for motor vehicles"));
    for strips in lanes {
        for strip in strips.iter_mut() {
            strip.kind = StripKind::Drive;
        }
    }
}
