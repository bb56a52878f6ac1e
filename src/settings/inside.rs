//! What `build` draws inside intersections beyond the ways through them: by a switch for all, or entry by entry.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{ApproachName, IntersectionSettings};

/// Latitude and longitude, degrees.
pub type Place = [f64; 2];

/// `[inside]` of `lanewright.toml`: what is painted inside every intersection. OpenStreetMap does not tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct InsideSettings {
    /// Guide lines between the lanes of a turn that has several; none without it.
    pub guide_lines: Option<bool>,
    /// Stop lines where far turns wait for oncoming traffic; none without it.
    pub stop_lines: Option<bool>,
    /// From every lane a way to each lane of the road that it turns into; none but those that keep lanes apart without it.
    pub fan_out: Option<bool>,
}

impl InsideSettings {
    /// Whether no key is there.
    pub fn says_nothing(&self) -> bool {
        *self == Self::default()
    }

    /// These settings, and those of `outer` where these say nothing.
    pub(super) fn over(self, outer: Self) -> Self {
        Self {
            guide_lines: self.guide_lines.or(outer.guide_lines),
            stop_lines: self.stop_lines.or(outer.stop_lines),
            fan_out: self.fan_out.or(outer.fan_out),
        }
    }
}

/// A line that is painted inside an intersection to lead a turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a guide line is the id of a way, or its places: [[latitude, longitude], ...]")]
pub enum GuideLine {
    /// Id of the way in the map, for `check`.
    Way(i64),
    /// The places along it from the stop line on, for `build`.
    Places(Vec<Place>),
}

/// A virtual traffic light for each lane of an approach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VirtualLightSettings {
    /// Who asks the infrastructure for leave.
    pub approach: ApproachName,
    /// How far before the stop line a vehicle begins to ask, metres.
    pub start: Option<f64>,
    /// Tags by which the infrastructure knows the light.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tags: BTreeMap<String, String>,
}

/// No vehicle asks for leave farther away than this, metres: it could not reach the infrastructure.
const START_MOST: f64 = 150.0;

impl IntersectionSettings {
    /// Whether `build` has something to do.
    pub fn is_to_draw(&self) -> bool {
        let guided = self.guide_lines.iter().any(|line| matches!(line, GuideLine::Places(_)));
        let drawn = guided || !self.stop_lines.is_empty() || !self.virtual_lights.is_empty();
        drawn || !self.phases.is_empty() || self.arrows.is_some()
    }

    /// The first thing that cannot be meant: its key, its place in the list, and what is wrong.
    pub(super) fn fault(&self) -> Option<(&'static str, usize, &'static str)> {
        let off = |place: &Place| place[0].abs() > 90.0 || place[1].abs() > 180.0;
        let guide = |line: &GuideLine| match line {
            GuideLine::Places(places) if places.len() < 2 => Some("a line has two places at least"),
            GuideLine::Places(places) if places.iter().any(off) => Some(NO_PLACE),
            _ => None,
        };
        let stop = |line: &[Place; 2]| line.iter().any(off).then_some(NO_PLACE);
        let light = |light: &VirtualLightSettings| match light.start {
            Some(start) if !(start > 0.0 && start <= START_MOST) => {
                Some("`start` is a number of metres before the stop line, above 0 and at most 150")
            }
            _ if light.tags.contains_key("type") => Some("its `type` is intersection_coordination and nothing else"),
            _ => None,
        };
        first("guide_lines", &self.guide_lines, guide)
            .or_else(|| first("stop_lines", &self.stop_lines, stop))
            .or_else(|| first("virtual_lights", &self.virtual_lights, light))
    }
}

const NO_PLACE: &str = "one of its places is not a latitude and a longitude";

fn first<T>(
    key: &'static str,
    list: &[T],
    fault: impl Fn(&T) -> Option<&'static str>,
) -> Option<(&'static str, usize, &'static str)> {
    list.iter().enumerate().find_map(|(at, one)| Some((key, at, fault(one)?)))
}
