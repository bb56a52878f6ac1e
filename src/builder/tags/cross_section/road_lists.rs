//! Lists of lanes without a direction (`bus:lanes`) that name all lanes of a road.

use crate::builder::tags::admission::{Admitted, of_value};
use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::values::{is_yes, per_lane as entries};

use super::bus_tags::{counted_against, has_own_lane};
use super::facts::tagged_count;
use super::flow::{Flow, is_for_buses};
use super::{Travel, WayFacts};

/// Access tags for cars, from the most specific to the least.
pub(super) const MOTOR: [&str; 4] = ["motorcar:lanes", "motor_vehicle:lanes", "vehicle:lanes", "access:lanes"];
pub(super) const BUS: [&str; 2] = ["bus:lanes", "psv:lanes"];
/// Lists of which the entries mean nothing without the direction of their lane.
const OF_DIRECTION: [&str; 2] = ["turn:lanes", "change:lanes"];

/// The numbers of lanes of a road.
#[derive(Clone, Copy)]
struct Shares {
    forward: usize,
    backward: usize,
    both: usize,
}

/// The entries of a list of lanes.
pub(super) fn listed(value: &str) -> Vec<String> {
    entries(value).map(str::to_owned).collect()
}

/// The part of a list without a direction that is about the lanes of one direction, or of both: it names all lanes of the road, from left
/// to right along the way. So mappers tag who may use a lane and how wide it is.
pub(super) fn of_direction(facts: &WayFacts<'_>, travel: Travel, flow: Flow, key: &str) -> Option<Vec<String>> {
    let needs_direction = OF_DIRECTION.contains(&key) && (flow == Flow::TwoWay || flow.against() == Some(travel));
    let shares = shares(facts, flow).filter(|_| !needs_direction)?;
    let all = facts.tags.get(key).map(listed)?;
    let mut part = shares.part(facts.side, &all, travel)?.to_vec();
    if travel == Travel::Backward {
        part.reverse();
    }
    (!part.is_empty()).then_some(part)
}

/// Whether a list of a two-way road is given without a direction, and does not name all its lanes.
pub(super) fn is_without_direction(facts: &WayFacts<'_>, flow: Flow, key: &str) -> bool {
    let directed =
        [":forward", ":backward", ":both_ways"].iter().any(|suffix| facts.tags.get_joined([key, suffix]).is_some());
    let travels = [Travel::Forward, Travel::Backward, Travel::Both];
    facts.tags.has(key) && !directed && travels.iter().all(|travel| of_direction(facts, *travel, flow, key).is_none())
}

impl Shares {
    /// The entries about the lanes of a direction in a list of all lanes, from left to right along the way; `None` if it has not as many.
    fn part(self, side: DrivingSide, all: &[String], travel: Travel) -> Option<&[String]> {
        let Self { forward, backward, both } = self;
        if all.len() != forward + backward + both {
            return None;
        }
        let on_right = side == DrivingSide::Right;
        let left = if on_right { backward } else { forward };
        let (from, count) = match travel {
            Travel::Both => (left, both),
            Travel::Forward => (if on_right { left + both } else { 0 }, forward),
            Travel::Backward => (if on_right { 0 } else { left + both }, backward),
        };
        all.get(from..from + count)
    }
}

/// How many lanes lead where if lists without a direction may name all lanes that `lanes` counts.
fn shares(facts: &WayFacts<'_>, flow: Flow) -> Option<Shares> {
    let total = tagged_count(facts, "lanes").filter(|total| *total > 1)?;
    let tagged = |key| tagged_count(facts, key).filter(|n| *n > 0);
    let [forward, backward] = ["lanes:forward", "lanes:backward"].map(tagged);
    if flow == Flow::TwoWay {
        let both = tagged("lanes:both_ways").unwrap_or(0);
        let rest = total.checked_sub(both)?;
        let (forward, backward) = match (forward, backward) {
            (Some(forward), Some(backward)) => (forward, backward),
            (Some(forward), None) => (forward, rest.checked_sub(forward)?),
            (None, Some(backward)) => (rest.checked_sub(backward)?, backward),
            (None, None) => (rest.div_ceil(2), rest / 2),
        };
        return Some(Shares { forward, backward, both });
    }
    let against = flow.against()?;
    let told = if against == Travel::Forward { forward } else { backward };
    let counted = counted_against(facts, against);
    if told.or(counted).is_none() && !is_for_buses(facts, against) && !has_own_lane(facts, against) {
        return None;
    }
    let count = told.or(counted).unwrap_or(1);
    let along = total.checked_sub(count).filter(|along| *along > 0)?;
    let shares = match against {
        Travel::Forward => Shares { forward: count, backward: along, both: 0 },
        _ => Shares { forward: along, backward: count, both: 0 },
    };
    // If the lanes on the far side are not for buses, or all others are, the list is about the direction of the cars.
    let gives_to_buses = |key: &str, is_open: fn(&str) -> bool| {
        let all = facts.tags.get(key).map(listed).unwrap_or_default();
        let part = |travel| shares.part(facts.side, &all, travel);
        let leaves_cars = part(against.reversed()).is_some_and(|part| part.iter().any(|entry| entry != "designated"));
        leaves_cars && part(against).is_some_and(|part| part.iter().all(|entry| is_open(entry)))
    };
    let names_buses = |entry: &str| of_value(entry) == Some(Admitted::Buses);
    let given =
        BUS.iter().any(|key| gives_to_buses(key, is_yes)) || MOTOR.iter().any(|key| gives_to_buses(key, names_buses));
    given.then_some(shares)
}
