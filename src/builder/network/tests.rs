//! Small networks: cutting, ends, features, restrictions.

use crate::builder::tags::cross_section::{StripKind, Travel};
use crate::builder::tags::driving_side::Country;
use crate::osm::OsmData;
use crate::projection::{Extent, LonLat};
use crate::settings::Settings;

use super::hand_drawn::{SCALE, osm as data, plane, restrict};
use super::*;

mod barriers;
mod unreachable_lanes;

fn try_build(osm: &OsmData) -> Result<NetworkReading, NetworkError> {
    road_network(osm, &plane, &NetworkOptions::default())
}

fn build(osm: &OsmData) -> NetworkReading {
    try_build(osm).unwrap()
}

/// Way and end nodes of every road.
fn keys(network: &NetworkReading) -> Vec<(i64, i64, i64)> {
    network.network.roads.iter().map(|r| (r.key.way, r.key.first, r.key.last)).collect()
}

fn slugs(network: &NetworkReading) -> Vec<&'static str> {
    let quiet = ["lanes-guessed", "width-guessed"];
    network.notes.iter().map(|note| note.fault).filter(|fault| !quiet.contains(fault)).collect()
}

fn at(network: &NetworkReading, node: i64) -> &Intersection {
    network.network.intersections.iter().find(|i| i.nodes == [node]).unwrap()
}

/// A cross around node 5: 1 west, 2 north, 3 east, 4 south, each 100 m away.
const CROSS: [(i64, f64, f64, &str); 5] =
    [(1, -100.0, 0.0, ""), (2, 0.0, 100.0, ""), (3, 100.0, 0.0, ""), (4, 0.0, -100.0, ""), (5, 0.0, 0.0, "")];

#[test]
fn ways_are_cut_where_they_meet() {
    let built = build(&data(&CROSS, &[(10, &[1, 5, 3], ""), (20, &[2, 5, 4], "name=High_Street maxspeed=30")]));
    assert_eq!(keys(&built), [(10, 1, 5), (10, 5, 3), (20, 2, 5), (20, 5, 4)]);
    let arms: Vec<i64> = at(&built, 5)
        .arms
        .iter()
        .map(|arm| {
            let key = built.network.road(arm.road).key;
            if key.first == 5 { key.last } else { key.first }
        })
        .collect();
    assert_eq!(arms, [1, 2, 3, 4], "clockwise from the smallest key");
    assert_eq!(built.network.roads[2].name.as_deref(), Some("High_Street"));
    assert_eq!(built.network.roads[2].speed, [30.0; 2]);
    assert_eq!(built.network.side, DrivingSide::Right);
}

#[test]
fn a_change_of_tags_is_a_connection_and_an_end_is_an_end() {
    let built = build(&data(&CROSS, &[(10, &[1, 5], "lanes=2"), (11, &[5, 3], "lanes=4")]));
    assert_eq!(at(&built, 5).arms.len(), 2);
    assert_eq!(at(&built, 1).arms.len(), 1);
    assert!(!at(&built, 1).map_edge);
}

#[test]
fn missing_nodes_are_the_edge_of_the_map() {
    let built = build(&data(&CROSS, &[(10, &[77, 1, 5, 78, 79, 3, 80], ""), (20, &[2, 5, 4], "")]));
    assert_eq!(keys(&built), [(10, 1, 5), (20, 2, 5), (20, 5, 4)]);
    assert!(at(&built, 1).map_edge && at(&built, 5).map_edge);
    assert!(!at(&built, 2).map_edge);
    assert_eq!(slugs(&built), ["node-missing"]);
}

