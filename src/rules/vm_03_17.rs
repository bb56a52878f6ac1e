//! vm-03-17: a lanelet that a virtual traffic light rules yields everybody: the light alone decides who drives.

use crate::diagnostic::{Finding, Subject};
use crate::geometry::polygon;
use crate::lanelet::RegulatoryElement;
use crate::lanelet::index::MapIndex;

use super::NoParams;
use super::right_of_way_element::{Judged, wiring};
use super::virtual_light::is_coordinated;
use crate::lanelet::index::thresholds;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let mut findings = wiring(map, |id| is_coordinated(map, id));
    for mut judged in Judged::all(map, |traffic, x| is_coordinated(map, map.lanes[traffic.movements[x].lane].id)) {
        judged.due = everybody(map, judged.lane);
        judged.sure.clone_from(&judged.due);
        findings.extend(judged.multi_re());
        findings.extend(re_missing(&judged));
        findings.extend(yields(&judged));
        findings.extend(judged.needless());
    }
    findings
}

/// Every lane that a lanelet conflicts with, those that start with it included.
fn everybody(map: &MapIndex, lane: usize) -> Vec<usize> {
    let conflicts = map.conflicts[lane].iter().filter(|conflict| conflict.real).map(|conflict| conflict.other);
    let mut all: Vec<usize> = conflicts.chain(map.siblings(lane).filter(|&other| overlap(map, lane, other))).collect();
    all.retain(|&other| map.lanes[other].vehicle);
    all.sort_unstable();
    all
}

/// Whether two lanelets that start together lie on each other, and do not share a border.
fn overlap(map: &MapIndex, lane: usize, other: usize) -> bool {
    let (a, b) = (&map.lanes[lane], &map.lanes[other]);
    if !a.simple || !b.simple || a.bounds.iter().any(|way| b.bounds.contains(way)) {
        return false;
    }
    let area = polygon::overlap(&a.outline, &b.outline);
    area >= thresholds::REAL_AREA || area >= thresholds::REAL_SHARE * a.area
}

/// The light that rules the lanelet.
fn light<'m>(judged: &Judged<'m>) -> Option<&'m RegulatoryElement> {
    judged.map.elements(judged.id, "virtual_traffic_light").next()
}

fn re_missing(judged: &Judged) -> Option<Finding> {
    let light = light(judged)?;
    let message = format!(
        "Virtual traffic light {}: lanelet {} has no right_of_way; Autoware will wait for others though the light lets it go.",
        light.id, judged.id
    );
    Some(judged.re_missing(message)?.with(Subject::RegulatoryElement(light.id.0), "virtual traffic light"))
}

fn yields(judged: &Judged) -> Vec<Finding> {
    let Some(light) = light(judged) else { return Vec::new() };
    let findings = judged.missing().map(|y| {
        let other = judged.map.lanes[y].id;
        let message = format!(
            "Virtual traffic light {}: right_of_way of lanelet {} does not yield {other}.",
            light.id, judged.id
        );
        let finding = judged.about("yield", y, message);
        let finding = finding.with(Subject::RegulatoryElement(light.id.0), "virtual traffic light");
        judged.with_yield(finding, y)
    });
    findings.collect()
}
