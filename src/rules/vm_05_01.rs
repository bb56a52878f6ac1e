//! vm-05-01: a crosswalk is a lanelet for people on foot, and an element that tells the lanes across it.

use std::collections::BTreeSet;

use geo::Intersects;
use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::{Point, polygon};
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::index::{MapIndex, extent};
use crate::lanelet::{LaneletId, LineStringId, RegulatoryElement};

use super::Rule;
use super::stop_line_crossings::crossings;
use super::walkway::walking_allowed;

/// A lane that shares at least this area (m2) with a crosswalk runs over it.
const CROSSES: f64 = 0.1;
/// A stop line farther (m) before a crosswalk belongs to something else.
const BEFORE: f64 = 8.0;

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
        let mut findings: Vec<Finding> =
            crosswalks.filter(|seen| !used.contains(&seen.id())).map(|seen| unreferenced(map, seen)).collect();
        findings.extend(view.elements("crosswalk").flat_map(|element| judge(map, element, params)));
        findings
    }
}

/// A crosswalk without element; where cars drive over it, the element can be made.
fn unreferenced(map: &MapIndex, crosswalk: &Seen) -> Finding {
    let id = crosswalk.id();
    let on = Subject::Lanelet(id.0);
    let finding = Finding::new("unreferenced", on, format!("Crosswalk {id} belongs to no crosswalk element."));
    let across = lanes_across(map, crosswalk);
    if across.is_empty() {
        return finding;
    }
    let mut members = vec![("refers".into(), on)];
    let lines = stop_lines_before(map, &across);
    members.extend(lines.iter().map(|line| ("ref_line".into(), Subject::LineString(line.0))));
    let referrers: Vec<i64> = across.iter().map(|&(lane, _)| map.lanes[lane].id.0).collect();
    let stop = match lines.len() {
        0 => String::new(),
        1 => format!(", with stop line {}", lines[0]),
        count => format!(", with {count} stop lines"),
    };
    let title = format!("create the crosswalk element for the {} lanelets across it{stop}", referrers.len());
    let element = Edit::CreateRegulatoryElement { subtype: "crosswalk".into(), members, referrers };
    let edits = walking_allowed(map, id).into_iter().chain([element]).collect();
    finding.fixed_by(title, false, edits)
}

/// The lanes for cars that run over a crosswalk on its level, each with the station (m) where it comes to it.
fn lanes_across(map: &MapIndex, crosswalk: &Seen) -> Vec<(usize, f64)> {
    let [low, high] = crosswalk.extent;
    let near = map.lanes_near(low, high).into_iter().filter(|&lane| map.lanes[lane].is_for_cars());
    let height = |lane: usize, place: Point| map.height(lane, place);
    let own = map.lane(crosswalk.id());
    let over = near.filter_map(|lane| {
        let (_, place) =
            polygon::common_part(&map.lanes[lane].outline, &crosswalk.outline).filter(|one| one.0 >= CROSSES)?;
        let apart = own.and_then(|own| height(own, place)).zip(height(lane, place));
        if apart.is_some_and(|(a, b)| (a - b).abs() > map.thresholds.grade_separation) {
            return None;
        }
        let center = map.lanes[lane].center.as_ref()?;
        let stations = crosswalk.outline.iter().map(|&corner| center.project(corner).station);
        Some((lane, stations.fold(f64::INFINITY, f64::min)))
    });
    over.collect()
}

/// The stop lines before a crosswalk on the lanes across it, or on those that lead to them.
fn stop_lines_before(map: &MapIndex, across: &[(usize, f64)]) -> Vec<LineStringId> {
    let mut lines = BTreeSet::new();
    let corners: Vec<Point> = across.iter().flat_map(|&(lane, _)| map.lanes[lane].extent).collect();
    let [low, high] = extent(&corners);
    let reach = nalgebra::Vector2::repeat(BEFORE);
    for line in map.stop_lines_near(low - reach, high + reach) {
        for crossing in crossings(map, &line, 0.0) {
            let gap = across.iter().filter_map(|&(lane, entry)| {
                let on_it = (lane == crossing.lane).then_some(entry - crossing.station);
                let before = map.predecessors(lane).contains(&crossing.lane);
                let length = map.lanes[crossing.lane].length();
                on_it.or(before.then_some(length - crossing.station + entry))
            });
            if gap.into_iter().any(|gap| (0.0..=BEFORE).contains(&gap)) {
                lines.insert(line.way);
            }
        }
    }
    lines.into_iter().collect()
}

fn judge(map: &MapIndex, element: &RegulatoryElement, params: &Params) -> Vec<Finding> {
    let view = map.view();
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
    findings.extend(crosswalks.iter().filter_map(|seen| on_foot(map, seen, subject)));
    findings.extend(not_crossing(view, element, &crosswalks));
    for line in lines.into_iter().filter(|line| !line.attributes.is("type", "stop_line")) {
        let message = format!("ref_line {} of crosswalk {id} is no stop_line.", line.id);
        let on = Subject::LineString(line.id.0);
        let edits = vec![Edit::SetTag { on, key: "type".into(), value: "stop_line".into() }];
        let finding = Finding::new("line-type", on, message).with(subject, "element");
        findings.push(finding.fixed_by("set type=stop_line", false, edits));
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
        None => finding,
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
            findings.push(
                Finding::new("not-crossing", subject, message)
                    .with(Subject::Lanelet(name.0), "lanelet")
                    .with(Subject::Lanelet(other.0), "crosswalk"),
            );
        }
    }
    findings
}
