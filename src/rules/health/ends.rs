//! Lanes inside the map that lead nowhere, or into which nothing leads.

use crate::diagnostic::{Finding, Place, Severity};
use crate::geometry::{Point, Vector, angle_between, cross};
use crate::lanelet::index::{Edge, MapIndex};
use crate::rules::map_border::border;
use crate::rules::routing_moves::RoutingMoves;
use crate::rules::two_way::leads_on_backwards;

use super::links::Links;
use super::params::{Params, subject};
use super::street_ends::{is_alone, is_open, is_street};

pub fn judge(map: &MapIndex, params: &Params, moves: &RoutingMoves, links: &Links) -> Vec<Finding> {
    let Some(border) = border(map) else { return Vec::new() };
    let inside = |edge: &Edge| border.distance(edge.middle()) > params.map_border;
    let (mut findings, loose) = (Vec::new(), &map.settings.loose_ends);
    let [into_areas, out_of_areas] = map.lanes_at_areas();
    for at in (0..map.lanes.len()).filter(|&at| is_street(map, at)) {
        let lane = &map.lanes[at];
        if is_alone(moves, at, true)
            && !links.ends.contains(&at)
            && map.followers(at).is_empty()
            && !leads_on_backwards(map, at, true)
            && !into_areas.contains(&at)
            && inside(&lane.end)
            && goes_on(map, params, at, true)
            && !turns(map, params, at, true)
        {
            let message = format!("Lane {} ends inside the map, and no lane leads away from there.", lane.id);
            let known = loose.ends.contains(&lane.id.0);
            findings.push(found(map, at, "dead-end", message, &lane.end, known));
        }
        if is_alone(moves, at, false)
            && !links.starts.contains(&at)
            && map.predecessors(at).is_empty()
            && !leads_on_backwards(map, at, false)
            && !out_of_areas.contains(&at)
            && inside(&lane.start)
            && goes_on(map, params, at, false)
            && !turns(map, params, at, false)
        {
            let message = format!("Lane {} starts inside the map, and no lane leads there.", lane.id);
            let known = loose.starts.contains(&lane.id.0);
            findings.push(found(map, at, "unreachable", message, &lane.start, known));
        }
    }
    findings
}

/// A loose end; a note if it is `known` that the streets lead nowhere there.
fn found(map: &MapIndex, at: usize, fault: &'static str, message: String, edge: &Edge, known: bool) -> Finding {
    let finding = Finding::new(fault, subject(map, at), message).at(Place::Line(edge.points.to_vec()));
    if known { finding.graded(Severity::Info) } else { finding }
}

/// Half the angle (deg) of what lies ahead.
const AHEAD: f64 = 30.0;

/// Whether the map goes on beyond a loose end: another lane lies ahead, not too far off. Else the map ends there.
fn goes_on(map: &MapIndex, params: &Params, at: usize, end: bool) -> bool {
    let lane = &map.lanes[at];
    let (place, heading) = match end {
        true => (lane.end.middle(), lane.heading_out()),
        false => (lane.start.middle(), lane.heading_in().map(|heading| -heading)),
    };
    let Some(heading) = heading else { return false };
    let reach = Vector::repeat(params.map_border);
    let ahead = |p: &Point| {
        let way = p - place;
        way.norm() <= params.map_border && angle_between(heading, way).abs().to_degrees() <= AHEAD
    };
    let near = map.lanes_near(place - reach, place + reach);
    near.into_iter().any(|other| other != at && map.lanes[other].vehicle && map.lanes[other].outline.iter().any(ahead))
}

/// Whether a lane starts close to where this one ends, or the other way round: vehicles turn there, or the road ends. If all such
/// lanes only pass by, and the lane continues farther on, nobody turns: a piece is missing.
fn turns(map: &MapIndex, params: &Params, at: usize, end: bool) -> bool {
    let place = if end { map.lanes[at].end.middle() } else { map.lanes[at].start.middle() };
    let reach = Vector::repeat(params.turning_place);
    let near = map.lanes_near(place - reach, place + reach);
    let close = near.into_iter().filter(|&other| {
        let lane = &map.lanes[other];
        let edge = if end { lane.start } else { lane.end };
        other != at && lane.vehicle && (edge.middle() - place).norm() <= params.turning_place
    });
    let close: Vec<usize> = close.collect();
    let begins = |other: &usize| is_open(map, *other, end);
    close.iter().any(begins) || !(close.is_empty() || resumes(map, params, at, end))
}

/// Whether straight on from a loose end another loose end meets it.
fn resumes(map: &MapIndex, params: &Params, at: usize, end: bool) -> bool {
    let lane = &map.lanes[at];
    let (edge, heading) = match end {
        true => (lane.end, lane.heading_out()),
        false => (lane.start, lane.heading_in().map(|heading| -heading)),
    };
    let Some(heading) = heading else { return false };
    let place = edge.middle();
    let reach = Vector::repeat(params.map_border);
    let near = map.lanes_near(place - reach, place + reach);
    near.into_iter().filter(|&other| other != at && is_street(map, other) && is_open(map, other, end)).any(|other| {
        let lane = &map.lanes[other];
        let (edge, onward) = match end {
            true => (lane.start, lane.heading_in()),
            false => (lane.end, lane.heading_out().map(|heading| -heading)),
        };
        let way = edge.middle() - place;
        let ahead = heading.dot(&way) > 0.0 && way.norm() <= params.map_border;
        let straight = onward.is_some_and(|on| angle_between(heading, on).abs().to_degrees() <= params.straight_on);
        ahead && straight && cross(heading, way).abs() < edge.across().norm() / 2.0
    })
}
