//! Bounds of lanelets that are cut into several ways, each of which goes on where another ends.

use std::collections::VecDeque;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{BoundRole, Condition, LineStringId, PointId, RegulatoryElement, Target};

/// Says that the ways of a role follow each other, and lets one of them run over the points of all where no other lanelet uses it and
/// they are painted alike. `None` if they do not follow each other.
pub fn joined(map: &MapIndex, finding: &Finding, role: BoundRole, ways: &[i64]) -> Option<Finding> {
    let points = chain(map, ways)?;
    let mut finding = finding.clone();
    let names: Vec<String> = ways.iter().map(i64::to_string).collect();
    finding.message = format!("{} Ways {} follow each other end to end.", finding.message, names.join(", "));
    let line = |way: i64| map.map.linestrings.get(LineStringId(way));
    let first = line(*ways.first()?)?;
    let are_alike = ways.iter().all(|&way| line(way).is_some_and(|it| it.attributes == first.attributes));
    let kept = ways.iter().copied().find(|&way| are_alike && is_unshared(map, &finding, way));
    let Some(kept) = kept else { return Some(finding) };
    let is_idle = |way| is_unshared(map, &finding, way) && !is_named(map, way);
    let others = ways.iter().filter(|&&way| way != kept).map(|&way| match Subject::LineString(way) {
        subject if is_idle(way) => Edit::Remove { subject },
        member => Edit::RemoveMember { on: finding.subject, role: role.as_str().into(), member },
    });
    let ids = points.into_iter().map(|point| point.0).collect();
    let edits = [Edit::SetVertices { way: Subject::LineString(kept), points: ids }].into_iter().chain(others).collect();
    Some(finding.fixed_by(format!("let way {kept} run over the points of all of them"), false, edits))
}

/// Whether only the lanelet of the finding has this way, as far as the file shows.
fn is_unshared(map: &MapIndex, finding: &Finding, way: i64) -> bool {
    let is_other = |subject: Subject| subject != finding.subject;
    let in_fault = map
        .faults
        .iter()
        .filter(|fault| is_other(fault.subject))
        .any(|fault| matches!(&fault.condition, Condition::BoundCount { ways, .. } if ways.contains(&way)));
    let uses = |bounds: [LineStringId; 2]| bounds.contains(&LineStringId(way));
    let mut unloaded = map.map.dummies.lanelets.iter().filter(|lanelet| is_other(Subject::Lanelet(lanelet.id.0)));
    map.users_of(LineStringId(way)).is_empty()
        && !in_fault
        && !unloaded.any(|lanelet| uses([lanelet.left.line, lanelet.right.line]))
}

/// Whether a regulatory element refers to a way.
fn is_named(map: &MapIndex, way: i64) -> bool {
    let names = |element: &RegulatoryElement| {
        element.members.iter().any(|member| member.target == Target::LineString(LineStringId(way)))
    };
    map.map.regulatory_elements.iter().any(names)
}

/// The points of ways that follow each other, whichever way around each runs; `None` if they do not, or form a ring.
fn chain(map: &MapIndex, ways: &[i64]) -> Option<Vec<PointId>> {
    let lines = ways.iter().map(|&way| map.map.linestrings.get(LineStringId(way)).map(|line| line.points.clone()));
    let mut lines: VecDeque<Vec<PointId>> = lines.collect::<Option<_>>()?;
    let mut chain = lines.pop_front()?;
    let mut passed = 0;
    while let Some(mut line) = lines.pop_front() {
        let [Some(&start), Some(&end)] = [chain.first(), chain.last()] else { return None };
        if [line.first(), line.last()].contains(&Some(&start)) {
            if line.first() == Some(&start) {
                line.reverse();
            }
            line.pop();
            line.append(&mut chain);
            chain = line;
            passed = 0;
        } else if [line.first(), line.last()].contains(&Some(&end)) {
            if line.last() == Some(&end) {
                line.reverse();
            }
            chain.extend(line.into_iter().skip(1));
            passed = 0;
        } else {
            lines.push_back(line);
            passed += 1;
            if passed == lines.len() {
                return None;
            }
        }
    }
    let mut sorted = chain.clone();
    sorted.sort_unstable();
    (ways.len() > 1 && sorted.windows(2).all(|pair| pair[0] != pair[1])).then_some(chain)
}
