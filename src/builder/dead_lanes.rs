//! Single tracks are driven both ways, but for those that lead only into roads one may not enter.

use super::cross_section::Travel;
use super::road_network::{End, RoadEnd, RoadNetwork};

/// Rounds after which a chain of single tracks that lead nowhere is left as it is.
const ROUNDS: usize = 16;

/// Takes from single tracks the direction that ends where every other road is one-way against it. Nobody could drive it
/// but by turning around, and the lane the other way lies on the same ground.
#[must_use]
pub fn without_dead_lanes(mut network: RoadNetwork) -> RoadNetwork {
    for _ in 0..ROUNDS {
        let dead: Vec<RoadEnd> = network
            .intersections
            .iter()
            .filter(|i| !i.map_edge && i.arms.len() > 1)
            .flat_map(|i| &i.arms)
            .copied()
            .filter(|&at| is_single_track(&network, at) && !has_way_on(&network, at))
            .collect();
        if dead.is_empty() {
            break;
        }
        for at in dead {
            let travel = if at.end == End::End { Travel::Backward } else { Travel::Forward };
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

/// Whether any other road at this end may be entered.
fn has_way_on(network: &RoadNetwork, at: RoadEnd) -> bool {
    let arms = &network.intersection(network.road(at.road).intersection(at.end)).arms;
    arms.iter().filter(|&&other| other != at).any(|other| {
        let away = if other.end == End::Start { Travel::Forward } else { Travel::Backward };
        network.road(other.road).section.driven().any(|(_, s)| s.travel == away || s.travel == Travel::Both)
    })
}
