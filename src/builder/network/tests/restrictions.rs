//! Turn restrictions from relations, over nodes and over ways.

use super::super::hand_drawn::restrict;
use super::*;

/// The restrictions as (from way, via ways, to way, only).
fn turns(network: &NetworkReading) -> Vec<(i64, Vec<i64>, i64, bool)> {
    let way = |ix: RoadIx| network.network.road(ix).key.way;
    let turn =
        |r: &TurnRestriction| (way(r.from.road), r.via.iter().map(|ix| way(*ix)).collect(), way(r.to.road), r.only);
    network.network.restrictions.iter().map(turn).collect()
}

#[test]
fn restrictions_over_a_node() {
    let read = |text: &str, members: &[(&str, char, i64)]| {
        let mut osm = data(&CROSS, &[(10, &[1, 5], ""), (11, &[5, 3], ""), (20, &[2, 5, 4], "")]);
        restrict(&mut osm, 1, text, members);
        build(&osm)
    };
    let plain = [("from", 'w', 10), ("via", 'n', 5), ("to", 'w', 11)];
    let built = read("restriction=no_straight_on", &plain);
    assert_eq!(turns(&built), [(10, vec![], 11, false)]);
    assert_eq!(built.network.restrictions[0].from.end, End::End);
    assert_eq!(built.network.restrictions[0].to.end, End::Start);
    assert_eq!(turns(&read("restriction=only_straight_on", &plain)), [(10, vec![], 11, true)]);
    assert_eq!(turns(&read("restriction:motorcar=no_straight_on", &plain)).len(), 1);
    // Way 20 passes through: only the turn whose angle fits the value counts.
    let passing = [("from", 'w', 10), ("via", 'n', 5), ("to", 'w', 20)];
    let built = read("restriction=no_left_turn", &passing);
    assert_eq!(turns(&built), [(10, vec![], 20, false)]);
    assert_eq!(built.network.road(built.network.restrictions[0].to.road).key.first, 2, "north is left");
    let u_turn = [("from", 'w', 10), ("via", 'n', 5), ("to", 'w', 10)];
    assert_eq!(turns(&read("restriction=no_u_turn", &u_turn)), [(10, vec![], 10, false)]);
    let entry = [("from", 'w', 10), ("from", 'w', 20), ("via", 'n', 5), ("to", 'w', 11)];
    assert_eq!(turns(&read("restriction=no_entry", &entry)).len(), 3);
    for (text, members) in [
        ("restriction=no_left_turn except=motorcar;bus", &plain[..]),
        ("restriction:conditional=no_left_turn", &plain[..]),
        ("restriction:hgv=no_left_turn", &plain[..]),
        ("restriction=whatever", &plain[..]),
        ("restriction=no_weird_zigzags", &plain[..]),
        ("restriction=no_right_turn_on_red", &plain[..]),
        ("restriction=no_turn_on_red", &plain[..]),
        ("restriction=no_left_turn", &[("from", 'w', 10), ("via", 'n', 5), ("to", 'w', 99)][..]),
        ("restriction=no_left_turn", &[("from", 'w', 10), ("via", 'n', 99), ("to", 'w', 11)][..]),
        ("restriction=no_left_turn", &[("from", 'w', 10), ("to", 'w', 11)][..]),
        ("restriction=no_left_turn", &[][..]),
    ] {
        let built = read(text, members);
        assert_eq!(turns(&built), [], "{text}");
        assert_eq!(slugs(&built), ["restriction-skipped"], "{text}");
    }
}

#[test]
fn restrictions_over_ways() {
    // Two one-ways joined by a short link that another road cuts in two: no U-turn over it.
    let nodes = [
        (1, -50.0, 0.0, ""),
        (2, 0.0, 0.0, ""),
        (3, 50.0, 0.0, ""),
        (4, 0.0, 10.0, ""),
        (5, 0.0, 20.0, ""),
        (6, -50.0, 20.0, ""),
        (7, 50.0, 20.0, ""),
        (8, 40.0, 10.0, ""),
    ];
    let mut osm = data(
        &nodes,
        &[(10, &[1, 2, 3], "oneway=yes"), (20, &[7, 5, 6], "oneway=yes"), (30, &[2, 4, 5], ""), (40, &[4, 8], "")],
    );
    restrict(&mut osm, 1, "restriction=no_u_turn", &[("from", 'w', 10), ("via", 'w', 30), ("to", 'w', 20)]);
    let built = build(&osm);
    assert_eq!(turns(&built), [(10, vec![30, 30], 20, false)]);
    let r = &built.network.restrictions[0];
    assert_eq!((built.network.road(r.from.road).key.first, r.from.end), (1, End::End));
    assert_eq!((built.network.road(r.to.road).key.last, r.to.end), (6, End::Start));
    let mut osm = data(&nodes, &[(10, &[1, 2, 3], ""), (20, &[7, 5, 6], ""), (30, &[4, 8], "")]);
    restrict(&mut osm, 1, "restriction=no_u_turn", &[("from", 'w', 10), ("via", 'w', 30), ("to", 'w', 20)]);
    assert_eq!(slugs(&build(&osm)), ["restriction-skipped"]);
}

#[test]
fn ways_that_pass_through_the_via_ways_are_meant_where_the_turn_is_as_named() {
    // A street with a side road to the east that bends north or south at its end.
    let nodes = [
        (1, 0.0, 100.0, ""),
        (2, 0.0, 0.0, ""),
        (3, 0.0, -100.0, ""),
        (4, 60.0, 0.0, ""),
        (5, 60.0, 100.0, ""),
        (6, 60.0, -100.0, ""),
    ];
    let read = |value: &str, to: i64| {
        let ways: [(i64, &[i64], &str); 3] = [(10, &[1, 2, 3], ""), (20, &[2, 4], ""), (30, &[5, 4, 6], "")];
        let mut osm = data(&nodes, &ways);
        restrict(&mut osm, 1, value, &[("from", 'w', 10), ("via", 'w', 20), ("to", 'w', to)]);
        build(&osm)
    };
    let from_to = |read: &NetworkReading| {
        let ends = |arm: RoadEnd| {
            let road = read.network.road(arm.road);
            if arm.end == End::Start { road.key.last } else { road.key.first }
        };
        let turns = read.network.restrictions.iter().map(|r| [ends(r.from), ends(r.to)]);
        turns.collect::<Vec<[i64; 2]>>()
    };
    assert_eq!(from_to(&read("restriction=no_u_turn", 30)), [[1, 5], [3, 6]]);
    assert_eq!(from_to(&read("restriction=no_straight_on", 30)), [[1, 6], [3, 5]]);
    let none = read("restriction=no_right_turn", 30);
    assert_eq!((turns(&none), slugs(&none)), (vec![], vec!["restriction-skipped"]));
}
