//! Small networks: how ways are cut, where roads end, which lanes they have.

use crate::builder::tags::cross_section::{StripKind, Travel};
use crate::builder::tags::driving_side::Country;
use crate::osm::OsmData;
use crate::projection::{Extent, LonLat};
use crate::settings::{RoadSettings, Settings};

use super::hand_drawn::{SCALE, osm as data, plane};
use super::resolved_restrictions::ResolvedRestrictions;
use super::*;

mod barriers;
mod features;
mod restrictions;
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
    let first = Some("way 11 is not built: motor vehicles are not admitted (access=no)".to_owned());
    assert_eq!(nothing.unwrap_err(), NetworkError::NoRoad { ways: 2, left_out: 1, first });
    assert!(try_build(&OsmData::default()).is_err());
}

#[test]
fn ways_with_nodes_at_one_place_meet_there_on_one_level() {
    // A crossing where each of the two ways has a node of its own.
    let nodes = [&CROSS[..], &[(6, 0.0, 0.0, "")]].concat();
    let cross = |tags| build(&data(&nodes, &[(10, &[1, 5, 3], ""), (20, &[2, 6, 4], tags)]));
    let built = cross("");
    assert_eq!(keys(&built), [(10, 1, 5), (10, 5, 3), (20, 2, 5), (20, 5, 4)]);
    assert_eq!(slugs(&built), ["node-twin"]);
    for above in ["bridge=yes", "layer=1", "level=2"] {
        let built = cross(above);
        assert_eq!(keys(&built), [(10, 1, 3), (20, 2, 4)], "{above}");
        assert!(slugs(&built).is_empty(), "{above}");
    }
}

#[test]
fn ways_that_cross_without_a_node_have_an_intersection_on_which_nobody_turns() {
    let cross = |ways: [&str; 2]| build(&data(&CROSS, &[(10, &[1, 3], ways[0]), (20, &[2, 4], ways[1])]));
    let built = cross([""; 2]);
    let crossed = built.network.intersections.iter().find(|one| one.arms.len() == 4).unwrap();
    assert!(crossed.position.coords.norm() < 0.1, "{}", crossed.position);
    let (restrictions, _) = ResolvedRestrictions::new(&built.network);
    let way = |arm: &RoadEnd| built.network.road(arm.road).key.way;
    for (from, to) in crossed.arms.iter().flat_map(|from| crossed.arms.iter().map(move |to| (from, to))) {
        let permitted = restrictions.permit(crossed, *from, *to);
        assert_eq!(permitted, way(from) == way(to), "{from:?} to {to:?}");
    }
    assert_eq!(slugs(&built), ["crossing-without-node"]);
    for above in ["bridge=yes", "layer=-1", "level=1"] {
        let built = cross(["", above]);
        assert_eq!(built.network.roads.len(), 2, "{above}");
        assert!(slugs(&built).is_empty(), "{above}");
    }
    for motorway in ["highway=motorway", "highway=trunk_link"] {
        let built = cross(["", motorway]);
        let mut levels: Vec<(i64, f64)> = built.network.roads.iter().map(|road| (road.key.way, road.level)).collect();
        levels.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(levels, [(10, 0.0), (10, 0.0), (10, 1.0), (20, 0.0)], "{motorway}");
        assert_eq!(slugs(&built), ["bridge-assumed"], "{motorway}");
    }
}

#[test]
fn a_road_that_ends_a_little_beyond_another_joins_it() {
    let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 100.0, ""), (3, 100.0, 0.0, ""), (4, 0.0, -1.0, "")];
    let built = build(&data(&nodes, &[(10, &[1, 3], ""), (20, &[2, 4], "")]));
    let joined = built.network.intersections.iter().find(|one| one.arms.len() > 1).unwrap();
    assert_eq!(joined.arms.len(), 3);
    assert!(built.network.restrictions.is_empty());
    assert_eq!(slugs(&built), ["crossing-without-node", "way-skipped"]);
}

