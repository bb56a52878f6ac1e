//! Lanes on another level: Autoware, which looks at the plane only, would wait for what passes over an intersection or
//! under it, unless the `right_of_way` element of the lane says that it need not.

use std::collections::BTreeMap;

use crate::lanelet::index::{MapIndex, Thresholds};
use crate::lanelet::{LaneletId, LaneletMap, Member, RegulatoryElement, RegulatoryElementId, Target};
use crate::settings::Settings;

use super::assembly::tags;
use super::ids::{Ids, Key};

/// Lists every lane on another level as one that yields, for each lane of an intersection that would wait for it.
pub fn ignore(map: &mut LaneletMap) {
    let thresholds = Thresholds::default();
    let heights = map.points.iter().filter_map(|point| point.ele);
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    // Most maps are flat.
    if high - low <= thresholds.grade_separation {
        return;
    }
    for (lane, others) in passing(map, thresholds) {
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
fn passing(map: &LaneletMap, thresholds: Thresholds) -> BTreeMap<LaneletId, Vec<LaneletId>> {
    let settings = Settings::default();
    let index = MapIndex::new(map, &[], &settings, thresholds);
    let mut passing: BTreeMap<LaneletId, Vec<LaneletId>> = BTreeMap::new();
    for lane in (0..index.lanes.len()).filter(|&lane| index.movement(lane).is_some() && index.lanes[lane].vehicle) {
        let watched = index.attention(lane);
        let apart = index.conflicts[lane].iter().filter(|conflict| conflict.grade_separated);
        let apart = apart.filter(|conflict| index.lanes[conflict.other].vehicle && watched.contains(&conflict.other));
        let others: Vec<LaneletId> = apart.map(|conflict| index.lanes[conflict.other].id).collect();
        if !others.is_empty() {
            passing.insert(index.lanes[lane].id, others);
        }
    }
    passing
}

/// A `right_of_way` element of a lane that had none.
fn added(map: &mut LaneletMap, lane: LaneletId) -> RegulatoryElementId {
    let taken = |id: &u64| {
        let id = *id as i64;
        map.lanelets.get(LaneletId(id)).is_some()
            || map.regulatory_elements.get(RegulatoryElementId(id)).is_some()
            || map.points.get(crate::lanelet::PointId(id)).is_some()
            || map.linestrings.get(crate::lanelet::LineStringId(id)).is_some()
    };
    let id = RegulatoryElementId(Ids::default().claim(Key::new("right of way").number(lane.0), taken));
    map.regulatory_elements.insert(RegulatoryElement {
        id,
        subtype: "right_of_way".into(),
        members: vec![Member { role: "right_of_way".into(), target: Target::Lanelet(lane) }],
        attributes: tags(&[("type", "regulatory_element"), ("subtype", "right_of_way")]),
        span: None,
    });
    if let Some(lanelet) = map.lanelets.get_mut(lane) {
        lanelet.regulatory_elements.push(id);
    }
    id
}
