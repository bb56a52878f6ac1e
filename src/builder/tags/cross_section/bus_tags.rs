//! What the tags of buses say of a road: `lanes:bus`, `lanes:psv`, `busway`, lanes against a one-way road.

use crate::builder::tags::admission::OPPOSITE;
use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::values::number_of;
use crate::diagnostic::{Finding, Severity};

use super::facts::MAX_LANES;
use super::flow::is_for_buses;
use super::{Travel, WayFacts};

/// The number of bus lanes by `lanes:bus` and `lanes:psv`, with this suffix.
pub(super) fn count(facts: &WayFacts<'_>, suffix: &str) -> Option<usize> {
    let value = ["lanes:bus", "lanes:psv"].iter().find_map(|key| facts.tags.get_joined([key, suffix]))?;
    number_of(value).filter(|n| *n >= 1.0).map(|n| (n as usize).min(MAX_LANES))
}

/// The keys of bus lanes on one side of a road.
pub(super) const SIDES: [&str; 2] = ["busway:left", "busway:right"];

/// Whether the bus lane of this key, on one side of a one-way road, leads against the road.
pub(super) fn leads_against(facts: &WayFacts<'_>, side: &str, against: Travel) -> bool {
    let tags = facts.tags;
    let is_lane = SIDES.contains(&side) && tags.get(side).or_else(|| tags.get("busway:both")) == Some("lane");
    if !is_lane {
        return false;
    }
    let one_way = tags.get_joined([side, ":oneway"]);
    let backward = against == Travel::Backward;
    match one_way {
        Some("-1") => backward,
        Some("yes" | "1") => !backward,
        Some("no") => false,
        // On the far side of a road on which buses drive both ways.
        _ => {
            let far_side = (side == "busway:left") == backward;
            let is_far = far_side == (facts.side == DrivingSide::Right);
            is_far && is_for_buses(facts, against)
        }
    }
}

/// The number of bus lanes against a one-way road by `lanes:bus` and `lanes:psv`. Of a number for both directions half, and at
/// least one, belong to the buses that drive against it.
pub(super) fn counted_against(facts: &WayFacts<'_>, against: Travel) -> Option<usize> {
    let [own, other] = [":forward", ":backward"].map(|suffix| count(facts, suffix));
    let (here, there) = if against == Travel::Forward { (own, other) } else { (other, own) };
    let shared = || count(facts, "").filter(|_| there.is_none() && is_for_buses(facts, against));
    here.or_else(|| shared().map(|all| (all / 2).max(1)))
}

/// Whether a tag names a lane of buses against the one-way road.
pub(super) fn has_own_lane(facts: &WayFacts<'_>, against: Travel) -> bool {
    let opposite = OPPOSITE.iter().any(|key| facts.tags.is(key, "opposite_lane"));
    opposite || SIDES.iter().any(|key| leads_against(facts, key, against))
}

/// Whether `busway` names a bus lane in the direction of a one-way road at its near side; `against` is the other direction.
pub(super) fn bus_lane_along(facts: &WayFacts<'_>, against: Travel) -> bool {
    let [left, right] = SIDES;
    let near = if (facts.side == DrivingSide::Right) == (against == Travel::Backward) { right } else { left };
    ["busway", "busway:both", near].iter().any(|key| facts.tags.is(key, "lane"))
}

/// A note if buses have a track of their own beside the road, for which nothing is built.
pub(super) fn on_own_track(facts: &WayFacts<'_>) -> Option<Finding> {
    let is_track = |key: &str| matches!(facts.tags.get(key), Some("track" | "opposite_track" | "separate"));
    let key = ["busway", "busway:both"].into_iter().chain(SIDES).find(|key| is_track(key))?;
    let what =
        format!("{key}={} lies beside the road; no lane is built for it", facts.tags.get(key).unwrap_or_default());
    Some(facts.note("lanes-guessed", Severity::Info, &what))
}
