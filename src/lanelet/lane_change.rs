//! Who may change lanes over a line, and to which side, as Lanelet2 reads it (1.2.3, `GenericTrafficRules`).
//!
//! `lane_change` counts alone where it stands. Else the tags of the sides do, and a side that is not named is closed; but
//! `lane_change:left=no` alone is not read at all. Only then does the paint count. Left and right are those of the line as stored; a
//! bound that a lanelet uses turned around is read with its sides exchanged.

use super::{Attributes, Bound, LaneletMap};

/// Who changes lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Participant {
    /// Any vehicle but a bicycle.
    Vehicle,
    /// A bicycle: over what vehicles cross, and over low kerbs.
    Bicycle,
    /// Somebody on foot: over low kerbs.
    Pedestrian,
}

/// To which sides a line may be crossed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaneChange {
    /// From its right to its left.
    pub to_left: bool,
    /// From its left to its right.
    pub to_right: bool,
}

/// The tags of the sides.
pub const SIDES: [&str; 2] = ["lane_change:left", "lane_change:right"];

impl LaneChange {
    const BOTH: Self = Self { to_left: true, to_right: true };
    const NONE: Self = Self { to_left: false, to_right: false };

    /// What the tags of a line say, along the line as stored.
    pub fn of(tags: &Attributes, who: Participant) -> Self {
        let is_yes = |value: Option<&str>| matches!(value, Some("yes" | "true" | "1"));
        if let Some(value) = tags.get("lane_change") {
            return if is_yes(Some(value)) { Self::BOTH } else { Self::NONE };
        }
        let [left, right] = SIDES.map(|key| tags.get(key).map(|value| is_yes(Some(value))));
        match (left, right) {
            (Some(true), right) => Self { to_left: true, to_right: right == Some(true) },
            (_, Some(to_right)) => Self { to_left: false, to_right },
            _ => Self::of_paint(tags, who),
        }
    }

    /// What the paint alone says.
    pub fn of_paint(tags: &Attributes, who: Participant) -> Self {
        let kind = (tags.get("type").unwrap_or_default(), tags.get("subtype").unwrap_or_default());
        let painted = match kind {
            ("line_thin" | "line_thick", "dashed") => Self::BOTH,
            ("line_thin" | "line_thick", "dashed_solid") => Self { to_right: true, ..Self::NONE },
            ("line_thin" | "line_thick", "solid_dashed") => Self { to_left: true, ..Self::NONE },
            _ => Self::NONE,
        };
        let low_kerb = if kind == ("curbstone", "low") { Self::BOTH } else { Self::NONE };
        match who {
            Participant::Vehicle => painted,
            Participant::Bicycle if painted != Self::NONE => painted,
            Participant::Bicycle | Participant::Pedestrian => low_kerb,
        }
    }

    /// Of a bound, as the lanelet sees it that uses it; closed where the map does not hold the line.
    pub fn over(map: &LaneletMap, bound: Bound, who: Participant) -> Self {
        let stored = map.linestrings.get(bound.line).map_or(Self::NONE, |line| Self::of(&line.attributes, who));
        if bound.inverted { stored.turned() } else { stored }
    }

    /// Seen against the line's direction.
    pub fn turned(self) -> Self {
        Self { to_left: self.to_right, to_right: self.to_left }
    }

    /// Whether it may be crossed to one side at least.
    pub fn any(self) -> bool {
        self.to_left || self.to_right
    }

    /// The value of `lane_change` that says the same; `None` where only one side is open.
    pub fn as_value(self) -> Option<&'static str> {
        match self {
            Self::BOTH => Some("yes"),
            Self::NONE => Some("no"),
            _ => None,
        }
    }
}

/// Whether a line says by side who may change: by the tags of the sides, or by paint that is open to one side.
pub fn is_said_by_side(tags: &Attributes) -> bool {
    !tags.has("lane_change")
        && (SIDES.iter().any(|key| tags.has(key))
            || LaneChange::of_paint(tags, Participant::Vehicle).as_value().is_none())
}
