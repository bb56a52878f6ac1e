//! Traffic lights of drivers where pedestrians cross with lights.

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::geometry::Polyline;
use lanewright::lanelet::{Lanelet, LaneletId, LaneletMap, LineStringId, RegulatoryElement};

use super::{SIDES, built, elements, found, network, network_of, referrers};

/// A road of 200 m that is crossed at node 2, in two ways if it is to be split there.
fn crossed(side: DrivingSide, tags: &str, split: bool) -> Built {
    let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, "highway=crossing crossing=traffic_signals"), (3, 100.0, 0.0, "")];
    let whole: [(i64, &[i64]); 1] = [(10, &[1, 2, 3])];
    let halves: [(i64, &[i64]); 2] = [(10, &[1, 2]), (11, &[2, 3])];
    let xml = network(side, &nodes, if split { &halves } else { &whole }, tags);
    built(&xml.replace("<way id='11'>", "<way id='11'><tag k='maxspeed' v='20'/>"), side, "")
}

/// The lights of drivers, each with the lanelet that obeys it and the distance of its stop line from the crosswalk.
fn drivers(map: &LaneletMap) -> Vec<(&Lanelet, f64)> {
    let crosswalk = map.lanelets.iter().find(|lanelet| lanelet.attributes.is("subtype", "crosswalk")).unwrap();
    let area = map.outline(crosswalk);
    let found = elements(map, "traffic_light").into_iter().filter_map(|light| {
        let line = map.linestrings.get(light.linestrings("ref_line").next()?).unwrap();
        let places: Vec<_> = line.points.iter().map(|id| map.points.get(*id).unwrap().position).collect();
        let middle = nalgebra::center(&places[0], &places[1]);
        let off = Polyline::new(area.iter().copied().chain([area[0]])).unwrap().distance(middle);
        let [lane] = referrers(map, light)[..] else { panic!("one lane has one stop line") };
        Some((lane, off))
    });
    found.collect()
}

#[test]
fn drivers_have_lights_where_people_have_some_between_intersections() {
    for side in SIDES {
        for (tags, split, lanes) in [
            ("highway=residential lanes=2", false, 2),
            ("highway=residential lanes=2", true, 2),
            ("highway=secondary lanes=4", false, 4),
            ("highway=secondary lanes=3 oneway=yes", false, 3),
            ("highway=residential lanes=1 width=3", false, 2),
        ] {
            let Built { map, settings, .. } = crossed(side, tags, split);
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {tags}");
            let drivers = drivers(&map);
            assert_eq!(drivers.len(), lanes, "{side:?} {tags}");
            assert!(drivers.iter().all(|(_, off)| (1.9..2.1).contains(off)), "{drivers:?}");
            let bodies = map.linestrings.iter().filter(|line| line.attributes.is("subtype", "red_yellow_green"));
            assert_eq!(bodies.count(), if tags.contains("oneway") { 1 } else { 2 }, "one for each direction");
        }
    }
}

#[test]
fn crosswalks_that_would_lie_on_each_other_are_one_with_lights() {
    for side in SIDES {
        let nodes = [
            (1, -100.0, 0.0, ""),
            (2, 0.0, 0.0, "highway=crossing"),
            (3, 2.0, 0.0, "highway=crossing crossing=traffic_signals"),
            (4, 100.0, 0.0, ""),
        ];
        let Built { map, settings, .. } =
            built(&network(side, &nodes, &[(10, &[1, 2, 3, 4])], "highway=residential lanes=2"), side, "");
        assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?}");
        let crosswalks = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "crosswalk"));
        assert_eq!((crosswalks.count(), drivers(&map).len()), (1, 2));
    }
}

