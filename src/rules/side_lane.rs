//! Strips at the side of a road, be it a shoulder or one for people on foot: what lies beside them.

use super::graph::{Graph, Rules};
use super::view::View;
use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::MapIndex;

/// Judges all lanelets of a subtype: each lies beside another lanelet, and a side that is free ends in a road border.
/// `beside_road`: the only neighbour has to be a road.
pub fn judge(map: &MapIndex, subtype: &str, beside_road: bool) -> Vec<Finding> {
    if !map.map.lanelets.iter().any(|lanelet| lanelet.attributes.is("subtype", subtype)) {
        return Vec::new();
    }
    let view = View::new(map.map);
    let graph = Graph::new(&view, Rules::AnyLane);
    let mut findings = Vec::new();
    for (at, seen) in view.lanelets.iter().enumerate().filter(|(_, seen)| seen.is(subtype)) {
        let (id, subject) = (seen.id(), Subject::Lanelet(seen.id().0));
        let (neighbour, free) = match (graph.adjacent_left(at), graph.adjacent_right(at)) {
            (Some(_), Some(_)) => continue,
            (None, None) => {
                let message = format!("The {subtype} lanelet {id} shares no border with another lane.");
                findings.push(Finding::new("alone", subject, message));
                continue;
            }
            (Some(left), None) => (left, seen.lanelet.right.line),
            (None, Some(right)) => (right, seen.lanelet.left.line),
        };
        let other = &view.lanelets[neighbour];
        if beside_road && !other.is("road") {
            let message = format!("The {subtype} lanelet {id} lies beside {}, which is no road.", other.id());
            findings.push(Finding::new("beside", subject, message).with(Subject::Lanelet(other.id().0), "neighbour"));
        }
        if view.map.linestrings.get(free).is_some_and(|line| !line.attributes.is("type", "road_border")) {
            let message = format!("The outer bound {free} of the {subtype} lanelet {id} is no road_border.");
            let finding = Finding::new("outer-border", Subject::LineString(free.0), message);
            findings.push(finding.with(subject, "lanelet"));
        }
    }
    findings
}
