//! Lanes that share a bound, as the existing validator judges them (vm-01-02, vm-01-20): each bound and each pair once, by
//! the lanelet that it meets first.

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Issue, Params, issue, layer};
use crate::diagnostic::Subject;
use crate::lanelet::Bound;
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::view::View;
use crate::lanelet::placed::aligned_once;

/// Subtypes that may lie beside each other.
const LANES: [&str; 4] = ["road", "road_shoulder", "pedestrian_lane", "bicycle_lane"];

/// The lanelets in the validator's order.
fn in_order(view: &View) -> Vec<usize> {
    let ranks = layer::ranks(view);
    let mut order: Vec<usize> = (0..view.lanelets.len()).collect();
    order.sort_by_key(|&at| ranks[at]);
    order
}

/// `lane_change_attribute`: whether a bound is shared is asked once, of the lanelet that comes first, and from its side.
pub fn lane_change(view: &View, _: &Params) -> Vec<Issue> {
    // Who uses a bound was noted before bounds were aligned for the second time.
    let mut users: FxHashMap<Bound, Vec<usize>> = FxHashMap::default();
    for (at, seen) in view.lanelets.iter().enumerate().filter(|(_, seen)| seen.is("road")) {
        for bound in aligned_once(view.map, seen.lanelet) {
            users.entry(bound).or_default().push(at);
        }
    }
    let mut asked = FxHashSet::default();
    let mut issues = Vec::new();
    for at in in_order(view) {
        let lanelet = view.lanelets[at].lanelet;
        if !view.lanelets[at].is("road") {
            continue;
        }
        for (bound, is_left) in [(lanelet.left, true), (lanelet.right, false)] {
            let shares = |other: usize| {
                let neighbour = view.lanelets[other].lanelet;
                other != at && bound == if is_left { neighbour.right } else { neighbour.left }
            };
            let first = asked.insert(bound.line);
            if first && users.get(&bound).is_some_and(|users| users.iter().any(|&other| shares(other))) {
                issues.extend(said(view, bound));
            }
        }
    }
    issues
}

fn said(view: &View, bound: Bound) -> Option<Issue> {
    let line = bound.line;
    let (number, what) = match view.map.linestrings.get(line)?.attributes.get("lane_change") {
        Some("yes" | "no") => return None,
        None => (1, "no lane_change".to_owned()),
        Some(value) => (2, format!("lane_change={value}")),
    };
    let message = format!("Linestring {line} between two lanes of one direction has {what}; it must be yes or no.");
    Some(issue(number, Subject::LineString(line.0), message))
}

/// `lateral_subtype_connection`.
pub fn lateral(view: &View, _: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::AnyLane);
    let kind = |at: usize| view.lanelets[at].tag("subtype").unwrap_or_default();
    let mut asked = FxHashSet::default();
    let mut issues = Vec::new();
    for at in in_order(view) {
        for other in [graph.adjacent_left(at), graph.adjacent_right(at)].into_iter().flatten() {
            let fits = [at, other].iter().all(|&one| LANES.contains(&kind(one)));
            if asked.insert((at.min(other), at.max(other))) && !fits {
                let (id, name) = (view.lanelets[at].id(), view.lanelets[other].id());
                let message =
                    format!("Lanelet {id} ({}) shares a border with lanelet {name} ({}).", kind(at), kind(other));
                issues.push(issue(1, Subject::Lanelet(id.0), message));
            }
        }
    }
    issues
}
