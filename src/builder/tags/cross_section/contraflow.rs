//! Lanes against a one-way road: bus lanes in every spelling, and what lists of lanes say.

use crate::diagnostic::{Finding, Severity};

use super::bus_tags::{bus_lane_along, counted_against, has_own_lane};
use super::facts::{MAX_LANES, tagged_count};
use super::flow::{Flow, is_for_buses};
use super::per_lane::PerLane;
use super::{Travel, WayFacts};

/// How many lanes lead against a one-way road; the lists hold the `:lanes` tags of the road's own direction and of the other.
pub(super) fn lanes_against(facts: &WayFacts<'_>, flow: Flow, lists: [&PerLane; 2], notes: &mut Vec<Finding>) -> usize {
    let Some(against) = flow.against() else { return 0 };
    let [along, list] = lists;
    let tagged = tagged_count(facts, if against == Travel::Forward { "lanes:forward" } else { "lanes:backward" });
    let tagged = tagged.filter(|n| *n > 0);
    let total = tagged_count(facts, "lanes");
    let for_buses = |n| list.special_lanes(n) > 0 || list.admits_buses(n) && total.is_none_or(|total| n < total);
    let listed = list.longest().filter(|&n| for_buses(n));
    let own_lane = has_own_lane(facts, against);
    let of_buses = counted_against(facts, against);
    // Who makes two ways of one often leaves the lists of both directions on each.
    let fills = |total: usize| along.longest().is_some_and(|own| own >= total);
    if listed.is_some() && tagged.is_none() && of_buses.is_none() && !own_lane && total.is_some_and(fills) {
        let what = "it is one-way, and its own lanes are all that `lanes` counts, so the lists of lanes against it are not built";
        notes.push(facts.note("lanes-contradict", Severity::Warning, what));
        return 0;
    }
    if listed.is_some() || of_buses.is_some() || own_lane {
        let matching = list.matching(tagged);
        return matching.or(listed).or(tagged).unwrap_or(1).max(of_buses.unwrap_or(0)).min(MAX_LANES);
    }
    if !is_for_buses(facts, against) {
        if let Some(n) = tagged {
            let what = format!("it is one-way, so the {n} lanes against it are not built");
            notes.push(facts.note("lanes-contradict", Severity::Warning, &what));
        }
        return 0;
    }
    match (tagged, total) {
        (Some(n), _) => n,
        (None, Some(total)) if total <= 1 + usize::from(bus_lane_along(facts, against)) => {
            let what = "`lanes` leaves no lane for the buses that drive against it; their direction is not built";
            notes.push(facts.note("lanes-guessed", Severity::Info, what));
            0
        }
        (None, total) => {
            if total.is_none() {
                let what = "no lanes tag; a lane for the buses that drive against it is assumed";
                notes.push(facts.note("lanes-guessed", Severity::Info, what));
            }
            1
        }
    }
}
