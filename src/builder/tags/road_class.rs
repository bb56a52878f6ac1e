//! The class of a road, and the driving side.

use crate::osm::Tags;

/// The side of the road on which people drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DrivingSide {
    /// As in Japan and the United Kingdom.
    Left,
    /// As in Germany and the United States.
    #[default]
    Right,
}

/// The class of a road in the road hierarchy: the value of `highway`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RoadClass {
    /// `motorway`.
    Motorway,
    /// `trunk`.
    Trunk,
    /// `primary`.
    Primary,
    /// `secondary`.
    Secondary,
    /// `tertiary`.
    Tertiary,
    /// `unclassified`, and `road`.
    Unclassified,
    /// `residential`.
    Residential,
    /// `living_street`.
    LivingStreet,
    /// `service`.
    Service,
    /// `track`.
    Track,
}

/// Whether the way is a roundabout.
pub(crate) fn is_roundabout(tags: &Tags) -> bool {
    matches!(tags.get("junction"), Some("roundabout" | "circular"))
}

/// Whether a road is a priority road. So is the ring of a `junction=roundabout`; that of a `circular` one need not be.
pub fn is_priority_road(tags: &Tags) -> bool {
    tags.is("junction", "roundabout")
        || matches!(tags.get("priority_road"), Some("designated" | "yes_unposted" | "yes"))
}
