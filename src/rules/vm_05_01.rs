//! vm-05-01: a crosswalk is a lanelet for people on foot, and an element that tells the lanes across it.

use geo::Intersects;
use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Finding, Subject};
use crate::geometry::polygon;
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::{LaneletId, RegulatoryElement};

use super::Rule;

/// See `rules/vm-05-01.md`.
pub struct Crosswalks;

/// See the document.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    max_bounding_box_size: f64,
    /// Whether the lanes that refer to an element count as its parts: a long lane is no fault.
    lanes_count: bool,
    /// Whether a walkway that a crosswalk element names is wrong: Autoware treats both alike.
    walkways_are_wrong: bool,
    /// Whether each crosswalk is to have a stop line.
    stop_line_wanted: bool,
}

impl Rule for Crosswalks {
    type Params = Params;

    fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
        let view = map.view();
        let used: FxHashSet<LaneletId> =
            view.elements("crosswalk").flat_map(|element| element.lanelets("refers")).collect();
        let crosswalks = view.lanelets.iter().filter(|seen| seen.is("crosswalk"));
        let mut findings: Vec<Finding> = crosswalks
            .filter(|seen| !used.contains(&seen.id()))
            .map(|seen| {
                let message = format!("Crosswalk {} belongs to no crosswalk element.", seen.id());
                Finding::new("unreferenced", Subject::Lanelet(seen.id().0), message)
            })
            .collect();
        findings.extend(view.elements("crosswalk").flat_map(|element| judge(view, element, params)));
        findings
    }
}

fn judge(view: &View, element: &RegulatoryElement, params: &Params) -> Vec<Finding> {
    let (id, subject) = (element.id, Subject::RegulatoryElement(element.id.0));
    let refers: Vec<&Seen> =
        element.lanelets("refers").filter_map(|id| view.position(id)).map(|at| &view.lanelets[at]).collect();
    let mut findings = Vec::new();
    match refers.len() {
        0 => findings.push(Finding::new("no-refers", subject, format!("crosswalk {id} refers to no lanelet."))),
        1 => {}
        count => {
            findings.push(Finding::new(
                "several-refers",
                subject,
                format!("crosswalk {id} refers to {count} lanelets."),
            ));
        }
    }
    let lines: Vec<_> = view.lines(element, "ref_line").collect();
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
    let (crosswalks, wrong): (Vec<&Seen>, Vec<&Seen>) = refers.into_iter().partition(|seen| is_crosswalk(seen));
    findings.extend(wrong.into_iter().map(|seen| {
        let message = format!("Lanelet {} of crosswalk {id} is no crosswalk.", seen.id());
        Finding::new("refers-type", Subject::Lanelet(seen.id().0), message).with(subject, "element")
    }));
    findings.extend(crosswalks.iter().filter_map(|seen| on_foot(seen, subject)));
    findings.extend(not_crossing(view, element, &crosswalks));
    for line in lines.into_iter().filter(|line| !line.attributes.is("type", "stop_line")) {
        let message = format!("ref_line {} of crosswalk {id} is no stop_line.", line.id);
        findings.push(Finding::new("line-type", Subject::LineString(line.id.0), message).with(subject, "element"));
    }
    let diagonal = if params.lanes_count { view.diagonal(element) } else { view.spread(element) };
    if diagonal > params.max_bounding_box_size {
        let whole = if params.lanes_count { " and its lanelets spread" } else { " spreads" };
        let message = format!("crosswalk {id}{whole} over {diagonal:.0} m.");
        findings.push(Finding::new("extent", subject, message).measured(diagonal, params.max_bounding_box_size, "m"));
    }
    findings
}

/// A crosswalk says that people on foot may use it.
fn on_foot(seen: &Seen, element: Subject) -> Option<Finding> {
    let id = seen.id();
    let (fault, message) = match seen.tag("participant:pedestrian") {
        None => ("pedestrian-missing", format!("Crosswalk {id} has no participant:pedestrian.")),
        Some("yes" | "true" | "1") => return None,
        Some(other) => ("pedestrian-no", format!("participant:pedestrian={other} of crosswalk {id} is not yes.")),
    };
    Some(Finding::new(fault, Subject::Lanelet(id.0), message).with(element, "element"))
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
            findings.push(
                Finding::new("not-crossing", subject, message)
                    .with(Subject::Lanelet(name.0), "lanelet")
                    .with(Subject::Lanelet(other.0), "crosswalk"),
            );
        }
    }
    findings
}
