//! `[beside]` of `lanewright.toml`: what `build` draws beside the lanes for cars.

use serde::{Deserialize, Serialize};

/// What is drawn beside the lanes for cars, where OpenStreetMap's tags speak of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BesideSettings {
    /// Lanes for bicycles.
    pub bicycle_lanes: BicycleLanes,
    /// Shoulders, as `road_shoulder`.
    pub shoulders: bool,
    /// Rows of parked cars, as `road_shoulder`.
    pub parking: bool,
    /// Painted strips for people on foot, as `pedestrian_lane`.
    pub pedestrian_lanes: bool,
    /// Sidewalks where a way onto private ground crosses them, as `walkway`.
    pub walkways: bool,
}

impl Default for BesideSettings {
    fn default() -> Self {
        Self {
            bicycle_lanes: BicycleLanes::BicycleLane,
            shoulders: true,
            parking: true,
            pedestrian_lanes: true,
            walkways: true,
        }
    }
}

/// How a lane for bicycles is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BicycleLanes {
    /// As a lanelet of subtype `bicycle_lane`: format 2.
    #[default]
    BicycleLane,
    /// As a lanelet of subtype `road` that only its like continue: formats before.
    Road,
    /// Not at all.
    None,
}
