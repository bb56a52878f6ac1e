//! Tags of a primitive, read as what they mean.

use crate::osm::Tags;

/// The tags of a primitive with typed readings.
pub type Attributes = Tags;

/// The value of `turn_direction`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TurnDirection {
    /// Toward the left.
    Left,
    /// Straight on.
    Straight,
    /// Toward the right.
    Right,
}

impl TurnDirection {
    /// The tag's value.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Straight => "straight",
            Self::Right => "right",
        }
    }

    /// From the tag's value; `None` for every other word.
    pub fn parse(value: &str) -> Option<Self> {
        match value {
            "left" => Some(Self::Left),
            "straight" => Some(Self::Straight),
            "right" => Some(Self::Right),
            _ => None,
        }
    }
}

/// The `subtype` of a lanelet, as far as rules tell them apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RoadType {
    /// `road`: for vehicles.
    Road,
    /// `road_shoulder`.
    Shoulder,
    /// `pedestrian_lane`: a strip at the side of the road.
    PedestrianLane,
    /// `bicycle_lane`.
    BicycleLane,
    /// `crosswalk`.
    Crosswalk,
    /// `walkway`.
    Walkway,
    /// Any other word, or none.
    Other,
}

impl RoadType {
    /// From the tags of a lanelet.
    pub fn of(attributes: &Attributes) -> Self {
        match attributes.get("subtype") {
            Some("road") => Self::Road,
            Some("road_shoulder") => Self::Shoulder,
            Some("pedestrian_lane") => Self::PedestrianLane,
            Some("bicycle_lane") => Self::BicycleLane,
            Some("crosswalk") => Self::Crosswalk,
            Some("walkway") => Self::Walkway,
            _ => Self::Other,
        }
    }
}
