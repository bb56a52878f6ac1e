//! vm-04-01: a traffic light is an element with bodies, bulbs and a stop line, and lanelets that obey it.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::View;
use crate::lanelet::number::leading_integer;
use crate::lanelet::vocabulary::{On, THREE_LAMPS, slip, subtypes};
use crate::lanelet::{LaneletId, LineString, LineStringId, RegulatoryElement};
use crate::text::counted;

use super::element_size::{diagonal_of_lines, too_large};
use super::obeyed_light::ObeyedLights;
use super::stop_line_crossings::lanes_that_stop;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    max_bounding_box_size: f64,
    /// Whether to speak of stop lines missing in intersections, too, which vm-03-04 judges.
    everywhere: bool,
    /// Whether to speak of elements without any bulbs.
    bulbs_needed: bool,
    /// Whether lines in known roles count for the size and nothing else, so that an element without any is too large.
    lines_only: bool,
    /// Whether an id below one names no light.
    ids_above_zero: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let view = map.view();
    let used: FxHashSet<LineStringId> =
        view.elements("traffic_light").flat_map(|light| light.linestrings("refers")).collect();
    let bodies = view.map.linestrings.iter().filter(|line| line.attributes.is("type", "traffic_light"));
    let unnamed: Vec<LineStringId> = bodies.filter(|line| !used.contains(&line.id)).map(|line| line.id).collect();
    let mut findings = unreferenced(map, &unnamed);
    findings.extend(view.elements("traffic_light").flat_map(|light| judge(map, view, light, params)));
    findings.extend(of_no_kind(view));
    findings
}

/// The subtype of lights with which Autoware's detection does as with none: it does not look for them.
const PASSED_OVER: &str = "solid";

/// Lights that roads alone obey and that do not say which lamps they have.
fn of_no_kind(view: &View) -> Vec<Finding> {
    let known: FxHashSet<&str> = subtypes("traffic_light").filter(|kind| *kind != PASSED_OVER).collect();
    let mut told = FxHashSet::default();
    let mut findings = Vec::new();
    for element in view.elements("traffic_light") {
        let referrers: Vec<_> = view.referrers(element.id).iter().map(|&at| &view.lanelets[at]).collect();
        if referrers.is_empty() || !referrers.iter().all(|seen| seen.is("road")) {
            continue;
        }
        for body in view.lines(element, "refers").filter(|line| line.attributes.is("type", "traffic_light")) {
            let kind = body.attributes.get("subtype");
            let is_slip = |kind| slip(On::LineString, &body.attributes, "subtype", kind).is_some();
            if kind.is_some_and(|kind| known.contains(kind) || is_slip(kind)) || !told.insert(body.id) {
                continue;
            }
            let id = body.id;
            let message = match kind {
                None => format!("Traffic light {id} has no subtype: Autoware's camera does not look for it."),
                Some(PASSED_OVER) => {
                    format!("Traffic light {id} has subtype {PASSED_OVER}: Autoware's camera does not look for it.")
                }
                Some(kind) => format!("Traffic light {id} has subtype \"{kind}\", which names no kind of light."),
            };
            let on = Subject::LineString(id.0);
            let edits = vec![Edit::SetTag { on, key: "subtype".into(), value: THREE_LAMPS.into() }];
            let finding = Finding::new("kind", on, message).with(Subject::RegulatoryElement(element.id.0), "element");
            findings.push(finding.fixed_by(format!("set subtype={THREE_LAMPS}"), false, edits));
        }
    }
    findings
}

/// Lights that no element names.
fn unreferenced(map: &MapIndex, lights: &[LineStringId]) -> Vec<Finding> {
    let obeyed = ObeyedLights::new(map, lights);
    let finding = |&light: &LineStringId| {
        let message = format!("Traffic light {light} belongs to no traffic_light element.");
        obeyed.named(Finding::new("unreferenced", Subject::LineString(light.0), message), light)
    };
    lights.iter().map(finding).collect()
}

