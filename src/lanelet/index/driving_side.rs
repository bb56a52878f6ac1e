//! The side of the road on which people drive, as the map shows it.

use rustc_hash::FxHashMap;

use super::Lane;
use super::types::{Arm, ArmEdge, DrivingSide, Intersection, SideVote, SideVotes};
use crate::geometry::cross;
use crate::lanelet::{LineStringId, PointId, RoadType};
use crate::settings::{Settings, Side};

/// Two lanes of opposite directions lie beside each other where their middles are farther apart than this share (1) of the narrower one.
const ON_EACH_OTHER: f64 = 0.4;

/// The votes for either side: one for each pair of opposite lanes that share their inner bound, and one for each approach with
/// lanes in both directions. Two lanelets of opposite directions between the same ways lie on neither side and do not vote.
pub(super) fn votes(lanes: &[Lane], intersections: &[Intersection], settings: &Settings) -> SideVotes {
    let mut votes = SideVotes::default();
    // For every bound, by its way and by whether it is a left bound, the point from which its first lane drives.
    let mut users: FxHashMap<(LineStringId, usize), PointId> = FxHashMap::default();
    // A path for bicycles or people on foot may lie on either side.
    for lane in lanes.iter().filter(|lane| lane.kind == RoadType::Road && lane.is_for_cars() && !lane.both_ways) {
        for (side, way) in lane.bounds.into_iter().enumerate() {
            let from = lane.start.ids[side];
            // Two lanes with the same left bound, or the same right bound, have opposite directions unless they overlap.
            if *users.entry((way, side)).or_insert(from) != from {
                let side = if side == 1 { DrivingSide::Left } else { DrivingSide::Right };
                votes.add(SideVote { lane: lane.id, side, on_one_road: true });
            }
        }
    }
    for arm in intersections.iter().flat_map(|intersection| &intersection.arms) {
        let (Some(inward), Some(outward)) = (one_way(lanes, arm, true), one_way(lanes, arm, false)) else { continue };
        let Some(heading) = arm.heading_in else { continue };
        let side = cross(heading, outward.edge.middle() - inward.edge.middle());
        let Some(lane) = inward.lanes.first().and_then(|&lane| lanes.get(lane)) else { continue };
        // Lanes that lie on each other, on a narrow road, lie on neither side.
        let width = inward.edge.across().norm().min(outward.edge.across().norm());
        if side.abs() > ON_EACH_OTHER * width * heading.norm() {
            let side = if side < 0.0 { DrivingSide::Left } else { DrivingSide::Right };
            let on_one_road = inward.edge.ids.iter().any(|id| outward.edge.ids.contains(id));
            votes.add(SideVote { lane: lane.id, side, on_one_road });
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

/// The first edge of an approach that is crossed only inward, or only outward. Bicycles may ride against the traffic on either side of it.
fn one_way<'a>(lanes: &[Lane], arm: &'a Arm, inward: bool) -> Option<&'a ArmEdge> {
    let backwards = |edge: &ArmEdge| [edge.edge.ids[1], edge.edge.ids[0]];
    let both_ways = |edge: &ArmEdge| arm.edges.iter().any(|other| other.edge.ids == backwards(edge));
    let is_for_bicycles = |edge: &ArmEdge| edge.lanes.iter().all(|&at| lanes.get(at).is_some_and(|lane| lane.bicycle));
    arm.edges.iter().find(|edge| edge.inward == inward && !both_ways(edge) && !is_for_bicycles(edge))
}
