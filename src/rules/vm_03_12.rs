//! vm-03-12: whom Autoware will watch, and where it watches somebody for nothing.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::lanelet::index::thresholds;
use crate::lanelet::index::{Conflict, MapIndex};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    attention: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    for lane in (0..map.lanes.len()).filter(|&lane| map.movement(lane).is_some() && map.lanes[lane].vehicle) {
        if params.attention {
            findings.push(attention(map, lane));
        }
        findings.extend(no_conflict(map, lane));
        let (ignored, watched) = (map.ignored(lane), map.attention(lane));
        for conflict in map.conflicts[lane].iter().filter(|conflict| map.lanes[conflict.other].vehicle) {
            if ignored.binary_search(&conflict.other).is_err() {
                findings.extend(sliver(map, lane, conflict));
            }
            // A straight lane with a light watches nobody.
            if watched.contains(&conflict.other) {
                findings.extend(grade_separated(map, lane, conflict));
            }
        }
    }
    findings
}

fn attention(map: &MapIndex, lane: usize) -> Finding {
    let watched = map.attention(lane);
    let ids: Vec<i64> = watched.iter().map(|&other| map.lanes[other].id.0).collect();
    let list = match ids.is_empty() {
        true => "nobody".to_owned(),
        false => ids.iter().map(i64::to_string).collect::<Vec<_>>().join(", "),
    };
    let id = map.lanes[lane].id;
    let finding = Finding::new("attention", Subject::Lanelet(id.0), format!("{id} will watch: {list}."));
    ids.into_iter().fold(finding, |finding, other| finding.with(Subject::Lanelet(other), "watched"))
}

/// A lanelet of an intersection that crosses nobody.
fn no_conflict(map: &MapIndex, lane: usize) -> Option<Finding> {
    let id = map.lanes[lane].id;
    let alone =
        map.conflicts[lane].is_empty() && !map.lanes[lane].bicycle && map.lanes[lane].simple && map.has_area(lane);
    let message = format!("Lanelet {id} lies in an intersection but conflicts with no lanelet.");
    alone.then(|| Finding::new("no-conflict", Subject::Lanelet(id.0), message))
}

/// Two lanes that hardly touch: one finding for both.
fn sliver(map: &MapIndex, lane: usize, conflict: &Conflict) -> Option<Finding> {
    let back = map.conflicts[conflict.other].iter().find(|back| back.other == lane)?;
    if conflict.real || back.real || conflict.grade_separated || map.movement(conflict.other).is_none() {
        return None;
    }
    // The finding belongs to the lane that comes first.
    let said = conflict.other < lane && map.ignored(conflict.other).binary_search(&lane).is_err();
    if said {
        return None;
    }
    let (a, b) = (map.lanes[lane].id, map.lanes[conflict.other].id);
    let message = format!("{a},{b} overlap only {:.4} m2, yet Autoware treats them as conflicting.", conflict.area);
    let limit = thresholds::REAL_AREA;
    let finding = Finding::new("sliver", Subject::Lanelet(a.0), message)
        .with(Subject::Lanelet(b.0), "other lanelet")
        .measured(conflict.area, limit, "m2");
    Some(finding.at(Place::Point(conflict.place)))
}

/// A lane on another level, which Autoware sees all the same.
fn grade_separated(map: &MapIndex, lane: usize, conflict: &Conflict) -> Option<Finding> {
    if !conflict.grade_separated {
        return None;
    }
    let (a, b) = (map.lanes[lane].id, map.lanes[conflict.other].id);
    let message = format!("{a} and {b} lie on different levels, yet Autoware treats them as conflicting.");
    let finding = Finding::new("grade-separated-conflict", Subject::Lanelet(a.0), message)
        .with(Subject::Lanelet(b.0), "on another level")
        .at(Place::Point(conflict.place));
    let Some(element) = map.rights_of_way(lane).into_iter().next() else { return Some(finding) };
    let on = Subject::RegulatoryElement(element.id.0);
    let edits = vec![Edit::AddMember { on, role: "yield".into(), member: Subject::Lanelet(b.0) }];
    Some(finding.with(on, "right of way").fixed_by(format!("list {b} as yield"), true, edits))
}
