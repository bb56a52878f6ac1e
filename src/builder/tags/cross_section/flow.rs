//! Whether a way is one-way: by `oneway`, its class and roundabouts.

use crate::builder::tags::road_class::{RoadClass, is_roundabout};

use super::WayFacts;

/// The directions of motor traffic on a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow {
    /// Both directions, each on its own side.
    TwoWay,
    /// Only along the way.
    Forward,
    /// Only against the way.
    Backward,
    /// One direction at a time, on all lanes.
    Reversible,
}

impl Flow {
    /// Whether all motor traffic runs in one direction.
    pub fn is_oneway(self) -> bool {
        matches!(self, Self::Forward | Self::Backward)
    }
}

/// The flow of a way.
pub(super) fn flow(facts: &WayFacts<'_>) -> Flow {
    let keys = ["oneway:motorcar", "oneway:motor_vehicle", "oneway:vehicle", "oneway"];
    match keys.iter().find_map(|key| facts.tags.get(key)) {
        Some("yes" | "true" | "1") => Flow::Forward,
        Some("-1" | "reverse") => Flow::Backward,
        Some("reversible" | "alternating") => Flow::Reversible,
        Some("no" | "false" | "0") => Flow::TwoWay,
        _ if facts.class == RoadClass::Motorway || is_roundabout(facts.tags) => Flow::Forward,
        _ => Flow::TwoWay,
    }
}