fn judge(map: &MapIndex, view: &View, light: &RegulatoryElement, params: &Params) -> Vec<Finding> {
    let (id, subject) = (light.id, Subject::RegulatoryElement(light.id.0));
    let lines = |role| -> Vec<&LineString> { view.lines(light, role).collect() };
    let (bodies, bulbs, stop_lines) = (lines("refers"), lines("light_bulbs"), lines("ref_line"));
    let referrers: Vec<_> = view.referrers(id).iter().map(|&at| &view.lanelets[at]).collect();
    let mut findings = Vec::new();
    if referrers.is_empty() {
        let finding = Finding::new("idle", subject, format!("No lanelet refers to traffic_light {id}."));
        findings.push(obeyed(map, finding, light));
    }
    let on_foot = bodies.iter().all(|line| line.attributes.is("subtype", "red_green"))
        || referrers.iter().all(|seen| seen.is("crosswalk"));
    let elsewhere =
        params.everywhere || !referrers.iter().any(|seen| map.lane(seen.id()).is_some_and(|l| map.has_area(l)));
    if stop_lines.is_empty() && !on_foot && elsewhere {
        findings.push(Finding::new("no-stop-line", subject, format!("traffic_light {id} has no stop line.")));
    }
    for (fault, lines, role, kind) in [
        ("body-type", &bodies, "refers", "traffic_light"),
        ("line-type", &stop_lines, "ref_line", "stop_line"),
        ("bulbs-type", &bulbs, "light_bulbs", "light_bulbs"),
    ] {
        for line in lines.iter().filter(|line| !line.attributes.is("type", kind)) {
            let message = format!("{role} {} of traffic_light {id} is not of type {kind}.", line.id);
            let on = Subject::LineString(line.id.0);
            let edits = vec![Edit::SetTag { on, key: "type".into(), value: kind.into() }];
            let finding = Finding::new(fault, on, message).with(subject, "element");
            findings.push(finding.fixed_by(format!("set type={kind}"), false, edits));
        }
    }
    for line in bulbs.iter().filter(|line| !line.attributes.has("traffic_light_id")) {
        let message = format!("Bulbs {} of traffic_light {id} name no traffic_light_id.", line.id);
        let on = Subject::LineString(line.id.0);
        let finding = Finding::new("bulbs-nameless", on, message).with(subject, "element");
        findings.push(match bodies[..] {
            // With one body there is no other whose bulbs they could be.
            [body] => {
                let value = body.id.to_string();
                let edits = vec![Edit::SetTag { on, key: "traffic_light_id".into(), value: value.as_str().into() }];
                finding.fixed_by(format!("set traffic_light_id={value}"), true, edits)
            }
            _ => finding,
        });
    }
    if params.bulbs_needed || !bulbs.is_empty() {
        findings.extend(pairing(subject, id.0, &bodies, &bulbs, params.ids_above_zero));
    }
    let diagonal = match params.lines_only {
        true => diagonal_of_lines(view, light, &["refers", "ref_line", "light_bulbs"]),
        false => Some(view.reach(light)),
    };
    findings.extend(too_large("extent", light, diagonal, params.max_bounding_box_size));
    findings
}

/// Adds the edits that let the lanelets at a light's stop line refer to it.
fn obeyed(map: &MapIndex, finding: Finding, light: &RegulatoryElement) -> Finding {
    let lanes = light.linestrings("ref_line").flat_map(|line| lanes_that_stop(map, line));
    let lanelets: BTreeSet<LaneletId> = lanes.map(|lane| map.lanes[lane].id).collect();
    if lanelets.is_empty() {
        return finding;
    }
    let member = finding.subject;
    let refer =
        |id: &LaneletId| Edit::AddMember { on: Subject::Lanelet(id.0), role: "regulatory_element".into(), member };
    let title = format!("let {} at its stop line refer to it", counted(lanelets.len(), "lanelet"));
    finding.fixed_by(title, false, lanelets.iter().map(refer).collect())
}

/// Each body has its bulbs.
fn pairing(
    subject: Subject,
    id: i64,
    bodies: &[&LineString],
    bulbs: &[&LineString],
    ids_above_zero: bool,
) -> Option<Finding> {
    let (count, others) = (bodies.len(), bulbs.len());
    if count != others {
        let message = format!("traffic_light {id} has {count} bodies but {others} lines of bulbs.");
        return Some(Finding::new("bulbs-count", subject, message));
    }
    // Of bulbs that name nothing, that is told.
    if !ids_above_zero && bulbs.iter().any(|line| !line.attributes.has("traffic_light_id")) {
        return None;
    }
    let own: BTreeSet<i64> = bodies.iter().map(|line| line.id.0).collect();
    let named = bulbs.iter().filter_map(|line| leading_integer(line.attributes.get("traffic_light_id")?));
    let named: BTreeSet<i64> = named.filter(|id| i32::try_from(*id).is_ok() && (*id > 0 || !ids_above_zero)).collect();
    (own != named).then(|| {
        let message = format!("The bulbs of traffic_light {id} do not name its bodies one by one.");
        Finding::new("bulbs-unpaired", subject, message)
    })
}
