//! What the loader takes a relation for.

use crate::osm::Tags;

/// What a relation is to the loader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RelationType {
    Lanelet,
    RegulatoryElement,
    /// An area.
    Multipolygon,
    Unknown,
}

impl RelationType {
    pub(super) fn of(tags: &Tags) -> Self {
        match tags.get("type") {
            Some("lanelet") => Self::Lanelet,
            Some("regulatory_element") => Self::RegulatoryElement,
            Some("multipolygon") => Self::Multipolygon,
            _ => Self::Unknown,
        }
    }
}

/// Whether the loader takes a way with these tags as a polygon.
pub fn is_area(tags: &Tags) -> bool {
    matches!(tags.get("area"), Some("yes" | "true" | "1"))
}
