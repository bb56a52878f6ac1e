//! Lanes that lead nowhere: left out, directed, told of.

use super::super::hand_drawn::restrict;
use super::super::unreachable_lanes::without_unreachable_lanes;
use super::*;

/// The network without unreachable lanes, with the notes of that; every road is kept whole.
fn reachable(osm: &OsmData) -> (RoadNetwork, Vec<String>) {
    let network = build(osm).network;
    let kept = network.roads.iter().map(|road| [0.0, road.line.length()]).collect();
    let (network, _, notes) = without_unreachable_lanes(network, kept);
    (network, notes.into_iter().map(|note| note.message).collect())
}

/// The directions of travel of a way's lanes.
fn travels(network: &RoadNetwork, way: i64) -> Vec<Travel> {
    let roads = network.roads.iter().filter(|road| road.key.way == way);
    roads.flat_map(|road| road.section.driven().map(|(_, strip)| strip.travel)).collect()
}

#[test]
fn lanes_that_lead_nowhere_are_told_of() {
    // All other roads lead to node 5, or away from it.
    let into: [(i64, &[i64], &str); 3] = [(10, &[1, 5], "oneway=yes"), (20, &[5, 2], ""), (30, &[3, 5], "oneway=yes")];
    let (network, notes) = reachable(&data(&CROSS, &into));
    assert_eq!(travels(&network, 20).len(), 2);
    let told = "nobody can leave the lanes of way 20 against its line, nodes 5 to 2, at node 5: \
                every other road there is one-way against it";
    assert_eq!(notes, [told]);
    let out: [(i64, &[i64], &str); 3] = [(10, &[5, 1], "oneway=yes"), (20, &[5, 2], ""), (30, &[5, 3], "oneway=yes")];
    assert!(reachable(&data(&CROSS, &out)).1[0].starts_with("nobody can enter the lanes of way 20 with its line"));
    // A road that is one-way against another is what it is.
    let against = data(&CROSS, &[(10, &[1, 5], "oneway=yes"), (20, &[2, 5], "oneway=yes")]);
    assert_eq!(reachable(&against).1.len(), 0);
}

#[test]
fn a_restriction_over_a_link_that_nobody_enters_is_settled() {
    // Only those who turn back use the link from node 2 to node 5.
    let nodes = [
        (1, -200.0, 0.0, ""),
        (2, 0.0, 0.0, ""),
        (3, 200.0, 0.0, ""),
        (4, 200.0, 70.0, ""),
        (5, 0.0, 70.0, ""),
        (6, -200.0, 70.0, ""),
    ];
    let ways: [(i64, &[i64], &str); 5] = [
        (10, &[1, 2], "oneway=yes"),
        (11, &[2, 3], "oneway=yes"),
        (12, &[4, 5], "oneway=yes"),
        (13, &[5, 6], "oneway=yes"),
        (14, &[2, 5], "oneway=yes"),
    ];
    let mut osm = data(&nodes, &ways);
    restrict(&mut osm, 7, "restriction=no_u_turn", &[("from", 'w', 10), ("via", 'w', 14), ("to", 'w', 13)]);
    let (network, notes) = reachable(&osm);
    assert!(notes[0].starts_with("nobody can enter the lanes of way 14"), "{notes:?}");
    assert_eq!(ResolvedRestrictions::new(&network).1.len(), 0);
}

/// How far away a road may lie, metres, so that it changes nothing: as far as tiles look by themselves.
const FAR: f64 = 400.0;

#[test]
fn a_long_road_does_not_lead_to_roads_around() {
    let nodes: Vec<(i64, f64, f64, &str)> =
        [0.0, 40.0, 80.0, 180.0, 220.0].into_iter().zip(1..).map(|(east, node)| (node, east, 0.0, "")).collect();
    let lines: Vec<[i64; 2]> = (1..5).map(|way| [way, way + 1]).collect();
    let ways: Vec<(i64, &[i64], &str)> = lines.iter().map(|line| (line[0], &line[..], "")).collect();
    let network = build(&data(&nodes, &ways)).network;
    let first = IntersectionIx::all(5).find(|at| network.intersection(*at).nodes == [1]).unwrap();
    let around = |roads| -> Vec<i64> {
        network.roads_around(first, roads, 50.0).into_iter().map(|road| network.road(road).key.way).collect()
    };
    assert_eq!([around(1), around(2), around(4)], [vec![1], vec![1, 2], vec![1, 2, 3]]);
}

