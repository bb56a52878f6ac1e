//! Reads the lanes for motor vehicles: their number in each direction, and the `:lanes` tags of each.

use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::builder::tags::values::metres_under;
use crate::diagnostic::{Finding, Severity};
use crate::osm::Tags;

use super::bus_lanes::{self, mark_bus_lanes};
use super::bus_tags::{count, on_own_track};
use super::contraflow::lanes_against;
use super::facts::{MAX_LANES, MAX_SINGLE_TRACK, default_lane, tagged_count};
use super::flow::{Flow, closed_direction};
use super::per_lane::{PerLane, per_lane};
use super::{Assumed, Strip, StripKind, Travel, WayFacts, minimum_lane_width};

/// The lanes of a way from left to right along it.
pub(super) type Lanes = Vec<Strip>;

/// Without a `lanes` tag, a two-way carriageway narrower than this, metres, has one lane: two cars with their mirrors do not fit.
const TWO_LANES_FIT: f64 = 4.8;

/// With `lanes=1`, a two-way carriageway at least this wide, metres, has an unmarked lane in each direction.
const SURELY_TWO_LANES: f64 = 5.5;

/// The numbers of lanes forward, backward, and for both directions in the middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counts {
    forward: usize,
    backward: usize,
    both: usize,
}

impl Counts {
    /// Takes a direction from cars: its lanes become lanes of this kind. A road without tagged lanes has none for nobody; of a
    /// single track the other direction is left.
    fn close(&mut self, travel: Travel, kind: StripKind, told: bool) {
        let single = self.forward == 0 && self.backward == 0;
        let (open, closed) = match travel {
            Travel::Forward => (&mut self.backward, &mut self.forward),
            _ => (&mut self.forward, &mut self.backward),
        };
        if single {
            *open = std::mem::take(&mut self.both);
        } else if kind == StripKind::Buffer && !told {
            *closed = 0;
        }
    }
}

/// Reads the lanes of a way. `beside` is the width of parking and bicycle lanes on its carriageway, metres.
pub(super) fn lanes(facts: &WayFacts<'_>, flow: Flow, beside: f64, notes: &mut Vec<Finding>) -> Lanes {
    let room = metres_under(facts.tags, ["width:carriageway", "width", "est_width"]).map(|width| width - beside);
    let fits = |it: &&Assumed| !tells_lanes(facts.tags) && fit(facts.class, it.lanes.len(), room);
    if let Some(assumed) = facts.continued.filter(fits) {
        let what = format!("no lanes tag; as many as {} are assumed", assumed.like);
        notes.push(facts.note("lanes-guessed", Severity::Info, &what));
        return assumed.lanes.iter().map(|&(kind, travel)| Strip { kind, ..default_lane(facts, travel) }).collect();
    }
    let before = notes.len();
    notes.extend(on_own_track(facts));
    let forward_list = per_lane(facts, Travel::Forward, flow, tagged_count(facts, "lanes:forward"), notes);
    let backward_list = per_lane(facts, Travel::Backward, flow, tagged_count(facts, "lanes:backward"), notes);
    let both_list = per_lane(facts, Travel::Both, flow, tagged_count(facts, "lanes:both_ways"), notes);
    let closed = closed_direction(facts);
    let for_both = count(facts, ":both_ways").unwrap_or(0);
    let mut counts = numbers(facts, flow, [&forward_list, &backward_list, &both_list], room, notes);
    if let (Some((travel, kind)), Flow::TwoWay | Flow::Alternating) = (closed, flow) {
        counts.close(travel, kind, tells_lanes(facts.tags));
    }
    // Against a one-way road only buses drive.
    let closed = closed.map(|(travel, kind)| (travel, if flow.is_oneway() { StripKind::Bus } else { kind }));
    let closed = closed.or_else(|| flow.against().map(|against| (against, StripKind::Bus)));
    let strips = |count, travel, list: &PerLane| -> Vec<Strip> {
        let mut strips = vec![default_lane(facts, travel); count];
        list.apply(&mut strips, &facts.usual);
        if let Some((_, kind)) = closed.filter(|(closed, _)| *closed == travel) {
            strips.iter_mut().filter(|strip| strip.kind == StripKind::Drive).for_each(|strip| strip.kind = kind);
        }
        strips
    };
    let mut forward = strips(counts.forward, Travel::Forward, &forward_list);
    let mut backward = strips(counts.backward, Travel::Backward, &backward_list);
    let mut both = strips(counts.both, Travel::Both, &both_list);
    both.iter_mut().take(for_both).for_each(|strip| strip.kind = StripKind::Bus);
    mark_bus_lanes(facts, flow, [&mut forward, &mut backward], [&forward_list, &backward_list]);
    keep_drivable(facts, [&mut forward, &mut backward], &both, notes);
    backward.reverse();
    let (left, right) = match facts.side {
        DrivingSide::Right => (backward, forward),
        DrivingSide::Left => (forward, backward),
    };
    let mut all = [left, both, right].concat();
    if notes.iter().skip(before).all(|note| !note.fault.starts_with("lanes-")) {
        notes.extend(of_other_number(facts, &all));
    }
    let ways = ["cycleway", "cycleway:left", "cycleway:right", "cycleway:both"];
    let against = flow.against().filter(|_| ways.iter().any(|key| facts.tags.is(key, "opposite_share_busway")));
    for strip in &mut all {
        strip.bicycles = strip.kind == StripKind::Bus && (strip.bicycles || against == Some(strip.travel));
    }
    all
}

