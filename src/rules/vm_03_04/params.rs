//! The thresholds of the rule.

use serde::Deserialize;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    pub(super) border: f64,
    pub(super) near_miss: f64,
    pub(super) near_angle: f64,
    pub(super) map_border: f64,
    pub(super) stop_line: f64,
}
