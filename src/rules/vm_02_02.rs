//! vm-02-02: a stop line belongs to an element, and a stop sign has one.

use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::View;
use crate::lanelet::{LineString, LineStringId, RegulatoryElement};
use crate::text::counted;

use super::element_size::{diagonal_of_lines, too_large};
use super::lost_members::{self, LostMembers};
use super::stop_line_crossings::{lanes_that_stop, line_of_lanes};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    max_bounding_box_size: f64,
    /// Whether every sign has to be a stop sign, and its line to say so in its `subtype`.
    strict: bool,
    /// Whether to speak of stop lines inside intersections, too, which vm-03-14 judges.
    everywhere: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let view = map.view();
    let mut findings = unreferenced(map, view, params);
    findings.extend(view.elements("traffic_sign").flat_map(|sign| judge(map, sign, params)));
    findings
}

fn unreferenced(map: &MapIndex, view: &View, params: &Params) -> Vec<Finding> {
    let elements = view.map.regulatory_elements.iter();
    let used: FxHashSet<LineStringId> =
        elements.flat_map(|element| element.linestrings("ref_line").chain(element.linestrings("refers"))).collect();
    let lines = view.map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line"));
    let idle = lines.filter(|line| !used.contains(&line.id));
    let lost = LostMembers::of(map);
    idle.filter(|line| params.everywhere || !inside(map, view, line))
        .map(|line| {
            let id = line.id;
            let message = format!("Stop line {id} belongs to no regulatory element.");
            let finding = Finding::new("unreferenced", Subject::LineString(id.0), message);
            let lanelets = lanes_that_stop(map, id);
            if lanelets.is_empty() {
                return finding;
            }
            let obeying = lanelets.iter().map(|&lane| map.lanes[lane].id).collect();
            if let Some(marking) = lost.of_lanelets("road_marking", &obeying).next() {
                let edits = vec![lost_members::marking(marking, id)];
                return finding.fixed_by(format!("let road_marking {marking} refer to it"), false, edits);
            }
            let title =
                format!("create the road_marking element for {} that stop there", counted(lanelets.len(), "lanelet"));
            let members = vec![("refers".into(), finding.subject)];
            let referrers = lanelets.into_iter().map(|lane| map.lanes[lane].id.0).collect();
            let edit = Edit::CreateRegulatoryElement { subtype: "road_marking".into(), members, referrers };
            finding.fixed_by(title, false, vec![edit])
        })
        .collect()
}

/// Whether a line lies in an intersection.
fn inside(map: &MapIndex, view: &View, line: &LineString) -> bool {
    let places = view.places(line);
    let [low, high] = crate::lanelet::index::extent(&places);
    // Where lanes only end on it, nobody else speaks of it.
    let ends_there = |lane: usize| map.lanes[lane].end.ids.iter().all(|id| line.points.contains(id));
    let near: Vec<usize> = map.lanes_near(low, high).into_iter().filter(|&lane| map.has_area(lane)).collect();
    !near.is_empty() && !near.into_iter().any(ends_there)
}

fn judge(map: &MapIndex, sign: &RegulatoryElement, params: &Params) -> Vec<Finding> {
    let view = map.view();
    let (id, subject) = (sign.id, Subject::RegulatoryElement(sign.id.0));
    let (signs, lines): (Vec<&LineString>, Vec<&LineString>) =
        (view.lines(sign, "refers").collect(), view.lines(sign, "ref_line").collect());
    if signs.is_empty() {
        return vec![Finding::new("sign-missing", subject, format!("traffic_sign {id} refers to no sign."))];
    }
    let mut findings = Vec::new();
    let about = |fault, line: &LineString, message| {
        Finding::new(fault, Subject::LineString(line.id.0), message).with(subject, "element")
    };
    let is_sign = |line: &&LineString| {
        line.attributes.is("type", "traffic_sign") && (!params.strict || line.attributes.is("subtype", "stop_sign"))
    };
    let stops = |line: &&LineString| {
        let kind = line.attributes.get("subtype").unwrap_or_default();
        ["stop", "yield", "give_way"].iter().any(|word| kind.contains(word))
    };
    let signs_that_stop = signs.iter().any(stops);
    for line in signs.into_iter().filter(|line| !is_sign(line)) {
        let wanted = if params.strict { "a stop_sign" } else { "a traffic_sign" };
        let finding = about("sign-type", line, format!("Linestring {} of traffic_sign {id} is not {wanted}.", line.id));
        findings.push(if params.strict { finding } else { retyped(finding, "traffic_sign") });
    }
    // Without a line, only a sign that makes nobody stop is complete.
    if lines.is_empty() {
        if !params.strict && !signs_that_stop {
            return findings;
        }
        let finding = Finding::new("sign-without-line", subject, format!("traffic_sign {id} has no stop line."));
        findings.push(with_line(map, finding, sign));
        return findings;
    }
    let is_line = |line: &&LineString| {
        line.attributes.is("subtype", "stop_line") || (!params.strict && line.attributes.is("type", "stop_line"))
    };
    for line in lines.into_iter().filter(|line| !is_line(line)) {
        let message = format!("ref_line {} of traffic_sign {id} is no stop_line.", line.id);
        findings.push(retyped(about("line-type", line, message), "stop_line"));
    }
    let diagonal = match params.strict {
        true => diagonal_of_lines(view, sign, &["refers", "ref_line"]),
        false => Some(view.reach(sign)),
    };
    findings.extend(too_large("sign-extent", sign, diagonal, params.max_bounding_box_size));
    findings
}

/// Adds the edit that lets a sign name the stop line at which its lanes end.
fn with_line(map: &MapIndex, finding: Finding, sign: &RegulatoryElement) -> Finding {
    let lanes: Vec<usize> = map.referrers(sign.id).iter().filter_map(|&id| map.lane(id)).collect();
    let Some(line) = line_of_lanes(map, &lanes) else { return finding };
    let member = Subject::LineString(line.0);
    let edits = vec![Edit::AddMember { on: finding.subject, role: "ref_line".into(), member }];
    finding.with(member, "stop line").fixed_by(format!("give it stop line {line}"), false, edits)
}

/// Adds the edit that gives a line its type.
fn retyped(finding: Finding, kind: &'static str) -> Finding {
    let edits = vec![Edit::SetTag { on: finding.subject, key: "type".into(), value: kind.into() }];
    finding.fixed_by(format!("set type={kind}"), false, edits)
}
