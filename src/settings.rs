//! `lanewright.toml`: what a map cannot say about itself, and how its owner wants it judged. The builder writes the former
//! beside the map, the checks read both.

mod beside;
mod document;
mod inside;
mod lights;
mod loose_ends;
mod markings;
mod merge;
mod roads;
mod selection;
mod suppression;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use beside::{BesideSettings, BicycleLanes};
pub use document::{Document, DocumentError, Step};
pub use inside::{GuideLine, InsideSettings, Place, VirtualLightSettings};
pub use lights::LightSettings;
pub use loose_ends::LooseEnds;
pub use markings::MarkingSettings;
pub use merge::MergeSettings;
pub use roads::{AssumeSettings, Highway, RoadSettings};
pub use selection::{Selection, covers, most_specific};
pub use suppression::{Origin, PrimitiveKind, Suppression};

use crate::diagnostic::Severity;

/// The whole file. Every key may be missing; a key of `None` is not written, because TOML has no word for it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// `left`, `right`, or `auto`: from the map itself.
    pub driving_side: Option<Side>,
    /// Whose reading of the requirements counts.
    pub profile: Option<Profile>,
    /// The map's projector; overrules the file beside the map.
    pub projector: Option<ProjectorType>,
    /// Latitude and longitude of the projector's origin, where it has one.
    pub origin: Option<[f64; 2]>,
    /// Ids of lanelets of subtype road that are bicycle lanes; a `bicycle_lane` is one by itself.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bicycle_lanes: Vec<i64>,
    /// Lanelets that the streets leave without a way on.
    #[serde(skip_serializing_if = "LooseEnds::is_empty")]
    pub loose_ends: LooseEnds,
    /// Only rules and faults that one of these prefixes names.
    pub select: Option<Vec<String>>,
    /// No rules and faults that one of these prefixes names, unless a longer one of `select` does.
    pub ignore: Option<Vec<String>>,
    /// Severities other than the documents', by prefix; the longest prefix decides.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub severity: BTreeMap<String, Severity>,
    /// Parameters other than the documents', by rule.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, toml::Table>,
    /// What is known of single intersections.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub intersection: Vec<IntersectionSettings>,
    /// Findings that the map's owner answers for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub suppress: Vec<Suppression>,
    /// For `build`: how high roads lie.
    pub heights: Option<HeightSettings>,
    /// For `build`: what is drawn beside the lanes for cars.
    pub beside: Option<BesideSettings>,
    /// For `build`: what is painted inside intersections.
    #[serde(skip_serializing_if = "InsideSettings::says_nothing")]
    pub inside: InsideSettings,
    /// For `build`: how traffic lights look.
    pub lights: Option<LightSettings>,
    /// For `build`: what is painted.
    pub markings: Option<MarkingSettings>,
    /// For `build`: tags of roads that OpenStreetMap lacks, or has wrong.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub road: Vec<RoadSettings>,
    /// For `build`: what is assumed of roads where their tags are silent; of two that speak of a road, the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub assume: Vec<AssumeSettings>,
    /// For `build`: roads that lie inside an intersection.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub merge: Vec<MergeSettings>,
    /// For `build`: roads that do not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub keep_apart: Vec<MergeSettings>,
}

impl Settings {
    /// Puts what is known of single elements in the order of their ids, which does not depend on how a map was built.
    pub fn sort(&mut self) {
        self.intersection.sort_by_key(|entry| entry.ia);
        self.bicycle_lanes.sort_unstable();
    }

    /// These settings, and those of `outer` where these say nothing. Lists of tables add up.
    #[must_use]
    pub fn over(mut self, outer: Self) -> Self {
        let mut parameters = outer.parameters;
        for (rule, own) in self.parameters {
            parameters.entry(rule).or_default().extend(own);
        }
        let mut severity = outer.severity;
        severity.extend(self.severity);
        self.intersection.extend(outer.intersection);
        self.bicycle_lanes.extend(outer.bicycle_lanes);
        self.loose_ends.extend(outer.loose_ends);
        self.suppress.extend(outer.suppress);
        self.road.extend(outer.road);
        self.assume.extend(outer.assume);
        self.merge.extend(outer.merge);
        self.keep_apart.extend(outer.keep_apart);
        Self {
            driving_side: self.driving_side.or(outer.driving_side),
            profile: self.profile.or(outer.profile),
            // An origin belongs to the projector of the same document.
            origin: if self.projector.is_some() { self.origin } else { outer.origin },
            projector: self.projector.or(outer.projector),
            bicycle_lanes: self.bicycle_lanes,
            loose_ends: self.loose_ends,
            select: self.select.or(outer.select),
            ignore: self.ignore.or(outer.ignore),
            severity,
            parameters,
            heights: self.heights.or(outer.heights),
            beside: self.beside.or(outer.beside),
            inside: self.inside.over(outer.inside),
            lights: self.lights.or(outer.lights),
            markings: self.markings.or(outer.markings),
            intersection: self.intersection,
            suppress: self.suppress,
            road: self.road,
            assume: self.assume,
            merge: self.merge,
            keep_apart: self.keep_apart,
        }
    }

