//! Finds lanes that nobody can drive into or out of: every other road is one-way against them, restrictions forbid the turns, or
//! a car would have to turn back. Directs single tracks the way that they lead, and ends roads where no turn leads to them.

use crate::builder::ids::Key;
use crate::builder::tags::cross_section::Travel;
use crate::builder::tags::road_class::DrivingSide;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::{Point, cross};

use super::closed_by::ClosedBy;
use super::resolved_restrictions::ResolvedRestrictions;
use super::road_end::{at_depth, leads_out, outward};
use super::turn_angle::{STRAIGHT_ON, TURNS_BACK, turn};
use super::{End, Intersection, IntersectionIx, RoadEnd, RoadIx, RoadKey, RoadNetwork, Stations};

/// Roads that are directed one after another, each because of the one before, reach no farther than this, metres, so that their
/// directions depend on nothing far away.
const LONGEST_CHAIN: f64 = 300.0;
/// Distance from the intersection at which the direction of a road is taken, metres.
const LOOK: f64 = 10.0;
/// The least distance between two roads side by side, metres, at which a vehicle can turn back from one to the other.
const ROOM_TO_TURN: f64 = 9.0;
/// A road that nobody turns into ends this far, metres, behind its cut ...
const SETBACK: f64 = 2.0;
/// ... if this length of it is left, metres.
const LEAST_LEFT: f64 = 6.0;

/// The network without directions of single tracks that lead nowhere, and with roads ended where no turn leads into them or out
/// of them; with a note for each direction of travel that nobody can enter or leave.
///
/// A single track loses the direction at whose end every other road is one-way against it, or at whose beginning every other
/// road leads away. A two-way lane in the middle of a road loses the direction at whose end no road can be turned into and
/// no lane continues. Where no turn is left for any lane at the end of a road, the road ends before the intersection; where
/// lanes of the other direction lead on, it stays as it is: who starts on such lanes can leave them. `kept` are the stations between
/// which the outlines leave each road.
#[must_use]
pub fn without_unreachable_lanes(
    mut network: RoadNetwork,
    mut kept: Vec<Stations>,
) -> (RoadNetwork, Vec<Stations>, Vec<Finding>) {
    let mut chains = vec![0.0; network.roads.len()];
    while direct_single_tracks(&mut network, &mut chains) {}
    let (restrictions, _) = ResolvedRestrictions::new(&network);
    let ends = RoadIx::all(network.roads.len()).flat_map(|road| End::BOTH.map(|end| RoadEnd { road, end }));
    let closed: Vec<ClosedLanes> = ends.flat_map(|at| closed_lanes(&network, &restrictions, at)).collect();
    let notes = closed.iter().map(|closed| closed.note(&network)).collect();
    for closed in closed.iter().filter(|closed| closed.whole_end) {
        detach(&mut network, &mut kept, closed.at, closed.why);
    }
    (network, kept, notes)
}

/// Gives single tracks and two-way lanes the only direction in which they lead on; `false` if there are none. `chains` holds for
/// each road the length, metres, of those that were directed one after another up to it and with it; 0 if it was not.
fn direct_single_tracks(network: &mut RoadNetwork, chains: &mut [f64]) -> bool {
    let directed = |road: RoadIx| {
        let (strip, travel) = remaining_travel(network, road)?;
        let beside = End::BOTH.into_iter().flat_map(|end| others(network, RoadEnd { road, end }));
        let before = beside.map(|arm| chains[arm.road.position()]).fold(0.0, f64::max);
        (before <= LONGEST_CHAIN).then(|| (road, strip, travel, before + network.road(road).line.length()))
    };
    let directed: Vec<_> = RoadIx::all(network.roads.len()).filter_map(directed).collect();
    for &(road, strip, travel, chain) in &directed {
        network.roads[road].section.strips[strip].travel = travel;
        chains[road.position()] = chain;
    }
    !directed.is_empty()
}

/// Lanes of one direction of a road that nobody can drive into, or out of, at an end.
struct ClosedLanes {
    at: RoadEnd,
    travel: Travel,
    why: ClosedBy,
    /// Whether that is so of all lanes at this end, and other roads would lead on.
    whole_end: bool,
}

