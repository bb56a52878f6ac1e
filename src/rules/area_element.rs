//! Areas on the road that an element tells the lanes about: one polygon, the stop line where there is one, road lanelets.

use rustc_hash::FxHashSet;

use super::view::View;
use crate::diagnostic::{Finding, Subject};
use crate::lanelet::{PolygonId, RegulatoryElement};

/// Judges polygons and elements of one kind: the type of the ones is the subtype of the others.
pub fn judge(view: &View, kind: &str) -> Vec<Finding> {
    let mut findings = unreferenced(view, kind);
    findings.extend(view.elements(kind).filter_map(|element| chain(view, kind, element)));
    findings
}

/// Polygons of which no element speaks.
pub fn unreferenced(view: &View, kind: &str) -> Vec<Finding> {
    let used: FxHashSet<PolygonId> = view.elements(kind).flat_map(|element| element.polygons("refers")).collect();
    let idle = view.polygons(kind).filter(|polygon| !used.contains(&polygon.id));
    idle.map(|polygon| {
        let message = format!("The {kind} {} belongs to no {kind} element.", polygon.id);
        Finding::new("unreferenced", Subject::Polygon(polygon.id.0), message)
    })
    .collect()
}

/// The first thing that is wrong with an element.
fn chain(view: &View, kind: &str, element: &RegulatoryElement) -> Option<Finding> {
    let (id, subject) = (element.id, Subject::RegulatoryElement(element.id.0));
    let finding = |fault, message| Some(Finding::new(fault, subject, message));
    let polygons: Vec<PolygonId> = element.polygons("refers").collect();
    let [polygon] = polygons[..] else {
        return finding("number", format!("{kind} element {id} refers to {} polygons.", polygons.len()));
    };
    if !view.map.polygons.get(polygon).is_some_and(|polygon| polygon.attributes.is("type", kind)) {
        let finding = finding("type", format!("Polygon {polygon} of {kind} element {id} is no {kind}."))?;
        return Some(finding.with(Subject::Polygon(polygon.0), "polygon"));
    }
    if let Some(line) = view.lines(element, "ref_line").find(|line| !line.attributes.is("type", "stop_line")) {
        let finding = finding("line-type", format!("ref_line {} of {kind} element {id} is no stop_line.", line.id))?;
        return Some(finding.with(Subject::LineString(line.id.0), "ref_line"));
    }
    let referrers = view.referrers(id);
    if referrers.is_empty() {
        return finding("idle", format!("No lanelet refers to {kind} element {id}."));
    }
    let other = referrers.iter().map(|&at| &view.lanelets[at]).find(|seen| !seen.is("road"))?;
    let finding = finding("referrer", format!("Lanelet {}, which is no road, refers to {kind} {id}.", other.id()))?;
    Some(finding.with(Subject::Lanelet(other.id().0), "lanelet"))
}
