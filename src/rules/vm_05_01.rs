//! vm-05-01: a crosswalk is a lanelet for people on foot, and an element that tells the lanes across it.

use geo::Intersects;
use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Severity, Subject};
use crate::geometry::polygon;
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::{LaneletId, LineString, RegulatoryElement, Target};

use super::crosswalk_element;
use super::element_size::too_large;
use super::walkway::walking_allowed;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    max_bounding_box_size: f64,
    /// Whether the lanes that refer to an element count as its parts: a long lane is no fault.
    lanes_count: bool,
    /// Whether a member that follows one which is not what it should be counts without a look.
    next_is_trusted: bool,
    /// Whether a walkway that a crosswalk element names is wrong: Autoware treats both alike.
    walkways_are_wrong: bool,
    /// Whether each crosswalk is to have a stop line.
    stop_line_wanted: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let view = map.view();
    let used: FxHashSet<LaneletId> =
        view.elements("crosswalk").flat_map(|element| element.lanelets("refers")).collect();
    let is_walkway = |seen: &&Seen| !params.walkways_are_wrong && seen.is("walkway");
    let unused = view.lanelets.iter().filter(|seen| !used.contains(&seen.id()));
    let idle: Vec<&Seen> = unused.filter(|seen| seen.is("crosswalk") || is_walkway(seen)).collect();
    let crosswalks = idle.iter().filter(|seen| seen.is("crosswalk"));
    let mut findings: Vec<Finding> = crosswalks.map(|seen| unreferenced(map, seen)).collect();
    findings.extend(view.elements("crosswalk").flat_map(|element| judge(map, element, params, &idle)));
    findings
}

/// A crosswalk without element; where cars drive over it, the element can be made.
fn unreferenced(map: &MapIndex, crosswalk: &Seen) -> Finding {
    let id = crosswalk.id();
    let finding = |rest: &str| {
        let message = format!("Crosswalk {id} belongs to no crosswalk element{rest}.");
        Finding::new("unreferenced", Subject::Lanelet(id.0), message)
    };
    let Some(element) = crosswalk_element::creation(map, crosswalk) else {
        // No vehicle can meet anybody on it.
        return finding(", and crosses no road lanelet").graded(Severity::Warning);
    };
    let finding = finding("");
    let edits = walking_allowed(map, id).into_iter().chain(element.edits).collect();
    finding.fixed_by(element.title, false, edits)
}

fn judge(map: &MapIndex, element: &RegulatoryElement, params: &Params, idle: &[&Seen]) -> Vec<Finding> {
    let view = map.view();
    let (id, subject) = (element.id, Subject::RegulatoryElement(element.id.0));
    let refers: Vec<&Seen> =
        element.lanelets("refers").filter_map(|id| view.position(id)).map(|at| &view.lanelets[at]).collect();
    let mut findings = Vec::new();
    match refers.len() {
        0 => {
            let finding = Finding::new("no-refers", subject, format!("crosswalk {id} refers to no lanelet."));
            findings.push(crosswalk_element::with_crosswalk(map, finding, element, idle, None));
        }
        1 => {}
        count => {
            let message = format!("crosswalk {id} refers to {count} lanelets.");
            let finding = Finding::new("several-refers", subject, message);
            findings.push(crosswalk_element::divided(map, finding, element, &refers));
        }
    }
    let lines: Vec<&LineString> = view.lines(element, "ref_line").collect();
    match lines.len() {
        0 if params.stop_line_wanted
            && (params.walkways_are_wrong || refers.iter().any(|seen| seen.is("crosswalk"))) =>
        {
            findings.push(Finding::new("no-stop-line", subject, format!("crosswalk {id} has no stop line.")));
        }
        0 => {}
        1 => {}
        count => {
            let message = format!("crosswalk {id} has {count} stop lines.");
            findings.push(Finding::new("several-stop-lines", subject, message));
        }
    }
    let is_crosswalk = |seen: &Seen| seen.is("crosswalk") || (!params.walkways_are_wrong && seen.is("walkway"));
    let (crosswalks, wrong) = sorted_out(refers, is_crosswalk, params.next_is_trusted);
    findings.extend(wrong.into_iter().map(|seen| {
        let message = format!("Lanelet {} of crosswalk {id} is no crosswalk.", seen.id());
        let finding = Finding::new("refers-type", Subject::Lanelet(seen.id().0), message).with(subject, "element");
        crosswalk_element::with_crosswalk(map, finding, element, idle, Some(seen.id()))
    }));
    findings.extend(crosswalks.iter().filter_map(|seen| on_foot(map, seen, subject)));
    findings.extend(not_crossing(view, element, &crosswalks));
    let is_stop_line = |line: &LineString| line.attributes.is("type", "stop_line");
    let (stop_lines, wrong) = sorted_out(lines, is_stop_line, params.next_is_trusted);
    for line in wrong {
        let message = format!("ref_line {} of crosswalk {id} is no stop_line.", line.id);
        let on = Subject::LineString(line.id.0);
        let edits = vec![Edit::SetTag { on, key: "type".into(), value: "stop_line".into() }];
        let finding = Finding::new("line-type", on, message).with(subject, "element");
        findings.push(finding.fixed_by("set type=stop_line", false, edits));
    }
    findings.extend(extent(view, element, params, &crosswalks, &stop_lines));
    findings
}

