//! What the constructors of Lanelet2's and Autoware's regulatory elements demand of their members.

use super::Target;

/// The kinds of primitive that count for a role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetKind {
    /// Linestrings.
    Line,
    /// Polygons.
    Polygon,
    /// Either.
    LineOrPolygon,
    /// Lanelets.
    Lanelet,
}

impl TargetKind {
    /// Whether a member with this target counts.
    pub const fn holds(self, target: Target) -> bool {
        match target {
            Target::Point(_) => false,
            Target::LineString(_) => matches!(self, Self::Line | Self::LineOrPolygon),
            Target::Polygon(_) => matches!(self, Self::Polygon | Self::LineOrPolygon),
            Target::Lanelet(_) => matches!(self, Self::Lanelet),
        }
    }

    /// The word for one of them.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Line => "linestring",
            Self::Polygon => "polygon",
            Self::LineOrPolygon => "linestring or polygon",
            Self::Lanelet => "lanelet",
        }
    }
}

/// How many members one role needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoleLimit {
    /// `refers`, `ref_line`, ...
    pub role: &'static str,
    /// What counts; members of other kinds do not.
    pub kind: TargetKind,
    /// At least.
    pub min: usize,
    /// At most.
    pub max: Option<usize>,
}

impl std::fmt::Display for RoleLimit {
    /// `exactly 1`, `at least 1`, `at most 1`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.min, self.max) {
            (min, Some(max)) if min == max => write!(f, "exactly {min}"),
            (0, Some(max)) => write!(f, "at most {max}"),
            (min, Some(max)) => write!(f, "{min} to {max}"),
            (min, None) => write!(f, "at least {min}"),
        }
    }
}

const fn some(role: &'static str, kind: TargetKind) -> RoleLimit {
    RoleLimit { role, kind, min: 1, max: None }
}

const fn one(role: &'static str, kind: TargetKind) -> RoleLimit {
    RoleLimit { role, kind, min: 1, max: Some(1) }
}

const fn optional(role: &'static str, kind: TargetKind) -> RoleLimit {
    RoleLimit { role, kind, min: 0, max: Some(1) }
}

use TargetKind::{Lanelet, Line, LineOrPolygon, Polygon};

/// Every subtype that has a constructor, with its limits. A role that is not named takes anything.
const LIMITS: &[(&str, &[RoleLimit])] = &[
    ("all_way_stop", &[]),
    ("bus_stop_area", &[some("refers", Polygon)]),
    ("crosswalk", &[]),
    ("detection_area", &[some("refers", Polygon), one("ref_line", Line)]),
    ("no_parking_area", &[some("refers", Polygon)]),
    ("no_stopping_area", &[some("refers", Polygon), optional("ref_line", Line)]),
    // Lanelet2's own name for an element without a class.
    ("regulatory_element", &[]),
    ("right_of_way", &[some("right_of_way", Lanelet), some("yield", Lanelet), optional("ref_line", Line)]),
    ("road_marking", &[one("refers", Line)]),
    ("roundabout", &[]),
    ("speed_bump", &[one("refers", Polygon)]),
    ("speed_limit", &[]),
    ("traffic_light", &[some("refers", LineOrPolygon), optional("ref_line", Line)]),
    ("traffic_sign", &[]),
    ("virtual_traffic_light", &[one("start_line", Line), some("end_line", Line)]),
];

/// The limits of a subtype; `None` if nobody has registered it, so that its creation throws.
pub fn role_limits(subtype: &str) -> Option<&'static [RoleLimit]> {
    LIMITS.iter().find(|(name, _)| *name == subtype).map(|(_, limits)| *limits)
}

/// All subtypes that can be created, in alphabetical order.
pub fn known_subtypes() -> impl Iterator<Item = &'static str> {
    LIMITS.iter().map(|(name, _)| *name)
}

/// Whether the element is one of the signs, whose type comes from `sign_type` or from the sign's own `subtype`.
pub(super) fn is_sign(subtype: &str) -> bool {
    matches!(subtype, "traffic_sign" | "speed_limit")
}
