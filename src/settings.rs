//! `lanewright.toml`: what a map cannot say about itself. The builder writes it beside the map, the checks read it.

use serde::{Deserialize, Serialize};

/// The whole file. Every key may be missing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// `left`, `right`, or `auto`: from the map itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub driving_side: Option<Side>,
    /// What is known of single intersections.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub intersection: Vec<IntersectionSettings>,
}

/// Which side of the road people drive on, as a user says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Whatever the map shows.
    Auto,
    /// As in Japan.
    Left,
    /// As in Germany.
    Right,
}

/// One approach of an intersection, in a user's words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ApproachName {
    /// The side of the intersection on which the approach lies: `N`, `NE`, `E`, `SE`, `S`, `SW`, `W`, `NW`.
    Compass(String),
    /// Ids of lanelets or regulatory elements that belong to it.
    Ids(Vec<i64>),
    /// One such id.
    Id(i64),
}

/// What is known of one intersection.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IntersectionSettings {
    /// Which one: id of its `intersection_area` polygon.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ia: Option<i64>,
    /// Which one: a place inside it, latitude and longitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 2]>,
    /// Approaches that are green together, phase by phase.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<Vec<ApproachName>>,
    /// Approaches of the road with priority, where no signal rules.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub priority_arms: Vec<ApproachName>,
    /// Movements that must not exist: from one approach to another.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub prohibited: Vec<[ApproachName; 2]>,
    /// Ids of ways that are guide lines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub guide_lines: Vec<i64>,
}
