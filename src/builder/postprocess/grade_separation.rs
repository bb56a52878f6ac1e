//! Lanes on another level: Autoware, which looks at the plane only, would wait for what passes over an intersection or
//! under it, unless the `right_of_way` element of the lane says that it need not.

use std::collections::BTreeMap;

use crate::builder::ids::{Ids, Key};
use crate::lanelet::index::{Reach, Thresholds};
use crate::lanelet::{
    Attributes, Lanelet, LaneletId, LaneletMap, Member, RegulatoryElement, RegulatoryElementId, Target, TurnDirection,
    index,
};

use super::map_editor::is_taken;

/// Lists every lane on another level as one that yields, for each lane of an intersection that would wait for it. Each
/// line of the map reaches as far as its place among `reaches` says.
pub fn ignore_other_levels(map: &mut LaneletMap, reaches: &[Option<Reach>]) {
    for (lane, others) in passing(map, reaches) {
        let own = map.lanelets.get(lane).map(|lanelet| lanelet.regulatory_elements.clone()).unwrap_or_default();
        let listing = |id: &RegulatoryElementId| {
            let element = map.regulatory_elements.get(*id);
            element.is_some_and(|e| e.subtype == "right_of_way" && e.lanelets("right_of_way").any(|own| own == lane))
        };
        let element = own.into_iter().find(listing).unwrap_or_else(|| added(map, lane));
        if let Some(element) = map.regulatory_elements.get_mut(element) {
            let yielding = |id| Member { role: "yield".into(), target: Target::Lanelet(id) };
            element.members.extend(others.into_iter().map(yielding));
        }
    }
}

/// For each lane of an intersection the lanes on another level for which it would wait.
fn passing(map: &LaneletMap, reaches: &[Option<Reach>]) -> BTreeMap<LaneletId, Vec<LaneletId>> {
    let mut waiting: BTreeMap<LaneletId, Vec<LaneletId>> = BTreeMap::new();
    let pairs = index::passing(map, reaches, &Thresholds::default(), |lanelet| waits(map, lanelet));
    for (lane, other) in pairs.into_iter().flat_map(|[x, y]| [(x, y), (y, x)]) {
        if map.lanelets.get(lane).is_some_and(|lanelet| waits(map, lanelet)) && !ignores(map, lane, other) {
            waiting.entry(lane).or_default().push(other);
        }
    }
    let place = |id: &LaneletId| map.lanelets.position(*id);
    waiting.values_mut().for_each(|others| others.sort_by_key(place));
    waiting
}

/// Whether a lane is part of an intersection and has no light for straight on, which lets Autoware wait for nobody.
fn waits(map: &LaneletMap, lanelet: &Lanelet) -> bool {
    let straight = lanelet.attributes.is("turn_direction", TurnDirection::Straight.as_str());
    lanelet.attributes.has("intersection_area") && !(straight && index::is_signalised(map, lanelet.id))
}

/// Whether a lane's own `right_of_way` element lists another as one that yields.
fn ignores(map: &LaneletMap, lane: LaneletId, other: LaneletId) -> bool {
    let own = map.lanelets.get(lane).into_iter().flat_map(|lanelet| &lanelet.regulatory_elements);
    let elements = own.filter_map(|&id| map.regulatory_elements.get(id)).filter(|e| e.subtype == "right_of_way");
    let mut listing = elements.filter(|e| e.lanelets("right_of_way").any(|own| own == lane));
    listing.any(|e| e.lanelets("yield").any(|id| id == other))
}

/// A `right_of_way` element of a lane that had none.
fn added(map: &mut LaneletMap, lane: LaneletId) -> RegulatoryElementId {
    let id =
        RegulatoryElementId(Ids::default().claim(Key::new("right of way").number(lane.0), |id| is_taken(map, *id)));
    map.regulatory_elements.insert(RegulatoryElement {
        id,
        subtype: "right_of_way".into(),
        members: vec![Member { role: "right_of_way".into(), target: Target::Lanelet(lane) }],
        attributes: Attributes::of(&[("type", "regulatory_element"), ("subtype", "right_of_way")]),
        span: None,
    });
    if let Some(lanelet) = map.lanelets.get_mut(lane) {
        lanelet.regulatory_elements.push(id);
    }
    id
}
