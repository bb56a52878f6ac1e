//! vm-03-16: a virtual traffic light has its lines, and they come in the order start, stop, end.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::lanelet::index::{MapIndex, extent};
use crate::lanelet::{LaneletId, LineStringId, RegulatoryElement, Target};

use super::virtual_light::{ANCHOR, Broken, Section, lights, sections};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    extent: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    for light in lights(map) {
        findings.extend(types(map, light));
        findings.extend(order(map, light));
        findings.extend(too_large(map, params, light));
    }
    findings
}

/// A finding about a light.
fn about(fault: &'static str, light: &RegulatoryElement, reason: &str) -> Finding {
    let message = format!("Virtual traffic light {}: {reason}.", light.id);
    Finding::new(fault, Subject::RegulatoryElement(light.id.0), message)
}

/// Every line is of its type, and there is one stop line and one thing that the light stands for.
fn types(map: &MapIndex, light: &RegulatoryElement) -> Vec<Finding> {
    let mut findings = Vec::new();
    for role in ["ref_line", "refers"] {
        let members: Vec<LineStringId> = light.linestrings(role).collect();
        if members.len() != 1 {
            let reason = format!("it has {} members {role}; exactly one is required", members.len());
            let finding = about("types", light, &reason);
            findings.push(members.iter().fold(finding, |finding, way| finding.with(Subject::LineString(way.0), role)));
        }
    }
    for (role, wanted) in
        [("start_line", "virtual"), ("ref_line", "stop_line"), ("end_line", "virtual"), ("refers", ANCHOR)]
    {
        for way in light.linestrings(role) {
            let Some(line) = map.map.linestrings.get(way).filter(|line| !line.attributes.is("type", wanted)) else {
                continue;
            };
            let found = line.attributes.get("type").map_or("no type".to_owned(), |kind| format!("type {kind}"));
            let reason = format!("its {role} {way} has {found}; it must be {wanted}");
            let on = Subject::LineString(way.0);
            let edits = vec![Edit::SetTag { on, key: "type".into(), value: wanted.into() }];
            let finding = about("types", light, &reason).with(on, role);
            findings.push(finding.fixed_by(format!("set type={wanted}"), false, edits));
        }
    }
    findings
}

/// On the way through each lanelet the lines follow one another.
fn order(map: &MapIndex, light: &RegulatoryElement) -> Vec<Finding> {
    let mut findings: Vec<Finding> = Vec::new();
    for &id in map.referrers(light.id) {
        let Some(lane) = map.lane(id) else { continue };
        let found = match sections(map, light, lane) {
            Ok(sections) => sections.iter().find_map(|section| out_of_order(section, id)),
            Err(broken) => Some(incomplete(light, id, broken)),
        };
        // The start line is one for all lanelets: said once.
        findings.extend(found.filter(|found| findings.iter().all(|known| known.message != found.message)));
    }
    findings
}

/// The lines cross the way through a lanelet, but not in their order.
fn out_of_order(section: &Section, id: LaneletId) -> Option<Finding> {
    let Section { start, stop, end, .. } = *section;
    if start < end && stop.is_none_or(|stop| start < stop && stop < end) {
        return None;
    }
    let mut lines: Vec<(&str, f64)> = vec![("start", start), ("end", end)];
    lines.extend(stop.map(|stop| ("stop", stop)));
    lines.sort_by(|a, b| a.1.total_cmp(&b.1));
    let words: Vec<&str> = lines.into_iter().map(|(word, _)| word).collect();
    let reason = format!("on the way through lanelet {id} its lines come as {}", words.join(", "));
    Some(about("order", section.light, &reason).with(Subject::Lanelet(id.0), "lanelet"))
}

/// A line does not cross the way through a lanelet at all.
fn incomplete(light: &RegulatoryElement, id: LaneletId, broken: Broken) -> Finding {
    let (reason, lanelet, line) = match broken {
        Broken::NoEnd => (format!("no end line of it crosses lanelet {id}"), id, None),
        Broken::StartInside(way, touched) => (
            format!("its start line {way} lies on lanelet {touched}, not before it"),
            touched,
            Some((way, "start line")),
        ),
        Broken::NoWay(way) => {
            (format!("no lane leads from its start line {way} to lanelet {id}"), id, Some((way, "start line")))
        }
        Broken::StopOff(way) => {
            (format!("its stop line {way} does not cross the way through lanelet {id}"), id, Some((way, "stop line")))
        }
    };
    let finding = about("order", light, &reason).with(Subject::Lanelet(lanelet.0), "lanelet");
    match line {
        Some((way, part)) => finding.with(Subject::LineString(way.0), part),
        None => finding,
    }
}

/// What belongs together lies together: a light that spans half the map holds a line of another one.
fn too_large(map: &MapIndex, params: &Params, light: &RegulatoryElement) -> Option<Finding> {
    let ways = light.members.iter().filter_map(|member| match member.target {
        Target::LineString(way) => map.map.linestrings.get(way),
        _ => None,
    });
    let places = ways.flat_map(|line| &line.points).filter_map(|&id| Some(map.map.points.get(id)?.position));
    let lanes = map.referrers(light.id).iter().filter_map(|&id| map.lane_of(id)).flat_map(|lane| lane.extent);
    let all: Vec<_> = places.filter(|p| p.x.is_finite() && p.y.is_finite()).chain(lanes).collect();
    let [low, high] = extent(&all);
    let diagonal = (high - low).norm();
    if all.is_empty() || diagonal <= params.extent {
        return None;
    }
    let reason = format!("it reaches over {diagonal:.0} m");
    let finding = about("too-large", light, &reason).measured(diagonal, params.extent, "m");
    Some(finding.at(Place::Line(vec![low, high])))
}
