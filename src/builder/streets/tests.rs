//! Streets of random towns, and places where roads double back, part on several levels, or cross without a node.

use proptest::prelude::*;

use crate::builder::network::hand_drawn::{self, network_of};
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::geometry::{polygon, simple_ring};

use super::outline::OutlineCase;
use super::*;

/// A node: id, east, north in metres.
type Node = (i64, f64, f64);
/// A way: id, nodes, tags.
type Way = (i64, Vec<i64>, String);

fn laid_out(nodes: &[Node], ways: &[Way]) -> Streets {
    let ways: Vec<_> = ways.iter().map(|(id, nodes, tags)| (*id, &nodes[..], &tags[..])).collect();
    streets(network_of(nodes, &ways), &StreetOptions::default())
}

fn way(id: i64, nodes: &[i64], tags: &str) -> Way {
    (id, nodes.to_vec(), tags.to_owned())
}

/// Asserts that every outline is a simple ring through its cuts, and that something remains of every road.
fn assert_valid(streets: &Streets) {
    let mut keys: Vec<_> = streets.network.roads.iter().map(|road| road.key).collect();
    keys.sort_unstable();
    assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "two roads with one key");
    for (outline, intersection) in streets.outlines.intersections.iter().zip(&streets.network.intersections) {
        assert_ne!(outline.case, OutlineCase::Fallback, "node {:?}", intersection.nodes);
        if outline.ring.is_empty() {
            continue;
        }
        assert!(simple_ring::is_simple(&outline.ring), "{:?}: {:?}", intersection.nodes, outline.ring);
        assert!(polygon::signed_area(&outline.ring) < 0.0, "the ring runs clockwise");
        for cut in &outline.cuts {
            assert!(outline.ring.contains(&cut.left) && outline.ring.contains(&cut.right));
        }
    }
    for (road, [from, to]) in streets.network.roads.iter().zip(&streets.outlines.kept) {
        assert!(from < to, "nothing remains of way {}", road.key.way);
        let line = road.line.cut(*from, *to).unwrap();
        let half = road.half_width();
        let mut strip = line.offset(half, 2.0).unwrap().points().to_vec();
        strip.extend(line.offset(-half, 2.0).unwrap().points().iter().rev());
        assert!(simple_ring::is_simple(&strip), "way {}: {strip:?}", road.key.way);
    }
}

