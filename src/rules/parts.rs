//! parts: elements that hang together with nothing, or with themselves.

mod same_place;

use std::collections::BTreeMap;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Condition, LineStringId, LoadFault};

use super::NoParams;

/// Elements of which a rule of their own says that no lanelet refers to them.
const JUDGED_ELSEWHERE: [&str; 10] = [
    "traffic_light",
    "traffic_sign",
    "right_of_way",
    "road_marking",
    "crosswalk",
    "virtual_traffic_light",
    "no_parking_area",
    "no_stopping_area",
    "detection_area",
    "roundabout",
];

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let mut findings = same_place::judge(map);
    findings.extend(unreferenced(map));
    findings.extend(curbstones(map));
    findings.extend(map.faults.iter().filter_map(blank_start));
    findings
}

fn blank_start(fault: &LoadFault) -> Option<Finding> {
    if fault.condition != Condition::BlankStart {
        return None;
    }
    let message = "Blanks stand before <?xml; strict readers of XML refuse the file.";
    Some(Finding::new("blank-start", fault.subject, message).standing_at(fault.span.clone()))
}

/// Regulatory elements that no lanelet refers to.
fn unreferenced(map: &MapIndex) -> Vec<Finding> {
    let elements = map.map.regulatory_elements.iter();
    let idle = elements.filter(|element| {
        !JUDGED_ELSEWHERE.contains(&element.subtype.as_str()) && map.referrers(element.id).is_empty()
    });
    let findings = idle.map(|element| {
        let subject = Subject::RegulatoryElement(element.id.0);
        let message =
            format!("No lanelet refers to the {} element {}, so it has no effect.", element.subtype, element.id);
        let finding = Finding::new("unreferenced", subject, message);
        match element.members.is_empty() {
            true => finding.fixed_by("remove the element, which is empty", false, vec![Edit::Remove { subject }]),
            false => finding,
        }
    });
    findings.collect()
}

/// Outer bounds of roads that are curbstones: one finding for the map, since whoever draws one so draws all of them so.
fn curbstones(map: &MapIndex) -> Option<Finding> {
    let mut bounds: BTreeMap<LineStringId, usize> = BTreeMap::new();
    for (at, lane) in map.lanes.iter().enumerate().filter(|(_, lane)| lane.vehicle) {
        for way in lane.bounds.into_iter().filter(|&way| map.users_of(way).len() == 1) {
            let line = map.map.linestrings.get(way);
            if line.is_some_and(|line| line.attributes.is("type", "curbstone")) {
                bounds.entry(way).or_insert(at);
            }
        }
    }
    let (&first, &lane) = bounds.first_key_value()?;
    let message = match bounds.len() {
        1 => format!(
            "The outer bound {first} is a curbstone; Autoware takes type road_border alone as the edge of the road."
        ),
        count => format!(
            "{count} outer bounds are curbstones, {first} the first; Autoware takes type road_border alone as the edge of the road."
        ),
    };
    let finding = Finding::new("curbstone", Subject::LineString(first.0), message);
    let finding = finding.with(Subject::Lanelet(map.lanes[lane].id.0), "lane");
    let edge = |way: &LineStringId| Edit::SetTag {
        on: Subject::LineString(way.0),
        key: "type".into(),
        value: "road_border".into(),
    };
    Some(finding.fixed_by("set type=road_border on all of them", false, bounds.keys().map(edge).collect()))
}