impl ClosedLanes {
    fn note(&self, network: &RoadNetwork) -> Finding {
        let RoadKey { way, first, last, .. } = network.road(self.at.road).key;
        let verb = if self.at.end.inbound() == self.travel { "leave" } else { "enter" };
        let direction = if self.travel == Travel::Forward { "with" } else { "against" };
        let node = network.intersection(network.intersection_at(self.at)).first_node();
        let why = match self.why {
            ClosedBy::OneWays => "every other road there is one-way against it",
            ClosedBy::Restrictions => "restrictions forbid every turn",
            ClosedBy::Angle => "a car would have to turn back",
            ClosedBy::Room => "there is no room for the turns",
        };
        let message = format!(
            "nobody can {verb} the lanes of way {way} {direction} its line, nodes {first} to {last}, at node {node}: {why}"
        );
        Finding::new("lanes-unreachable", Subject::Way(way), message).graded(Severity::Info)
    }
}

/// The lanes at the end of a road that nobody can enter or leave there; none of a one-way road that other roads do not lead to.
fn closed_lanes(network: &RoadNetwork, restrictions: &ResolvedRestrictions, at: RoadEnd) -> Vec<ClosedLanes> {
    let directions = [false, true].into_iter().filter(|away| lanes(network, at, *away) > 0);
    let found: Vec<(bool, Option<ClosedBy>)> =
        directions.map(|away| (away, closed_by(network, restrictions, at, away))).collect();
    let whole_end = found.iter().all(|(_, why)| why.is_some())
        && found.iter().any(|(_, why)| why.is_some_and(|why| why != ClosedBy::OneWays));
    if found.len() < 2 && !whole_end {
        return Vec::new();
    }
    let closed = found.into_iter().filter_map(|(away, why)| Some((away, why?)));
    closed.map(|(away, why)| ClosedLanes { at, travel: travel(at.end, away), why, whole_end }).collect()
}

/// What keeps all vehicles from driving into a road at its end (`away`), or out of it; `None` if some can, or no other road
/// ends there.
fn closed_by(network: &RoadNetwork, restrictions: &ResolvedRestrictions, at: RoadEnd, away: bool) -> Option<ClosedBy> {
    let intersection = network.intersection(network.intersection_at(at));
    if intersection.map_edge || intersection.circle.is_some() || intersection.arms.len() < 2 {
        return None;
    }
    let mut roads = others(network, at).filter(|&other| lanes(network, other, !away) > 0).peekable();
    if roads.peek().is_none() {
        return Some(ClosedBy::OneWays);
    }
    let permitted = |from, to| restrictions.permit(intersection, from, to);
    let mut why = ClosedBy::Restrictions;
    for other in roads {
        let (from, to) = if away { (other, at) } else { (at, other) };
        if permitted(from, to) {
            why = ClosedBy::Angle;
            // Where nothing else is left, vehicles turn back.
            let has_choice = others(network, from).any(|onto| {
                onto != to && leads_out(network, onto) && permitted(from, onto) && !turns_back(network, from, onto)
            });
            if !turns_back(network, from, to) || !has_choice {
                return None;
            }
        }
    }
    Some(why)
}

/// Whether the way from one end of a road to another is a turn back without room for it.
fn turns_back(network: &RoadNetwork, from: RoadEnd, to: RoadEnd) -> bool {
    let [a, b] = [from, to].map(|at| outward(network.road(at.road), at.end, LOOK));
    let place = |at: RoadEnd| -> Point {
        let line = &network.road(at.road).line;
        line.at(match at.end {
            End::Start => LOOK,
            End::End => line.length() - LOOK,
        })
    };
    let beside = cross(a.normalize(), place(to) - place(from)).abs();
    turn(network.side, -a, b).abs() > TURNS_BACK && beside < ROOM_TO_TURN
}

