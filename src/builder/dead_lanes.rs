//! Single tracks are driven both ways, but for those that end where one can only arrive, or only leave.

use super::cross_section::Travel;
use super::road_network::{End, RoadEnd, RoadNetwork};

/// Rounds after which a chain of single tracks that lead nowhere is left as it is.
const ROUNDS: usize = 16;

/// Takes from single tracks the direction that ends where every other road is one-way against it, or begins where every
/// other road leads away. Nobody could drive it but by turning around, and the lane the other way lies on the same
/// ground.
#[must_use]
pub fn without_dead_lanes(mut network: RoadNetwork) -> RoadNetwork {
    for _ in 0..ROUNDS {
        let dead: Vec<(RoadEnd, Travel)> = network
            .intersections
            .iter()
            .filter(|i| !i.map_edge && i.arms.len() > 1)
            .flat_map(|i| &i.arms)
            .filter(|&&at| is_single_track(&network, at))
            .filter_map(|&at| left_over(&network, at).map(|travel| (at, travel)))
            .collect();
        if dead.is_empty() {
            break;
        }
        for (at, travel) in dead {
            for strip in &mut network.roads[at.road.0 as usize].section.strips {
                if strip.travel == Travel::Both {
                    strip.travel = travel;
                }
            }
        }
    }
    network
}

/// Whether the only driven strip of a road is for both directions.
fn is_single_track(network: &RoadNetwork, at: RoadEnd) -> bool {
    let mut driven = network.road(at.road).section.driven();
    matches!((driven.next(), driven.next()), (Some((_, strip)), None) if strip.travel == Travel::Both)
}

/// The only direction of a road that goes on beyond this end; `None` if both do, or neither.
fn left_over(network: &RoadNetwork, at: RoadEnd) -> Option<Travel> {
    let arms = &network.intersection(network.road(at.road).intersection(at.end)).arms;
    let others: Vec<RoadEnd> = arms.iter().copied().filter(|&other| other != at).collect();
    let any = |away: bool| {
        others.iter().any(|other| {
            let travel = travel(other.end, away);
            network.road(other.road).section.driven().any(|(_, s)| s.travel == travel || s.travel == Travel::Both)
        })
    };
    match (any(true), any(false)) {
        (false, true) => Some(travel(at.end, true)),
        (true, false) => Some(travel(at.end, false)),
        _ => None,
    }
}

/// The direction on a road that leads away from one of its ends, or to it.
fn travel(end: End, away: bool) -> Travel {
    if (end == End::Start) == away { Travel::Forward } else { Travel::Backward }
}
