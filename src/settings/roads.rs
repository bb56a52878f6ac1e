//! What the user knows of roads: tags of single ways, and defaults where OpenStreetMap has no tags.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Origin;

/// One `[[road]]` of `lanewright.toml`: tags that OpenStreetMap lacks, or has wrong.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RoadSettings {
    /// Ids of OpenStreetMap ways.
    pub ways: Vec<i64>,
    /// Whether it is about all ways of people and bicycles that admit motor vehicles, too (`highway=pedestrian` with `motor_vehicle=yes`
    /// and their like): they become private roads with a low speed limit.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub shared_paths: bool,
    /// Stand in the place of their own; an empty value takes a tag away.
    pub tags: BTreeMap<String, String>,
    /// Why.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// Its position in the file; `None` unless read from a document.
    #[serde(skip)]
    pub origin: Option<Origin>,
}

impl RoadSettings {
    /// What is wrong with it.
    pub(super) fn fault(&self) -> Option<&'static str> {
        if self.ways.is_empty() != self.shared_paths {
            return Some(
                "it names no way; name some with `ways`, or all shared paths with `shared_paths = true`, not both",
            );
        }
        if self.shared_paths && self.tags.keys().all(|key| !key.is_empty()) {
            return None;
        }
        (self.tags.is_empty() || self.tags.keys().any(String::is_empty)).then_some("it has no tags")
    }
}

/// Values of `highway` that are roads for motor vehicles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "their names are OpenStreetMap's")]
pub enum Highway {
    Motorway,
    MotorwayLink,
    Trunk,
    TrunkLink,
    Primary,
    PrimaryLink,
    Secondary,
    SecondaryLink,
    Tertiary,
    TertiaryLink,
    Unclassified,
    Residential,
    LivingStreet,
    Service,
    Track,
}

/// One `[[assume]]` of `lanewright.toml`: what roads of some classes, in some country, are taken to be where their tags are
/// silent. Widths are metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AssumeSettings {
    /// Of which classes; all where empty.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub highway: Vec<Highway>,
    /// ISO 3166-1 code of the country; everywhere where absent.
    pub country: Option<String>,
    /// Lanes in each direction.
    pub lanes: Option<u8>,
    /// Speed limit, km/h.
    pub speed: Option<f64>,
    /// Of a lane for motor vehicles.
    pub lane_width: Option<f64>,
    /// Of a painted bicycle lane.
    pub bicycle_lane_width: Option<f64>,
    /// Of a bicycle track behind a kerb.
    pub bicycle_track_width: Option<f64>,
    /// Of cars parked along the road.
    pub parking_width: Option<f64>,
    /// Of a shoulder.
    pub shoulder_width: Option<f64>,
    /// Of a painted strip for people on foot.
    pub pedestrian_lane_width: Option<f64>,
    /// Of a sidewalk.
    pub sidewalk_width: Option<f64>,
}

impl AssumeSettings {
    /// Whether it speaks of roads of a class in a country.
    pub fn is_about(&self, highway: Highway, country: Option<&str>) -> bool {
        let class = self.highway.is_empty() || self.highway.contains(&highway);
        class && self.country.as_deref().is_none_or(|code| country.is_some_and(|own| own.eq_ignore_ascii_case(code)))
    }

    /// What is wrong with it: the key, and why.
    pub(super) fn fault(&self) -> Option<(&'static str, &'static str)> {
        let strips = [
            ("bicycle_lane_width", self.bicycle_lane_width),
            ("bicycle_track_width", self.bicycle_track_width),
            ("parking_width", self.parking_width),
            ("shoulder_width", self.shoulder_width),
            ("pedestrian_lane_width", self.pedestrian_lane_width),
            ("sidewalk_width", self.sidewalk_width),
        ];
        let outside = |value: Option<f64>, low: f64, high: f64| value.is_some_and(|v| !(low..=high).contains(&v));
        let code = |country: &String| country.len() == 2 && country.bytes().all(|b| b.is_ascii_alphabetic());
        if self.country.as_ref().is_some_and(|country| !code(country)) {
            return Some(("country", "a country is two letters, as \"DE\""));
        }
        if self.lanes.is_some_and(|lanes| !(1..=24).contains(&lanes)) {
            return Some(("lanes", "there are 1 to 24 lanes in each direction"));
        }
        if outside(self.speed, 1.0, 300.0) {
            return Some(("speed", "a limit is 1 to 300 km/h"));
        }
        if outside(self.lane_width, 2.0, 6.0) {
            return Some(("lane_width", "a lane is 2 to 6 metres wide"));
        }
        let (key, _) = strips.into_iter().find(|(_, width)| outside(*width, 0.3, 8.0))?;
        Some((key, "what lies beside the lanes is 0.3 to 8 metres wide"))
    }
}