/// Ends a road before its intersection where no lanelet joins its lanes: restrictions forbid it, or all turns are too tight. With a
/// note for each direction of travel; none where the road stays as it is because it is too short, the only one there, or has no lane. `kept` are
/// the stations between which the outlines leave each road.
pub fn end_road_without_turns(
    network: &mut RoadNetwork,
    restrictions: &ResolvedRestrictions,
    kept: &mut [Stations],
    at: RoadEnd,
) -> Vec<Finding> {
    let why = |away: bool| closed_by(network, restrictions, at, away).unwrap_or(ClosedBy::Room);
    let note = |away: bool| {
        let why = why(away);
        ClosedLanes { at, travel: travel(at.end, away), why, whole_end: true }.note(network)
    };
    let directions = || [false, true].into_iter().filter(|away| lanes(network, at, *away) > 0);
    let notes: Vec<Finding> = directions().map(note).collect();
    let Some(why) = directions().map(why).next() else { return Vec::new() };
    if detach(network, kept, at, why) { notes } else { Vec::new() }
}

/// Takes from a road the direction for which no lanelet leads to it at its end (`away`) or from it, though one does for the other
/// direction. With a note; `None` where a road with lanes for either direction stays as it is: what keeps vehicles from turning there
/// is the streets, and not only the room.
pub fn direct_half_served(
    network: &mut RoadNetwork,
    restrictions: &ResolvedRestrictions,
    at: RoadEnd,
    away: bool,
) -> Option<Finding> {
    let single = two_way_strip(network, at.road).is_some() && network.road(at.road).section.driven().count() == 1;
    let closed = closed_by(network, restrictions, at, away);
    if !single && closed.is_some() {
        return None;
    }
    let (lost, left) = (travel(at.end, away), travel(at.end, !away));
    let why = closed.unwrap_or(ClosedBy::Room);
    let note = ClosedLanes { at, travel: lost, why, whole_end: false }.note(network);
    let strips = &mut network.roads[at.road].section.strips;
    strips.retain(|strip| !(strip.kind.is_driven() && strip.travel == lost));
    let both = strips.iter_mut().filter(|strip| strip.kind.is_driven() && strip.travel == Travel::Both);
    both.for_each(|strip| strip.travel = left);
    Some(note)
}

/// Ends a road before its intersection because of `why`; `false` where it is too short or the only road there.
fn detach(network: &mut RoadNetwork, kept: &mut [Stations], at: RoadEnd, why: ClosedBy) -> bool {
    let old = network.intersection_at(at);
    let RoadKey { way, first, last, turn } = network.road(at.road).key;
    let [from, to] = kept[at.road];
    if to - from < LEAST_LEFT || network.intersection(old).arms.len() < 2 {
        return false;
    }
    let station = at_depth(kept[at.road], at.end, SETBACK);
    kept[at.road][at.end] = station;
    let key = Key::new("closed end").number(way).number(first).number(last).number(i64::from(turn));
    let new = IntersectionIx::new(network.intersections.len());
    let nodes = vec![key.number(at.end.index() as i64).new_node()];
    let position = network.road(at.road).line.at(station);
    let end = Intersection { closed_by: Some(why), ..Intersection::of_arms(nodes, position, vec![at]) };
    network.intersections.push(end);
    network.intersections[old].arms.retain(|arm| *arm != at);
    // Nobody drives over this end any more: nothing is left to forbid.
    network.restrictions.retain(|r| !r.via.contains(&at.road));
    let road = &mut network.roads[at.road];
    match at.end {
        End::Start => road.from = new,
        End::End => road.to = new,
    }
    true
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
        let turns_into = across > STRAIGHT_ON && across < TURNS_BACK;
        let enough_lanes = lanes(network, other, true) >= lanes(network, arm, false);
        let goes_on = turn.abs() <= STRAIGHT_ON && (enough_lanes || two_way_strip(network, other.road).is_some());
        turns_into || goes_on
    };
    !ahead.is_empty() && !ahead.iter().any(leads_to)
}

/// The direction of travel away from one end of a road, or towards it.
fn travel(end: End, away: bool) -> Travel {
    if away { end.other().inbound() } else { end.inbound() }
}