/// The numbers of lanes; the lists are those of the forward and the backward direction and of both.
fn numbers(
    facts: &WayFacts<'_>,
    flow: Flow,
    lists: [&PerLane; 3],
    room: Option<f64>,
    notes: &mut Vec<Finding>,
) -> Counts {
    let [forward_list, backward_list, both_list] = lists;
    let (along, against) = match flow {
        Flow::TwoWay => return two_way(facts, lists, room, notes),
        Flow::Alternating => {
            return Counts { forward: 0, backward: 0, both: one_way(facts, flow, [both_list; 2], 0, notes) };
        }
        Flow::Forward => (forward_list, backward_list),
        Flow::Backward => (backward_list, forward_list),
    };
    let both = count(facts, ":both_ways").unwrap_or(0);
    let of_against = lanes_against(facts, flow, [along, against], notes);
    let of_along = one_way(facts, flow, [along, against], of_against + both, notes);
    match flow {
        Flow::Backward => Counts { forward: of_against, backward: of_along, both },
        _ => Counts { forward: of_along, backward: of_against, both },
    }
}

/// A note if `lanes` counts more or fewer lanes than there are. Bicycle lanes never count, and bus lanes not for all mappers.
fn of_other_number(facts: &WayFacts<'_>, lanes: &[Strip]) -> Option<Finding> {
    let total = tagged_count(facts, "lanes").filter(|n| *n > 0)?;
    let built = lanes.iter().filter(|strip| strip.kind != StripKind::Bicycle).count();
    let of_buses = lanes.iter().filter(|strip| strip.kind == StripKind::Bus).count();
    let what = || format!("lanes={total}, though the tags of its lanes make {built}, which are built");
    (built != total && built != total + of_buses).then(|| facts.note("lanes-guessed", Severity::Info, &what()))
}

/// Whether a tag gives the number or the use of lanes.
pub(crate) fn tells_lanes(tags: &Tags) -> bool {
    let about_lanes =
        |key: &str| key == "lanes" || key.starts_with("lanes:") || key.contains(":lanes") || key.starts_with("busway");
    tags.iter().any(|(key, _)| about_lanes(key))
}

/// Whether lanes fit a carriageway of this width, metres, if it is known.
fn fit(class: RoadClass, lanes: usize, room: Option<f64>) -> bool {
    let each = minimum_lane_width(class)..=MAX_SINGLE_TRACK;
    room.is_none_or(|width| each.contains(&(width / lanes as f64)))
}

/// The lanes of a one-way road in its direction, beside `against` lanes that lead against it. The lists are those of either
/// direction.
fn one_way(
    facts: &WayFacts<'_>,
    flow: Flow,
    [list, list_against]: [&PerLane; 2],
    against: usize,
    notes: &mut Vec<Finding>,
) -> usize {
    // `lanes` counts no bicycle lanes.
    let motor = against.saturating_sub(list_against.bicycle_lanes(against));
    let tagged = tagged_count(facts, "lanes").filter(|n| *n > 0).map(|n| n.saturating_sub(motor).max(1));
    let directed = match flow {
        Flow::Forward => tagged_count(facts, "lanes:forward"),
        Flow::Backward => tagged_count(facts, "lanes:backward"),
        _ => tagged_count(facts, "lanes:both_ways"),
    };
    let count = directed.or(tagged);
    if let (Some(n), None, Some((key, entries))) = (count, directed, count.and_then(|n| list.misfit(n))) {
        let what = format!("{key} is a list of {entries}, and `lanes` leaves {n} in its direction: these are taken");
        notes.push(facts.note("lanes-contradict", Severity::Warning, &what));
    }
    if let Some(n) = list.matching(count).or(count.filter(|n| *n > 0)).or(list.longest()) {
        return n.min(MAX_LANES);
    }
    let major = facts.class <= RoadClass::Trunk && !facts.link && flow != Flow::Alternating;
    let n = facts.usual.lanes.unwrap_or(if major { 2 } else { 1 });
    notes.push(facts.note("lanes-guessed", Severity::Info, &format!("no lanes tag; {n} one-way assumed")));
    n
}

