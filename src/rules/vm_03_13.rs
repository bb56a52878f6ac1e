//! vm-03-13: driveways, and the sidewalks that they cross.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Vector, angle_between, polygon};
use crate::lanelet::index::{Lane, MapIndex, STRAIGHT_ON, U_TURN};
use crate::lanelet::{LaneletId, RegulatoryElement, RoadType};

use super::road_borders::Borders;
use super::walkway;
use super::walkway::walking_allowed;

/// Vehicles whose directions differ by more, degrees, come towards each other.
const ONCOMING: f64 = 135.0;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    overhang: f64,
    touch: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let borders = Borders::of(map);
    let mut findings = Vec::new();
    for at in (0..map.lanes.len()).filter(|&at| map.lanes[at].vehicle) {
        findings.extend(judge_exit(map, at));
        findings.extend(private_alone(map, at));
        findings.extend(walkway_missing(map, params, &borders, at));
    }
    let has_crosswalks = map.map.regulatory_elements.iter().any(|element| element.subtype == "crosswalk");
    let walkway = |at: &usize| map.lanes[*at].kind == RoadType::Walkway && map.lanes[*at].simple;
    for at in (0..map.lanes.len()).filter(walkway) {
        findings.extend(judge_walkway(map, params, at, has_crosswalks));
    }
    findings
}

fn is_at(map: &MapIndex, lane: usize, location: &str) -> bool {
    map.lanes[lane].lanelet.attributes.is("location", location)
}

/// The lanelet that leads from private ground onto the road.
fn judge_exit(map: &MapIndex, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let subject = Subject::Lanelet(lane.id.0);
    let road = *map
        .followers(at)
        .iter()
        .find(|&&next| map.lanes[next].vehicle && is_at(map, next, "urban") && meets_others(map, at, next))?;
    let next = Subject::Lanelet(map.lanes[road].id.0);
    let before = || map.predecessors(at).iter().filter(|&&lane| map.lanes[lane].vehicle);
    // What leads here from a public road, too, is a turn of that one.
    let is_private = |lane: usize| is_at(map, lane, "private") && !is_private_alone(map, lane);
    let is_exit = || before().next().is_some() && before().all(|&lane| is_private(lane));
    if is_at(map, at, "urban") && is_exit() {
        let message = format!("Driveway lanelet {} joins a public road but is not private.", lane.id);
        let edits = vec![Edit::SetTag { on: subject, key: "location".into(), value: "private".into() }];
        let finding = Finding::new("exit-not-private", subject, message).with(next, "road");
        return Some(finding.fixed_by("set location=private", true, edits));
    }
    // What turns onto the road behind it has the tag.
    if !is_at(map, at, "private") || map.turn_direction(at).is_some() || map.turn_direction(road).is_some() {
        return None;
    }
    let message = format!("Driveway lanelet {} joins a public road but lacks turn_direction.", lane.id);
    let label = map.label_for(lane.turn(), STRAIGHT_ON, U_TURN).as_str();
    let edits = vec![Edit::SetTag { on: subject, key: "turn_direction".into(), value: label.into() }];
    let finding = Finding::new("exit-no-turn", subject, message).with(next, "road");
    Some(finding.fixed_by(format!("set turn_direction={label}"), true, edits))
}

/// A lanelet in a row of public ones that alone says that it is private.
fn private_alone(map: &MapIndex, at: usize) -> Option<Finding> {
    if !is_private_alone(map, at) {
        return None;
    }
    let (id, subject) = (map.lanes[at].id, Subject::Lanelet(map.lanes[at].id.0));
    let message = format!("Lanelet {id} is private, but the road before and behind it is public.");
    let edits = vec![Edit::SetTag { on: subject, key: "location".into(), value: "urban".into() }];
    let both = map.predecessors(at).iter().chain(map.followers(at));
    let finding = Finding::new("private-alone", subject, message);
    let finding = both.fold(finding, |all, &other| all.with(Subject::Lanelet(map.lanes[other].id.0), "public"));
    Some(finding.fixed_by("set location=urban", false, edits))
}

