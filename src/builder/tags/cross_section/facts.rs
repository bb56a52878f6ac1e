//! The input and the output of reading a cross-section.

use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::builder::tags::values::{metres_under, number_of};
use crate::diagnostic::{Finding, Severity, Subject};
use crate::osm::Tags;

use super::defaults::Defaults;
use super::{CrossSection, Strip, StripKind, Travel};

/// The largest number of lanes in one direction: the widest toll plazas have fewer. A larger number is an error.
pub(super) const MAX_LANES: usize = 24;

/// The largest width of a single track for both directions, metres.
pub(super) const MAX_SINGLE_TRACK: f64 = 5.5;

/// A way of which the cross-section is read.
#[derive(Clone, Copy)]
pub(crate) struct WayFacts<'a> {
    /// Its id.
    pub way: i64,
    /// Its tags.
    pub tags: &'a Tags,
    /// Its class.
    pub class: RoadClass,
    /// Whether it is a `_link`.
    pub link: bool,
    /// Whether it is only for buses.
    pub bus_road: bool,
    /// The driving side.
    pub side: DrivingSide,
    /// The defaults for missing tags.
    pub usual: Defaults,
    /// The lanes that it takes from other ways if it has no lane tags.
    pub continued: Option<&'a Assumed>,
}

/// The lanes that a way takes from others.
#[derive(Clone, Debug)]
pub(crate) struct Assumed {
    /// From left to right along the way.
    pub lanes: Vec<Lane>,
    /// From which others, as a message says it: "as many as ...".
    pub like: String,
}

/// The kind and the direction of a lane for motor vehicles.
pub(crate) type Lane = (StripKind, Travel);

impl WayFacts<'_> {
    /// A finding about the way.
    pub(super) fn note(&self, slug: &'static str, severity: Severity, what: &str) -> Finding {
        Finding::new(slug, Subject::Way(self.way), format!("way {}: {what}", self.way)).graded(severity)
    }
}

/// A cross-section and its position relative to OpenStreetMap's line.
#[derive(Clone, Debug)]
pub(crate) struct SectionReading {
    /// The strips, seen along the way.
    pub section: CrossSection,
    /// The offset of the middle of the section from the way's line, metres, left positive.
    pub shift: f64,
}

/// The number of lanes under `key`: `1.5` counts as 1; of a list the first number counts.
pub(super) fn tagged_count(facts: &WayFacts<'_>, key: &str) -> Option<usize> {
    let value = facts.tags.get(key)?;
    let number = number_of(value.split(';').next().unwrap_or(value))?;
    (number >= 0.0 && number.is_finite()).then(|| (number as usize).min(MAX_LANES))
}

/// A lane without tags of its own.
pub(super) fn default_lane(facts: &WayFacts<'_>, travel: Travel) -> Strip {
    let kind = if facts.bus_road { StripKind::Bus } else { StripKind::Drive };
    match metres_under(facts.tags, ["lane_width", "width:lane"]) {
        Some(width) if super::LANE_WIDTHS.contains(&width) => Strip::plain(kind, travel, width, false),
        _ => Strip::plain(kind, travel, facts.usual.lane, true),
    }
}
