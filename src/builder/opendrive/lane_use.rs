//! What lanes of OpenDRIVE are for, and the tags of their lanelets.

use crate::lanelet::Attributes;
use crate::xodr::Lane;

use compact_str::ToCompactString;

/// The borders of a lane, at the larger and at the smaller offset to the left.
pub fn sides(lane: i64) -> [i64; 2] {
    if lane > 0 { [lane, lane - 1] } else { [lane + 1, lane] }
}

/// What a lane is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneUse {
    /// All motor vehicles.
    Vehicles,
    /// Buses.
    Buses,
    /// Taxis.
    Taxis,
    /// Bicycles.
    Bicycles,
    /// Where vehicles may halt.
    Shoulder,
    /// Nothing that a map for driving shows.
    None,
}

/// Lanes for motor vehicles, whatever they lead to.
const DRIVEN: [&str; 12] = [
    "driving",
    "entry",
    "exit",
    "onRamp",
    "offRamp",
    "connectingRamp",
    "slipLane",
    "bidirectional",
    "mwyEntry",
    "mwyExit",
    "hov",
    "HOV",
];

impl LaneUse {
    /// By the type of a lane and who may drive on it.
    pub fn of(lane: &Lane) -> Self {
        let kind = lane.kind.as_str();
        let only =
            |word: &str| !lane.access.is_empty() && lane.access.iter().all(|(allowed, who)| *allowed && who == word);
        match kind {
            "bus" => Self::Buses,
            "taxi" => Self::Taxis,
            "biking" => Self::Bicycles,
            "shoulder" | "stop" | "parking" => Self::Shoulder,
            _ if DRIVEN.contains(&kind) => match () {
                () if only("bus") => Self::Buses,
                () if only("taxi") => Self::Taxis,
                () if only("bicycle") => Self::Bicycles,
                () => Self::Vehicles,
            },
            _ => Self::None,
        }
    }

    /// Whether motor vehicles drive there.
    pub fn is_driven(self) -> bool {
        matches!(self, Self::Vehicles | Self::Buses | Self::Taxis)
    }

    /// The tags of its lanelets.
    pub fn tags(self, limit: f64) -> Attributes {
        let (subtype, participant) = match self {
            Self::Buses => ("bus_lane", "participant:vehicle:bus"),
            Self::Taxis => ("road", "participant:vehicle:taxi"),
            Self::Bicycles => ("bicycle_lane", ""),
            Self::Shoulder => ("road_shoulder", ""),
            Self::Vehicles | Self::None => ("road", "participant:vehicle"),
        };
        let known = [("type", "lanelet"), ("subtype", subtype), ("location", "urban"), ("one_way", "yes")];
        let mut tags = Attributes::of(&known);
        tags.push("speed_limit", (limit.round().clamp(5.0, 250.0) as u8).to_compact_string());
        if !participant.is_empty() {
            tags.push(participant, "yes");
        }
        tags
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_and_access_tell_the_use() {
        let lane = |kind: &str, access: &[(bool, &str)]| {
            let access = access.iter().map(|(allowed, word)| (*allowed, (*word).into())).collect();
            LaneUse::of(&Lane { kind: kind.into(), access, ..Lane::default() })
        };
        assert_eq!(lane("driving", &[]), LaneUse::Vehicles);
        assert_eq!(lane("driving", &[(true, "bus")]), LaneUse::Buses);
        assert_eq!(lane("driving", &[(false, "truck")]), LaneUse::Vehicles);
        assert_eq!(lane("onRamp", &[]), LaneUse::Vehicles);
        assert_eq!(lane("parking", &[]), LaneUse::Shoulder);
        assert_eq!(lane("median", &[]), LaneUse::None);
    }
}
