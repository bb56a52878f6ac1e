//! vm-05-03: where vehicles slow down before a crosswalk, speed and distance are numbers.

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::number::number;

use super::NoParams;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let crosswalks = map.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "crosswalk"));
    let mut findings = Vec::new();
    for lanelet in crosswalks {
        let id = lanelet.id;
        for (fault, key) in [("speed", "safety_slow_down_speed"), ("distance", "safety_slow_down_distance")] {
            let Some(said) = lanelet.attributes.get(key) else { continue };
            // C takes `nan` for a number, and no comparison holds it.
            if number(said).is_none_or(|value| value <= 0.0) {
                let message = format!("{key}={said} of crosswalk {id} is no positive number.");
                findings.push(Finding::new(fault, Subject::Lanelet(id.0), message));
            }
        }
    }
    findings
}