/// Blocks of 60 m with corners moved, some streets left out, and streets of one to four lanes.
fn any_town() -> impl Strategy<Value = (Vec<Node>, Vec<Way>)> {
    const SIDE: i64 = 3;
    let place = (-18.0..18.0_f64, -18.0..18.0_f64);
    let street = (0..4_usize, 0..6_usize);
    let (places, streets) = (SIDE * SIDE, 2 * SIDE * (SIDE - 1));
    (proptest::collection::vec(place, places as usize), proptest::collection::vec(street, streets as usize)).prop_map(
        |(places, streets)| {
            let at = |x: i64, y: i64| 1 + y * SIDE + x;
            let nodes: Vec<Node> = places
                .iter()
                .zip(0..)
                .map(|((dx, dy), i)| (i + 1, (i % SIDE) as f64 * 60.0 + dx, (i / SIDE) as f64 * 60.0 + dy))
                .collect();
            let across = (0..SIDE).flat_map(|y| (1..SIDE).map(move |x| [at(x - 1, y), at(x, y)]));
            let up = (0..SIDE).flat_map(|x| (1..SIDE).map(move |y| [at(x, y - 1), at(x, y)]));
            let kinds = [
                "highway=residential",
                "highway=residential oneway=yes lanes=1",
                "highway=tertiary lanes=3",
                "highway=primary lanes=4",
                "highway=service",
            ];
            let ways: Vec<Way> = across
                .chain(up)
                .zip(&streets)
                .zip(1..)
                .filter(|((_, (left_out, _)), id)| *id == 1 || *left_out > 0)
                .map(|((ends, (_, kind)), id)| way(id, &ends, kinds[kind % kinds.len()]))
                .collect();
            (nodes, ways)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_streets_of_any_town_are_valid((nodes, ways) in any_town()) {
        assert_valid(&laid_out(&nodes, &ways));
    }

    #[test]
    fn the_order_of_the_input_does_not_matter((mut nodes, mut ways) in any_town()) {
        let one = laid_out(&nodes, &ways);
        nodes.reverse();
        ways.reverse();
        let other = laid_out(&nodes, &ways);
        prop_assert_eq!(&one.outlines.kept, &other.outlines.kept);
        for (a, b) in one.outlines.intersections.iter().zip(&other.outlines.intersections) {
            prop_assert_eq!(&a.ring, &b.ring);
        }
    }
}

#[test]
fn a_ramp_on_a_bridge_lies_beside_the_road_it_leaves() {
    let nodes = [(1, 0.0, 0.0), (2, 100.0, 0.0), (3, 180.0, 0.0), (4, 180.0, 20.0)];
    let streets = laid_out(
        &nodes,
        &[
            way(1, &[1, 2], "highway=primary oneway=yes lanes=3"),
            way(2, &[2, 3], "highway=primary oneway=yes lanes=2"),
            way(3, &[2, 4], "highway=primary_link oneway=yes lanes=1 layer=1 bridge=yes"),
        ],
    );
    assert_valid(&streets);
    // The roads meet, so the ramp begins beside the road, whatever level it reaches later.
    let strip = |way: i64| {
        let i = streets.network.roads.iter().position(|r| r.key.way == way).unwrap();
        let road = &streets.network.roads[i];
        let [from, to] = streets.outlines.kept[i];
        let (line, half) = (road.line.cut(from, to).unwrap(), road.half_width());
        let mut ring = line.offset(half, 2.0).unwrap().points().to_vec();
        ring.extend(line.offset(-half, 2.0).unwrap().points().iter().rev());
        ring
    };
    let shared = polygon::overlap(&strip(2), &strip(3));
    assert!(shared < 0.1, "they overlap by {shared} m2");
}

#[test]
fn the_legs_of_a_hairpin_lie_side_by_side() {
    let nodes = [(1, 0.0, 0.0), (2, 60.0, 1.0), (3, 80.0, 4.0), (4, 62.0, 6.0), (5, 0.0, 6.0)];
    let streets = laid_out(&nodes, &[way(1, &[1, 2, 3, 4, 5], "highway=residential lanes=2")]);
    assert_valid(&streets);
}

#[test]
fn roads_that_cross_a_trunk_road_at_an_acute_angle_without_a_node_are_named() {
    let nodes = [(1, -50.0, 0.0), (2, 50.0, 0.0), (3, -50.0, -15.0), (4, 50.0, 15.0)];
    let cross = |tags: &str| {
        laid_out(&nodes, &[way(1, &[1, 2], "highway=residential"), way(2, &[3, 4], &format!("highway=trunk{tags}"))])
    };
    let faults = |streets: &Streets| streets.findings.iter().map(|f| f.fault).collect::<Vec<_>>();
    let named = faults(&cross(""));
    assert!(!named.is_empty() && named.iter().all(|fault| *fault == "roads-overlap"), "{named:?}");
    assert!(faults(&cross(" bridge=yes layer=1")).is_empty());
}

#[test]
fn guessed_widths_shrink_if_there_is_too_little_room() {
    // A road ends so close to another that it overlaps it.
    let nodes = [(1, -60.0, 0.0), (2, 60.0, 0.0), (3, 0.0, 2.7), (4, 0.0, 60.0)];
    let narrowed = |tags: &str| {
        let through = format!("highway=residential lanes=2 {tags}");
        let network = network_of(&nodes, &[(1, &[1, 2], &through), (2, &[3, 4], "highway=residential lanes=2")]);
        let whole: Vec<_> = network.roads.iter().map(|road| [0.0, road.line.length()]).collect();
        let (network, findings) = narrow_roads(network, &whole);
        let widths: Vec<f64> = network.roads.iter().map(|road| road.section.width()).collect();
        (findings.iter().map(|finding| finding.fault).collect::<Vec<_>>(), widths)
    };
    let (faults, widths) = narrowed("");
    assert_eq!(faults, ["width-narrowed"]);
    let [one, other] = widths[..] else { panic!("two roads") };
    assert!((5.3..5.45).contains(&one), "{one}");
    assert_eq!(other, 6.0);
    assert_eq!(narrowed("width=6"), (vec![], vec![6.0, 6.0]));
}

#[test]
fn dead_ends_on_a_carriageway_are_set_back_and_those_before_it_are_not() {
    let end_of = |end: f64, tags: &str| {
        let nodes = [(1, -60.0, 0.0), (2, 60.0, 0.0), (3, 0.0, end), (4, 0.0, 60.0)];
        let ways = [
            way(1, &[1, 2], "highway=residential lanes=2 width=6"),
            way(2, &[3, 4], &format!("highway=residential lanes=2 width=6 {tags}")),
        ];
        let streets = laid_out(&nodes, &ways);
        assert_valid(&streets);
        assert!(streets.findings.is_empty(), "{:?}", streets.findings);
        let road = streets.network.roads.iter().find(|road| road.key.way == 2).unwrap();
        road.line.first().y.min(road.line.last().y)
    };
    for end in [0.5, 1.5, 2.7] {
        let left = end_of(end, "");
        assert!((2.5..=3.5).contains(&left), "drawn to {end}: {left}");
    }
    assert!((end_of(3.1, "") - 3.1).abs() < 0.01, "it ends where it is drawn to end");
    assert!((end_of(1.5, "layer=1 bridge=yes") - 1.5).abs() < 0.01, "nothing is in the way on another level");
}

#[test]
fn roads_that_face_each_other_at_a_gate_reach_up_to_it() {
    let nodes = [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, "barrier=bollard"), (3, 60.0, 0.0, "")];
    let drawn = hand_drawn::osm(&nodes, &[(1, &[1, 2, 3], "highway=residential")]);
    let streets = streets(hand_drawn::network(&drawn), &StreetOptions::default());
    assert_valid(&streets);
    let lengths: Vec<f64> = streets.network.roads.iter().map(|road| road.line.length().round()).collect();
    assert_eq!(lengths, [59.0; 2], "the barrier takes 1 m on either side");
}

/// A dual carriageway north and south of two nodes that are one intersection, streets to the west and east, a second
/// carriageway to the north-west and a slip lane between the two, through these places.
fn slip_lane_between(inner: (f64, f64), north_west: (f64, f64), slip: [(f64, f64); 5]) -> Streets {
    let mut nodes: Vec<Node> = vec![
        (1, 0.0, 0.0),
        (2, inner.0, inner.1),
        (3, 10.0, 95.0),
        (4, -60.0, -5.0),
        (5, -3.0, -70.0),
        (6, 60.0, 15.0),
        (7, north_west.0, north_west.1),
        (8, -10.0, 95.0),
    ];
    nodes.extend(slip.iter().zip(11..).map(|((x, y), id)| (id, *x, *y)));
    let carriageway = "highway=primary lanes=4 oneway=yes";
    laid_out(
        &nodes,
        &[
            way(101, &[5, 1], carriageway),
            way(102, &[1, 2], &format!("{carriageway} junction=intersection")),
            way(103, &[2, 3], carriageway),
            way(104, &[4, 1], "highway=secondary lanes=2"),
            way(105, &[2, 6], "highway=secondary lanes=2"),
            way(106, &[1, 11, 12, 13, 14, 15], "highway=primary_link lanes=1 oneway=yes"),
            way(107, &[1, 7, 8], carriageway),
        ],
    )
}

#[test]
fn a_slip_lane_over_the_edge_of_its_intersection_has_its_cut_on_the_outline() {
    let slip = [(-2.2, 3.6), (-3.5, 11.4), (-6.8, 23.5), (0.5, 29.7), (0.5, 95.0)];
    assert_valid(&slip_lane_between((2.0, 16.0), (-13.8, 14.1), slip));
}

#[test]
fn arms_that_cross_beyond_their_node_have_the_order_of_their_cuts() {
    let slip = [(-4.8, 3.3), (-3.0, 13.4), (-3.5, 18.5), (-1.2, 33.1), (-2.1, 95.0)];
    let streets = slip_lane_between((2.9, 19.8), (-15.4, 13.6), slip);
    assert_valid(&streets);
    let crossed = streets.network.intersections.iter().find(|at| at.nodes.contains(&1)).unwrap();
    let ways: Vec<i64> = crossed.arms.iter().map(|arm| streets.network.road(arm.road).key.way).collect();
    // The slip lane begins on the west of the carriageway to the north-west, and leaves on its east.
    let at = |way: i64| ways.iter().position(|one| *one == way).unwrap();
    assert_eq!((at(107) + 1) % ways.len(), at(106), "{ways:?}");
    assert_eq!((at(106) + 1) % ways.len(), at(103), "{ways:?}");
}

/// A street eastward in ways 1 to 5 that becomes one road between its side streets: way 6 leads away north between ways 2 and 3, way 7
/// between ways 4 and 5. The roads that those who come from the west on the street may take at way 7, by their ways, and the notes.
fn after_restriction(members: &[(&str, char, i64)], value: &str, sixth: &str) -> (Vec<Vec<i64>>, Vec<&'static str>) {
    let along = [-200.0, -100.0, 0.0, 60.0, 120.0, 200.0];
    let mut nodes: Vec<_> = along.iter().zip(1..).map(|(x, id)| (id, *x, 0.0, "")).collect();
    nodes.extend([(13, 0.0, 90.0, ""), (15, 120.0, 90.0, "")]);
    let toward = "highway=primary oneway=yes lanes=2 name=Street";
    let pairs: [[i64; 2]; 5] = [[1, 2], [2, 3], [3, 4], [4, 5], [5, 6]];
    let mut ways: Vec<hand_drawn::DrawnWay<'_>> =
        pairs.iter().zip(1..).map(|(pair, id)| (id, &pair[..], toward)).collect();
    ways.extend([(6, &[3_i64, 13][..], sixth), (7, &[5, 15], "highway=primary oneway=yes")]);
    let mut osm = hand_drawn::osm(&nodes, &ways);
    hand_drawn::restrict(&mut osm, 99, &format!("restriction={value}"), members);
    let network = streets(hand_drawn::network(&osm), &StreetOptions::default()).network;
    let (restrictions, notes) = ResolvedRestrictions::new(&network);
    let corner = network.intersections.iter().find(|it| it.nodes == [5]).unwrap();
    let from = corner.arms.iter().find(|arm| network.road(arm.road).ways.contains(&4)).unwrap();
    let to = corner.arms.iter().filter(|to| *to != from && restrictions.permit(corner, *from, **to));
    let mut to: Vec<Vec<i64>> = to.map(|to| network.road(to.road).ways.clone()).collect();
    to.sort();
    (to, notes.iter().map(|note| note.fault).collect())
}

#[test]
fn restrictions_hold_where_their_ways_become_one_road() {
    const AWAY: &str = "highway=primary oneway=yes";
    const TOWARD: &str = "highway=primary oneway=-1";
    let left = |from: i64, via: &[i64]| {
        let mut members = vec![("from", 'w', from), ("to", 'w', 7)];
        members.extend(via.iter().map(|way| ("via", 'w', *way)));
        members
    };
    let ahead = vec![vec![5]];
    // Two `via` ways are one road; `from` has become one with the way before it.
    assert_eq!(after_restriction(&left(2, &[3, 4]), "no_left_turn", AWAY), (ahead.clone(), vec![]));
    // `from` and `via` are one road: whoever is on it comes from `from`.
    assert_eq!(after_restriction(&left(3, &[4]), "no_left_turn", AWAY), (ahead.clone(), vec![]));
    assert_eq!(after_restriction(&left(3, &[4]), "no_left_turn", TOWARD), (ahead.clone(), vec![]));
    // Three and four `via` ways.
    assert_eq!(after_restriction(&left(1, &[2, 3, 4]), "no_left_turn", AWAY), (ahead, vec![]));
    // Those who come out of the side street make the same turn and may.
    let both = vec![vec![5], vec![7]];
    let noted = vec!["restriction-not-built"];
    assert_eq!(after_restriction(&left(2, &[3, 4]), "no_left_turn", TOWARD), (both.clone(), noted.clone()));
    assert_eq!(after_restriction(&left(1, &[2, 3, 4]), "no_left_turn", TOWARD), (both, noted));
    // `to` has become one with `via`: all that is left forbids to enter what leads on to it.
    let straight = [("from", 'w', 2), ("via", 'w', 3), ("to", 'w', 4)];
    let (to, notes) = after_restriction(&straight, "no_straight_on", AWAY);
    assert!(to.len() == 2 && notes.len() <= 1, "{to:?} {notes:?}");
}
