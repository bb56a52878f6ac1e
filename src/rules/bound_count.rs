//! Lanelets with a bound too many or too few, and the fix where the map tells which is meant.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{BoundRole, Condition, LoadFault};

use super::cut_bound;

/// What is wrong with the number of a lanelet's bounds of one role; `meant` is the only way that fits there.
pub fn finding(
    map: &MapIndex,
    subject: Subject,
    role: BoundRole,
    count: usize,
    ways: &[i64],
    meant: Option<i64>,
) -> Finding {
    let finding = said(subject, role, count, ways);
    if let Some(joined) = cut_bound::joined(map, &finding, role, ways) {
        return joined;
    }
    let Some(way) = meant else { return without_bounds(map, finding) };
    let (on, role_of) = (subject, || role.as_str().into());
    if ways.contains(&way) {
        let others = ways.iter().filter(|&&other| other != way).map(|&other| Subject::LineString(other));
        let edits = others.map(|member| Edit::RemoveMember { on, role: role_of(), member }).collect();
        return finding.fixed_by(format!("leave way {way} alone, the only one that fits"), false, edits);
    }
    let edits = vec![Edit::AddMember { on, role: role_of(), member: Subject::LineString(way) }];
    finding.fixed_by(format!("add way {way} as {role} bound, the only one that fits"), false, edits)
}

fn said(subject: Subject, role: BoundRole, count: usize, ways: &[i64]) -> Finding {
    let needed = match role {
        BoundRole::Centerline => "one at most is allowed",
        _ => "exactly one is required",
    };
    let id = subject.id().unwrap_or_default();
    let message = match role {
        BoundRole::Centerline => format!("Lanelet {id} has {count} centre lines; {needed}."),
        _ => format!("Lanelet {id} has {count} {role} bounds; {needed}."),
    };
    let finding = Finding::new("bound-count", subject, message);
    ways.iter().fold(finding, |finding, &way| finding.with(Subject::Way(way), role.as_str()))
}

/// Adds the fix that removes a lanelet of which nothing is left: it names no bound, not even one that is missing from the file. The
/// loader leaves it out, so that no route changes.
fn without_bounds(map: &MapIndex, finding: Finding) -> Finding {
    let own: Vec<&LoadFault> = map.faults.iter().filter(|fault| fault.subject == finding.subject).collect();
    let lacks = |side: BoundRole| {
        own.iter().any(|fault| matches!(fault.condition, Condition::BoundCount { role, count: 0, .. } if role == side))
    };
    let names_one = own.iter().any(|fault| {
        let role = match &fault.condition {
            Condition::MissingReference { role, .. } => role.as_deref(),
            Condition::MemberDropped { role, .. } => Some(role.as_str()),
            Condition::BoundIsNotWay { role, .. } => Some(role.as_str()),
            Condition::UnreadRole { role, .. } => Some(role.as_str()),
            _ => None,
        };
        role.is_some_and(|role| role != "regulatory_element")
    });
    if names_one || ![BoundRole::Left, BoundRole::Right].into_iter().all(lacks) {
        return finding;
    }
    let edits = vec![Edit::Remove { subject: finding.subject }];
    finding.fixed_by("remove the lanelet, which names no bound", false, edits)
}
