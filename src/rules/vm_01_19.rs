//! vm-01-19: a walkway is the piece of a sidewalk that a lane crosses.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::polygon;
use crate::lanelet::RoadType;
use crate::lanelet::index::{Lane, MapIndex};

use super::walkway;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    long: f64,
    doubled: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let walkways = map.lanes.iter().filter(|lane| lane.kind == RoadType::Walkway && lane.simple);
    walkways.flat_map(|walkway| judge(map, params, walkway)).collect()
}

fn judge(map: &MapIndex, params: &Params, walkway: &Lane) -> Vec<Finding> {
    let near = map.lanes_near(walkway.extent[0], walkway.extent[1]);
    let near: Vec<&Lane> = near.into_iter().map(|at| &map.lanes[at]).filter(|lane| lane.simple).collect();
    let mut findings = Vec::new();
    findings.extend(not_for_people(walkway));
    findings.extend(doubled(params, walkway, &near));
    findings.extend(long(params, walkway, &near));
    findings
}

/// As soon as one participant is named, the others may not pass.
fn not_for_people(walkway: &Lane) -> Option<Finding> {
    let attributes = &walkway.lanelet.attributes;
    let named = attributes.iter().any(|(key, _)| key.starts_with("participant"));
    let passes = matches!(attributes.get("participant:pedestrian"), Some("yes" | "true" | "1"));
    let general = attributes.iter().any(|(key, value)| key == "participant" && value == "yes");
    if !named || passes || general {
        return None;
    }
    let on = Subject::Lanelet(walkway.id.0);
    let message = format!("Walkway {} names who may pass, and people on foot are not among them.", walkway.id);
    let edits = vec![Edit::SetTag { on, key: "participant:pedestrian".into(), value: "yes".into() }];
    Some(Finding::new("not-for-people", on, message).fixed_by("set participant:pedestrian=yes", true, edits))
}

fn doubled(params: &Params, walkway: &Lane, near: &[&Lane]) -> Option<Finding> {
    let crosswalks = near.iter().filter(|lane| lane.kind == RoadType::Crosswalk);
    let shares = crosswalks.map(|lane| {
        let share = polygon::overlap(&walkway.outline, &lane.outline) / walkway.area.min(lane.area);
        (share, lane.id)
    });
    let (share, id) = shares.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(share, _)| *share > params.doubled)?;
    let percent = share * 100.0;
    let message = format!("Walkway {} and crosswalk {id} lie on each other ({percent:.0} %).", walkway.id);
    let finding = Finding::new("doubled", Subject::Lanelet(walkway.id.0), message);
    Some(finding.with(Subject::Lanelet(id.0), "crosswalk").measured(percent, params.doubled * 100.0, "%"))
}

/// How far the walkway goes on behind the lanes that it crosses, at the end where that is more.
fn long(params: &Params, walkway: &Lane, near: &[&Lane]) -> Option<Finding> {
    let length = walkway.length();
    let over = near.iter().copied().filter(|lane| lane.vehicle && walkway::leads_over(walkway, lane));
    let [first, last] = walkway::crossed(walkway, over)?;
    let beyond = first.max(length - last);
    if beyond <= params.long {
        return None;
    }
    let message = format!("Walkway {} goes on {beyond:.0} m beside the lanes that it crosses.", walkway.id);
    let finding = Finding::new("long", Subject::Lanelet(walkway.id.0), message);
    Some(finding.measured(beyond, params.long, "m"))
}
