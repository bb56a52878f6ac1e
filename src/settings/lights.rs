//! `[lights]` of `lanewright.toml`: what `build` knows of traffic lights beyond OpenStreetMap.

use serde::{Deserialize, Serialize};

/// How traffic lights look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LightSettings {
    /// Lanes from which all movements go one way have lights with an arrow; they look like all others without it.
    pub arrows: Option<bool>,
}
