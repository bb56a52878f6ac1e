//! Lanelets and their traffic lights.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::{Point, Polyline};
use crate::lanelet::index::{Edge, MapIndex, Movement, Traffic};
use crate::lanelet::right_of_way::Turn;
use crate::lanelet::{PointId, RegulatoryElement, RoadType};

use super::super::stop_line_crossings::lanes_that_stop;
use super::params::Params;

/// Lanes that start farther (m) from one line across them do not stop at it together.
const STAGGERED: f64 = 1.0;

/// All findings about lights.
pub fn judge(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    for traffic in &map.traffic {
        findings.extend(traffic.movements.iter().filter_map(|movement| link_missing(map, traffic, movement)));
    }
    for (at, lane) in map.lanes.iter().enumerate().filter(|(_, lane)| lane.kind == RoadType::Road) {
        let lights: Vec<&RegulatoryElement> = map.elements(lane.id, "traffic_light").collect();
        if let [first, second, ..] = lights[..] {
            let message = format!("Lanelet {} refers to {} traffic lights; Autoware uses one.", lane.id, lights.len());
            let finding = Finding::new("signal-multi", Subject::Lanelet(lane.id.0), message);
            let finding = finding.with(Subject::RegulatoryElement(first.id.0), "first light");
            let finding = finding.with(Subject::RegulatoryElement(second.id.0), "second light");
            findings.push(without_other_lights(map, finding, at, &lights));
        }
        findings.extend(lights.iter().filter_map(|light| on_in_lane(map, params, at, light)));
    }
    findings.extend(map.map.regulatory_elements.iter().filter_map(|light| no_stopline(map, light)));
    findings
}

/// Adds the edits that let a lanelet refer to the one light whose stop line it starts at, and no longer to those of others.
fn without_other_lights(map: &MapIndex, finding: Finding, lane: usize, lights: &[&RegulatoryElement]) -> Finding {
    let is_own = |light: &&&RegulatoryElement| {
        light.linestrings("ref_line").any(|line| lanes_that_stop(map, line).contains(&lane))
    };
    let (own, others): (Vec<&RegulatoryElement>, Vec<&RegulatoryElement>) = lights.iter().partition(is_own);
    if own.len() != 1 {
        return finding;
    }
    let on = finding.subject;
    let edits = others.iter().map(|light| Edit::RemoveMember {
        on,
        role: "regulatory_element".into(),
        member: Subject::RegulatoryElement(light.id.0),
    });
    finding.fixed_by("no longer refer to the lights of other stop lines", false, edits.collect())
}

/// A lanelet without light though others from the same approach have one. A near turn from a lane of its own may pass
/// without.
fn link_missing(map: &MapIndex, traffic: &Traffic, movement: &Movement) -> Option<Finding> {
    let lane = &map.lanes[movement.lane];
    let finished = map.turn_direction(movement.lane).is_some();
    if !lane.vehicle || !finished || map.elements(lane.id, "traffic_light").next().is_some() {
        return None;
    }
    let same_start = |other: &Movement| map.lanes[other.lane].start.ids == lane.start.ids;
    let others = traffic.movements.iter().filter(|other| other.from == movement.from && other.lane != movement.lane);
    let comparable = others.filter(|other| same_start(other) || movement.ranked.turn != Turn::Near);
    // The lights of those who start at the same place fit best.
    let (light, other) = comparable
        .filter_map(|other| Some((map.elements(map.lanes[other.lane].id, "traffic_light").next()?, other)))
        .min_by_key(|(_, other)| !same_start(other))?;
    let name = map.lanes[other.lane].id;
    let message =
        format!("Lanelet {} has no traffic light although {name} from the same approach has {}.", lane.id, light.id);
    let subject = Subject::Lanelet(lane.id.0);
    let finding = Finding::new("signal-link-missing", subject, message)
        .with(Subject::Lanelet(name.0), "same approach")
        .with(Subject::RegulatoryElement(light.id.0), "traffic light");
    let member = Subject::RegulatoryElement(light.id.0);
    let edits = vec![Edit::AddMember { on: subject, role: "regulatory_element".into(), member }];
    Some(finding.fixed_by(format!("let lanelet {} refer to {}", lane.id, light.id), same_start(other), edits))
}

