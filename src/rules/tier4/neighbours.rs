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

/// The lanelets in the validator's order: those that come first have the lowest rank.
fn in_order(ranks: &[usize]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..ranks.len()).collect();
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
    for at in in_order(&layer::ranks(view)) {
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
    let ranks = layer::ranks(view);
    let mut asked = FxHashSet::default();
    let mut issues = Vec::new();
    for at in in_order(&ranks) {
        for other in graph.adjacent(at, &ranks).into_iter().flatten() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanelet::from_osm;
    use crate::osm::{OsmData, read_bytes};
    use crate::projection::Projector;

    /// Who is named where a shoulder (4) lies on the right of a road and of a walkway between the same bounds.
    fn named(road: i64, walkway: i64) -> Vec<Subject> {
        let node = |id: i64| {
            let (lat, lon) = (35.0 - (id / 2) as f64 * 3e-5, 139.3 + (id % 2) as f64 * 1e-4);
            format!("<node id='1{id}' lat='{lat}' lon='{lon}'><tag k='ele' v='0'/></node>")
        };
        let way = |id: i64| format!("<way id='2{id}'><nd ref='1{}'/><nd ref='1{}'/></way>", 2 * id, 2 * id + 1);
        let lanelet = |id: i64, left: i64, subtype: &str| {
            format!(
                "<relation id='{id}'><member type='way' ref='2{left}' role='left'/><member type='way' ref='2{}' role='right'/>\
                 <tag k='type' v='lanelet'/><tag k='subtype' v='{subtype}'/><tag k='location' v='urban'/></relation>",
                left + 1
            )
        };
        let nodes: String = (0..6).map(node).collect();
        let ways: String = (0..3).map(way).collect();
        let lanelets =
            [lanelet(road, 0, "road"), lanelet(walkway, 0, "walkway"), lanelet(4, 1, "road_shoulder")].concat();
        let mut osm = OsmData::default();
        read_bytes(&mut osm, "test", format!("<osm>{nodes}{ways}{lanelets}</osm>").into_bytes()).unwrap();
        let map = from_osm(&osm, &Projector::mgrs("54SUD".parse().unwrap())).map;
        let issues = lateral(&View::new(&map), &Params::default());
        issues.into_iter().map(|issue| issue.subject).collect()
    }

    #[test]
    fn of_two_lanelets_beside_one_the_graph_holds_the_one_that_comes_first() {
        // The table lists 4 first, then 2 and 1: beside the shoulder, the graph holds what comes next.
        assert_eq!(named(1, 2), [Subject::Lanelet(4)]);
        assert_eq!(named(2, 1), [Subject::Lanelet(1)]);
    }
}