#[test]
fn a_road_that_ends_on_the_bounds_of_the_data_may_go_on() {
    let mut osm = data(&CROSS, &[(10, &[1, 5, 3], ""), (20, &[2, 5, 4], "")]);
    let edges = |osm: &OsmData| (1..6).filter(|node| at(&build(osm), *node).map_edge).collect::<Vec<_>>();
    assert!(edges(&osm).is_empty(), "without bounds nothing is known");
    let corner = |x: f64, y: f64| LonLat { lon: x / SCALE, lat: y / SCALE };
    let from_west_to_east = |west, east| Extent { min: corner(west, -200.0), max: corner(east, 200.0) };
    osm.bounds = vec![from_west_to_east(-200.0, 200.0)];
    assert!(edges(&osm).is_empty(), "each ends within");
    osm.bounds = vec![from_west_to_east(-200.0, 100.0)];
    assert_eq!(edges(&osm), [3], "on the border in the east");
    osm.bounds = vec![from_west_to_east(-50.0, 50.0)];
    assert_eq!(edges(&osm), [1, 3], "outside in the west and in the east");
    osm.bounds = vec![from_west_to_east(-200.0, 0.0), from_west_to_east(0.0, 200.0)];
    assert!(edges(&osm).is_empty(), "bounds that touch have no border between them");
}

#[test]
fn a_node_far_away_is_not_part_of_a_road() {
    let nodes = [(1, 0.0, 0.0, ""), (2, 100.0, 0.0, ""), (3, 9e6, 0.0, ""), (4, 200.0, 0.0, ""), (5, 300.0, 0.0, "")];
    let built = build(&data(&nodes, &[(10, &[1, 2, 3, 4, 5], "")]));
    assert_eq!(keys(&built), [(10, 1, 2), (10, 4, 5)]);
    assert!(at(&built, 2).map_edge && at(&built, 4).map_edge && !at(&built, 1).map_edge);
    assert_eq!(slugs(&built), ["node-far"]);
}

#[test]
fn loops_and_ways_that_touch_themselves() {
    let square = [(1, 0.0, 0.0, ""), (2, 50.0, 0.0, ""), (3, 50.0, 50.0, ""), (4, 0.0, 50.0, ""), (5, -50.0, 0.0, "")];
    let built = build(&data(&square, &[(10, &[5, 1, 2, 3, 4, 1], "")]));
    assert_eq!(keys(&built), [(10, 1, 1), (10, 5, 1)]);
    assert_eq!(at(&built, 1).arms.len(), 3, "a loop appears twice");
    let built = build(&data(&square, &[(10, &[1, 2, 3, 4, 1], "junction=roundabout")]));
    assert_eq!(keys(&built), [(10, 1, 1)]);
    assert!(built.network.roads[0].roundabout);
    let built = build(&data(&square, &[(10, &[1, 2, 3, 2, 1], "")]));
    assert_eq!(keys(&built), [(10, 1, 2), (10, 2, 3)], "a way that doubles back is drawn once");
    let built = build(&data(&square, &[(10, &[1, 2, 2, 2, 3], "")]));
    assert_eq!(keys(&built), [(10, 1, 3)]);
    // Two pieces of one way between the same nodes.
    let built = build(&data(&square, &[(10, &[1, 2, 3, 1, 4, 3], "")]));
    let turns: Vec<_> = built.network.roads.iter().map(|r| (r.key.first, r.key.last, r.key.turn)).collect();
    assert_eq!(turns, [(1, 3, 0), (1, 3, 1), (3, 1, 0)]);
}

#[test]
fn pieces_without_length_and_duplicates_are_skipped() {
    let nodes = [(1, 0.0, 0.0, ""), (2, 50.0, 0.0, ""), (3, 50.0, 0.0, ""), (4, 90.0, 0.0, "")];
    let built = build(&data(&nodes, &[(10, &[1, 2], ""), (11, &[2, 3], ""), (12, &[3, 4], "")]));
    assert_eq!(keys(&built), [(10, 1, 2), (12, 2, 4)], "nodes at one place are one");
    assert_eq!(slugs(&built), ["way-skipped"]);
    let built = build(&data(&CROSS, &[(10, &[1, 5, 3], ""), (9, &[3, 5], "highway=primary"), (8, &[1], "")]));
    assert_eq!(keys(&built), [(9, 3, 5), (10, 1, 5)]);
    assert_eq!(slugs(&built), ["way-skipped", "way-duplicate"]);
    let nothing = try_build(&data(&CROSS, &[(10, &[1, 5], "highway=footway"), (11, &[2, 5], "access=no")]));
    assert_eq!(nothing.unwrap_err(), NetworkError::NoRoad { ways: 2, left_out: 1 });
    assert!(try_build(&OsmData::default()).is_err());
}

