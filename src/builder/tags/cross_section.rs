//! The cross-section of a road: its strips from left to right, read from tags.

mod bus_lanes;
mod bus_tags;
mod contraflow;
mod defaults;
mod facts;
mod flow;
mod lanes;
mod per_lane;
mod placement;
mod read;
mod road_lists;
mod sides;
#[cfg(test)]
mod tests;

pub(crate) use facts::{Assumed, Lane, SectionReading, WayFacts};

pub(crate) use defaults::{Customs, Defaults, SIDEWALK};
pub(crate) use lanes::tells_lanes;
pub(crate) use read::layout;

use super::road_class::RoadClass;

/// The use of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StripKind {
    /// A lane for all motor vehicles.
    Drive,
    /// A lane for buses and other vehicles that the tags allow, not for cars.
    Bus,
    /// A lane for bicycles.
    Bicycle,
    /// A painted lane for people on foot.
    Pedestrian,
    /// Parked cars.
    Parking,
    /// A paved edge.
    Shoulder,
    /// A raised footway.
    Sidewalk,
    /// A verge, kerb or painted buffer.
    Buffer,
}

impl StripKind {
    /// Whether it is a lane for motor vehicles.
    pub fn is_driven(self) -> bool {
        matches!(self, Self::Drive | Self::Bus)
    }
}

/// The direction of travel on a strip, seen along the road's line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Travel {
    /// With the line.
    Forward,
    /// Against the line.
    Backward,
    /// Both directions: a single track, or a centre turn lane.
    Both,
}

impl Travel {
    /// The same direction of travel, seen against the road's line.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
            Self::Both => Self::Both,
        }
    }
}

/// The arrows of a lane as in `turn:lanes`.
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

    /// The union of both sets.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether the sets have a common arrow.
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
    /// Its use.
    pub kind: StripKind,
    /// Its direction of travel.
    pub travel: Travel,
    /// Metres.
    pub width: f64,
    /// Its arrows, seen in its direction of travel.
    pub arrows: Arrows,
    /// Whether a vehicle may change to the strip on its left and on its right, seen in its direction of travel; `None` without
    /// a tag.
    pub change: [Option<bool>; 2],
    /// Whether the width is a default.
    pub width_guessed: bool,
    /// Its own speed limit, km/h, if it differs from lane to lane.
    pub speed: Option<f64>,
    /// Whether bicycles may use it, too: of a bus lane.
    pub bicycles: bool,
}

impl Strip {
    /// A strip without arrows and without rules for lane changes.
    pub fn plain(kind: StripKind, travel: Travel, width: f64, width_guessed: bool) -> Self {
        Self {
            kind,
            travel,
            width,
            arrows: Arrows::NONE,
            change: [None, None],
            width_guessed,
            speed: None,
            bicycles: false,
        }
    }
}

/// The strips of a road from left to right, seen along its line.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSection {
    /// From left to right.
    pub strips: Vec<Strip>,
}

impl CrossSection {
    /// The width, metres.
    pub fn width(&self) -> f64 {
        self.strips.iter().map(|s| s.width).sum()
    }

    /// The offset of edge `i`, the left edge of strip `i`, from the middle of the section, metres, left positive. The last edge
    /// is the right edge of the last strip.
    pub fn edge(&self, i: usize) -> f64 {
        self.width() / 2.0 - self.strips.iter().take(i).map(|s| s.width).sum::<f64>()
    }

    /// The indices of the first strip of the carriageway and of the strip after its last.
    pub fn carriageway(&self) -> (usize, usize) {
        let between = |s: &Strip| !matches!(s.kind, StripKind::Sidewalk | StripKind::Buffer);
        let first = self.strips.iter().position(between).unwrap_or(0);
        let last = self.strips.iter().rposition(between).map_or(self.strips.len(), |i| i + 1);
        (first, last)
    }

    /// The lanes for motor vehicles, with their indices.
    pub fn driven(&self) -> impl Iterator<Item = (usize, &Strip)> {
        self.strips.iter().enumerate().filter(|(_, strip)| strip.kind.is_driven())
    }

    /// The only direction of travel; `None` if vehicles use both directions, or none.
    pub fn one_way(&self) -> Option<Travel> {
        let mut travels = self.driven().map(|(_, strip)| strip.travel);
        let first = travels.next()?;
        (first != Travel::Both && travels.all(|travel| travel == first)).then_some(first)
    }
}

/// The valid widths of a lane, metres. Other values of a tag are ignored.
pub(crate) const LANE_WIDTHS: std::ops::RangeInclusive<f64> = 2.0..=6.0;

/// The smallest width of a lane, metres, whatever the tagged total width: a car needs it, or a lorry on major roads.
pub fn minimum_lane_width(class: RoadClass) -> f64 {
    match class {
        RoadClass::Motorway => 3.25,
        RoadClass::Trunk => 3.0,
        _ => 2.4,
    }
}
