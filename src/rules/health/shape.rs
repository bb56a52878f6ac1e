//! Lanelets without length, that cross themselves, that lean over; bounds that say a point twice.

use std::collections::BTreeSet;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::simple_ring;
use crate::geometry::simple_ring::RingFault;
use crate::lanelet::index::{Edge, Lane, MapIndex};
use crate::lanelet::{LineStringId, PointId};

use super::params::{Params, subject};

pub fn judge(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = repeated(map);
    for at in 0..map.lanes.len() {
        let lane = &map.lanes[at];
        match lane.length() < params.least_length {
            true => findings.push(too_short(map, params, at)),
            false => findings.extend(crossing(map, at)),
        }
        findings.extend(tilted(map, params, at));
    }
    findings
}

fn too_short(map: &MapIndex, params: &Params, at: usize) -> Finding {
    let lane = &map.lanes[at];
    let message = format!("Lanelet {} is {:.3} m long.", lane.id, lane.length());
    Finding::new("zero-length", subject(map, at), message)
        .measured(lane.length(), params.least_length, "m")
        .at(Place::Point(lane.start.middle()))
}

/// A lanelet of which the outline crosses itself. Bounds with a point in common are another rule's business.
fn crossing(map: &MapIndex, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    // What follows itself closes its outline on itself, too.
    if lane.simple || lane.start.ids == lane.end.ids || share_a_point(map, lane) {
        return None;
    }
    let place = match simple_ring::faults(&lane.outline, 0.0, 1).first()? {
        RingFault::Crossing(_, _, place) => *place,
        RingFault::TooFew(at) | RingFault::NotFinite(at) | RingFault::Spike(at) => *lane.outline.get(*at)?,
    };
    let message = format!("The outline of lanelet {} crosses itself.", lane.id);
    let finding = Finding::new("self-crossing", subject(map, at), message).at(Place::Point(place));
    let [left, right] = lane.bounds;
    Some(finding.with(Subject::LineString(left.0), "left").with(Subject::LineString(right.0), "right"))
}

fn share_a_point(map: &MapIndex, lane: &Lane) -> bool {
    let points = |line: LineStringId| map.map.linestrings.get(line).map_or(&[][..], |line| &line.points);
    let left: BTreeSet<PointId> = points(lane.bounds[0]).iter().copied().collect();
    points(lane.bounds[1]).iter().any(|point| left.contains(point))
}

/// A lanelet with one bound far above the other.
fn tilted(map: &MapIndex, params: &Params, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let leaning = |edge: &Edge| {
        let [left, right] = edge.ids.map(|id| map.map.points.get(id).and_then(|point| point.ele()));
        let step = (left? - right?).abs();
        let limit = (params.tilt * edge.across().norm()).max(params.least_tilt);
        (step > limit).then_some((step, limit))
    };
    let (edge, (step, limit)) = [lane.start, lane.end].into_iter().find_map(|edge| Some((edge, leaning(&edge)?)))?;
    let message = format!(
        "Lanelet {} leans over: points {} and {} across it differ by {step:.2} m in height.",
        lane.id, edge.ids[0], edge.ids[1]
    );
    let finding = Finding::new("tilt", subject(map, at), message).measured(step, limit, "m");
    let [left, right] = edge.ids.map(|id| Subject::Point(id.0));
    Some(finding.with(left, "left").with(right, "right").at(Place::Line(edge.points.to_vec())))
}

/// Points that follow themselves on a bound.
fn repeated(map: &MapIndex) -> Vec<Finding> {
    let mut findings = Vec::new();
    for line in map.map.linestrings.iter().filter(|line| !map.users_of(line.id).is_empty()) {
        let subject = Subject::LineString(line.id.0);
        for (before, pair) in line.points.windows(2).enumerate() {
            if pair[0] != pair[1] {
                continue;
            }
            let id = pair[0];
            let message = format!("Bound {} names point {id} twice in a row.", line.id);
            let finding = Finding::new("repeated-point", subject, message).with(Subject::Point(id.0), "point");
            let edits = vec![Edit::RemoveVertex { way: subject, position: before + 1 }];
            let place = map.map.points.get(id).map_or(Place::Unknown, |point| Place::Point(point.position));
            findings.push(finding.at(place).fixed_by(format!("name point {id} once"), true, edits));
        }
    }
    findings
}
