//! The thresholds of the rule, and whom its findings are about.

use crate::diagnostic::Subject;
use crate::lanelet::index::MapIndex;
use serde::Deserialize;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    pub(super) least_length: f64,
    pub(super) short_length: f64,
    pub(super) tilt: f64,
    pub(super) least_tilt: f64,
    pub(super) near_miss: f64,
    pub(super) gap: f64,
    pub(super) wide_gap: f64,
    pub(super) straight_on: f64,
    pub(super) shortest_loop: f64,
    pub(super) least_width: f64,
    pub(super) most_width: f64,
    pub(super) map_border: f64,
    pub(super) turning_place: f64,
}

pub(super) fn subject(map: &MapIndex, lane: usize) -> Subject {
    Subject::Lanelet(map.lanes[lane].id.0)
}
