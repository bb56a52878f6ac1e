//! planner: what Autoware's planner will make of an intersection, where that is hardly meant.

mod pairs;
mod sight;
mod stops;
mod watching;

use rayon::prelude::*;
use serde::Deserialize;

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;
use crate::parallel::InSmallParts;
use crate::planner;

use watching::Watching;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    attention_area_length: f64,
    default_stopline_margin: f64,
    wheel_base: f64,
    front_overhang: f64,
    rear_overhang: f64,
    vehicle_width: f64,
    map_border: f64,
}

impl Params {
    /// Autoware's usual parameters but for those that the rule has.
    fn of_autoware(&self) -> planner::Params {
        planner::Params {
            attention_area_length: self.attention_area_length,
            default_stopline_margin: self.default_stopline_margin,
            wheel_base: self.wheel_base,
            front_overhang: self.front_overhang,
            rear_overhang: self.rear_overhang,
            wheel_tread: self.vehicle_width,
            left_overhang: 0.0,
            right_overhang: 0.0,
            ..planner::Params::default()
        }
    }
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let all = Watching::new(map, params.of_autoware());
    let turns = all.turns.as_slice().par_iter().in_small_parts();
    let mut findings: Vec<Finding> = turns.flat_map_iter(|&at| stops::judge(&all, at)).collect();
    findings.extend(pairs::judge(&all));
    findings.extend(sight::judge(&all, params.map_border));
    findings
}
