//! ids: every element has a number of its own that Autoware can read.

use rustc_hash::FxHashSet;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Condition, ElementKind, LoadFault, PolygonId, Repeat};

use super::NoParams;
use super::load::{name, with_shared_ids};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let twice = with_shared_ids(map);
    let faults = map.faults.iter();
    faults.filter_map(|fault| Some(finding(map, fault, &twice)?.standing_at(fault.span.clone()))).collect()
}

fn finding(map: &MapIndex, fault: &LoadFault, twice: &FxHashSet<Subject>) -> Option<Finding> {
    let subject = fault.subject;
    // vm-03-01 speaks of their ids.
    let area = match subject {
        Subject::Polygon(id) => map.map.polygons.get(PolygonId(id)),
        _ => None,
    };
    let area = area.is_some_and(|area| area.attributes.is("type", "intersection_area"));
    let about = name(subject);
    Some(match &fault.condition {
        Condition::DuplicateId { kind, spans, repeat } => duplicate(subject, *kind, spans.len(), repeat),
        Condition::IdReused { kinds } => {
            let kinds: Vec<String> = kinds.iter().map(ToString::to_string).collect();
            let message = format!("{about} has the id of a {} too.", kinds.join(" and of a "));
            Finding::new("reused", subject, message)
        }
        Condition::IdNotPositive | Condition::PolygonIdTooLarge if area => return None,
        Condition::IdNotPositive => {
            renumbered(twice, Finding::new("range", subject, format!("{about} has an id that is not positive.")))
        }
        Condition::PolygonIdTooLarge => {
            renumbered(twice, Finding::new("range", subject, format!("{about} has an id above {}.", i32::MAX)))
        }
        _ => return None,
    })
}

/// Adds the fix that gives a new id, here and in all references. The library loads such ids, and other files may know the old ones.
fn renumbered(twice: &FxHashSet<Subject>, finding: Finding) -> Finding {
    let on = finding.subject;
    if twice.contains(&on) {
        return finding;
    }
    let edits = vec![Edit::Renumber { on, nth: 0, referrers: None }];
    finding.fixed_by("give it an id that is free, here and in all references", false, edits)
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
