//! Bus lanes beside lanes for cars. Autoware's documents and TIER IV's validator know no bus lane: the validator misses the border that
//! a bus lane shares with the lane beside it, because a bus lane is not in its graph. A lane that cars keep clear of is a
//! `bicycle_lane` to both.

use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::{Attributes, LaneletId, LaneletMap, LineStringId, PointId};

/// Says of a `bicycle_lane` what it is on the ground.
const BUS_LANE: (&str, &str) = ("bus_lane", "yes");

/// Makes a `bicycle_lane` of each bus lane beside a lane for cars, unless it leads to such a lane or from one: only lanes of one kind may
/// follow each other.
pub fn retag_bus_lanes(map: &mut LaneletMap) {
    let chosen: Vec<LaneletId> = {
        let view = View::new(map);
        beside_cars(&view).into_iter().map(|at| view.lanelets[at].id()).collect()
    };
    for id in chosen {
        if let Some(lanelet) = map.lanelets.get_mut(id) {
            lanelet.attributes = retagged(&lanelet.attributes);
        }
    }
}

/// The tags of a bus lane as a `bicycle_lane`. Who may use it follows from the subtype; a tag that names anybody would take it out of the
/// validator's graph again.
fn retagged(attributes: &Attributes) -> Attributes {
    let mut tags = Attributes::new();
    for (key, value) in attributes.iter().filter(|(key, _)| !key.starts_with("participant")) {
        tags.push(key, if key == "subtype" { "bicycle_lane" } else { value });
    }
    tags.push(BUS_LANE.0, BUS_LANE.1);
    tags
}

/// The bus lanes to be changed, by position: those that share a bound with a lane that the graph knows, or with one of themselves.
fn beside_cars(view: &View) -> BTreeSet<usize> {
    let graph = Graph::new(view, Rules::AnyLane);
    let known: Vec<&Seen> =
        view.lanelets.iter().enumerate().filter(|(at, _)| graph.passes(*at)).map(|(_, seen)| seen).collect();
    let mut by_line = apart_from(&known, view);
    let mut lines: Vec<LineStringId> = known.into_iter().flat_map(bounds).collect();
    let mut chosen = BTreeSet::new();
    while let Some(line) = lines.pop() {
        for at in by_line.remove(&line).unwrap_or_default() {
            if chosen.insert(at) {
                lines.extend(bounds(&view.lanelets[at]));
            }
        }
    }
    chosen
}

/// The bus lanes that neither lead to one of these lanelets nor follow one, by their bounds.
fn apart_from(known: &[&Seen], view: &View) -> FxHashMap<LineStringId, Vec<usize>> {
    let edges = |edge: usize| known.iter().filter_map(|seen| edge_of(seen, edge)).collect::<FxHashSet<_>>();
    let [starts, ends] = [0, 1].map(edges);
    let mut by_line: FxHashMap<LineStringId, Vec<usize>> = FxHashMap::default();
    for (at, seen) in view.lanelets.iter().enumerate().filter(|(_, seen)| seen.is("bus_lane")) {
        let leads_to = edge_of(seen, 1).is_some_and(|edge| starts.contains(&edge));
        if !leads_to && !edge_of(seen, 0).is_some_and(|edge| ends.contains(&edge)) {
            bounds(seen).into_iter().for_each(|line| by_line.entry(line).or_default().push(at));
        }
    }
    by_line
}

/// Where a lanelet starts (0) or ends (1): its left and its right point.
fn edge_of(seen: &Seen, edge: usize) -> Option<[PointId; 2]> {
    Some(seen.ends()?[edge].map(|point| point.id))
}

fn bounds(seen: &Seen) -> [LineStringId; 2] {
    [seen.lanelet.left.line, seen.lanelet.right.line]
}

#[cfg(test)]
mod tests {
    use crate::builder::BuildOptions;
    use crate::builder::tests::{Asked, built_as, of_subtype};
    use crate::settings::Profile;

    /// How many bus lanes and bicycle lanes there are on a street that goes on in another one, and whether the latter name nobody.
    fn lanes(profile: Profile, first: &str, second: &str) -> [usize; 2] {
        let nodes = [(1, 0.0, 0.0, ""), (2, 80.0, 0.0, ""), (3, 160.0, 0.0, "")];
        let street = |tags: &str| format!("highway=secondary oneway=yes lanes=3 {tags}");
        let [first, second] = [first, second].map(street);
        let ways: [(i64, &[i64], &str); 2] = [(10, &[1, 2], &first), (11, &[2, 3], &second)];
        let options = BuildOptions { profile, ..BuildOptions::default() };
        let map = built_as(&Asked { nodes: &nodes, ways: &ways, options }).map;
        for lanelet in of_subtype(&map, "bicycle_lane") {
            assert!(lanelet.attributes.is("bus_lane", "yes"));
            assert!(lanelet.attributes.iter().all(|(key, _)| !key.starts_with("participant")));
        }
        ["bus_lane", "bicycle_lane"].map(|subtype| of_subtype(&map, subtype).len())
    }

    #[test]
    fn bus_lanes_beside_cars_are_bicycle_lanes_to_the_validator() {
        let buses = "lanes:bus=1";
        assert_eq!(lanes(Profile::Ours, buses, buses), [1, 0]);
        assert_eq!(lanes(Profile::Tier4, buses, buses), [0, 1]);
    }

    #[test]
    fn a_bus_lane_that_becomes_a_lane_for_cars_stays_one() {
        assert_eq!(lanes(Profile::Ours, "lanes:bus=1", ""), [2, 0]);
        assert_eq!(lanes(Profile::Tier4, "lanes:bus=1", ""), [1, 1]);
    }
}
