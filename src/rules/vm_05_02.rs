//! vm-05-02: a crosswalk with signals refers to lights for people on foot.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Severity, Subject};
use crate::geometry::{Point, Polyline, polygon};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::vocabulary::THREE_LAMPS;
use crate::lanelet::{LineString, RegulatoryElement};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    reach: f64,
}

/// The subtype of a light for people on foot.
const ON_FOOT: &str = "red_green";

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let view = map.view();
    view.elements("traffic_light").flat_map(|element| judge(view, params, element)).collect()
}

fn judge(view: &View, params: &Params, element: &RegulatoryElement) -> Vec<Finding> {
    let (id, subject) = (element.id, Subject::RegulatoryElement(element.id.0));
    let lights: Vec<&LineString> =
        view.lines(element, "refers").filter(|line| line.attributes.is("type", "traffic_light")).collect();
    let referrers = view.referrers(id).iter().map(|&at| &view.lanelets[at]);
    let (crosswalks, others): (Vec<_>, Vec<_>) = referrers.partition(|seen| seen.is("crosswalk"));
    let on_foot = |light: &&&LineString| light.attributes.is("subtype", ON_FOOT);
    let mut findings = Vec::new();
    if !lights.is_empty() && lights.iter().filter(on_foot).count() == lights.len() {
        findings.extend(others.iter().filter(|seen| seen.is("road")).map(|road| {
            let message =
                format!("Road lanelet {} refers to {id}, which has lights for people on foot only.", road.id());
            let finding = Finding::new("vehicles", subject, message).with(Subject::Lanelet(road.id().0), "lanelet");
            match crosswalks.is_empty() {
                true => for_vehicles(view, finding, element, &lights),
                false => forgotten_by(view, finding, element, road),
            }
        }));
    }
    let Some(first) = crosswalks.first() else { return findings };
    let named = |finding: Finding| finding.with(Subject::Lanelet(first.id().0), "crosswalk");
    for light in lights.iter().filter(|light| !on_foot(light)) {
        let kind = light.attributes.get("subtype").unwrap_or("none");
        let on = Subject::LineString(light.id.0);
        let message = format!("Light {} of crosswalk {} has subtype {kind}, not {ON_FOOT}.", light.id, first.id());
        let finding = named(Finding::new("light-kind", on, message).with(subject, "element"));
        // Another light is worse than one that nobody has said the kind of.
        let finding = if kind == THREE_LAMPS { finding } else { finding.graded(Severity::Warning) };
        let edits = vec![Edit::SetTag { on, key: "subtype".into(), value: ON_FOOT.into() }];
        findings.push(finding.fixed_by(
            format!("set subtype={ON_FOOT}"),
            kind != THREE_LAMPS && others.is_empty(),
            edits,
        ));
    }
    if others.is_empty() {
        for line in view.lines(element, "ref_line") {
            let message = format!("Light {id} of crosswalk {} has stop line {}.", first.id(), line.id);
            let member = Subject::LineString(line.id.0);
            let edits = vec![Edit::RemoveMember { on: subject, role: "ref_line".into(), member }];
            let finding = named(Finding::new("stop-line", subject, message).with(member, "ref_line"));
            findings.push(finding.fixed_by(format!("remove {} from the element", line.id), false, edits));
        }
    }
    for light in lights {
        let places = view.places(light);
        let distance =
            |p: &Point| crosswalks.iter().map(|seen| from_ring(&seen.outline, *p)).fold(f64::INFINITY, f64::min);
        let nearest = places.iter().map(distance).fold(f64::INFINITY, f64::min);
        if nearest.is_finite() && nearest > params.reach {
            let message = format!("Light {} of crosswalk {} stands {nearest:.1} m from it.", light.id, first.id());
            let finding = Finding::new("far", Subject::LineString(light.id.0), message).with(subject, "element");
            findings.push(named(finding).measured(nearest, params.reach, "m"));
        }
    }
    findings
}

/// Distance of a point from an area, metres; 0 inside.
fn from_ring(ring: &[Point], p: Point) -> f64 {
    if polygon::contains(ring, p) {
        return 0.0;
    }
    Polyline::new(ring.iter().chain(ring.first()).copied()).map_or(f64::INFINITY, |line| line.distance(p))
}

/// Adds the fix that makes lights for vehicles of those with a stop line to which no crosswalk refers.
fn for_vehicles(view: &View, finding: Finding, element: &RegulatoryElement, lights: &[&LineString]) -> Finding {
    let stops = view.lines(element, "ref_line").next().is_some();
    let is_of_crosswalk = |light: &&LineString| {
        let with_light =
            view.elements("traffic_light").filter(|other| other.linestrings("refers").any(|id| id == light.id));
        let mut referrers = with_light.flat_map(|other| view.referrers(other.id)).map(|&at| &view.lanelets[at]);
        referrers.any(|seen| seen.is("crosswalk"))
    };
    if !stops || lights.iter().any(is_of_crosswalk) {
        return finding;
    }
    let kind = |light: &&LineString| Edit::SetTag {
        on: Subject::LineString(light.id.0),
        key: "subtype".into(),
        value: THREE_LAMPS.into(),
    };
    finding.fixed_by(format!("set subtype={THREE_LAMPS} on its lights"), false, lights.iter().map(kind).collect())
}

/// Adds the fix that takes the reference to the lights of a crosswalk from a lane that has lights of its own.
fn forgotten_by(view: &View, finding: Finding, element: &RegulatoryElement, road: &Seen) -> Finding {
    let own = view.elements("traffic_light").filter(|other| other.id != element.id);
    let has_own = own.into_iter().any(|other| {
        let for_vehicles = view
            .lines(other, "refers")
            .any(|line| line.attributes.is("type", "traffic_light") && !line.attributes.is("subtype", ON_FOOT));
        for_vehicles && view.referrers(other.id).iter().any(|&at| view.lanelets[at].id() == road.id())
    });
    if !has_own {
        return finding;
    }
    let (on, member) = (Subject::Lanelet(road.id().0), finding.subject);
    let edits = vec![Edit::RemoveMember { on, role: "regulatory_element".into(), member }];
    finding.fixed_by(format!("let lanelet {} not refer to it", road.id()), false, edits)
}
