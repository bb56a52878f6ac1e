//! Lights for vehicles away from intersections, and where no vehicles cross.

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::lanelet::{Lanelet, LaneletMap};

use super::{SIDES, built, elements, found, network, network_of, referrers};

/// The lanes that lights hold, each with the place of its stop line, metres east of the middle of the map; west of it where people drive
/// on the left, for those networks are mirrored.
fn held(map: &LaneletMap, side: DrivingSide) -> Vec<(&Lanelet, f64)> {
    let east = || map.points.iter().map(|point| point.position.x);
    let middle = (east().fold(f64::INFINITY, f64::min) + east().fold(f64::NEG_INFINITY, f64::max)) / 2.0;
    let mut held = Vec::new();
    for light in elements(map, "traffic_light") {
        let Some(line) = light.linestrings("ref_line").next() else { continue };
        let line = map.linestrings.get(line).unwrap();
        let place = map.points.get(line.points[0]).unwrap().position;
        held.extend(referrers(map, light).into_iter().map(|lane| (lane, (place.x - middle) * mirrored(side))));
    }
    held
}

fn mirrored(side: DrivingSide) -> f64 {
    if side == DrivingSide::Left { -1.0 } else { 1.0 }
}

/// Whether a lane leads along the way of its road, which leads east in a network that is not mirrored.
fn is_forward(map: &LaneletMap, side: DrivingSide, lane: &Lanelet) -> bool {
    let bound = map.bound_line(lane.left);
    (bound[bound.len() - 1].x - bound[0].x) * mirrored(side) > 0.0
}

#[test]
fn lights_without_a_crossing_hold_vehicles_where_they_stand() {
    for side in SIDES {
        for (light, tags, forward, backward) in [
            ("highway=traffic_signals", "highway=secondary lanes=4", 2, 2),
            ("highway=traffic_signals traffic_signals:direction=forward", "highway=secondary lanes=4", 2, 0),
            ("highway=traffic_signals traffic_signals:direction=backward", "highway=residential lanes=2", 0, 1),
            ("highway=traffic_signals", "highway=primary lanes=3 oneway=yes", 3, 0),
        ] {
            let nodes = [(1, -150.0, 0.0, ""), (2, 0.0, 0.0, light), (3, 150.0, 0.0, "")];
            let Built { map, settings, .. } = built(&network(side, &nodes, &[(10, &[1, 2, 3])], tags), side, "");
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {light}");
            let held = held(&map, side);
            let count = |forward: bool| held.iter().filter(|(lane, _)| is_forward(&map, side, lane) == forward).count();
            assert_eq!([count(true), count(false)], [forward, backward], "{side:?} {light} {tags}");
            // Lights for one direction stand where vehicles stop; those for both, between the two stop lines.
            let off = if forward > 0 && backward > 0 { 3.5 } else { 0.0 };
            let before = |(lane, at): &(&Lanelet, f64)| if is_forward(&map, side, lane) { -at } else { *at };
            let before: Vec<f64> = held.iter().map(before).collect();
            assert!(before.iter().all(|before| (before - off).abs() < 0.1), "{before:?}");
            assert!(!map.lanelets.iter().any(|lanelet| lanelet.attributes.is("subtype", "crosswalk")));
        }
    }
}

#[test]
fn two_lights_without_a_direction_are_one_for_each() {
    for side in SIDES {
        let light = "highway=traffic_signals";
        let nodes = [(1, -150.0, 0.0, ""), (2, -8.0, 0.0, light), (3, 8.0, 0.0, light), (4, 150.0, 0.0, "")];
        let xml = network(side, &nodes, &[(10, &[1, 2, 3, 4])], "highway=secondary lanes=2");
        let Built { map, settings, .. } = built(&xml, side, "");
        assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?}");
        let held = held(&map, side);
        let before = |(lane, at): &(&Lanelet, f64)| if is_forward(&map, side, lane) { -at } else { *at };
        assert_eq!(held.len(), 2, "{side:?}: nobody stops twice");
        assert!(held.iter().map(before).all(|before| (before - 11.5).abs() < 0.1), "{side:?} {held:?}");
    }
}

#[test]
fn lights_near_a_crossing_are_its_lights() {
    for side in SIDES {
        for (x, lanes) in [(-8.0, 2), (8.0, 2), (-25.0, 1)] {
            let light = "highway=traffic_signals traffic_signals:direction=forward";
            let nodes = [
                (1, -150.0, 0.0, ""),
                (2, x, 0.0, light),
                (3, 0.0, 0.0, "highway=crossing crossing=marked"),
                (4, 150.0, 0.0, ""),
            ];
            let way: &[i64] = if x < 0.0 { &[1, 2, 3, 4] } else { &[1, 3, 2, 4] };
            let xml = network(side, &nodes, &[(10, way)], "highway=residential lanes=2");
            let Built { map, settings, .. } = built(&xml, side, "");
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {x}");
            assert_eq!(held(&map, side).len(), lanes, "{side:?} {x}");
        }
    }
}