/// Members of an element that are what they should be, and those that are not.
fn sorted_out<T>(members: Vec<&T>, right: impl Fn(&T) -> bool, next_is_trusted: bool) -> (Vec<&T>, Vec<&T>) {
    let mut trusted = false;
    members.into_iter().partition(|member| {
        let stays = trusted || right(member);
        trusted = next_is_trusted && !stays;
        stays
    })
}

/// Whether the element is too large. Where the lanes count, what is not as it should be does not.
fn extent(
    view: &View,
    element: &RegulatoryElement,
    params: &Params,
    crosswalks: &[&Seen],
    stop_lines: &[&LineString],
) -> Option<Finding> {
    let limit = params.max_bounding_box_size;
    if params.lanes_count {
        let diagonal = view.diagonal_of(element, |member| match (member.role.as_str(), member.target) {
            ("refers", Target::Lanelet(id)) => crosswalks.iter().any(|one| one.id() == id),
            ("ref_line", Target::LineString(id)) => stop_lines.iter().any(|line| line.id == id),
            ("crosswalk_polygon", Target::Polygon(_)) => true,
            _ => false,
        });
        return too_large("extent", element, diagonal, limit);
    }
    let (id, diagonal) = (element.id, view.spread(element));
    (diagonal > limit).then(|| {
        let message = format!("crosswalk {id} spreads over {diagonal:.0} m.");
        Finding::new("extent", Subject::RegulatoryElement(id.0), message).measured(diagonal, limit, "m")
    })
}

/// A crosswalk says that people on foot may use it.
fn on_foot(map: &MapIndex, seen: &Seen, element: Subject) -> Option<Finding> {
    let id = seen.id();
    let (fault, message) = match seen.tag("participant:pedestrian") {
        None => ("pedestrian-missing", format!("Crosswalk {id} has no participant:pedestrian.")),
        Some("yes" | "true" | "1") => return None,
        Some(other) => ("pedestrian-no", format!("participant:pedestrian={other} of crosswalk {id} is not yes.")),
    };
    let finding = Finding::new(fault, Subject::Lanelet(id.0), message).with(element, "element");
    Some(match walking_allowed(map, id) {
        Some(edit) => finding.fixed_by("set participant:pedestrian=yes", true, vec![edit]),
        None => {
            let key = "participant:pedestrian".into();
            let edits = vec![Edit::SetTag { on: finding.subject, key, value: "yes".into() }];
            finding.fixed_by("set participant:pedestrian=yes", false, edits)
        }
    })
}

/// A road lanelet that refers to a crosswalk runs across it.
fn not_crossing(view: &View, element: &RegulatoryElement, crosswalks: &[&Seen]) -> Vec<Finding> {
    let (id, subject) = (element.id, Subject::RegulatoryElement(element.id.0));
    let roads = view.referrers(id).iter().map(|&at| &view.lanelets[at]).filter(|seen| seen.is("road"));
    let mut findings = Vec::new();
    for road in roads {
        let outline = polygon::to_geo(&road.outline);
        for crosswalk in crosswalks.iter().filter(|one| !outline.intersects(&polygon::to_geo(&one.outline))) {
            let (name, other) = (road.id(), crosswalk.id());
            let message = format!("Lanelet {name} refers to crosswalk {id} but does not run across {other}.");
            let lanelet = Subject::Lanelet(name.0);
            let finding = Finding::new("not-crossing", subject, message)
                .with(lanelet, "lanelet")
                .with(Subject::Lanelet(other.0), "crosswalk");
            // With one crosswalk there is no other that the lanelet may run over.
            findings.push(match crosswalks {
                [_] => {
                    let role = "regulatory_element".into();
                    let edits = vec![Edit::RemoveMember { on: lanelet, role, member: subject }];
                    finding.fixed_by(format!("let lanelet {name} no longer refer to it"), false, edits)
                }
                _ => finding,
            });
        }
    }
    findings
}
