//! vm-01-20: only kinds of lanes that belong to one road lie side by side.

use rustc_hash::FxHashSet;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Seen, View};

use super::access::meant_subtype;
use super::{NoParams, lane_kinds};
use crate::lanelet::index::routing_graph::{Graph, Rules};

const LANES: [&str; 4] = ["road", "road_shoulder", "pedestrian_lane", "bicycle_lane"];

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let view = map.view();
    let graph = Graph::new(view, Rules::AnyLane);
    // What is a lane of a road but for its subtype is told of as that.
    let fits = |seen: &Seen| LANES.contains(&meant_subtype(seen.lanelet));
    let mut said = FxHashSet::default();
    let mut findings = Vec::new();
    let mut foreign: Option<(usize, Finding)> = None;
    for (at, seen) in view.lanelets.iter().enumerate() {
        for other in [graph.adjacent_left(at), graph.adjacent_right(at)].into_iter().flatten() {
            let neighbour = &view.lanelets[other];
            if (fits(seen) && fits(neighbour)) || !said.insert((at.min(other), at.max(other))) {
                continue;
            }
            let kind = |seen: &Seen| seen.tag("subtype").unwrap_or("no subtype").to_owned();
            let (id, name) = (seen.id(), neighbour.id());
            let message =
                format!("Lanelet {id} ({}) shares a border with lanelet {name} ({}).", kind(seen), kind(neighbour));
            let finding = Finding::new("neighbours", Subject::Lanelet(id.0), message);
            let finding = finding.with(Subject::Lanelet(name.0), "neighbour");
            let is_foreign = |seen: &Seen| LANES.contains(&lane_kinds::for_autoware(&kind(seen)));
            match is_foreign(seen) && is_foreign(neighbour) {
                true => foreign.get_or_insert((0, finding)).0 += 1,
                false => findings.push(finding),
            }
        }
    }
    findings.extend(foreign.map(|(count, first)| foreign_words(view, count, first)));
    findings
}

/// What is said once of lanes that belong beside each other, but have words of Lanelet2 that Autoware does not read. `first` speaks of
/// the first pair.
fn foreign_words(view: &View, count: usize, first: Finding) -> Finding {
    let said = first.message.trim_end_matches('.');
    let rest = match count {
        1 => String::new(),
        count => format!("; so do {count} pairs in all"),
    };
    let message = format!("{said}{rest}. Lanelet2 knows both words, Autoware reads others.");
    lane_kinds::renamed(view, Finding { fault: "foreign-word", message, ..first })
}
