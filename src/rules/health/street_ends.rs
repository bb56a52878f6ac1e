//! What the checks of loose ends ask of a lane: whether it is a street's, has others beside it, and where people turn.

use crate::geometry::angle_between;
use crate::lanelet::RoadType;
use crate::lanelet::index::MapIndex;
use crate::rules::routing_moves::RoutingMoves;

use super::params::Params;

/// A street's lane outside intersections; loose ends in and at those are the business of vm-03-04. Vehicles that reverse leave a lane
/// as they came.
pub fn is_street(map: &MapIndex, at: usize) -> bool {
    let lane = &map.lanes[at];
    !lane.reverses()
        && lane.kind == RoadType::Road
        && lane.is_for_cars()
        && map.intersections_touching(at).next().is_none()
}

/// Whether no lane beside it goes on at its end, or comes from before its start. Else it is an added or a dropped lane: vm-07-06.
pub fn is_alone(moves: &RoutingMoves, at: usize, end: bool) -> bool {
    let goes_on = |other: usize| if end { moves.leads_on(other) } else { moves.is_led_to(other) };
    !moves.beside(at).iter().any(|other| goes_on(other.lane))
}

/// Whether no lane leads to a lane's start, or away from its end.
pub fn is_open(map: &MapIndex, at: usize, start: bool) -> bool {
    if start { map.predecessors(at).is_empty() } else { map.followers(at).is_empty() }
}

/// Angle (deg) from which on a lane leads back.
const BACK: f64 = 120.0;

/// Whether a lane leads back close to where one ends, or leads there close to where one starts.
pub fn is_turning_place(map: &MapIndex, params: &Params, at: usize, end: bool) -> bool {
    let lane = &map.lanes[at];
    let (place, heading) = match end {
        true => (lane.end.middle(), lane.heading_out()),
        false => (lane.start.middle(), lane.heading_in()),
    };
    map.edges_near(place, params.turning_place, !end).into_iter().any(|at| {
        let other = &map.lanes[at];
        let edge = if end { other.start } else { other.end };
        if !other.vehicle || (edge.middle() - place).norm() > params.turning_place || !is_open(map, at, end) {
            return false;
        }
        let onward = if end { other.heading_in() } else { other.heading_out() };
        heading.zip(onward).is_some_and(|(a, b)| angle_between(a, b).abs().to_degrees() >= BACK)
    })
}
