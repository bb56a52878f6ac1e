//! Removes the direction in which a two-way lane leads nowhere.

use crate::builder::tags::cross_section::Travel;
use crate::builder::tags::road_class::DrivingSide;

use super::road_end::outward;
use super::turn_angle::{STRAIGHT, TURNS_BACK, turn};
use super::{End, RoadEnd, RoadIx, RoadNetwork};

/// Most rounds; each follows a chain of such lanes by one road.
const ROUNDS: usize = 16;
/// Distance from the intersection at which the direction of a road is taken, metres.
const LOOK: f64 = 10.0;

/// The network without directions of travel that lead nowhere.
///
/// A single track loses the direction at whose end every other road is one-way against it, or at whose beginning every other
/// road leads away. A two-way lane in the middle of a road loses the direction at whose end no road can be turned into and
/// no lane continues.
#[must_use]
pub fn without_unreachable_lanes(mut network: RoadNetwork) -> RoadNetwork {
    for _ in 0..ROUNDS {
        let remaining: Vec<Option<(usize, Travel)>> =
            RoadIx::all(network.roads.len()).map(|road| remaining_travel(&network, road)).collect();
        if remaining.iter().all(Option::is_none) {
            break;
        }
        for (road, remaining) in network.roads.iter_mut().zip(remaining) {
            if let Some((strip, travel)) = remaining {
                road.section.strips[strip].travel = travel;
            }
        }
    }
    network
}

/// The two-way strip of a road and the only direction in which it leads on; `None` if both or neither do, or if the road does
/// not have exactly one such strip.
fn remaining_travel(network: &RoadNetwork, road: RoadIx) -> Option<(usize, Travel)> {
    let strip = two_way_strip(network, road)?;
    let ends = End::BOTH.map(|end| RoadEnd { road, end });
    let travel = if network.road(road).section.driven().count() == 1 {
        ends.iter().find_map(|&arm| single_track(network, arm))
    } else {
        match ends.map(|arm| leads_nowhere(network, arm)) {
            [true, false] => Some(Travel::Forward),
            [false, true] => Some(Travel::Backward),
            _ => None,
        }
    };
    travel.map(|travel| (strip, travel))
}

/// The two-way strip of a road, if there is exactly one.
fn two_way_strip(network: &RoadNetwork, road: RoadIx) -> Option<usize> {
    let mut both = network.road(road).section.driven().filter(|(_, strip)| strip.travel == Travel::Both);
    let (Some((strip, _)), None) = (both.next(), both.next()) else { return None };
    Some(strip)
}

/// The other arms of the intersection at one end of a road; none where the map ends.
fn others(network: &RoadNetwork, arm: RoadEnd) -> impl Iterator<Item = RoadEnd> {
    let intersection = network.intersection(network.intersection_at(arm));
    let arms = if intersection.map_edge { &[] } else { &intersection.arms[..] };
    arms.iter().copied().filter(move |&other| other != arm)
}

/// The number of lanes that lead away from one end of a road, or towards it.
fn lanes(network: &RoadNetwork, arm: RoadEnd, away: bool) -> usize {
    let travel = travel(arm.end, away);
    let driven = network.road(arm.road).section.driven();
    driven.filter(|(_, strip)| strip.travel == travel || strip.travel == Travel::Both).count()
}

/// The only direction of a single track in which traffic can pass this end; `None` if both can, or neither.
fn single_track(network: &RoadNetwork, arm: RoadEnd) -> Option<Travel> {
    let any = |away| others(network, arm).any(|other| lanes(network, other, away) > 0);
    match (any(true), any(false)) {
        (false, true) => Some(travel(arm.end, true)),
        (true, false) => Some(travel(arm.end, false)),
        _ => None,
    }
}

/// Whether a two-way lane in the middle of a road leads nowhere at this end, although other roads leave there.
fn leads_nowhere(network: &RoadNetwork, arm: RoadEnd) -> bool {
    let outward = |arm: RoadEnd| outward(network.road(arm.road), arm.end, LOOK);
    let ahead: Vec<RoadEnd> = others(network, arm).filter(|&other| lanes(network, other, true) > 0).collect();
    let leads_to = |&other: &RoadEnd| {
        let turn = turn(network.side, -outward(arm), outward(other));
        let across = if network.side == DrivingSide::Right { turn } else { -turn };
        let turns_into = across > STRAIGHT && across < TURNS_BACK;
        let enough_lanes = lanes(network, other, true) >= lanes(network, arm, false);
        let goes_on = turn.abs() <= STRAIGHT && (enough_lanes || two_way_strip(network, other.road).is_some());
        turns_into || goes_on
    };
    !ahead.is_empty() && !ahead.iter().any(leads_to)
}

/// The direction of travel away from one end of a road, or towards it.
fn travel(end: End, away: bool) -> Travel {
    if away { end.other().inbound() } else { end.inbound() }
}