#[test]
fn the_stop_line_lies_before_the_crosswalk_on_the_lane_that_leads_to_it() {
    for side in SIDES {
        let Built { map, .. } = crossed(side, "highway=residential lanes=2", true);
        let lanes = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road")).count();
        assert_eq!(lanes, 6, "two roads, the first of them cut at one stop line: at the other it ends");
        let stopping: Vec<LaneletId> = drivers(&map).iter().map(|(lane, _)| lane.id).collect();
        assert!(stopping.len() == 2 && stopping[0] != stopping[1]);
        for light in elements(&map, "traffic_light").into_iter().filter(|light| light.role("ref_line").next().is_some())
        {
            let place = |line: LineStringId| {
                let id = map.linestrings.get(line).unwrap().points[0];
                map.points.get(id).unwrap().position
            };
            let (stop, body) =
                (light.linestrings("ref_line").next().unwrap(), light.linestrings("refers").next().unwrap());
            let lane = referrers(&map, light)[0];
            let bound = map.bound_line(lane.left);
            let heading = bound[bound.len() - 1] - bound[0];
            assert!((place(body) - place(stop)).dot(&heading) > 0.0, "drivers look ahead");
        }
    }
}

#[test]
fn whoever_has_just_left_an_intersection_with_lights_stops_at_no_other() {
    for side in SIDES {
        let nodes = [
            (1, 0.0, 0.0, "highway=traffic_signals"),
            (2, -100.0, 0.0, ""),
            (3, 200.0, 0.0, ""),
            (4, 0.0, -100.0, ""),
            (5, 0.0, 100.0, ""),
            (6, 32.0, 0.0, "highway=crossing crossing=traffic_signals"),
            (7, 120.0, 0.0, "highway=crossing crossing=traffic_signals"),
        ];
        for (road, lights) in [(&[3, 6, 1][..], 1), (&[3, 7, 1], 2), (&[3, 7, 6, 1], 3)] {
            let ways: [(i64, &[i64]); 4] = [(12, &[2, 1]), (13, road), (14, &[4, 1]), (15, &[5, 1])];
            let built = built(&network(side, &nodes, &ways, "highway=residential lanes=2"), side, "");
            let Built { map, settings, .. } = &built;
            assert_eq!(found(map, settings), Vec::<String>::new());
            let outside = |light: &&&RegulatoryElement| {
                light.role("ref_line").next().is_some()
                    && referrers(map, light).iter().all(|lane| !lane.attributes.has("intersection_area"))
            };
            assert_eq!(elements(map, "traffic_light").iter().filter(outside).count(), lights, "{side:?} {road:?}");
            assert!(built.notes.iter().all(|note| note.fault != "crossing-unlit"));
        }
    }
}

#[test]
fn lights_hang_on_the_lanes_between_two_stop_lines() {
    // Two crossings 60 m apart on a road of 400 m, and two with 5 m between them.
    let crossing = "highway=crossing crossing=traffic_signals";
    let at = |x: f64, id: i64| (id, x, 0.0, crossing);
    for side in SIDES {
        for (places, groups) in [(vec![at(-30.0, 3), at(30.0, 4)], 2), (vec![at(-4.0, 3), at(4.0, 4)], 1)] {
            let mut nodes = vec![(1, -200.0, 0.0, ""), (2, 200.0, 0.0, "")];
            nodes.extend(places);
            let ways: [(i64, &[i64]); 1] = [(10, &[1, 3, 4, 2])];
            let Built { map, settings, .. } =
                built(&network(side, &nodes, &ways, "highway=secondary lanes=4"), side, "");
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {groups}");
            let lights =
                elements(&map, "traffic_light").into_iter().filter(|light| light.role("ref_line").next().is_some());
            let mut lanes: Vec<LaneletId> = Vec::new();
            for light in lights {
                let [lane] = referrers(&map, light)[..] else { panic!("one lane obeys it") };
                let line = map.linestrings.get(light.linestrings("ref_line").next().unwrap()).unwrap();
                let starts = [lane.left, lane.right].map(|bound| map.bound_points(bound).next().unwrap().id);
                assert_eq!(line.points, starts, "the lane begins at the stop line");
                let crosses =
                    elements(&map, "crosswalk").into_iter().filter(|it| lane.regulatory_elements.contains(&it.id));
                assert_eq!(crosses.count(), 2 / groups);
                lanes.push(lane.id);
            }
            lanes.sort_unstable();
            lanes.dedup();
            assert_eq!(lanes.len(), 4 * groups);
        }
    }
}