#[test]
fn access() {
    let one = |text: &str| try_build(&data(&CROSS, &[(10, &[1, 5], text)])).map(|n| n.network.roads[0].clone());
    assert!(one("").unwrap().public);
    assert!(!one("access=private").unwrap().public);
    assert!(!one("highway=service service=driveway access=customers").unwrap().public);
    assert!(one("access=no motor_vehicle=yes").unwrap().public);
    assert!(one("motor_vehicle=no").is_err());
    assert!(one("area=yes").is_err());
    for highway in ["footway", "cycleway", "path", "steps", "pedestrian", "proposed", "construction", "corridor"] {
        assert!(one(&format!("highway={highway}")).is_err(), "{highway}");
    }
    for bus_road in ["highway=busway", "access=no bus=yes", "motor_vehicle=no psv=designated"] {
        let road = one(bus_road).unwrap();
        assert!(road.section.strips.iter().all(|strip| strip.kind == StripKind::Bus), "{bus_road}");
    }
}

#[test]
fn levels() {
    let level = |text: &str| build(&data(&CROSS, &[(10, &[1, 5], text)])).network.roads[0].level;
    assert_eq!(level(""), 0.0);
    assert_eq!(level("bridge=yes"), 1.0);
    assert_eq!(level("bridge=no"), 0.0);
    assert_eq!(level("tunnel=yes"), -1.0);
    assert_eq!(level("tunnel=building_passage"), 0.0);
    assert_eq!(level("bridge=yes layer=2"), 2.0);
    assert_eq!(level("layer=0.5"), 0.5);
    assert_eq!(level("bridge=yes layer=inf"), 1.0);
}

#[test]
fn lines_are_simplified_and_moved() {
    let nodes = [(1, 0.0, 0.0, ""), (2, 50.0, 0.01, ""), (3, 100.0, 0.0, ""), (4, 100.0, 60.0, "")];
    let built = build(&data(&nodes, &[(10, &[1, 2, 3, 4], "")]));
    assert_eq!(built.network.roads[0].line.points().len(), 3);
    let built = build(&data(&nodes, &[(10, &[1, 3], "sidewalk=right")]));
    let road = &built.network.roads[0];
    assert!((road.line.first().y + 0.75).abs() < 1e-9, "{:?}", road.line);
}

#[test]
fn features_stand_where_their_nodes_are() {
    let mut nodes = CROSS.to_vec();
    nodes.push((6, -20.0, 0.0, "highway=traffic_signals traffic_signals:direction=forward"));
    nodes.push((7, -40.0, 0.0, "highway=crossing crossing=zebra"));
    nodes.push((8, 20.0, 0.0, "highway=give_way"));
    nodes.push((9, 30.0, 0.0, ""));
    nodes.push((90, 30.0, 9.0, ""));
    let ways: [(i64, &[i64], &str); 3] = [
        (10, &[1, 7, 6, 5, 8, 9, 3], ""),
        (20, &[2, 5, 4], "highway=secondary"),
        (30, &[9, 90], "highway=footway footway=crossing crossing:markings=lines crossing:signals=yes"),
    ];
    let built = build(&data(&nodes, &ways));
    let features = |way, first| {
        let road = built.network.roads.iter().find(|r| r.key.way == way && r.key.first == first).unwrap();
        road.features.iter().map(|f| (f.node, f.station.round(), f.kind)).collect::<Vec<_>>()
    };
    let zebra = FeatureKind::Crossing { signals: false, marked: true };
    let lights = FeatureKind::Crossing { signals: true, marked: true };
    assert_eq!(features(10, 1), {
        let forward = Travel::Forward;
        [(7, 60.0, zebra), (6, 80.0, FeatureKind::StopLine(forward)), (6, 80.0, FeatureKind::Signals(forward))]
    });
    let give_way = FeatureKind::GiveWay(Travel::Backward);
    assert_eq!(features(10, 5), [(8, 20.0, give_way), (9, 30.0, lights)], "the sign faces the crossing");
    assert!(at(&built, 5).signals, "lights stand before it");
    assert!(!at(&built, 1).signals && !at(&built, 3).signals);
}