    /// The codes that a run is about.
    pub fn selection(&self) -> Selection {
        Selection { select: self.select.clone().unwrap_or_default(), ignore: self.ignore.clone().unwrap_or_default() }
    }
}

/// How high roads lie where the input does not tell, and how they climb.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HeightSettings {
    /// Height of the ground where nothing is known of it, metres above the ellipsoid.
    pub ground: Option<f64>,
    /// Height from one `layer` to the next, metres.
    pub layer: Option<f64>,
    /// Steepest ramp, metres per metre.
    pub grade: Option<f64>,
    /// Steepest road where the ground is steeper than a ramp may be, metres per metre.
    pub steepest: Option<f64>,
}

/// Whose reading of the requirements counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Ours, as the documents of `rules/` say.
    #[default]
    Ours,
    /// That of the existing validator of TIER IV.
    Tier4,
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

/// Autoware's projectors, in its letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ProjectorType {
    /// UTM in squares of 100 km.
    #[serde(rename = "MGRS")]
    Mgrs,
    /// UTM, from an origin.
    #[serde(rename = "LocalCartesianUTM")]
    LocalCartesianUtm,
    /// Transverse Mercator through an origin.
    TransverseMercator,
    /// A plane that touches the ellipsoid at an origin.
    LocalCartesian,
    /// None: `local_x` and `local_y` are the coordinates.
    Local,
}

impl ProjectorType {
    /// Whether it means nothing without an origin.
    pub fn needs_origin(self) -> bool {
        matches!(self, Self::LocalCartesianUtm | Self::TransverseMercator | Self::LocalCartesian)
    }
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

impl std::fmt::Display for ApproachName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Compass(side) => f.write_str(side),
            Self::Id(id) => write!(f, "{id}"),
            Self::Ids(ids) => f.write_str(&ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
        }
    }
}

/// What is known of one intersection.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IntersectionSettings {
    /// Which one: id of its `intersection_area` polygon.
    pub ia: Option<i64>,
    /// Which one: a place inside it, latitude and longitude.
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
    /// For `build`: whether lights have arrows, other than `[lights]` says.
    pub arrows: Option<bool>,
    /// Lines that are painted inside to lead turns.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub guide_lines: Vec<GuideLine>,
    /// For `build`: stop lines inside, each from one place to another.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stop_lines: Vec<[Place; 2]>,
    /// For `build`: approaches that ask an infrastructure for leave.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub virtual_lights: Vec<VirtualLightSettings>,
    /// Its position in the file; `None` unless read from a document.
    #[serde(skip)]
    pub origin: Option<Origin>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(text: &str) -> Settings {
        Document::parse("a.toml", text).unwrap().settings
    }

    #[test]
    fn the_nearer_settings_win_key_by_key() {
        let near = "ignore = []\n[severity]\n\"a/b\" = \"info\"\n[parameters.a]\nx = 1\n[[intersection]]\nia = 1\n";
        let far = "driving_side = \"left\"\nignore = [\"a\"]\n[severity]\n\"a/b\" = \"error\"\na = \"warning\"\n\
                   [parameters.a]\nx = 2\ny = 3\n[[intersection]]\nia = 2\n";
        let both = settings(near).over(settings(far));
        assert_eq!(both.driving_side, Some(Side::Left));
        assert_eq!(both.ignore, Some(Vec::new()));
        assert_eq!(both.severity["a/b"], Severity::Info);
        assert_eq!(both.severity["a"], Severity::Warning);
        assert_eq!(both.parameters["a"].to_string(), "x = 1\ny = 3\n");
        assert_eq!(both.intersection.iter().map(|one| one.ia).collect::<Vec<_>>(), [Some(1), Some(2)]);
    }
}
