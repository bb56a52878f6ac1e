//! The class of a road in the road hierarchy, and the side of the road on which people drive.

use crate::osm::Tags;

/// Which side of the road people drive on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DrivingSide {
    /// As in Japan and the United Kingdom.
    Left,
    /// As in Germany and the United States.
    #[default]
    Right,
}

/// What a road is in the road hierarchy, from `highway`.
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

/// Whether the way is a ring that is driven round.
pub(crate) fn is_roundabout(tags: &Tags) -> bool {
    matches!(tags.get("junction"), Some("roundabout" | "circular"))
}

/// Whether a road is a priority road: `priority_road`, other than `no` and the `end` of one.
pub fn is_priority_road(tags: &Tags) -> bool {
    matches!(tags.get("priority_road"), Some("designated" | "yes_unposted" | "yes"))
}
