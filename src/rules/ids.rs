//! ids: every element has a number of its own that Autoware can read.

use super::load::name;
use super::{NoParams, Rule};
use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Condition, LoadFault};

/// See `rules/ids.md`.
pub struct Ids;

impl Rule for Ids {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        map.faults.iter().filter_map(|fault| Some(finding(fault)?.standing_at(fault.span.clone()))).collect()
    }
}

fn finding(fault: &LoadFault) -> Option<Finding> {
    let subject = fault.subject;
    let about = name(subject);
    let (slug, message) = match &fault.condition {
        Condition::DuplicateId { kind, spans } => {
            let id = subject.id().unwrap_or_default();
            ("duplicate", format!("Id {id} is used by {} {kind}s.", spans.len()))
        }
        Condition::IdReused { kinds } => {
            let kinds: Vec<String> = kinds.iter().map(ToString::to_string).collect();
            ("reused", format!("{about} has the id of a {} too.", kinds.join(" and of a ")))
        }
        Condition::IdNotPositive => ("range", format!("{about} has an id that is not positive.")),
        Condition::PolygonIdTooLarge => ("range", format!("{about} has an id above {}.", i32::MAX)),
        _ => return None,
    };
    Some(Finding::new(slug, subject, message))
}
