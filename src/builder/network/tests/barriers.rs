//! Barriers end roads, gates make the ground behind them private.

use super::*;

/// A street along the x axis over nodes 1 to 5 with a node 3 of these tags, and a side street at node 5.
fn street_past(tags: &str) -> NetworkReading {
    let nodes = [
        (1, -100.0, 0.0, ""),
        (2, -50.0, 0.0, ""),
        (3, 0.0, 0.0, tags),
        (4, 50.0, 0.0, ""),
        (5, 100.0, 0.0, ""),
        (6, 100.0, 50.0, ""),
    ];
    build(&data(&nodes, &[(10, &[1, 2, 3, 4, 5], ""), (20, &[5, 6], "")]))
}

/// Length of every road of way 10 and whether only buses use it.
fn street_lengths(built: &NetworkReading) -> Vec<(i64, bool)> {
    let roads = built.network.roads.iter().filter(|road| road.key.way == 10);
    let bus = |road: &Road| road.section.driven().all(|(_, strip)| strip.kind == StripKind::Bus);
    let mut lengths: Vec<(i64, bool)> = roads.map(|road| (road.line.length().round() as i64, bus(road))).collect();
    lengths.sort_unstable();
    lengths
}

#[test]
fn a_road_ends_on_both_sides_of_a_barrier() {
    for tags in [
        "barrier=bollard",
        "barrier=bus_trap access=no",
        "motor_vehicle=no",
        "barrier=gate vehicle=no",
        "access=no",
        "access=no emergency=yes taxi=yes",
        "barrier=gate locked=yes",
        "barrier=kerb kerb=raised",
        "barrier=wire_fence",
        "barrier=tree",
    ] {
        let built = street_past(tags);
        assert_eq!(street_lengths(&built), [(99, false), (99, false)], "{tags}");
        assert_eq!(slugs(&built), ["road-closed"], "{tags}");
        assert_eq!(built.network.intersections.iter().filter(|place| place.arms.len() == 1).count(), 4, "{tags}");
    }
    let open = [
        "barrier=bollard motor_vehicle=yes",
        "barrier=kerb",
        "barrier=toll_booth",
        "barrier=fence sensory=audible",
        "entrance=main access=no",
        "bicycle=no",
    ];
    for tags in open {
        let built = street_past(tags);
        assert_eq!((street_lengths(&built), slugs(&built)), (vec![(200, false)], vec![]), "{tags}");
    }
    for tags in ["barrier=gate", "barrier=lift_gate access=yes", "barrier=gate locked=yes motor_vehicle=yes"] {
        let built = street_past(tags);
        assert_eq!((street_lengths(&built), slugs(&built)), (vec![(200, false)], vec!["gate"]), "{tags}");
    }
}

#[test]
fn a_rising_bollard_is_a_gate_to_private_ground() {
    for (tags, fault) in
        [("barrier=bollard bollard=rising", "gate"), ("barrier=bollard bollard=removable", "road-closed")]
    {
        assert_eq!(slugs(&street_past(tags)), [fault], "{tags}");
    }
}

#[test]
fn ground_behind_a_gate_with_private_access_is_private() {
    let ways: [(i64, &[i64], &str); 2] = [(10, &[1, 2, 3, 4, 5], ""), (20, &[5, 6], "")];
    let public = |tags: &str, far: f64| {
        let nodes = [
            (1, -far, 0.0, ""),
            (2, -50.0, 0.0, ""),
            (3, 0.0, 0.0, tags),
            (4, 50.0, 0.0, ""),
            (5, 100.0, 0.0, ""),
            (6, 100.0, 50.0, ""),
        ];
        let built = build(&data(&nodes, &ways));
        built.network.roads.iter().map(|road| road.public).collect::<Vec<_>>()
    };
    assert_eq!(public("barrier=gate access=private", 2000.0), [true, false, false]);
    assert_eq!(
        public("barrier=gate access=private", 260.0),
        [true, false, false],
        "no ground of a gate reaches so far"
    );
    assert_eq!(public("barrier=gate", 2000.0), [true, true]);
    assert_eq!(public("barrier=gate access=private", 240.0), [true; 3], "either side may be the private one");
}

#[test]
fn buses_pass_a_barrier_that_lets_them_through() {
    for tags in
        ["barrier=bollard bus=yes", "barrier=bus_trap", "barrier=sump_buster", "motor_vehicle=no psv=designated"]
    {
        let built = street_past(tags);
        assert_eq!(street_lengths(&built), [(16, true), (92, false), (92, false)], "{tags}");
        assert_eq!(built.network.intersections.iter().filter(|place| place.arms.len() == 2).count(), 3, "{tags}");
    }
}

#[test]
fn a_barrier_where_roads_meet_ends_all_of_them() {
    let mut nodes = CROSS;
    nodes[4].3 = "barrier=bollard";
    let built = build(&data(&nodes, &[(10, &[1, 5, 3], ""), (20, &[2, 5, 4], "")]));
    assert_eq!(built.network.roads.len(), 4);
    assert!(built.network.intersections.iter().all(|place| place.arms.len() == 1));
    assert!(built.network.roads.iter().all(|road| (road.line.length() - 95.0).abs() < 1e-6));
    // Between two barriers there is no room for a car.
    let nodes =
        [(1, 0.0, 0.0, ""), (2, 50.0, 0.0, "barrier=bollard"), (3, 54.0, 0.0, "barrier=bollard"), (4, 99.0, 0.0, "")];
    let built = build(&data(&nodes, &[(10, &[1, 2, 3, 4], "")]));
    assert_eq!(built.network.roads.len(), 2);
    assert_eq!(slugs(&built), ["road-closed", "road-closed", "way-skipped"]);
}

#[test]
fn a_node_may_close_one_direction() {
    let lanes = |built: &NetworkReading, travel: Travel| {
        let roads = built.network.roads.iter().filter(|road| road.key.way == 10);
        roads.filter(|road| road.section.driven().any(|(_, strip)| strip.travel == travel)).count()
    };
    for (tags, forward, backward) in [
        ("motor_vehicle:backward=no", 3, 2),
        ("access=no access:forward=yes", 3, 2),
        ("vehicle:forward=no", 2, 3),
        ("vehicle:forward=no bus:forward=yes", 2, 3),
        ("barrier=bollard motor_vehicle:forward=yes", 3, 2),
    ] {
        let built = street_past(tags);
        assert_eq!([lanes(&built, Travel::Forward), lanes(&built, Travel::Backward)], [forward, backward], "{tags}");
        assert_eq!(slugs(&built), ["road-closed"], "{tags}");
    }
    let both = street_past("motor_vehicle:forward=no motor_vehicle:backward=no");
    assert_eq!(street_lengths(&both), [(99, false), (99, false)]);
    // A one-way road is closed by a node that closes its direction; where roads meet nobody knows whose direction it is.
    let one_way = |tags: &str| {
        let nodes = [(1, 0.0, 0.0, ""), (2, 50.0, 0.0, tags), (3, 100.0, 0.0, "")];
        build(&data(&nodes, &[(10, &[1, 2, 3], "oneway=yes")])).network.roads.len()
    };
    assert_eq!(one_way("motor_vehicle:forward=no"), 2);
    let mut nodes = CROSS;
    nodes[4].3 = "motor_vehicle:forward=no";
    let built = build(&data(&nodes, &[(10, &[1, 5, 3], ""), (20, &[2, 5, 4], "")]));
    assert_eq!((built.network.roads.len(), slugs(&built)), (4, vec!["road-closed"]));
    assert!(built.network.intersections.iter().any(|place| place.arms.len() == 4));
}