#[test]
fn a_ring_that_is_driven_both_ways_is_no_roundabout() {
    let ring = |tags| build(&data(&CROSS, &[(10, &[1, 2, 3, 4, 1], tags)])).network.roads[0].roundabout;
    assert!(ring("junction=roundabout"));
    assert!(!ring("junction=roundabout oneway=no"));
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
fn closed_roads_are_named_with_their_tag() {
    let read = |text: &str| build(&data(&CROSS, &[(10, &[1, 5], text), (20, &[5, 3], "")]));
    for (text, named) in [
        ("highway=service service=emergency_access", "service=emergency_access"),
        ("smoothness=impassable", "smoothness=impassable"),
        ("impassable=yes", "impassable=yes"),
        ("status=impassable", "status=impassable"),
        ("disused=yes", "disused=yes"),
        ("abandoned=yes", "abandoned=yes"),
        ("demolished=yes", "demolished=yes"),
        ("construction=yes", "construction=yes"),
        ("proposed=primary", "proposed=primary"),
        ("route=ferry", "route=ferry"),
        ("highway=pedestrian vehicle=destination", "vehicle=destination"),
        ("highway=pedestrian bus=yes", "bus=yes"),
        ("oneway=reversible", "oneway=reversible"),
        ("motor_vehicle=agricultural;forestry", "motor_vehicle=agricultural;forestry"),
        ("access=emergency", "access=emergency"),
        ("motor_vehicle:forward=no motor_vehicle:backward=no", "motor_vehicle:forward=no"),
        ("oneway=yes motorcar:forward=no", "motorcar:forward=no"),
        ("highway=pedestrian motor_vehicle=yes", "motor_vehicle=yes"),
        ("highway=cycleway motor_vehicle=destination", "motor_vehicle=destination"),
        ("highway=path motorcar=designated", "motorcar=designated"),
    ] {
        let built = read(text);
        let notes: Vec<&str> = built.notes.iter().map(|note| note.message.as_str()).collect();
        assert_eq!(slugs(&built), ["way-skipped"], "{text}");
        assert!(notes[0].contains(named), "{text}: {notes:?}");
    }
    for text in ["access=destination;agricultural", "motor_vehicle=unheard_of", "hov=designated", "construction=minor"]
    {
        assert_eq!(slugs(&read(text)), [""; 0], "{text}");
    }
    let bus = read("access=psv");
    assert!(bus.network.roads[0].section.strips.iter().all(|strip| strip.kind == StripKind::Bus));
}

#[test]
fn shared_paths_are_private_roads_where_the_settings_have_it() {
    let osm = data(&CROSS, &[(10, &[1, 5], "highway=pedestrian motor_vehicle=yes"), (20, &[5, 3], "highway=footway")]);
    let with = |tags: &[(&str, &str)]| {
        let tags = tags.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect();
        let roads = vec![RoadSettings { shared_paths: true, tags, ..RoadSettings::default() }];
        assert_eq!(osm.ways.iter().map(|way| is_driven(way, &roads)).collect::<Vec<_>>(), [true, false]);
        let options = NetworkOptions { driving_side: Some(DrivingSide::Right), roads, ..NetworkOptions::default() };
        let built = road_network(&osm, &plane, &options).unwrap();
        let [road] = &built.network.roads[..] else { panic!("{:?}", built.network.roads) };
        assert_eq!(slugs(&built).first(), Some(&"path-shared"), "{:?}", built.notes);
        (road.public, road.class, road.speed[0])
    };
    assert_eq!(with(&[]), (false, RoadClass::Service, 10.0));
    assert_eq!(with(&[("maxspeed", "6")]), (false, RoadClass::Service, 6.0));
    assert!(!is_driven(&osm.ways[0], &[]));
}

#[test]
fn ways_over_the_same_nodes_are_one_road() {
    let lanes = |ways: &[(i64, &[i64], &str)]| {
        let built = build(&data(&CROSS, ways));
        let roads = built.network.roads.iter();
        let travels: Vec<Vec<Travel>> =
            roads.map(|road| road.section.driven().map(|(_, strip)| strip.travel).collect()).collect();
        (travels, slugs(&built).into_iter().map(str::to_owned).collect::<Vec<_>>())
    };
    let (back, on) = (Travel::Backward, Travel::Forward);
    let one_way = "oneway=yes lanes=1";
    assert_eq!(
        lanes(&[(10, &[1, 5], one_way), (11, &[5, 1], one_way)]),
        (vec![vec![back, on]], vec!["way-twin".into()])
    );
    let twice = lanes(&[(10, &[1, 5], "oneway=yes lanes=2"), (11, &[5, 1], "oneway=yes lanes=1")]);
    assert_eq!(twice.0, [vec![back, on, on]]);
    assert_eq!(lanes(&[(10, &[1, 5], "oneway=-1"), (11, &[1, 5], "oneway=yes")]).0, [vec![back, on]]);
    assert_eq!(lanes(&[(10, &[1, 5], "lanes=2"), (11, &[1, 5], "lanes=2")]).0, [vec![back, on]]);
    assert_eq!(lanes(&[(10, &[1, 5], "oneway=yes"), (11, &[5, 1], "lanes=2")]).0, [vec![back, on]]);
    let three = lanes(&[(10, &[1, 5], one_way), (11, &[5, 1], one_way), (12, &[1, 5], one_way)]);
    assert_eq!(three.0, [vec![back, on]]);
    let above = lanes(&[(10, &[1, 5], ""), (11, &[1, 5], "bridge=yes")]);
    assert_eq!(above.1, ["way-duplicate"], "another level");
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
fn a_way_without_lane_tags_takes_the_lanes_before_and_after_it() {
    let lanes_of = |length: f64, texts: [&str; 3], middle: &[i64]| {
        let nodes = [
            (1, -50.0, 0.0, ""),
            (2, 0.0, 0.0, ""),
            (3, length, 0.0, ""),
            (4, length + 50.0, 0.0, ""),
            (5, 0.0, 50.0, ""),
        ];
        let ways: [(i64, &[i64], &str); 4] =
            [(10, &[1, 2], texts[0]), (20, middle, texts[1]), (30, &[3, 4], texts[2]), (40, &[5, 2], "lanes=1")];
        let built = build(&data(&nodes, &ways));
        let road = built.network.roads.iter().find(|road| road.key.way == 20).unwrap();
        road.section.driven().map(|(_, strip)| strip.travel).collect::<Vec<_>>()
    };
    const ALONG: Travel = Travel::Forward;
    const AGAINST: Travel = Travel::Backward;
    let (three, piece) = ("name=A oneway=yes lanes=3", 10.0);
    assert_eq!(lanes_of(piece, [three, "name=A oneway=yes", three], &[2, 3]), [ALONG; 3]);
    assert_eq!(lanes_of(piece, [three, "name=A oneway=yes width=8", three], &[2, 3]), [ALONG; 3]);
    let two_way = "name=A lanes=3 lanes:forward=2";
    assert_eq!(lanes_of(piece, [two_way, "name=A", two_way], &[2, 3]), [AGAINST, ALONG, ALONG]);
    assert_eq!(
        lanes_of(piece, [two_way, "name=A", two_way], &[3, 2]),
        [AGAINST, AGAINST, ALONG],
        "drawn the other way"
    );
    // Own tags win; a way of another direction or number of lanes is not continued, a long way only by one of its name and class.
    assert_eq!(lanes_of(piece, [three, "name=A oneway=yes lanes=2", three], &[2, 3]), [ALONG; 2]);
    assert_eq!(lanes_of(piece, [three, "name=A oneway=yes width=4", three], &[2, 3]), [ALONG]);
    assert_eq!(lanes_of(piece, [three, "name=A oneway=yes", "name=A oneway=yes lanes=2"], &[2, 3]), [ALONG]);
    for other in ["name=B oneway=yes lanes=3", "name=A oneway=yes lanes=3 highway=primary"] {
        assert_eq!(lanes_of(piece, [three, "name=A oneway=yes", other], &[2, 3]), [ALONG; 3], "{other}");
        assert_eq!(lanes_of(80.0, [three, "name=A oneway=yes", other], &[2, 3]), [ALONG], "{other}");
    }
    assert_eq!(lanes_of(piece, [three, "name=A oneway=yes", three], &[3, 2]), [ALONG], "against the others");
}

#[test]
fn a_carriageway_of_a_main_road_does_not_lose_its_lanes() {
    const NODES: [(i64, f64, f64, &str); 7] = [
        (1, -90.0, 0.0, ""),
        (2, 0.0, 0.0, ""),
        (3, 80.0, 0.0, ""),
        (4, 80.0, 20.0, ""),
        (5, 0.0, 20.0, ""),
        (6, 180.0, 0.0, ""),
        (7, 260.0, 0.0, ""),
    ];
    const STREET: &str = "highway=secondary name=A";
    let lanes_of = |own: &str, others: &[(i64, &[i64], &str)]| {
        let with = |text: &str| format!("oneway=yes {text}");
        let own = with(own);
        let texts: Vec<String> = others.iter().map(|(_, _, text)| with(&format!("{STREET} {text}"))).collect();
        let mut ways: Vec<(i64, &[i64], &str)> = vec![(20, &[2, 3], &own)];
        ways.extend(others.iter().zip(&texts).map(|((id, nodes, _), text)| (*id, *nodes, text.as_str())));
        let built = build(&data(&NODES, &ways));
        let road = built.network.roads.iter().find(|road| road.key.way == 20).unwrap();
        road.section.driven().count()
    };
    let before: (i64, &[i64], &str) = (10, &[1, 2], "lanes=4");
    let twin: (i64, &[i64], &str) = (30, &[4, 5], "lanes=3");
    let nearby: (i64, &[i64], &str) = (40, &[6, 7], "lanes=5");
    assert_eq!(lanes_of(STREET, &[nearby, twin, before]), 4, "as before it");
    assert_eq!(lanes_of(STREET, &[nearby, twin]), 3, "as its twin");
    assert_eq!(lanes_of(STREET, &[nearby]), 5, "as the street nearby");
    for class in [STREET, "highway=primary", "highway=trunk"] {
        assert_eq!(lanes_of(class, &[]), 2, "as most of its class");
    }
    assert_eq!(lanes_of("highway=secondary name=B", &[nearby, twin]), 2, "not as another street");
    let narrow = [
        "highway=secondary name=A width=4",
        "highway=tertiary name=A",
        "highway=secondary_link name=A",
        "highway=secondary name=A lanes=1",
    ];
    for own in narrow {
        assert_eq!(lanes_of(own, &[nearby, twin]), 1, "{own}");
    }
    // Of two pieces the one with fewer lanes: a lane for turns may begin or end with the other.
    let after: (i64, &[i64], &str) = (50, &[3, 6], "lanes=3");
    assert_eq!(lanes_of(STREET, &[before, after]), 3);
}

#[test]
fn a_carriageway_beside_an_island_has_the_lanes_of_the_two_way_road() {
    // Around the island from 2 to 3 the road has a carriageway for each direction, each in two pieces.
    let island = |length: f64, before: &str, after: &str| {
        let nodes: [(i64, f64, f64, &str); 6] = [
            (1, -100.0, 0.0, ""),
            (2, 0.0, 0.0, ""),
            (3, length, 0.0, ""),
            (4, length + 100.0, 0.0, ""),
            (5, length / 2.0, 12.0, ""),
            (6, length / 2.0, -12.0, ""),
        ];
        let [before, after] = [before, after].map(|text| format!("highway=secondary name=A {text}"));
        let carriageway = "highway=secondary name=A oneway=yes";
        let ways: [(i64, &[i64], &str); 6] = [
            (10, &[1, 2], &before),
            (20, &[2, 6], carriageway),
            (21, &[6, 3], carriageway),
            (30, &[3, 5], carriageway),
            (31, &[5, 2], carriageway),
            (40, &[4, 3], &after),
        ];
        let built = build(&data(&nodes, &ways));
        [20, 21, 30, 31].map(|way| {
            let road = built.network.roads.iter().find(|road| road.key.way == way);
            road.unwrap().section.driven().count()
        })
    };
    assert_eq!(island(80.0, "", ""), [1; 4]);
    assert_eq!(island(80.0, "lanes=4", "lanes=4"), [2; 4]);
    assert_eq!(island(80.0, "lanes=4", ""), [1; 4], "the fewer of both ends");
    let one_more_ahead = "lanes=3 lanes:forward=2 lanes:backward=1";
    let one_more_back = "lanes=3 lanes:forward=1 lanes:backward=2";
    assert_eq!(island(80.0, one_more_ahead, one_more_back), [2, 2, 1, 1], "by direction, however the ways are drawn");
    assert_eq!(island(400.0, "", ""), [2; 4], "a long island is the median of a divided road");
}

#[test]
fn a_carriageway_keeps_one_lane_where_two_have_no_room_or_lead_nowhere() {
    const CLOSED: &[i64] = &[2, 5, 6, 7, 3, 2];
    let lanes_of = |apart: f64, ring: &str, nodes_of_ring: &[i64]| {
        let nodes: [(i64, f64, f64, &str); 8] = [
            (1, -200.0, 0.0, ""),
            (2, 0.0, 0.0, ""),
            (3, 0.0, apart, ""),
            (4, -200.0, apart, ""),
            (5, 20.0, -10.0, ""),
            (6, 40.0, 5.0, ""),
            (7, 20.0, 20.0, ""),
            (8, 240.0, 5.0, ""),
        ];
        let avenue = "highway=secondary name=A oneway=yes";
        let ring = format!("highway=secondary oneway=yes {ring}");
        let ways: [(i64, &[i64], &str); 4] = [
            (20, &[1, 2], avenue),
            (21, &[3, 4], avenue),
            (30, nodes_of_ring, &ring),
            (40, &[6, 8], "highway=residential"),
        ];
        let built = build(&data(&nodes, &ways));
        let road = built.network.roads.iter().find(|road| road.key.way == 20);
        road.unwrap().section.driven().count()
    };
    assert_eq!(lanes_of(20.0, "", &[2, 5, 6, 7, 3]), 2);
    assert_eq!(lanes_of(5.0, "", &[2, 5, 6, 7, 3]), 1, "the other carriageway lies where the second lane would");
    for ring in ["junction=roundabout", ""] {
        assert_eq!(lanes_of(20.0, ring, CLOSED), 1, "two lanes would end in one of the ring {ring}");
    }
    assert_eq!(lanes_of(20.0, "junction=roundabout lanes=2", CLOSED), 2);
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
    let slip = build(&data(&nodes, &[(10, &[1, 6, 7, 5], ""), (20, &[1, 2, 5], "layer=1")]));
    assert_eq!(keys(&slip), [(10, 1, 5), (20, 1, 5)], "a slip of the mapper is no loop");
}
