//! Intersections with little room between them, and where vehicles wait for nobody.

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::lanelet::LaneletMap;

use super::{SIDES, built, found, network_of};

const STREET: &str = "highway=residential lanes=2";

/// A street along the x axis with two side streets so far apart, metres, to one side; at the place between them lies what is told.
fn staggered(side: DrivingSide, apart: f64, between: &str) -> Built {
    let nodes = [
        (1, -150.0, 0.0, ""),
        (2, 0.0, 0.0, ""),
        (3, apart / 2.0, 0.0, between),
        (4, apart, 0.0, ""),
        (5, 150.0, 0.0, ""),
        (6, 0.0, 100.0, ""),
        (7, apart, 100.0, ""),
    ];
    let ways: [(i64, &[i64], &str); 3] = [(11, &[1, 2, 3, 4, 5], STREET), (12, &[2, 6], STREET), (13, &[4, 7], STREET)];
    built(&network_of(side, &nodes, &ways), side, "")
}

fn crosswalks(map: &LaneletMap) -> usize {
    map.lanelets.iter().filter(|one| one.attributes.is("subtype", "crosswalk")).count()
}

fn stop_lines(map: &LaneletMap) -> usize {
    map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line")).count()
}

#[test]
fn two_intersections_with_less_than_seven_metres_between_them_are_one() {
    for side in SIDES {
        let counts = [17.0, 30.0].map(|apart| staggered(side, apart, "").summary.intersections);
        assert_eq!(counts, [1, 2], "{side:?}");
    }
}

#[test]
fn a_crosswalk_between_two_intersections_is_not_lost() {
    for side in SIDES {
        let built = staggered(side, 17.0, "highway=crossing crossing=zebra");
        assert_eq!((built.summary.intersections, crosswalks(&built.map)), (2, 1), "{side:?}");
    }
}

/// A ring of one-way streets with three arms, which nobody tagged as a roundabout.
#[test]
fn a_small_ring_is_not_cut_open() {
    for side in SIDES {
        let on_ring = |degrees: f64, radius: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            (radius * cosine, radius * sine)
        };
        let mut nodes = Vec::new();
        for (at, degrees) in (0..12).map(|at| (at, 30.0 * at as f64)) {
            let (x, y) = on_ring(degrees, 12.0);
            nodes.push((1 + at, x, y, ""));
        }
        for (at, degrees) in [(21, 0.0), (22, 120.0), (23, 240.0)] {
            let (x, y) = on_ring(degrees, 120.0);
            nodes.push((at, x, y, ""));
        }
        let ring = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 1];
        let round = "highway=residential oneway=yes";
        let ways: [(i64, &[i64], &str); 4] =
            [(31, &ring, round), (32, &[1, 21], STREET), (33, &[5, 22], STREET), (34, &[9, 23], STREET)];
        let Built { summary, map, .. } = built(&network_of(side, &nodes, &ways), side, "");
        assert_eq!(summary.intersections, 3, "{side:?}");
        let of_ring = |lanelet: &&lanewright::lanelet::Lanelet| {
            lanelet.attributes.get("road_id").is_some_and(|id| id.starts_with("31:"))
        };
        assert_eq!(map.lanelets.iter().filter(of_ring).count(), 3, "{side:?}");
    }
}

/// A road along the x axis with these tags, and another one with its own that ends on it from the south.
fn joined(side: DrivingSide, main: &str, other: &str) -> Built {
    let nodes = [(1, -150.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 150.0, 0.0, ""), (4, -60.0, -100.0, "")];
    let ways: [(i64, &[i64], &str); 2] = [(11, &[1, 2, 3], main), (12, &[4, 2], other)];
    built(&network_of(side, &nodes, &ways), side, "")
}

/// Two streets that cross, these tags on the one along the x axis.
fn crossed(side: DrivingSide, main: &str) -> Built {
    let nodes =
        [(1, -150.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 150.0, 0.0, ""), (4, 0.0, -150.0, ""), (5, 0.0, 150.0, "")];
    let ways: [(i64, &[i64], &str); 2] = [(11, &[1, 2, 3], main), (12, &[4, 2, 5], STREET)];
    built(&network_of(side, &nodes, &ways), side, "")
}

#[test]
fn who_crosses_a_priority_road_has_a_stop_line() {
    for side in SIDES {
        for (main, lines) in [(STREET, 4), ("highway=residential lanes=2 priority_road=designated", 2)] {
            let Built { map, settings, .. } = crossed(side, main);
            assert_eq!(stop_lines(&map), lines, "{side:?}: {main}");
            let found = found(&map, &settings);
            assert!(!found.iter().any(|code| code.starts_with("vm-03-09")), "{side:?}: {main}: {found:?}");
        }
    }
}

#[test]
fn a_stop_line_lies_only_where_somebody_waits() {
    for side in SIDES {
        for (main, other, lines) in [
            // Who comes out of the street that ends there waits, and nobody on the road that leads through.
            (STREET, STREET, 1),
            // The greater road ends there: each of three approaches may have to wait.
            (STREET, "highway=secondary lanes=2", 3),
            // Who comes out of the driveway waits.
            (STREET, "highway=service service=driveway", 1),
            // Between the aisles of a car park nobody paints lines.
            ("highway=service service=parking_aisle", "highway=service service=parking_aisle", 0),
            // The street that joins waits, and nobody on the road that it joins.
            ("highway=residential oneway=yes", "highway=residential oneway=yes", 1),
        ] {
            let Built { map, settings, .. } = joined(side, main, other);
            assert_eq!(stop_lines(&map), lines, "{side:?}: {other} joins {main}");
            let found = found(&map, &settings);
            assert!(
                !found.iter().any(|code| code.starts_with("vm-03-09")),
                "{side:?}: {other} joins {main}: {found:?}"
            );
        }
    }
}
