//! Areas on the road that an element tells the lanes about: one polygon, the stop line where there is one, road lanelets.

use rustc_hash::FxHashSet;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::{Point, polygon};
use crate::lanelet::index::extent;
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::{PolygonId, RegulatoryElement};
use crate::text::counted;

/// Judges polygons and elements of one kind: the type of the ones is the subtype of the others. Lanelets of these subtypes may refer to
/// them.
pub fn judge(view: &View, kind: &str, referrers: &[&str]) -> Vec<Finding> {
    let mut findings = unreferenced(view, kind);
    findings.extend(view.elements(kind).filter_map(|element| chain(view, kind, element, referrers)));
    findings
}

/// Polygons of which no element speaks.
pub fn unreferenced(view: &View, kind: &str) -> Vec<Finding> {
    let used: FxHashSet<PolygonId> = view.elements(kind).flat_map(|element| element.polygons("refers")).collect();
    let idle = view.polygons(kind).filter(|polygon| !used.contains(&polygon.id));
    idle.map(|polygon| {
        let message = format!("The {kind} {} belongs to no {kind} element.", polygon.id);
        let finding = Finding::new("unreferenced", Subject::Polygon(polygon.id.0), message);
        let ring = view.ring(polygon);
        let roads: Vec<i64> = roads_under(view, &ring).into_iter().map(|at| view.lanelets[at].id().0).collect();
        if roads.is_empty() {
            return finding;
        }
        let title = format!("create the {kind} element for {} under it", counted(roads.len(), "lanelet"));
        let members = vec![("refers".into(), Subject::Polygon(polygon.id.0))];
        let edit = Edit::CreateRegulatoryElement { subtype: kind.into(), members, referrers: roads };
        finding.fixed_by(title, false, vec![edit])
    })
    .collect()
}

/// The road lanelets on which an area lies, by position.
fn roads_under(view: &View, ring: &[Point]) -> Vec<usize> {
    let near = if ring.len() > 2 { view.near(extent(ring), 0.0) } else { Vec::new() };
    let under = |at: &usize| {
        let seen = &view.lanelets[*at];
        seen.is("road") && polygon::overlap(&seen.outline, ring) > BESIDE
    };
    near.into_iter().filter(under).collect()
}

/// The first thing that is wrong with an element.
fn chain(view: &View, kind: &str, element: &RegulatoryElement, may_refer: &[&str]) -> Option<Finding> {
    let (id, subject) = (element.id, Subject::RegulatoryElement(element.id.0));
    let finding = |fault, message| Some(Finding::new(fault, subject, message));
    let polygons: Vec<PolygonId> = element.polygons("refers").collect();
    let [polygon] = polygons[..] else {
        let finding = finding("number", format!("{kind} element {id} refers to {} polygons.", polygons.len()))?;
        return Some(one_for_each_polygon(view, finding, element, &polygons));
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
    let may_not = |seen: &&Seen| !may_refer.iter().any(|kind| seen.is(kind));
    let other = referrers.iter().map(|&at| &view.lanelets[at]).find(may_not)?;
    let finding = finding("referrer", format!("Lanelet {}, which is no road, refers to {kind} {id}.", other.id()))?;
    Some(finding.with(Subject::Lanelet(other.id().0), "lanelet"))
}

/// Adds the fix that lets an element keep its first polygon and gives each other one an element of its own, to which the same lanelets
/// refer: together they say what the one did. Not where the element says more than that.
fn one_for_each_polygon(view: &View, finding: Finding, element: &RegulatoryElement, polygons: &[PolygonId]) -> Finding {
    let Some((_, others)) = polygons.split_first() else { return finding };
    let lanelets: Vec<i64> = view.referrers(element.id).iter().map(|&at| view.lanelets[at].id().0).collect();
    if lanelets.is_empty() || element.members.len() > polygons.len() {
        return finding;
    }
    let (on, subtype) = (finding.subject, &element.subtype);
    let edits = others.iter().flat_map(|polygon| {
        let member = Subject::Polygon(polygon.0);
        let members = vec![("refers".into(), member)];
        [
            Edit::RemoveMember { on, role: "refers".into(), member },
            Edit::CreateRegulatoryElement { subtype: subtype.clone(), members, referrers: lanelets.clone() },
        ]
    });
    let edits = edits.collect();
    finding.fixed_by(format!("create {subtype} elements for all polygons but the first"), true, edits)
}

/// A lane on which less of an area lies (m2) is beside it: borders are drawn by hand.
const BESIDE: f64 = 1.0;

/// Lanelets that refer to an area which does not touch them. Of those whose kind is wrong, that is what is said.
pub fn apart(view: &View, kind: &str, kinds: &[&str]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for element in view.elements(kind) {
        let rings: Vec<Vec<Point>> = rings(view, element);
        for seen in view.referrers(element.id).iter().map(|&at| &view.lanelets[at]) {
            let touched = rings.iter().any(|ring| polygon::overlap(&seen.outline, ring) > 0.0);
            if touched || rings.is_empty() || !kinds.iter().any(|kind| seen.is(kind)) {
                continue;
            }
            let (id, on) = (seen.id(), Subject::RegulatoryElement(element.id.0));
            let message = format!("Lanelet {id} refers to {kind} {}, which does not lie on it.", element.id);
            let edits =
                vec![Edit::RemoveMember { on: Subject::Lanelet(id.0), role: "regulatory_element".into(), member: on }];
            let finding = Finding::new("apart", on, message).with(Subject::Lanelet(id.0), "lanelet");
            findings.push(finding.fixed_by(format!("let lanelet {id} not refer to {}", element.id), false, edits));
        }
    }
    findings
}

/// Road lanelets on which an area lies that they do not refer to, though others do.
pub fn not_told(view: &View, kind: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    for element in view.elements(kind) {
        let told = view.referrers(element.id);
        for ring in rings(view, element).iter().filter(|ring| !told.is_empty() && ring.len() > 2) {
            for at in view.near(extent(ring), 0.0) {
                let seen = &view.lanelets[at];
                let area = if seen.is("road") { polygon::overlap(&seen.outline, ring) } else { 0.0 };
                if area <= BESIDE || told.contains(&at) {
                    continue;
                }
                let (id, member) = (seen.id(), Subject::RegulatoryElement(element.id.0));
                let message =
                    format!("{area:.1} m2 of {kind} {} lie on lanelet {id}, which does not refer to it.", element.id);
                let (on, role) = (Subject::Lanelet(id.0), "regulatory_element".into());
                let finding =
                    Finding::new("not-told", member, message).with(on, "lanelet").measured(area, BESIDE, "m2");
                let edits = vec![Edit::AddMember { on, role, member }];
                findings.push(finding.fixed_by(format!("let lanelet {id} refer to {}", element.id), true, edits));
            }
        }
    }
    findings
}

/// The outlines of an element's polygons.
fn rings(view: &View, element: &RegulatoryElement) -> Vec<Vec<Point>> {
    element.polygons("refers").filter_map(|id| view.map.polygons.get(id)).map(|polygon| view.ring(polygon)).collect()
}