#[test]
fn a_crossing_on_a_junction_crosses_the_road_that_the_footway_runs_past() {
    let crossed = |footway: &[i64]| {
        let mut nodes = CROSS.to_vec();
        nodes[4].3 = "highway=crossing crossing=marked";
        nodes.extend([(6, -20.0, -5.0, ""), (7, 20.0, -5.0, ""), (8, -20.0, 5.0, "")]);
        let built = build(&data(&nodes, &[(10, &[1, 5, 3], ""), (20, &[4, 5], ""), (30, footway, "highway=footway")]));
        let roads = built.network.roads.iter().filter(|r| !r.features.is_empty());
        let crossed: Vec<(i64, i64)> = roads.map(|r| (r.key.first, r.key.last)).collect();
        (crossed, slugs(&built))
    };
    assert_eq!(crossed(&[6, 5, 7]), (vec![(4, 5)], vec![]), "it runs along way 10 and crosses way 20");
    assert_eq!(crossed(&[6, 5, 8]), (vec![(1, 5)], vec![]));
    assert_eq!(crossed(&[6, 5]), (vec![], vec!["crossing-ambiguous"]));
}

#[test]
fn lights_belong_to_the_intersection_they_face() {
    let signals = |text: &str, x: f64, tags: &str| {
        let mut nodes = CROSS.to_vec();
        nodes.push((6, x, 0.0, text));
        at(&build(&data(&nodes, &[(10, &[1, 6, 5, 3], tags), (20, &[2, 5, 4], "")])), 5).signals
    };
    let (ahead, away) = ("highway=traffic_signals direction=forward", "highway=traffic_signals direction=backward");
    assert!(signals(ahead, -20.0, ""));
    assert!(!signals(away, -20.0, ""));
    assert!(!signals(ahead, -40.0, ""), "too far");
    assert!(signals("highway=traffic_signals", -20.0, ""));
    assert!(signals("highway=traffic_signals", -20.0, "oneway=yes"));
    assert!(!signals("highway=traffic_signals", -20.0, "oneway=-1"), "traffic leaves there");
}

#[test]
fn lights_beyond_a_change_of_tags_count() {
    let mut nodes = CROSS.to_vec();
    nodes.extend([(6, -25.0, 0.0, "highway=traffic_signals"), (7, -10.0, 0.0, "")]);
    let built = build(&data(&nodes, &[(10, &[1, 6, 7], ""), (11, &[7, 5, 3], "lanes=3"), (20, &[2, 5, 4], "")]));
    assert!(at(&built, 5).signals);
}