/// A light of road lanelets without stop line.
fn no_stopline(map: &MapIndex, light: &RegulatoryElement) -> Option<Finding> {
    if light.subtype != "traffic_light" || light.linestrings("ref_line").next().is_some() {
        return None;
    }
    let lanes = map.referrers(light.id).iter().filter_map(|&id| map.lane(id));
    let roads: Vec<usize> = lanes.filter(|&lane| map.lanes[lane].kind == RoadType::Road).collect();
    let lane = map.lanes[*roads.first()?].id;
    let message =
        format!("Traffic light {} of lanelet {lane} has no stop line; Autoware ignores the signal.", light.id);
    let subject = Subject::RegulatoryElement(light.id.0);
    let finding = Finding::new("signal-no-stopline", subject, message).with(Subject::Lanelet(lane.0), "lanelet");
    let Some(line) = roads.iter().find_map(|&lane| map.stop_line_of(lane)) else {
        return Some(with_line_drawn(map, finding, &roads));
    };
    let member = Subject::LineString(line.way.0);
    let edits = vec![Edit::AddMember { on: subject, role: "ref_line".into(), member }];
    Some(finding.with(member, "stop line").fixed_by(format!("give it stop line {}", line.way), true, edits))
}

/// Adds the edit that draws a stop line over the points where lanes of an intersection start, from the first to the last as
/// seen across them.
fn with_line_drawn(map: &MapIndex, finding: Finding, lanes: &[usize]) -> Finding {
    let inside = lanes.iter().copied().filter(|&lane| map.movement(lane).is_some());
    let starts: Vec<&Edge> = inside.map(|lane| &map.lanes[lane].start).collect();
    let Some(across) = starts.first().and_then(|edge| edge.across().try_normalize(0.0)) else { return finding };
    let ends = starts.iter().flat_map(|edge| edge.points.into_iter().zip(edge.ids));
    let along = |place: Point| place.coords.dot(&across);
    let ordered = |(a, x): &(Point, PointId), (b, y): &(Point, PointId)| along(*a).total_cmp(&along(*b)).then(x.cmp(y));
    let (first, last) = (ends.clone().min_by(ordered), ends.clone().max_by(ordered));
    let Some((first, last)) = first.zip(last).filter(|(a, b)| a.1 != b.1) else { return finding };
    let Some(line) = Polyline::new([first.0, last.0]) else { return finding };
    // Lanes that start one behind the other need lines of their own.
    if ends.clone().any(|(place, _)| line.distance(place) > STAGGERED) {
        return finding;
    }
    let edits = vec![Edit::CreateStopLine { points: vec![first.1.0, last.1.0], element: finding.subject }];
    finding.fixed_by("draw a stop line where its lanelets start", false, edits)
}

/// A light that hangs on the lane before its stop line instead of on the lanelets behind.
fn on_in_lane(map: &MapIndex, params: &Params, at: usize, light: &RegulatoryElement) -> Option<Finding> {
    let behind = map.followers(at);
    let refers = |lane: &usize| map.elements(map.lanes[*lane].id, "traffic_light").any(|own| own.id == light.id);
    let inside = |lane: &usize| map.movement(*lane).is_some();
    if map.movement(at).is_some() || !behind.iter().any(inside) || behind.iter().any(refers) {
        return None;
    }
    let line = map.stop_line(light.linestrings("ref_line").next()?)?;
    let lane = &map.lanes[at];
    let across = Polyline::new(line.ends)?;
    let distance = across.distance(lane.end.middle());
    // A short lane may begin at the line: then it lies behind it.
    if distance > params.stop_line || across.distance(lane.start.middle()) < distance {
        return None;
    }
    let (subject, element) = (Subject::Lanelet(lane.id.0), Subject::RegulatoryElement(light.id.0));
    let message = format!(
        "Traffic light {} hangs on approach lane {}; it belongs on the lanelets behind the stop line.",
        light.id, lane.id
    );
    let mut edits = vec![Edit::RemoveMember { on: subject, role: "regulatory_element".into(), member: element }];
    let mut finding = Finding::new("signal-on-in-lane", element, message)
        .with(subject, "approach")
        .with(Subject::LineString(line.way.0), "stop line");
    // Also those that say nothing of the intersection: nobody behind the line is to lose the light.
    for &lane in behind.iter().filter(|&&lane| inside(&lane) || map.lanes[lane].vehicle) {
        let on = Subject::Lanelet(map.lanes[lane].id.0);
        finding = finding.with(on, "behind the stop line");
        edits.push(Edit::AddMember { on, role: "regulatory_element".into(), member: element });
    }
    Some(finding.fixed_by("let the lanelets behind the stop line refer to it", true, edits))
}