/// Whether one public lanelet leads straight into a private one, and one straight on from it: where private ground begins and ends,
/// vehicles turn off.
fn is_private_alone(map: &MapIndex, at: usize) -> bool {
    let goes_on = |lane: usize| {
        map.lanes[lane].vehicle && map.turn_direction(lane).is_none() && map.lanes[lane].turn().abs() < STRAIGHT_ON
    };
    let is_public_road = |lane: usize| is_at(map, lane, "urban") && goes_on(lane);
    let ([before], [behind]) = (map.predecessors(at), map.followers(at)) else { return false };
    is_at(map, at, "private")
        && goes_on(at)
        && [*before, *behind].into_iter().all(is_public_road)
        && map.followers(*before).len() == 1
        && map.predecessors(*behind).len() == 1
}

/// Whether others drive onto the same road, or across the lanelet that leads there. Where a road only stops being private,
/// nobody does, and there is nothing to merge with.
fn meets_others(map: &MapIndex, at: usize, road: usize) -> bool {
    let vehicle = |lane: usize| map.lanes[lane].vehicle;
    // On a narrow road the oncoming lane lies under it.
    let is_oncoming = |other: usize| {
        let [own, theirs] = [at, other].map(|lane| &map.lanes[lane]);
        let are_opposite = |a: Option<Vector>, b: Option<Vector>| {
            a.zip(b).is_some_and(|(a, b)| angle_between(a, b).abs() > ONCOMING.to_radians())
        };
        are_opposite(own.heading_in(), theirs.heading_out()) && are_opposite(own.heading_out(), theirs.heading_in())
    };
    map.predecessors(road).iter().any(|&other| other != at && vehicle(other))
        || map.conflicts[at].iter().any(|one| one.real && vehicle(one.other) && !is_oncoming(one.other))
}

/// A connector between private ground and the road that crosses a kerb or a strip for people on foot, and no walkway.
fn walkway_missing(map: &MapIndex, params: &Params, borders: &Borders, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let beside = |lanes: &[usize], location| lanes.iter().any(|&lane| is_at(map, lane, location));
    let connector = (beside(map.predecessors(at), "private") && beside(map.followers(at), "urban"))
        || (beside(map.predecessors(at), "urban") && beside(map.followers(at), "private"))
        || (is_at(map, at, "private") && (beside(map.followers(at), "urban") || beside(map.predecessors(at), "urban")));
    if !connector || !lane.simple {
        return None;
    }
    let near = map.lanes_near(lane.extent[0], lane.extent[1]);
    let over = |kinds: &[RoadType]| {
        near.iter().map(|&other| &map.lanes[other]).find(|other| {
            kinds.contains(&other.kind)
                && other.simple
                && polygon::overlap(&other.outline, &lane.outline) > params.touch
        })
    };
    if over(&[RoadType::Walkway, RoadType::Crosswalk]).is_some() {
        return None;
    }
    let message = |what: String| format!("Driveway lanelet {} crosses {what} but no walkway.", lane.id);
    let subject = Subject::Lanelet(lane.id.0);
    if let Some(strip) = over(&[RoadType::PedestrianLane]) {
        let finding = Finding::new("walkway-missing", subject, message(format!("pedestrian lane {}", strip.id)));
        return Some(finding.with(Subject::Lanelet(strip.id.0), "pedestrian lane"));
    }
    let on_level = |&(border, place): &_| map.is_level_with(at, border, place);
    let (border, place) = borders.crossed(lane.center.as_ref()?, on_level)?;
    let finding = Finding::new("walkway-missing", subject, message(format!("road border {border}")));
    Some(finding.with(Subject::LineString(border.0), "road border").at(Place::Point(place)))
}

/// Whether a walkway leads across a lane, and not below a bridge.
fn crosses(map: &MapIndex, params: &Params, walkway: usize, lane: usize) -> bool {
    let shared = polygon::common_part(&map.lanes[walkway].outline, &map.lanes[lane].outline);
    shared.is_some_and(|(area, place)| area > params.touch && map.are_level(walkway, lane, place))
}

