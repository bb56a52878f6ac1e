//! Strips at the side of a road, shoulders and lanes for people on foot, and what lies beside them.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{LaneletId, LineStringId, RoadType};

use super::parallel_bounds;
use super::parallel_bounds::{ParallelBounds, Reach};
use crate::lanelet::index::routing_graph::{Graph, Rules};

/// Judges all lanelets of a subtype: each lies beside another lanelet, and a side that is free ends in a road border.
/// `copied`: one whose border is as close to that of a road is not called alone. `beside_road`: the only neighbour has to
/// be a road.
pub fn judge(map: &MapIndex, subtype: &str, kind: RoadType, copied: Option<Reach>, beside_road: bool) -> Vec<Finding> {
    if !map.map.lanelets.iter().any(|lanelet| lanelet.attributes.is("subtype", subtype)) {
        return Vec::new();
    }
    let view = map.view();
    let graph = Graph::new(view, Rules::AnyLane);
    let copies = copied.map(|reach| copies(map, kind, reach)).unwrap_or_default();
    let is_copy = |id: LaneletId| copies.iter().any(|twins| map.lanes[twins.lanes[1]].id == id);
    let mut findings = Vec::new();
    for (at, seen) in view.lanelets.iter().enumerate().filter(|(_, seen)| seen.is(subtype)) {
        let (id, subject) = (seen.id(), Subject::Lanelet(seen.id().0));
        // Where the border may be crossed, the graph has a lane change and no neighbour.
        let user_of = |line: LineStringId| {
            let others = map.users_of(line).iter().map(|&lane| map.lanes[lane].id).filter(|other| *other != id);
            others.min().filter(|_| copied.is_some())
        };
        let [left, right] =
            [(graph.adjacent_left(at), seen.lanelet.left), (graph.adjacent_right(at), seen.lanelet.right)]
                .map(|(seen, bound)| seen.map(|other| view.lanelets[other].id()).or_else(|| user_of(bound.line)));
        let (neighbour, free) = match (left, right) {
            (Some(_), Some(_)) => continue,
            (None, None) if is_copy(id) => continue,
            (None, None) => {
                let message = format!("The {subtype} lanelet {id} shares no border with another lane.");
                findings.push(Finding::new("alone", subject, message));
                continue;
            }
            (Some(left), None) => (left, seen.lanelet.right.line),
            (None, Some(right)) => (right, seen.lanelet.left.line),
        };
        let is_road = |id| map.map.lanelets.get(id).is_some_and(|other| other.attributes.is("subtype", "road"));
        if beside_road && !is_road(neighbour) {
            let message = format!("The {subtype} lanelet {id} lies beside {neighbour}, which is no road.");
            findings.push(Finding::new("beside", subject, message).with(Subject::Lanelet(neighbour.0), "neighbour"));
        }
        if view.map.linestrings.get(free).is_some_and(|line| !line.attributes.is("type", "road_border")) {
            let message = format!("The outer bound {free} of the {subtype} lanelet {id} is no road_border.");
            let on = Subject::LineString(free.0);
            let edits = vec![Edit::SetTag { on, key: "type".into(), value: "road_border".into() }];
            let finding = Finding::new("outer-border", on, message).with(subject, "lanelet");
            findings.push(finding.fixed_by("set type=road_border", false, edits));
        }
    }
    findings
}

/// Strips of a kind whose bound runs along that of a road without being the same way.
pub fn copies(map: &MapIndex, kind: RoadType, reach: Reach) -> Vec<ParallelBounds> {
    if !map.lanes.iter().any(|lane| lane.kind == kind) {
        return Vec::new();
    }
    parallel_bounds::all(map, reach, |at| map.lanes[at].kind == RoadType::Road, |at| map.lanes[at].kind == kind)
}

/// Says of each copy that it is one.
pub fn judge_copies(map: &MapIndex, kind: RoadType, subtype: &str, reach: Reach) -> Vec<Finding> {
    let mut findings = Vec::new();
    for twins in copies(map, kind, reach) {
        let [road, strip] = twins.lanes.map(|lane| map.lanes[lane].id);
        let [way, own] = twins.ways;
        let message =
            format!("Border {own} of the {subtype} lanelet {strip} runs along border {way} of lanelet {road}.");
        let finding = Finding::new("not-shared", Subject::Lanelet(strip.0), message)
            .with(Subject::Lanelet(road.0), "road")
            .with(Subject::LineString(way.0), "road's border")
            .with(Subject::LineString(own.0), "own border");
        findings.push(match twins.shared(map) {
            Some(edit) => finding.fixed_by(format!("use way {way} for both"), true, vec![edit]),
            None => finding,
        });
    }
    findings
}
