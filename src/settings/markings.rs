//! `[markings]` of `lanewright.toml`: what `build` paints where OpenStreetMap's tags are silent.

use serde::{Deserialize, Serialize};

/// What is painted where the tags are silent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MarkingSettings {
    /// How far before a stop line lanes are no longer changed, metres; 0 for not at all, the usual of the country where
    /// absent.
    pub before_stop: Option<f64>,
}
