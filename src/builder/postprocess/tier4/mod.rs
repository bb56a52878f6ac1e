//! A map for TIER IV's validator, where it asks for other than Autoware's documents.
//!
//! Each change is safe by Autoware's documents: a vehicle drives more slowly than it might, or waits where it need not.

mod bus_lanes;
mod idle_areas;
mod lanes_seen;
mod lights;
mod yields;

use rustc_hash::FxHashSet;

use super::map_editor::drop_elements;
use crate::lanelet::lane_change::{SIDES, is_said_by_side};
use crate::lanelet::{Attributes, LaneletId, LaneletMap, LineStringId, RegulatoryElement};
use crate::settings::Settings;

/// The highest speed limit that the validator takes, km/h.
const SPEED_MOST: u32 = 80;

/// Changes a map, and what is known of its intersections, as the validator reads the requirements.
pub fn suit_validator(map: &mut LaneletMap, settings: &mut Settings) {
    lower_speed_limits(map);
    close_one_sided_borders(map);
    drop_give_way_elements(map);
    retag_walkways(map);
    bus_lanes::retag_bus_lanes(map);
    lights::turn_lights(map);
    idle_areas::drop_idle_areas(map, settings);
    yields::suit_validator(map);
}

fn lower_speed_limits(map: &mut LaneletMap) {
    for lanelet in map.lanelets.as_mut_slice() {
        let limit = lanelet.attributes.get("speed_limit").and_then(|value| value.parse::<f64>().ok());
        if limit.is_some_and(|limit| limit > f64::from(SPEED_MOST)) {
            lanelet.attributes.set("speed_limit", SPEED_MOST.to_string());
        }
    }
}

/// Closes borders that are open to one side: the validator asks for `lane_change`, beside which the tags of the sides do not count.
fn close_one_sided_borders(map: &mut LaneletMap) {
    for line in map.linestrings.as_mut_slice() {
        if is_said_by_side(&line.attributes) && SIDES.iter().any(|key| line.attributes.has(key)) {
            let others: Vec<(&str, &str)> = line.attributes.iter().filter(|(key, _)| !SIDES.contains(key)).collect();
            line.attributes = Attributes::of(&[&others[..], &[("lane_change", "no")]].concat());
        }
    }
}

/// Takes out the elements of give-way signs: the validator takes each sign for one at which vehicles halt. Autoware passes
/// these, and vehicles wait for others at their stop line all the same.
fn drop_give_way_elements(map: &mut LaneletMap) {
    let halts =
        |id: LineStringId| map.linestrings.get(id).is_some_and(|sign| sign.attributes.is("subtype", "stop_sign"));
    let passed =
        |element: &&RegulatoryElement| element.subtype == "traffic_sign" && !element.linestrings("refers").all(halts);
    let dropped: FxHashSet<_> = map.regulatory_elements.iter().filter(passed).map(|element| element.id).collect();
    drop_elements(map, &dropped);
}

/// Makes crosswalks of the walkways that elements announce: to the validator an element of anything else is wrong, and Autoware
/// treats both alike.
fn retag_walkways(map: &mut LaneletMap) {
    let elements = map.regulatory_elements.iter().filter(|element| element.subtype == "crosswalk");
    let announced: Vec<LaneletId> = elements.flat_map(|element| element.lanelets("refers")).collect();
    for id in announced {
        if let Some(lanelet) = map.lanelets.get_mut(id) {
            lanelet.attributes.set("subtype", "crosswalk");
        }
    }
}