#[test]
fn stops_on_every_arm_are_an_all_way_stop() {
    let stops = |count: usize| {
        let places = [(61, -9.0, 0.0), (62, 0.0, 9.0), (63, 9.0, 0.0), (64, 0.0, -9.0)];
        let mut nodes = CROSS.to_vec();
        let sign = |i| if i < count { "highway=stop" } else { "" };
        nodes.extend(places.iter().enumerate().map(|(i, (id, x, y))| (*id, *x, *y, sign(i))));
        at(&build(&data(&nodes, &[(10, &[1, 61, 5, 63, 3], ""), (20, &[2, 62, 5, 64, 4], "")])), 5).all_way_stop
    };
    assert!(stops(4));
    assert!(!stops(3));
    let sign_on_one = |text: &'static str| {
        let mut nodes = CROSS.to_vec();
        nodes.push((61, -9.0, 0.0, text));
        at(&build(&data(&nodes, &[(10, &[1, 61, 5, 3], ""), (20, &[2, 5, 4], "")])), 5).all_way_stop
    };
    assert!(sign_on_one("highway=stop stop=all"), "one sign counts for all");
    assert!(!sign_on_one("highway=stop stop=minor") && !sign_on_one("highway=stop"));
    assert!(!sign_on_one("highway=stop stop=all direction=backward"), "it faces away");
    let on_node = |text: &'static str, class: &str| {
        let mut nodes = CROSS.to_vec();
        nodes[4].3 = text;
        build(&data(&nodes, &[(10, &[1, 5, 3], class), (20, &[2, 5, 4], "")]))
    };
    assert!(at(&on_node("highway=stop stop=all", ""), 5).all_way_stop);
    let minor = on_node("highway=stop", "highway=primary");
    assert!(!at(&minor, 5).all_way_stop);
    let signed: Vec<i64> = minor.network.roads.iter().filter(|r| !r.features.is_empty()).map(|r| r.key.way).collect();
    assert_eq!(signed, [20, 20], "the lower class stops");
    let equal = on_node("highway=stop", "");
    assert!(!at(&equal, 5).all_way_stop);
    assert_eq!(slugs(&equal), ["sign-ambiguous"]);
}

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
fn a_way_without_lane_tags_takes_the_lanes_before_and_after_it() {
    let nodes = [(1, 0.0, 0.0, ""), (2, 50.0, 0.0, ""), (3, 60.0, 0.0, ""), (4, 110.0, 0.0, ""), (5, 50.0, 50.0, "")];
    let lanes_of = |texts: [&str; 3], middle: &[i64]| {
        let ways: [(i64, &[i64], &str); 4] =
            [(10, &[1, 2], texts[0]), (20, middle, texts[1]), (30, &[3, 4], texts[2]), (40, &[5, 2], "lanes=1")];
        let built = build(&data(&nodes, &ways));
        let road = built.network.roads.iter().find(|road| road.key.way == 20).unwrap();
        road.section.driven().map(|(_, strip)| strip.travel).collect::<Vec<_>>()
    };
    const ALONG: Travel = Travel::Forward;
    const AGAINST: Travel = Travel::Backward;
    let three = "name=A oneway=yes lanes=3";
    assert_eq!(lanes_of([three, "name=A oneway=yes", three], &[2, 3]), [ALONG; 3]);
    assert_eq!(lanes_of([three, "name=A oneway=yes width=8", three], &[2, 3]), [ALONG; 3]);
    let two_way = "name=A lanes=3 lanes:forward=2";
    assert_eq!(lanes_of([two_way, "name=A", two_way], &[2, 3]), [AGAINST, ALONG, ALONG]);
    assert_eq!(lanes_of([two_way, "name=A", two_way], &[3, 2]), [AGAINST, AGAINST, ALONG], "drawn the other way");
    // Own tags win; a way of another name, class, direction or number of lanes is not continued.
    assert_eq!(lanes_of([three, "name=A oneway=yes lanes=2", three], &[2, 3]), [ALONG; 2]);
    assert_eq!(lanes_of([three, "name=A oneway=yes width=4", three], &[2, 3]), [ALONG]);
    for other in ["name=B oneway=yes lanes=3", "name=A oneway=yes lanes=2", "name=A oneway=yes lanes=3 highway=primary"]
    {
        assert_eq!(lanes_of([three, "name=A oneway=yes", other], &[2, 3]), [ALONG], "{other}");
    }
    assert_eq!(lanes_of([three, "name=A oneway=yes", three], &[3, 2]), [ALONG], "against the others");
}

