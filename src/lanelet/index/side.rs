//! On which side of the road people drive, as the map itself shows.

use rustc_hash::FxHashMap;

use super::{Intersection, Lane};
use crate::geometry::cross;
use crate::lanelet::{LineStringId, RoadType, TurnDirection};
use crate::settings::{Settings, Side};

/// The side of the road on which people drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DrivingSide {
    /// As in Japan: the near turn is the left turn.
    Left,
    /// As in Germany: the near turn is the right turn.
    Right,
}

impl DrivingSide {
    /// The turn across oncoming traffic.
    pub fn far_turn(self) -> TurnDirection {
        match self {
            Self::Left => TurnDirection::Right,
            Self::Right => TurnDirection::Left,
        }
    }

    /// The turn toward the own kerb.
    pub fn near_turn(self) -> TurnDirection {
        match self {
            Self::Left => TurnDirection::Left,
            Self::Right => TurnDirection::Right,
        }
    }
}

/// What the map shows, and what is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SideVotes {
    /// Places that show driving on the left.
    pub left: usize,
    /// Places that show driving on the right.
    pub right: usize,
    /// What is taken: the user's word, else the majority; `None` where nothing tells.
    pub side: Option<DrivingSide>,
}

/// Opposite lanes that share their inner bound vote, and so does every approach with lanes both ways.
pub(super) fn votes(lanes: &[Lane], intersections: &[Intersection], settings: &Settings) -> SideVotes {
    let mut votes = SideVotes::default();
    let mut users: FxHashMap<(LineStringId, usize), usize> = FxHashMap::default();
    for lane in lanes.iter().filter(|lane| lane.kind == RoadType::Road) {
        for (side, way) in lane.bounds.into_iter().enumerate() {
            // Shared on the same hand by two lanes: they run against each other.
            if let Some(_opposite) = users.insert((way, side), 1) {
                if side == 1 { votes.left += 1 } else { votes.right += 1 }
            }
        }
    }
    for arm in intersections.iter().flat_map(|intersection| &intersection.arms) {
        let (Some(inward), Some(outward)) = (arm.edges.iter().find(|e| e.inward), arm.edges.iter().find(|e| !e.inward))
        else {
            continue;
        };
        let Some(heading) = arm.heading_in else { continue };
        let side = cross(heading, outward.edge.middle() - inward.edge.middle());
        if side < 0.0 {
            votes.left += 1;
        } else if side > 0.0 {
            votes.right += 1;
        }
    }
    votes.side = match settings.driving_side {
        Some(Side::Left) => Some(DrivingSide::Left),
        Some(Side::Right) => Some(DrivingSide::Right),
        _ if votes.left > votes.right => Some(DrivingSide::Left),
        _ if votes.right > votes.left => Some(DrivingSide::Right),
        _ => None,
    };
    votes
}