fn judge_walkway(map: &MapIndex, params: &Params, at: usize, has_crosswalks: bool) -> Vec<Finding> {
    let walkway = &map.lanes[at];
    let subject = Subject::Lanelet(walkway.id.0);
    let near = map.lanes_near(walkway.extent[0], walkway.extent[1]);
    let crossed: Vec<&Lane> = near
        .into_iter()
        .filter(|&other| {
            let lane = &map.lanes[other];
            lane.kind == RoadType::Road
                && lane.vehicle
                && lane.simple
                && walkway::leads_over(walkway, lane)
                && walkway::crossed(walkway, [lane]).is_some()
                && crosses(map, params, at, other)
        })
        .map(|other| &map.lanes[other])
        .collect();
    if crossed.is_empty() {
        let message = format!("Walkway {} crosses no road lanelet.", walkway.id);
        return vec![walkway::as_pedestrian_lane(map, Finding::new("walkway-idle", subject, message), walkway.id)];
    }
    let mut findings = Vec::new();
    findings.extend(walkway_short(params, walkway, &crossed));
    for lane in crossed.iter().filter(|_| has_crosswalks) {
        let announced =
            map.elements(lane.id, "crosswalk").any(|element| element.lanelets("refers").any(|id| id == walkway.id));
        if announced {
            continue;
        }
        let message =
            format!("Walkway {} is referenced by no crosswalk element of crossing lane {}.", walkway.id, lane.id);
        let finding = Finding::new("walkway-unreferenced", subject, message);
        let finding = finding.with(Subject::Lanelet(lane.id.0), "crossing lane");
        let lost = map.elements(lane.id, "crosswalk").find_map(|element| refers_again(map, element, subject));
        let (title, edits) = lost.unwrap_or_else(|| {
            let (members, referrers) = (vec![("refers".into(), subject)], vec![lane.id.0]);
            let edit = Edit::CreateRegulatoryElement { subtype: "crosswalk".into(), members, referrers };
            (format!("let lane {} announce it", lane.id), vec![edit])
        });
        let edits = walking_allowed(map, walkway.id).into_iter().chain(edits).collect();
        findings.push(finding.fixed_by(title, true, edits));
    }
    findings
}

/// What lets an element refer to a walkway if it refers to nothing on which people walk: it may have lost the walkway.
fn refers_again(map: &MapIndex, element: &RegulatoryElement, walkway: Subject) -> Option<(String, Vec<Edit>)> {
    let on = Subject::RegulatoryElement(element.id.0);
    let is_walked = |id: LaneletId| {
        let lanelet = map.map.lanelets.get(id);
        lanelet.is_none_or(|it| it.attributes.is("subtype", "crosswalk") || it.attributes.is("subtype", "walkway"))
    };
    if element.lanelets("refers").any(is_walked) {
        return None;
    }
    let wrong = element.lanelets("refers").map(|id| Subject::Lanelet(id.0));
    let mut edits: Vec<Edit> = wrong.map(|member| Edit::RemoveMember { on, role: "refers".into(), member }).collect();
    edits.push(Edit::AddMember { on, role: "refers".into(), member: walkway });
    Some((format!("let {on} refer to it"), edits))
}

/// How far the walkway reaches beyond the lanes that it crosses, at the end where that is less.
fn walkway_short(params: &Params, walkway: &Lane, crossed: &[&Lane]) -> Option<Finding> {
    let [first, last] = walkway::crossed(walkway, crossed.iter().copied())?;
    let overhang = first.min(walkway.length() - last);
    if overhang >= params.overhang {
        return None;
    }
    let message = format!("Walkway {} overhangs the lanes that it crosses by {overhang:.2} m only.", walkway.id);
    let finding = Finding::new("walkway-short", Subject::Lanelet(walkway.id.0), message);
    let finding = finding.measured(overhang, params.overhang, "m");
    Some(crossed.iter().fold(finding, |finding, lane| finding.with(Subject::Lanelet(lane.id.0), "crossing lane")))
}
