//! On which side of the road people drive, as the map itself shows.

use rustc_hash::FxHashMap;

use super::Lane;
use super::types::{Arm, ArmEdge, DrivingSide, Intersection, SideVotes};
use crate::geometry::cross;
use crate::lanelet::{LineStringId, PointId, RoadType};
use crate::settings::{Settings, Side};

/// Opposite lanes that share their inner bound vote, and so does every approach with lanes both ways. A lane that is
/// driven both ways, by two lanelets between the same ways, lies on neither side and shows nothing.
pub(super) fn votes(lanes: &[Lane], intersections: &[Intersection], settings: &Settings) -> SideVotes {
    let mut votes = SideVotes::default();
    // For every bound, by its way and hand, the point from which its first user drives.
    let mut users: FxHashMap<(LineStringId, usize), PointId> = FxHashMap::default();
    // A path for bicycles or people on foot may lie on either side.
    for lane in lanes.iter().filter(|lane| lane.kind == RoadType::Road && lane.is_for_cars() && !lane.both_ways) {
        for (side, way) in lane.bounds.into_iter().enumerate() {
            let from = lane.start.ids[side];
            // Lanes that share it on the same hand run against each other, unless they lie on top of each other.
            if *users.entry((way, side)).or_insert(from) != from {
                votes.add(lane.id, if side == 1 { DrivingSide::Left } else { DrivingSide::Right });
            }
        }
    }
    for arm in intersections.iter().flat_map(|intersection| &intersection.arms) {
        let (Some(inward), Some(outward)) = (one_way(arm, true), one_way(arm, false)) else { continue };
        let Some(heading) = arm.heading_in else { continue };
        let side = cross(heading, outward.edge.middle() - inward.edge.middle());
        let Some(lane) = inward.lanes.first().and_then(|&lane| lanes.get(lane)) else { continue };
        if side < 0.0 {
            votes.add(lane.id, DrivingSide::Left);
        } else if side > 0.0 {
            votes.add(lane.id, DrivingSide::Right);
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

/// The first edge of an approach that is crossed only inward, or only outward.
fn one_way(arm: &Arm, inward: bool) -> Option<&ArmEdge> {
    let backwards = |edge: &ArmEdge| [edge.edge.ids[1], edge.edge.ids[0]];
    let both_ways = |edge: &ArmEdge| arm.edges.iter().any(|other| other.edge.ids == backwards(edge));
    arm.edges.iter().find(|edge| edge.inward == inward && !both_ways(edge))
}
