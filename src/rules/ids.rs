//! ids: every element has a number of its own that Autoware can read.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Condition, ElementKind, LoadFault, PolygonId, Repeat};

use super::load::{name, with_shared_ids};
use super::{NoParams, crowd};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let twice = with_shared_ids(map);
    // JOSM numbers all that is new below 0: of hundreds of one kind one finding says so.
    let mut not_positive: BTreeMap<ElementKind, Vec<&LoadFault>> = BTreeMap::new();
    let mut findings = Vec::new();
    for fault in map.faults.iter().filter(|fault| !is_area(map, fault.subject)) {
        match kind_of(fault.subject).filter(|_| fault.condition == Condition::IdNotPositive) {
            Some(kind) => not_positive.entry(kind).or_default().push(fault),
            None => findings.extend(finding(fault, &twice).map(|it| it.standing_at(fault.span.clone()))),
        }
    }
    for (kind, faults) in not_positive {
        let (Some(first), count) = (faults.first(), faults.len()) else { continue };
        if count > crowd::MOST {
            let message = format!("{count} {kind}s have ids that are not positive; {} is the first.", first.subject);
            let subjects: Vec<Subject> = faults.iter().map(|fault| fault.subject).collect();
            findings.push(renumbered(&twice, Finding::new("range", first.subject, message), &subjects));
            continue;
        }
        findings
            .extend(faults.iter().filter_map(|fault| Some(finding(fault, &twice)?.standing_at(fault.span.clone()))));
    }
    findings
}

const fn kind_of(subject: Subject) -> Option<ElementKind> {
    match subject {
        Subject::Point(_) | Subject::Node(_) => Some(ElementKind::Node),
        Subject::LineString(_) | Subject::Polygon(_) | Subject::Way(_) => Some(ElementKind::Way),
        Subject::Lanelet(_) | Subject::RegulatoryElement(_) | Subject::Relation(_) => Some(ElementKind::Relation),
        _ => None,
    }
}

/// Whether it is an intersection area, of the id of which vm-03-01 speaks.
fn is_area(map: &MapIndex, subject: Subject) -> bool {
    let Subject::Polygon(id) = subject else { return false };
    map.map.polygons.get(PolygonId(id)).is_some_and(|area| area.attributes.is("type", "intersection_area"))
}

fn finding(fault: &LoadFault, twice: &FxHashSet<Subject>) -> Option<Finding> {
    let subject = fault.subject;
    let about = name(subject);
    Some(match &fault.condition {
        Condition::DuplicateId { kind, spans, repeat } => duplicate(subject, *kind, spans.len(), repeat),
        Condition::IdReused { kinds } => {
            let kinds: Vec<String> = kinds.iter().map(ToString::to_string).collect();
            let message = format!("{about} has the id of a {} too.", kinds.join(" and of a "));
            Finding::new("reused", subject, message)
        }
        Condition::IdNotPositive => {
            let message = format!("{about} has an id that is not positive.");
            renumbered(twice, Finding::new("range", subject, message), &[subject])
        }
        Condition::PolygonIdTooLarge => {
            let message = format!("{about} has an id above {}.", i32::MAX);
            renumbered(twice, Finding::new("range", subject, message), &[subject])
        }
        _ => return None,
    })
}

/// Adds the fix that gives new ids, here and in all references. The library loads such ids, and other files may know the old ones.
fn renumbered(twice: &FxHashSet<Subject>, finding: Finding, all: &[Subject]) -> Finding {
    let all = all.iter().filter(|on| !twice.contains(on));
    let edits: Vec<Edit> = all.map(|&on| Edit::Renumber { on, nth: 0, referrers: None }).collect();
    let title = match edits.len() {
        0 => return finding,
        1 => "give it an id that is free, here and in all references".to_owned(),
        count => format!("give {count} of them ids that are free, here and in all references"),
    };
    finding.fixed_by(title, false, edits)
}

fn duplicate(subject: Subject, kind: ElementKind, count: usize, repeat: &Repeat) -> Finding {
    let message = format!("Id {} is used by {count} {kind}s", subject.id().unwrap_or_default());
    let found = |rest: &str| Finding::new("duplicate", subject, format!("{message}{rest}."));
    let nth = count.saturating_sub(1);
    match repeat {
        Repeat::Copy => {
            let edits = vec![Edit::RemoveRepeat { on: subject, nth }];
            found(", the last a copy of the first").fixed_by("remove the copy", true, edits)
        }
        Repeat::Twin { id } => {
            let edits = vec![Edit::RemoveRepeat { on: subject, nth }];
            let rest = format!(", the last of which says what {kind} {id} says");
            found(&rest).fixed_by(format!("remove the last, which says what {kind} {id} says"), false, edits)
        }
        Repeat::Other { referrers } => {
            let safe = referrers.is_empty() && kind != ElementKind::Node;
            let edits = vec![Edit::Renumber { on: subject, nth, referrers: Some(referrers.clone()) }];
            let title = match referrers.len() {
                0 => "give the last an id that is free; nothing refers to it".to_owned(),
                count => format!("give the last an id that is free, here and in the {count} that mean it"),
            };
            referrers
                .iter()
                .fold(found(""), |one, referrer| one.with(*referrer, "means the last"))
                .fixed_by(title, safe, edits)
        }
        Repeat::Unclear { why } => found(&format!("; which is meant is not clear: {why}")),
    }
}
