//! What is known of a way before its cross-section is read, and what is read.

use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::builder::tags::values::metres_under;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::osm::Tags;

use super::defaults::Defaults;
use super::{CrossSection, Strip, StripKind, Travel};

/// A single track for both directions may take all of a narrow carriageway, metres.
pub(super) const MAX_SINGLE_TRACK: f64 = 5.5;

/// What is known of a way before its strips are read.
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
    /// Whether only buses may use it.
    pub bus_road: bool,
    /// The side people drive on.
    pub side: DrivingSide,
    /// What is assumed where its tags are silent.
    pub usual: Defaults,
    /// The lanes, left to right along the way, of the road that it continues on both sides; heeded where its own tags tell
    /// none.
    pub continued: Option<&'a [Lane]>,
}

/// What a lane for motor vehicles is for, and which way.
pub(crate) type Lane = (StripKind, Travel);

impl WayFacts<'_> {
    /// A note about the way.
    pub(super) fn note(&self, slug: &'static str, severity: Severity, what: &str) -> Finding {
        Finding::new(slug, Subject::Way(self.way), format!("way {}: {what}", self.way)).graded(severity)
    }
}

/// A cross-section and where it lies beside OpenStreetMap's line.
#[derive(Clone, Debug)]
pub(crate) struct SectionReading {
    /// What lies across the road, along the way's direction.
    pub section: CrossSection,
    /// How far the middle of the section lies left of the way's line, metres.
    pub shift: f64,
}

/// A lane of which nothing is known but its direction.
pub(super) fn plain(facts: &WayFacts<'_>, travel: Travel) -> Strip {
    let kind = if facts.bus_road { StripKind::Bus } else { StripKind::Drive };
    match metres_under(facts.tags, ["lane_width", "width:lane"]) {
        Some(width) if super::LANE_WIDTHS.contains(&width) => Strip::plain(kind, travel, width, false),
        _ => Strip::plain(kind, travel, facts.usual.lane, true),
    }
}
