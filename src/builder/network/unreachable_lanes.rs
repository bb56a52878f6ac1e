//! Lanes that are driven both ways lose the direction in which they lead nowhere.

use crate::builder::tags::cross_section::Travel;
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::Vector;

use super::turn::{STRAIGHT, TURNS_BACK, turn};
use super::{End, RoadEnd, RoadIx, RoadNetwork};

/// Rounds after which a chain of lanes that lead nowhere is left as it is.
const ROUNDS: usize = 16;
/// How far from an intersection roads show where they lead, metres.
const LOOK: f64 = 10.0;

/// Takes from single tracks the direction that ends where every other road is one-way against it, or begins where every
/// other road leads away: nobody could drive it but by turning around, and the lane the other way lies on the same
/// ground. From a lane in the middle, between those of both directions, it takes the one in which there is nothing to
/// turn into and no lane to go on in: who stayed on it would have to push into the lane beside it.
#[must_use]
pub fn without_unreachable_lanes(mut network: RoadNetwork) -> RoadNetwork {
    for _ in 0..ROUNDS {
        let left: Vec<Option<(usize, Travel)>> =
            (0..network.roads.len() as u32).map(|road| left_over(&network, RoadIx(road))).collect();
        if left.iter().all(Option::is_none) {
            break;
        }
        for (road, left) in network.roads.iter_mut().zip(left) {
            if let Some((strip, travel)) = left {
                road.section.strips[strip].travel = travel;
            }
        }
    }
    network
}

/// The strip of a road that is driven both ways, and the only direction in which it leads on; `None` where both do, or
/// neither, and without such a strip or with several.
fn left_over(network: &RoadNetwork, road: RoadIx) -> Option<(usize, Travel)> {
    let strip = driven_both_ways(network, road)?;
    let ends = End::BOTH.map(|end| RoadEnd { road, end });
    let travel = if network.road(road).section.driven().count() == 1 {
        ends.iter().find_map(|&at| single_track(network, at))
    } else {
        match ends.map(|at| is_dead(network, at)) {
            [true, false] => Some(Travel::Forward),
            [false, true] => Some(Travel::Backward),
            _ => None,
        }
    };
    travel.map(|travel| (strip, travel))
}

/// The only strip of a road that is driven both ways.
fn driven_both_ways(network: &RoadNetwork, road: RoadIx) -> Option<usize> {
    let mut both = network.road(road).section.driven().filter(|(_, strip)| strip.travel == Travel::Both);
    let (Some((strip, _)), None) = (both.next(), both.next()) else { return None };
    Some(strip)
}

/// The other arms of the intersection at one end of a road; none where the map ends.
fn others(network: &RoadNetwork, at: RoadEnd) -> impl Iterator<Item = RoadEnd> {
    let intersection = network.intersection(network.road(at.road).intersection(at.end));
    let arms = if intersection.map_edge { &[] } else { &intersection.arms[..] };
    arms.iter().copied().filter(move |&other| other != at)
}

/// How many lanes of a road are driven away from one of its ends, or to it.
fn lanes(network: &RoadNetwork, at: RoadEnd, away: bool) -> usize {
    let wanted = travel(at.end, away);
    let driven = network.road(at.road).section.driven();
    driven.filter(|(_, strip)| strip.travel == wanted || strip.travel == Travel::Both).count()
}

/// The direction in which a single track is driven beyond this end; `None` if both are, or neither.
fn single_track(network: &RoadNetwork, at: RoadEnd) -> Option<Travel> {
    let any = |away| others(network, at).any(|other| lanes(network, other, away) > 0);
    match (any(true), any(false)) {
        (false, true) => Some(travel(at.end, true)),
        (true, false) => Some(travel(at.end, false)),
        _ => None,
    }
}

/// Whether a lane in the middle leads nowhere at this end, although others do.
fn is_dead(network: &RoadNetwork, at: RoadEnd) -> bool {
    let ahead: Vec<RoadEnd> = others(network, at).filter(|&other| lanes(network, other, true) > 0).collect();
    let leads_to = |&other: &RoadEnd| {
        let turn = turn(network.side, -outward(network, at), outward(network, other));
        let across = if network.side == DrivingSide::Right { turn } else { -turn };
        let into = across > STRAIGHT && across < TURNS_BACK;
        let room = lanes(network, other, true) >= lanes(network, at, false);
        let on = turn.abs() <= STRAIGHT && (room || driven_both_ways(network, other.road).is_some());
        into || on
    };
    !ahead.is_empty() && !ahead.iter().any(leads_to)
}

/// The direction in which a road leaves the intersection at one of its ends.
fn outward(network: &RoadNetwork, at: RoadEnd) -> Vector {
    let line = &network.road(at.road).line;
    match at.end {
        End::Start => line.at(LOOK) - line.first(),
        End::End => line.at(line.length() - LOOK) - line.last(),
    }
}

/// The direction on a road that leads away from one of its ends, or to it.
fn travel(end: End, away: bool) -> Travel {
    if (end == End::Start) == away { Travel::Forward } else { Travel::Backward }
}
