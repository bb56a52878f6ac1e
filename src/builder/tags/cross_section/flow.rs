//! Whether traffic runs one way or both ways, from `oneway` and what implies it.

use crate::builder::tags::road_class::{RoadClass, is_roundabout};

use super::WayFacts;

/// How motor traffic runs along a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow {
    /// Both ways, each on its own side.
    TwoWay,
    /// Only with the way.
    Forward,
    /// Only against the way.
    Backward,
    /// Now one way, now the other, all lanes alike.
    Reversible,
}

impl Flow {
    /// Whether all motor traffic runs one way.
    pub fn is_oneway(self) -> bool {
        matches!(self, Self::Forward | Self::Backward)
    }
}

/// The flow of a way.
pub(super) fn flow(facts: &WayFacts<'_>) -> Flow {
    let said = ["oneway:motorcar", "oneway:motor_vehicle", "oneway:vehicle", "oneway"]
        .iter()
        .find_map(|key| facts.tags.get(key));
    match said {
        Some("yes" | "true" | "1") => Flow::Forward,
        Some("-1" | "reverse") => Flow::Backward,
        Some("reversible" | "alternating") => Flow::Reversible,
        Some("no" | "false" | "0") => Flow::TwoWay,
        _ if facts.class == RoadClass::Motorway || is_roundabout(facts.tags) => Flow::Forward,
        _ => Flow::TwoWay,
    }
}
