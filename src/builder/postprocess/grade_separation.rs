//! Lanes that pass over or under an intersection. Autoware compares lanes in the plane only and would wait for them, unless
//! the `right_of_way` element of its own lane lists them as yielding.

use std::collections::BTreeMap;

use crate::builder::ids::Key;
use crate::lanelet::index::Reach;
use crate::lanelet::{Lanelet, LaneletId, LaneletMap, Member, RegulatoryElementId, Target, TurnDirection, index};

use super::map_editor::{insert_element, is_taken, right_of_way_of};

/// Lists, for each lane of an intersection, the lanes on other levels that it would wait for as yielding. `reaches` holds the
/// extent of each linestring of the map.
pub fn ignore_other_levels(map: &mut LaneletMap, reaches: &[Option<Reach>]) {
    for (lane, others) in passing(map, reaches) {
        let existing = right_of_way_of(map, lane).next().map(|element| element.id);
        let element = existing.unwrap_or_else(|| add_right_of_way(map, lane));
        if let Some(element) = map.regulatory_elements.get_mut(element) {
            let yielding = |id| Member { role: "yield".into(), target: Target::Lanelet(id) };
            element.members.extend(others.into_iter().map(yielding));
        }
    }
}

/// For each lane of an intersection, the lanes on other levels that it would wait for.
fn passing(map: &LaneletMap, reaches: &[Option<Reach>]) -> BTreeMap<LaneletId, Vec<LaneletId>> {
    let mut passing: BTreeMap<LaneletId, Vec<LaneletId>> = BTreeMap::new();
    let pairs = index::passing(map, reaches, |lanelet| may_wait(map, lanelet));
    for (lane, other) in pairs.into_iter().flat_map(|[x, y]| [(x, y), (y, x)]) {
        if map.lanelets.get(lane).is_some_and(|lanelet| may_wait(map, lanelet)) && !ignores(map, lane, other) {
            passing.entry(lane).or_default().push(other);
        }
    }
    let position = |id: &LaneletId| map.lanelets.position(*id);
    passing.values_mut().for_each(|others| others.sort_by_key(position));
    passing
}

/// Whether Autoware may wait on a lane: it is part of an intersection and not a straight lane with a traffic light.
fn may_wait(map: &LaneletMap, lanelet: &Lanelet) -> bool {
    let straight = lanelet.attributes.is("turn_direction", TurnDirection::Straight.as_str());
    lanelet.attributes.has("intersection_area") && !(straight && index::is_signalised(map, lanelet.id))
}

/// Whether the `right_of_way` element of a lane lists another lane as yielding.
fn ignores(map: &LaneletMap, lane: LaneletId, other: LaneletId) -> bool {
    right_of_way_of(map, lane).any(|element| element.lanelets("yield").any(|id| id == other))
}

fn add_right_of_way(map: &mut LaneletMap, lane: LaneletId) -> RegulatoryElementId {
    let key = Key::new("right of way").number(lane.0);
    let id = RegulatoryElementId(key.id(|id| is_taken(map, id)));
    let owner = Member { role: "right_of_way".into(), target: Target::Lanelet(lane) };
    insert_element(map, id, "right_of_way", vec![owner], &[lane]);
    id
}