#[test]
fn single_tracks_are_directed_one_after_another_up_to_a_length() {
    // Tracks of 40 m in a row, from way 1 to the last one, at whose end all other roads lead to it.
    let row = |count: i64| -> Vec<Travel> {
        let end = count + 1;
        let at = |node: i64| 40.0 * node as f64;
        let sides = [(1000, at(end), 40.0, ""), (1001, at(end), -40.0, "")];
        let nodes: Vec<(i64, f64, f64, &str)> = (1..=end).map(|node| (node, at(node), 0.0, "")).chain(sides).collect();
        let tracks: Vec<[i64; 2]> = (1..=count).map(|way| [way, way + 1]).collect();
        let into = [[1000, end], [1001, end]];
        let mut ways: Vec<(i64, &[i64], &str)> = Vec::new();
        ways.extend(into.iter().map(|line| (line[0], &line[..], "oneway=yes")));
        ways.extend(tracks.iter().map(|line| (line[0], &line[..], "lanes=1 width=3")));
        let (network, _) = reachable(&data(&nodes, &ways));
        (1..=count).flat_map(|way| travels(&network, way)).collect()
    };
    assert_eq!(row(5), [Travel::Backward; 5]);
    let long = row(30);
    let directed = long.iter().filter(|travel| **travel == Travel::Backward).count();
    assert!(directed > 5 && 40.0 * directed as f64 <= FAR, "{directed} tracks of 40 m");
    assert!(long[..30 - directed].iter().all(|travel| *travel == Travel::Both), "{long:?}");
}

#[test]
fn lanes_that_can_only_be_reached_by_turning_back_are_told_of() {
    // A two-way street merges with a one-way street at 10 degrees.
    let ways: [(i64, &[i64], &str); 3] = [(10, &[1, 5], "oneway=yes"), (20, &[6, 5], ""), (30, &[5, 3], "oneway=yes")];
    let mut nodes = CROSS.to_vec();
    nodes.push((6, -98.0, -17.0, ""));
    let (network, notes) = reachable(&data(&nodes, &ways));
    assert_eq!((travels(&network, 20).len(), notes.len()), (2, 1));
    assert!(notes[0].starts_with("nobody can enter the lanes of way 20 against its line"), "{notes:?}");
    assert!(notes[0].ends_with("a car would have to turn back"), "{notes:?}");
    // At 35 degrees the turn is a hairpin. Where nothing else is left, cars turn back.
    nodes[5] = (6, -82.0, -57.0, "");
    assert_eq!(reachable(&data(&nodes, &ways)).1.len(), 0);
    nodes[5] = (6, -98.0, -17.0, "");
    assert_eq!(reachable(&data(&nodes, &ways[..2])).1.len(), 1, "out of way 20 only");
}

#[test]
fn a_road_that_restrictions_close_ends_before_the_intersection() {
    let mut osm = data(&CROSS, &[(10, &[1, 5, 3], ""), (20, &[5, 2], "oneway=yes"), (21, &[4, 5], "oneway=yes")]);
    for (id, from) in [(1, 10), (2, 21)] {
        restrict(&mut osm, id, "restriction=no_entry", &[("from", 'w', from), ("via", 'n', 5), ("to", 'w', 20)]);
    }
    let (network, notes) = reachable(&osm);
    assert!(notes[0].ends_with("at node 5: restrictions forbid every turn"), "{notes:?}");
    let road = network.roads.iter().find(|road| road.key.way == 20).unwrap();
    assert_eq!(network.intersection(road.from).arms.len(), 1);
    assert_eq!(network.intersections.iter().find(|at| at.nodes == [5]).unwrap().arms.len(), 3);
}
