//! Crossings, lights, signs and stop lines on roads, and the intersections that they control.

use super::*;

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