fn two_way(facts: &WayFacts<'_>, lists: [&PerLane; 3], room: Option<f64>, notes: &mut Vec<Finding>) -> Counts {
    let [of_forward, of_backward, of_both] = lists;
    let [forward, backward] = [(of_forward, "lanes:forward"), (of_backward, "lanes:backward")].map(|(list, key)| {
        let tagged = tagged_count(facts, key).filter(|n| *n > 0);
        list.matching(tagged).or(tagged).or(list.longest()).map(|n| n.min(MAX_LANES))
    });
    let centre = usize::from(facts.tags.is("centre_turn_lane", "yes")).max(count(facts, ":both_ways").unwrap_or(0));
    let both = tagged_count(facts, "lanes:both_ways").or(of_both.longest()).unwrap_or(centre).min(MAX_LANES);
    let Some(total) = tagged_count(facts, "lanes").filter(|n| *n > 0) else {
        return without_total(facts, [forward, backward], both, room, notes);
    };
    // Lists may include bicycle lanes, which `lanes` does not count, and bus lanes, which some mappers do not count.
    let motor = |list: &PerLane, count: usize| count.saturating_sub(list.bicycle_lanes(count));
    let rest = |list: &PerLane, count: usize| total.saturating_sub(both + motor(list, count));
    let contradiction = match (forward, backward) {
        (Some(f), Some(b)) => {
            let special = of_forward.special_lanes(f) + of_backward.special_lanes(b);
            let least = (f + b).saturating_sub(special) + both;
            let of_buses: usize = bus_lanes::counted(facts, Flow::TwoWay).iter().flatten().sum();
            let most = motor(of_forward, f) + motor(of_backward, b) + both + of_buses;
            !(least..=most).contains(&total)
        }
        (Some(f), None) => rest(of_forward, f) == 0,
        (None, Some(b)) => rest(of_backward, b) == 0,
        (None, None) => total < both + 2 && total != both && facts.tags.has("lanes:both_ways"),
    };
    if contradiction {
        let what = format!("lanes={total} contradicts the lanes of each direction, which are taken");
        notes.push(facts.note("lanes-contradict", Severity::Warning, &what));
    }
    match (forward, backward) {
        (Some(forward), Some(backward)) => Counts { forward, backward, both },
        (Some(f), None) => Counts { forward: f, backward: rest(of_forward, f).max(1), both },
        (None, Some(b)) => Counts { forward: rest(of_backward, b).max(1), backward: b, both },
        (None, None) if total == both => Counts { forward: 0, backward: 0, both },
        (None, None) => split(facts, total.saturating_sub(both), both, room, notes),
    }
}

/// Splits `total` lanes of two-way traffic, besides those for both directions, without tags for each direction.
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
    if total > 1 && total % 2 == 1 {
        // A bus lane on one side only is the lane that this direction has more.
        match bus_lanes::on_sides(facts) {
            [false, true] => return Counts { forward: total / 2, backward: total.div_ceil(2), both },
            [true, false] => {}
            _ => {
                let what = format!("no tag tells the direction of the middle one of {total} lanes; forward is assumed");
                notes.push(facts.note("lanes-guessed", Severity::Info, &what));
            }
        }
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
    let untagged = forward.is_none() && backward.is_none() && both == 0;
    let counts = if untagged && is_single_track(facts, room) {
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

/// Whether a two-way road without lane tags has a single lane.
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

/// Turns all lanes into lanes for cars if the tags leave none for motor vehicles.
fn keep_drivable(facts: &WayFacts<'_>, lanes: [&mut Vec<Strip>; 2], both: &[Strip], notes: &mut Vec<Finding>) {
    let has =
        |is_wanted: fn(&Strip) -> bool| both.iter().chain(lanes.iter().flat_map(|strips| strips.iter())).any(is_wanted);
    let [of_cars, driven] = [has(|strip| strip.kind == StripKind::Drive), has(|strip| strip.kind.is_driven())];
    if driven {
        if !of_cars && !facts.bus_road {
            notes.push(facts.note(
                "lanes-contradict",
                Severity::Warning,
                "its lane tags leave no lane for cars, only for buses",
            ));
        }
        return;
    }
    notes.push(facts.note("lanes-contradict", Severity::Warning, "its lane tags leave no lane for motor vehicles"));
    for strips in lanes {
        for strip in strips.iter_mut() {
            strip.kind = StripKind::Drive;
        }
    }
}