#[test]
fn vehicles_stop_at_lights_before_the_place_where_a_lane_ends() {
    let light = "highway=traffic_signals";
    let nodes = [(1, -150.0, 0.0, ""), (2, 0.0, 0.0, light), (3, 150.0, 0.0, "")];
    for side in SIDES {
        for behind in ["lanes=3 maxspeed=30", "lanes=2"] {
            let behind = format!("highway=primary oneway=yes {behind}");
            let ways: [(i64, &[i64], &str); 2] =
                [(10, &[1, 2], "highway=primary oneway=yes lanes=3"), (11, &[2, 3], &behind)];
            let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {behind}");
            let held = held(&map, side);
            assert_eq!(held.len(), 3, "{side:?} {behind}");
            let stops: Vec<f64> = held.iter().map(|(_, stop)| *stop).collect();
            assert!(stops.iter().all(|stop| (-40.0..=0.0).contains(stop)), "{stops:?}");
        }
    }
}

#[test]
fn lights_hold_vehicles_where_a_road_divides() {
    // A road that leaves at 22 degrees, for which nobody signals, one at 53, and one at 127.
    for (beyond, signalled) in [(100.0, false), (30.0, true), (-30.0, true)] {
        for side in SIDES {
            let off = (4, beyond, 40.0, "");
            let nodes = [(1, 0.0, 0.0, "highway=traffic_signals"), (2, -100.0, 0.0, ""), (3, 100.0, 0.0, ""), off];
            let ways: [(i64, &[i64]); 3] = [(10, &[2, 1]), (11, &[1, 3]), (12, &[1, 4])];
            let xml = network(side, &nodes, &ways, "highway=residential oneway=yes lanes=1");
            let Built { map, settings, .. } = built(&xml, side, "");
            // Lanelets of an area that cross nobody are a note.
            let told = if signalled { vec!["vm-03-12/no-conflict"; 2] } else { Vec::new() };
            assert_eq!(found(&map, &settings), told, "{side:?}");
            let held = held(&map, side);
            assert_eq!(held.len(), 2, "both lanelets behind the stop line");
            let mut turns: Vec<_> = held.iter().map(|(lane, _)| lane.attributes.get("turn_direction")).collect();
            turns.sort_unstable();
            let turn = if side == SIDES[0] { "left" } else { "right" };
            let expected = if signalled { [Some(turn), Some("straight")] } else { [None; 2] };
            assert_eq!(turns, expected, "{side:?} {beyond}");
            let in_area = |lane: &Lanelet| lane.attributes.has("intersection_area");
            assert!(held.iter().all(|(lane, _)| in_area(lane) == signalled), "{side:?} {beyond}");
        }
    }
}

#[test]
fn a_ramp_meter_holds_nobody_on_the_motorway() {
    for side in SIDES {
        let meter = "highway=traffic_signals traffic_signals=ramp_meter";
        let ramp = if side == SIDES[0] { 20.0 } else { -20.0 };
        let nodes = [
            (1, -200.0, 0.0, ""),
            (2, 0.0, 0.0, ""),
            (3, 200.0, 0.0, ""),
            (4, -160.0, ramp, ""),
            (5, -20.0, ramp / 8.0, meter),
        ];
        let ways: [(i64, &[i64], &str); 3] = [
            (10, &[1, 2], "highway=motorway lanes=2"),
            (11, &[2, 3], "highway=motorway lanes=3"),
            (12, &[4, 5, 2], "highway=motorway_link lanes=1"),
        ];
        let Built { map, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let held = held(&map, side);
        let ways = held.iter().map(|(lane, _)| lane.attributes.get("road_id").unwrap_or_default());
        assert!(
            !held.is_empty() && ways.clone().all(|road| road.starts_with("12:")),
            "{side:?} {:?}",
            ways.collect::<Vec<_>>()
        );
    }
}

#[test]
fn vehicles_cross_at_a_roundabout_with_lights() {
    for (lights, has_area) in [("highway=traffic_signals", true), ("", false)] {
        for side in SIDES {
            // A ring of four arcs, clockwise where people drive on the left.
            let turn = if side == SIDES[0] { 1.0 } else { -1.0 };
            let nodes = [
                (1, 40.0, 0.0, lights),
                (2, 0.0, 40.0 * turn, ""),
                (3, -40.0, 0.0, ""),
                (4, 0.0, -40.0 * turn, ""),
                (5, 140.0, -20.0 * turn, ""),
                (6, -140.0, 0.0, ""),
                (7, 28.3, 28.3 * turn, ""),
                (8, -28.3, 28.3 * turn, ""),
                (9, -28.3, -28.3 * turn, ""),
                (10, 28.3, -28.3 * turn, ""),
            ];
            let ring = "highway=primary junction=roundabout oneway=yes lanes=2";
            let ways: [(i64, &[i64], &str); 3] = [
                (20, &[1, 7, 2, 8, 3, 9, 4, 10, 1], ring),
                (21, &[5, 1], "highway=primary oneway=yes lanes=2"),
                (22, &[3, 6], "highway=primary oneway=yes lanes=2"),
            ];
            let Built { map, .. } = built(&network_of(side, &nodes, &ways), side, "");
            let areas = map.polygons.iter().filter(|polygon| polygon.attributes.is("type", "intersection_area"));
            assert_eq!(areas.count() > 0, has_area, "{side:?} {lights}");
            assert_eq!(!held(&map, side).is_empty(), has_area, "{side:?} {lights}");
        }
    }
}

#[test]
fn lights_in_a_bend_face_those_who_wait() {
    for side in SIDES {
        let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, "highway=traffic_signals"), (3, -50.0, 100.0, "")];
        let xml = network(side, &nodes, &[(10, &[1, 2, 3])], "highway=residential lanes=2");
        let Built { map, settings, .. } = built(&xml, side, "");
        assert_eq!(held(&map, side).len(), 2, "{side:?}");
        assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?}");
    }
}
