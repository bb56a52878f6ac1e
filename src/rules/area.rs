//! area: whether vehicles can cross the areas that are there for it.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Point, polygon};
use crate::lanelet::index::{Door, MapIndex, lets_vehicles_in};
use crate::lanelet::{Area, LineStringId};
use crate::text::counted;

/// The tag of lanes and areas in which vehicles change between forward and reverse.
const DIRECTION_CHANGE: &str = "direction_change";

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Share of the convex hull.
    concave: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let (mut findings, mut unreached) = (Vec::new(), Vec::new());
    for area in &map.map.areas {
        let for_changing = area.attributes.is(DIRECTION_CHANGE, "yes");
        if for_changing {
            findings.extend(shape(map, params, area));
        }
        if !lets_vehicles_in(area) {
            findings.extend(for_changing.then(|| closed(area)));
            continue;
        }
        let doors = map.doors(area);
        let mut obstructed = shut(map, area, &doors);
        obstructed.extend(unspanned(map, area));
        let leads = |inward: bool| doors.iter().any(|door| door.is_open && door.leads_in == inward);
        match (leads(true), leads(false)) {
            (true, true) => {}
            (false, false) if obstructed.is_empty() => unreached.push(area),
            (false, false) => {}
            (inward, _) => findings.push(one_way(area, inward)),
        }
        findings.extend(obstructed);
        if for_changing {
            findings.extend(untagged(map, area, &doors));
        }
    }
    findings.extend(out_of_reach(&unreached));
    findings
}

fn subject(area: &Area) -> Subject {
    Subject::Relation(area.id.0)
}

fn closed(area: &Area) -> Finding {
    let message = format!("Area {} is there to change direction in, but its tags let no vehicles in.", area.id);
    let edit = Edit::SetTag { on: subject(area), key: "participant:vehicle".into(), value: "yes".into() };
    Finding::new("closed", subject(area), message).fixed_by("set participant:vehicle=yes", false, vec![edit])
}

/// Lanelets that end at an area, or start there, over a line that vehicles may not cross, and that have no other way on.
fn shut(map: &MapIndex, area: &Area, doors: &[Door]) -> Vec<Finding> {
    let opens = |door: &Door| {
        doors.iter().any(|other| other.lane == door.lane && other.is_open && other.leads_in == door.leads_in)
    };
    let others = |door: &Door| if door.leads_in { map.followers(door.lane) } else { map.predecessors(door.lane) };
    let shut = doors.iter().filter(|door| door.is_end && !opens(door) && others(door).is_empty());
    let findings = shut.map(|door| {
        let (line, lane) = (door.line, map.lanes[door.lane].id);
        let message = match door.leads_in {
            true => {
                format!("Lanelet {lane} ends at area {}, but line {line} between them may not be crossed.", area.id)
            }
            false => {
                format!("Lanelet {lane} starts at area {}, but line {line} between them may not be crossed.", area.id)
            }
        };
        let finding = Finding::new("shut", Subject::LineString(line.0), message)
            .with(subject(area), "area")
            .with(Subject::Lanelet(lane.0), "lanelet");
        match dashed(map, line) {
            Some(edits) => finding.fixed_by("make the line dashed", false, edits),
            None => finding,
        }
    });
    let mut findings: Vec<Finding> = findings.collect();
    findings.dedup_by(|a, b| a.subject == b.subject);
    findings
}

/// How a line between lanes comes to be one that may be crossed.
fn dashed(map: &MapIndex, line: LineStringId) -> Option<Vec<Edit>> {
    let tags = &map.map.linestrings.get(line)?.attributes;
    if !matches!(tags.get("type"), Some("line_thin" | "line_thick")) {
        return None;
    }
    let on = Subject::LineString(line.0);
    let mut edits = vec![Edit::SetTag { on, key: "subtype".into(), value: "dashed".into() }];
    let said = ["lane_change", "lane_change:left", "lane_change:right"].into_iter().filter(|key| tags.has(key));
    edits.extend(said.map(|key| Edit::RemoveTag { on, key: key.into() }));
    Some(edits)
}

/// Lanelets of which the end lies on an area's outline, but not as a line of its own.
fn unspanned(map: &MapIndex, area: &Area) -> Vec<Finding> {
    let loose = |at: &usize| map.followers(*at).is_empty() || map.predecessors(*at).is_empty();
    let findings = map.unspanned_ends(area).into_iter().filter(loose).map(|at| {
        let lane = map.lanes[at].id;
        let message = format!(
            "Both corners of an end of lanelet {lane} lie on the outline of area {}, but no line of it runs from one to the other.",
            area.id
        );
        Finding::new("unspanned", subject(area), message).with(Subject::Lanelet(lane.0), "lanelet")
    });
    findings.collect()
}

fn one_way(area: &Area, leads_in: bool) -> Finding {
    let message = match leads_in {
        true => format!("Lanelets lead into area {}, and none leads out.", area.id),
        false => format!("Lanelets lead out of area {}, and none leads in.", area.id),
    };
    Finding::new("dead-end", subject(area), message)
}

/// Lanes at an area for changing direction in which vehicles may not do that.
fn untagged(map: &MapIndex, area: &Area, doors: &[Door]) -> Vec<Finding> {
    let mut lanes: Vec<usize> = doors.iter().filter(|door| door.is_open && door.is_end).map(|door| door.lane).collect();
    lanes.dedup();
    let findings = lanes.into_iter().filter(|&at| !map.lanes[at].reverses()).map(|at| {
        let lane = map.lanes[at].id;
        let about = Subject::Lanelet(lane.0);
        let message = format!(
            "Lanelet {lane} leads over area {}, in which vehicles change direction, without saying so.",
            area.id
        );
        let edit = Edit::SetTag { on: about, key: DIRECTION_CHANGE.into(), value: "yes".into() };
        let finding = Finding::new("lane-untagged", about, message).with(subject(area), "area");
        finding.fixed_by("set direction_change=yes", false, vec![edit])
    });
    findings.collect()
}

/// What Autoware's format asks of the outline of an area for changing direction.
fn shape(map: &MapIndex, params: &Params, area: &Area) -> Vec<Finding> {
    let mut findings = Vec::new();
    if area.holes > 0 {
        let message = format!("Area {} has {}; vehicles change direction in it.", area.id, counted(area.holes, "hole"));
        findings.push(Finding::new("hole", subject(area), message));
    }
    let ring: Vec<Point> =
        area.points.iter().filter_map(|&id| map.map.points.get(id)).map(|point| point.position).collect();
    let hull = polygon::signed_area(&polygon::convex_hull(ring.iter().copied())).abs();
    let lacking = 1.0 - polygon::signed_area(&ring).abs() / hull;
    if lacking > params.concave {
        let message = format!(
            "Area {} is not convex: {:.0} % of what its corners span lies outside of it.",
            area.id,
            100.0 * lacking
        );
        let finding = Finding::new("concave", subject(area), message).at(Place::Polygon(ring));
        findings.push(finding.measured(lacking, params.concave, "1"));
    }
    findings
}

/// Areas of which no lanelet ends at the edge: one finding for the map, since whoever draws one so draws all of them so.
fn out_of_reach(areas: &[&Area]) -> Option<Finding> {
    let first = areas.first()?;
    let message = match areas.len() {
        1 => format!("Vehicles may enter area {}, but no lanelet leads there.", first.id),
        count => format!("Vehicles may enter {count} areas to which no lanelet leads, {} the first.", first.id),
    };
    Some(Finding::new("unreached", subject(first), message))
}
