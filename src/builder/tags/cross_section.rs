//! The lanes of a road as an ordered cross-section, read from OpenStreetMap's tags.

mod bus_lanes;
mod defaults;
mod facts;
mod flow;
mod lanes;
mod per_lane;
mod placement;
mod read;
mod sides;
#[cfg(test)]
mod tests;

pub(crate) use facts::{Lane, SectionReading, WayFacts};

pub(crate) use defaults::{Customs, Defaults, SIDEWALK};
pub(crate) use lanes::tells_lanes;
pub(crate) use read::layout;

use super::road_class::RoadClass;

/// What a strip of the road is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StripKind {
    /// A lane for all motor vehicles.
    Drive,
    /// A lane for buses (and what the tags admit), not for cars.
    Bus,
    /// A lane for bicycles.
    Bicycle,
    /// A painted strip for people on foot.
    Pedestrian,
    /// Parked cars.
    Parking,
    /// A paved edge.
    Shoulder,
    /// A footway raised beside the carriageway.
    Sidewalk,
    /// A strip nobody uses: a verge, a kerb, a painted buffer.
    Buffer,
}

/// Which way a strip is used, seen along the road's line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Travel {
    /// With the line.
    Forward,
    /// Against the line.
    Backward,
    /// Both ways: a single track, or a centre turn lane.
    Both,
}

/// The turns that a lane's arrows allow, as `turn:lanes` says; empty: no arrows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Arrows(u16);

impl Arrows {
    /// No arrows on the lane.
    pub const NONE: Self = Self(0);
    /// `left`.
    pub const LEFT: Self = Self(1);
    /// `slight_left`.
    pub const SLIGHT_LEFT: Self = Self(2);
    /// `sharp_left`.
    pub const SHARP_LEFT: Self = Self(4);
    /// `through`.
    pub const THROUGH: Self = Self(8);
    /// `right`.
    pub const RIGHT: Self = Self(16);
    /// `slight_right`.
    pub const SLIGHT_RIGHT: Self = Self(32);
    /// `sharp_right`.
    pub const SHARP_RIGHT: Self = Self(64);
    /// `reverse`.
    pub const REVERSE: Self = Self(128);
    /// `merge_to_left`.
    pub const MERGE_TO_LEFT: Self = Self(256);
    /// `merge_to_right`.
    pub const MERGE_TO_RIGHT: Self = Self(512);

    /// All arrows with their values of `turn:lanes`.
    pub const NAMES: [(&str, Self); 10] = [
        ("left", Self::LEFT),
        ("slight_left", Self::SLIGHT_LEFT),
        ("sharp_left", Self::SHARP_LEFT),
        ("through", Self::THROUGH),
        ("right", Self::RIGHT),
        ("slight_right", Self::SLIGHT_RIGHT),
        ("sharp_right", Self::SHARP_RIGHT),
        ("reverse", Self::REVERSE),
        ("merge_to_left", Self::MERGE_TO_LEFT),
        ("merge_to_right", Self::MERGE_TO_RIGHT),
    ];

    /// The arrow of a value of `turn:lanes`.
    pub fn named(value: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(name, _)| *name == value).map(|(_, arrow)| *arrow)
    }

    /// Both sets together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether any arrow of `other` is here.
    pub fn has(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Whether the lane has no arrow.
    pub fn is_none(self) -> bool {
        self.0 == 0
    }
}

/// One strip of a road.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// What it is for.
    pub kind: StripKind,
    /// Which way it is used.
    pub travel: Travel,
    /// Metres.
    pub width: f64,
    /// The arrows painted on it, in its own direction of travel.
    pub arrows: Arrows,
    /// Whether a vehicle on it may change to the strip on its left (first) and right, in its own direction of
    /// travel; `None` where the tags are silent.
    pub change: [Option<bool>; 2],
    /// Whether the width is a default, not a tag's.
    pub width_guessed: bool,
}

impl Strip {
    /// A strip without arrows and of which no tag tells whether its lane may be left.
    pub fn plain(kind: StripKind, travel: Travel, width: f64, width_guessed: bool) -> Self {
        Self { kind, travel, width, arrows: Arrows::NONE, change: [None, None], width_guessed }
    }
}

/// The strips of a road from left to right, seen along its line.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSection {
    /// From left to right.
    pub strips: Vec<Strip>,
}

impl CrossSection {
    /// Whole width in metres.
    pub fn width(&self) -> f64 {
        self.strips.iter().map(|s| s.width).sum()
    }

    /// Offset of the left edge of strip `i` from the middle of the section: positive to the left. `i` may be the
    /// number of strips: the right edge of the last.
    pub fn edge(&self, i: usize) -> f64 {
        self.width() / 2.0 - self.strips[..i].iter().map(|s| s.width).sum::<f64>()
    }

    /// Index of the first and behind the last strip of the carriageway: what lies between the kerbs.
    pub fn carriageway(&self) -> (usize, usize) {
        let between = |s: &Strip| !matches!(s.kind, StripKind::Sidewalk | StripKind::Buffer);
        let first = self.strips.iter().position(between).unwrap_or(0);
        let last = self.strips.iter().rposition(between).map_or(self.strips.len(), |i| i + 1);
        (first, last)
    }

    /// The strips that motor vehicles drive on, with their index.
    pub fn driven(&self) -> impl Iterator<Item = (usize, &Strip)> {
        self.strips.iter().enumerate().filter(|(_, s)| matches!(s.kind, StripKind::Drive | StripKind::Bus))
    }
}

/// Widths that a single lane can have, metres; other values of a tag are passed over.
pub(crate) const LANE_WIDTHS: std::ops::RangeInclusive<f64> = 2.0..=6.0;

/// A lane is drawn no narrower than this, metres, however little a tagged total width leaves for it: what a car (a
/// lorry on the great roads) needs.
pub fn minimum_lane_width(class: RoadClass) -> f64 {
    match class {
        RoadClass::Motorway => 3.25,
        RoadClass::Trunk => 3.0,
        _ => 2.4,
    }
}