#[test]
fn settings_overrule_tags() {
    let ways: [(i64, &[i64], &str); 4] = [
        (10, &[1, 5], "lanes=2 maxspeed=50"),
        (20, &[2, 5], ""),
        (30, &[3, 5], "sidewalk=both lane_width=3.5"),
        (40, &[4, 5], "highway=service service=alley"),
    ];
    let own = |text: &str| crate::settings::Document::parse("lanewright.toml", text).unwrap().settings;
    let inner = own("
        [[road]]
        ways = [10, 77]
        tags = { lanes = '3', maxspeed = '' }
        [[assume]]
        highway = ['residential']
        country = 'de'
        lane_width = 2.75
        sidewalk_width = 2
        [[assume]]
        lanes = 2
        speed = 40
        lane_width = 4
        [[assume]]
        country = 'FR'
        speed = 10
    ");
    let outer = own("[[road]]\nways = [10]\ntags = { lanes = '6', name = 'Main Street' }\n");
    let Settings { assume, road: roads, .. } = inner.over(outer);
    let germany = Country { country: Some("DE".into()), side: DrivingSide::Right };
    let options = NetworkOptions { country: Some(germany), assume, roads, ..NetworkOptions::default() };
    let NetworkReading { network, notes } = road_network(&data(&CROSS, &ways), &plane, &options).unwrap();
    let road = |way: i64| network.roads.iter().find(|road| road.key.way == way).unwrap();
    let widths = |way: i64| road(way).section.driven().map(|(_, strip)| strip.width).collect::<Vec<_>>();
    // `[[road]]` replaces tags; `[[assume]]` counts where there are none.
    assert_eq!((widths(10), road(10).speed), (vec![2.75; 3], [40.0; 2]));
    assert_eq!(road(10).name.as_deref(), Some("Main Street"));
    assert_eq!(widths(20), [2.75; 4]);
    assert_eq!(widths(30), [3.5; 4]);
    assert_eq!(road(30).section.strips[0].width, 2.0);
    assert_eq!(widths(40), [4.0; 4]);
    let unmet: Vec<&str> = notes.iter().filter(|n| n.fault == UNMET_ROAD).map(|n| n.message.as_str()).collect();
    assert_eq!(unmet, ["lanewright.toml:2: [[road]] does nothing for way 77: it is not in the data"]);
}

#[test]
fn a_dead_end_without_room_for_a_car_is_left_out() {
    let nodes = [(1, -50.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 50.0, 0.0, ""), (4, 0.0, 5.0, ""), (5, 0.0, 9.0, "")];
    let roads = |end: i64, tags: &str, goes_on: bool| {
        let mut stub = vec![2, end];
        stub.extend(goes_on.then_some(99));
        let built = build(&data(&nodes, &[(10, &[1, 2], ""), (11, &[2, 3], ""), (20, &stub, tags)]));
        (keys(&built).len(), slugs(&built).contains(&"way-skipped"))
    };
    // The street is 6 m wide: 2 m are left of the first, 6 m of the second.
    assert_eq!(roads(4, "", false), (2, true));
    assert_eq!(roads(5, "", false), (3, false));
    assert_eq!(roads(4, "", true), (3, false), "it goes on outside");
    // The end of a street may be short.
    let built = build(&data(&nodes, &[(10, &[1, 2], ""), (20, &[2, 4], "lanes=1")]));
    assert_eq!(keys(&built).len(), 2);
    let built = build(&data(&nodes, &[(20, &[2, 4], ""), (21, &[4, 5], ""), (22, &[2, 5], "")]));
    assert_eq!(keys(&built).len(), 3, "nothing is left");
}

#[test]
fn the_order_of_the_input_does_not_matter() {
    let ways: [(i64, &[i64], &str); 3] = [(10, &[1, 5, 3], ""), (20, &[2, 5], "lanes=3"), (21, &[5, 4], "oneway=yes")];
    let mut nodes = CROSS;
    let first = build(&data(&nodes, &ways));
    nodes.reverse();
    let mut ways = ways;
    ways.reverse();
    let second = build(&data(&nodes, &ways));
    assert_eq!(format!("{first:?}"), format!("{second:?}"));
}

#[test]
fn a_way_that_crosses_itself_is_cut_there() {
    let nodes = [
        (1, -60.0, 0.0, ""),
        (2, 20.0, 0.0, ""),
        (3, 20.0, 20.0, ""),
        (4, 0.0, 20.0, ""),
        (5, 0.0, -60.0, ""),
        (6, 1.0, 2.0, ""),
        (7, 0.0, 2.0, ""),
    ];
    let built = build(&data(&nodes, &[(10, &[1, 2, 3, 4, 5], "")]));
    let ends: Vec<[i64; 2]> = built.network.roads.iter().map(|road| [road.key.first, road.key.last]).collect();
    let crossing = ends.iter().find(|[first, last]| first == last).unwrap()[0];
    let expected = [[1, crossing], [crossing, 5], [crossing, crossing]];
    assert!(ends.len() == 3 && expected.iter().all(|pair| ends.contains(pair)), "{ends:?}");
    assert!((at(&built, crossing).position - Point::origin()).norm() < 1e-9);
    assert_eq!(at(&built, crossing).arms.len(), 4);
    let slip = build(&data(&nodes, &[(10, &[1, 6, 7, 5], ""), (20, &[1, 2, 5], "")]));
    assert_eq!(keys(&slip), [(10, 1, 5), (20, 1, 5)], "a slip of the mapper is no loop");
}