/// A T of a main road with people's lights so far east of it, and a side road of these tags.
fn crossed_near(side: DrivingSide, off: f64, side_road: &str) -> Built {
    let nodes = [
        (1, 0.0, 0.0, ""),
        (2, -100.0, 0.0, ""),
        (3, 100.0, 0.0, ""),
        (4, 0.0, -80.0, ""),
        (5, off, 0.0, "highway=crossing crossing=traffic_signals"),
    ];
    let main = "highway=tertiary lanes=2";
    let ways: [(i64, &[i64], &str); 3] = [(12, &[2, 1], main), (13, &[1, 5, 3], main), (14, &[4, 1], side_road)];
    built(&network_of(side, &nodes, &ways), side, "")
}

#[test]
fn drivers_on_the_main_road_have_lights_where_people_cross_it_beside_an_intersection() {
    for side in SIDES {
        for side_road in ["highway=residential lanes=2", "highway=tertiary lanes=2"] {
            for off in [5.0, 8.0, 12.0, 14.0] {
                let Built { map, settings, notes, .. } = crossed_near(side, off, side_road);
                assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {off} {side_road}");
                assert!(notes.iter().all(|note| note.fault != "crossing-unlit"));
                let inside = |lanelet: &&&Lanelet| lanelet.attributes.has("intersection_area");
                let lit = |lanelet: &&Lanelet| {
                    elements(&map, "traffic_light").iter().any(|light| lanelet.regulatory_elements.contains(&light.id))
                };
                let lit: Vec<&Lanelet> =
                    map.lanelets.iter().filter(|it| it.attributes.is("subtype", "road")).filter(lit).collect();
                // Both approaches of the main road, straight on and around a corner; the side road gives way.
                assert_eq!((lit.len(), lit.iter().filter(inside).count()), (4, 4), "{side:?} {off} {side_road}");
                let crosswalk = map.lanelets.iter().find(|it| it.attributes.is("subtype", "crosswalk")).unwrap();
                assert!(
                    elements(&map, "traffic_light")
                        .iter()
                        .any(|light| crosswalk.regulatory_elements.contains(&light.id))
                );
            }
        }
    }
}

#[test]
fn drivers_wait_behind_the_intersection_where_there_is_room() {
    for side in SIDES {
        for off in [18.0, 20.0, 25.0, 30.0, 50.0] {
            let Built { map, settings, .. } = crossed_near(side, off, "highway=residential lanes=2");
            let mut found = found(&map, &settings);
            found.retain(|code| code != "vm-03-11/priority-unknown");
            assert_eq!(found, Vec::<String>::new(), "{side:?} {off}");
            let drivers = drivers(&map);
            assert!(drivers.iter().all(|(lane, _)| !lane.attributes.has("intersection_area")));
            assert_eq!(drivers.len(), 2, "{side:?} {off}");
        }
    }
}

#[test]
fn who_gives_way_beside_lights_of_people_has_none_and_is_named() {
    for side in SIDES {
        // People cross what gives way: a lower road, and one of four equal ones.
        let built = crossed_near(side, 8.0, "highway=primary lanes=2");
        assert!(elements(&built.map, "traffic_light").iter().all(|light| light.role("ref_line").next().is_none()));
        assert_eq!(built.notes.iter().filter(|note| note.fault == "crossing-unlit").count(), 1);
    }
}

#[test]
fn where_people_have_no_lights_drivers_have_none() {
    let side = DrivingSide::Right;
    let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, "highway=crossing crossing=zebra"), (3, 100.0, 0.0, "")];
    let map = built(&network(side, &nodes, &[(10, &[1, 2, 3])], "highway=residential lanes=2"), side, "").map;
    assert!(elements(&map, "traffic_light").is_empty() && !elements(&map, "crosswalk").is_empty());
}
