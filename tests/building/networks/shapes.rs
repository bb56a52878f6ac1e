//! The shapes of junctions: short roads, narrow streets, roads side by side or above each other.

use std::collections::BTreeSet;

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::geometry::polygon;
use lanewright::lanelet::{Lanelet, PointId};

use super::{SIDES, built, elements, found, found_of_geometry, network, network_of, referrers};

#[test]
fn roads_that_leave_side_by_side_are_approaches_of_their_own() {
    for side in SIDES {
        for east in [6.0, 20.0, 30.0] {
            let nodes = [
                (1, 0.0, 0.0, ""),
                (2, -90.0, 3.0, ""),
                (3, 90.0, 0.0, ""),
                (4, 0.0, 90.0, ""),
                (5, 0.0, -80.0, ""),
                (6, east, -80.0, ""),
            ];
            let ways: [(i64, &[i64]); 5] = [(12, &[2, 1]), (13, &[3, 1]), (14, &[4, 1]), (15, &[5, 1]), (16, &[6, 1])];
            let xml = network(side, &nodes, &ways, "highway=residential lanes=2");
            let Built { map, settings, .. } = built(&xml, side, "");
            let mut found = found(&map, &settings);
            // Nothing says which of them has priority.
            found.retain(|code| code != "vm-03-11/priority-unknown");
            assert_eq!(found, Vec::<String>::new(), "{side:?}, {east} m apart at their ends");
        }
    }
}

#[test]
fn a_turn_around_a_small_loop_may_be_missing() {
    for side in SIDES {
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, 80.0, 20.0, ""),
            (3, -10.8, 3.0, ""),
            (4, -18.0, -2.0, ""),
            (5, -18.9, -6.3, ""),
            (6, -14.4, -10.8, ""),
            (7, -7.2, -7.2, ""),
        ];
        let ways: [(i64, &[i64]); 2] = [(12, &[2, 1]), (13, &[1, 3, 4, 5, 6, 7, 1])];
        let xml = network(side, &nodes, &ways, "highway=residential lanes=2 oneway=no");
        let Built { map, settings, .. } = built(&xml, side, "");
        let turning = map.lanelets.iter().filter(|one| one.attributes.get("intersection_area").is_some()).count();
        assert_eq!(turning, 4, "{side:?}: two onto the loop and two off it; there is no room to go around again");
        let missed = found(&map, &settings).into_iter().filter(|code| code == "vm-03-04/movement-missing").count();
        assert_eq!(missed, 0, "{side:?}");
    }
}

#[test]
fn nobody_is_led_around_a_loop_with_two_directions_once_more() {
    for side in SIDES {
        for (tags, movements) in [("highway=residential lanes=2", 4), ("highway=residential oneway=yes", 3)] {
            let place = |i: usize| {
                let angle = std::f64::consts::TAU * i as f64 / 12.0;
                (1 + i as i64, 25.0 * angle.cos(), 25.0 * angle.sin(), "")
            };
            let nodes: Vec<_> = (0..12).map(place).chain([(13, 120.0, 0.0, "")]).collect();
            let around: Vec<i64> = (1..=12).chain([1]).collect();
            let mut drawn = network(side, &nodes, &[(14, &around)], tags);
            drawn = drawn.replace(
                "</osm>",
                "<way id='15'><nd ref='13'/><nd ref='1'/><tag k='highway' v='residential'/></way></osm>",
            );
            let map = built(&drawn, side, "").map;
            let turning = map.lanelets.iter().filter(|one| one.attributes.get("intersection_area").is_some()).count();
            assert_eq!(turning, movements, "{side:?}: {tags}");
        }
    }
}

#[test]
fn what_is_left_of_a_road_too_short_for_the_turns_at_its_ends_lies_inside() {
    for side in SIDES {
        for apart in [18.0, 20.0, 22.0] {
            let nodes = [
                (1, 0.0, 0.0, ""),
                (2, apart, 0.0, ""),
                (3, -150.0, 0.0, ""),
                (4, apart + 150.0, 0.0, ""),
                (5, 85.0, 120.0, ""),
                (6, apart - 85.0, -120.0, ""),
            ];
            let ways: [(i64, &[i64]); 3] = [(11, &[3, 1, 2, 4]), (14, &[1, 5]), (15, &[2, 6])];
            let built = built(&network(side, &nodes, &ways, "highway=residential"), side, "");
            let mut found = found_of_geometry(&built.map, &built.settings);
            // Two turns brush each other behind the place where one has left the other's way.
            found.retain(|code| code != "planner/never-meets");
            assert!(found.is_empty(), "{side:?} {apart}: {found:?}");
            assert_eq!((built.summary.roads, built.summary.intersections), (4, 1), "{side:?} {apart}");
        }
    }
}

#[test]
fn a_dead_end_too_short_for_the_turn_into_it_is_left_out() {
    for side in SIDES {
        for (length, roads) in [(9.0, 2), (20.0, 3)] {
            let nodes = [(1, 0.0, 0.0, ""), (3, -150.0, 0.0, ""), (4, 150.0, 0.0, ""), (5, 0.0, length, "")];
            let ways: [(i64, &[i64]); 3] = [(11, &[3, 1]), (13, &[1, 4]), (14, &[1, 5])];
            let built = built(&network(side, &nodes, &ways, "highway=residential"), side, "");
            let found = found_of_geometry(&built.map, &built.settings);
            assert!(found.is_empty(), "{side:?} {length}: {found:?}");
            assert_eq!(built.summary.roads, roads, "{side:?} {length}");
            let told = built.notes.iter().any(|note| note.fault == "way-skipped" && note.message.contains("way 14"));
            assert_eq!(told, roads == 2, "{side:?} {length}");
        }
    }
}

#[test]
fn a_road_that_leads_around_a_loop_ends_before_its_own_carriageway() {
    for side in SIDES {
        for gap in [3.0, 4.5] {
            let nodes =
                [(1, 0.0, 0.0, ""), (2, 100.0, 0.0, ""), (3, 100.0, 60.0, ""), (4, 40.0, 60.0, ""), (5, 40.0, gap, "")];
            let xml = network(side, &nodes, &[(11, &[1, 2, 3, 4, 5])], "highway=residential lanes=2");
            let built = built(&xml, side, "");
            let found = found_of_geometry(&built.map, &built.settings);
            assert!(found.is_empty(), "{side:?} {gap}: {found:?}");
            let farthest = |axis: usize| {
                let corners = built.map.lanelets.iter().flat_map(|lanelet| built.map.outline(lanelet));
                corners
                    .map(|corner| corner[axis])
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], c| [a.min(c), b.max(c)])
            };
            let [width, height] = [0, 1].map(|axis| farthest(axis)[1] - farthest(axis)[0]);
            assert!(width > 95.0 && height > 60.0, "{side:?} {gap}: {width} m by {height} m");
        }
    }
}

#[test]
fn a_place_to_turn_around_that_lies_inside_its_intersection_is_left_out() {
    for side in SIDES {
        for (radius, roads) in [(4.0, 1), (6.5, 2), (12.0, 2)] {
            let place = |i: usize| {
                let angle = std::f64::consts::TAU * i as f64 / 12.0;
                (1 + i as i64, radius * angle.cos(), radius * angle.sin(), "")
            };
            let nodes: Vec<_> = (0..12).map(place).chain([(13, 90.0, 0.0, "")]).collect();
            let around: Vec<i64> = (1..=12).chain([1]).collect();
            let ways: [(i64, &[i64]); 2] = [(14, &around), (15, &[13, 1])];
            let built = built(&network(side, &nodes, &ways, "highway=service"), side, "");
            let found = found_of_geometry(&built.map, &built.settings);
            assert!(roads > 1 || found.is_empty(), "{side:?} {radius}: {found:?}");
            assert_eq!(built.summary.roads, roads, "{side:?} {radius}");
            let told = built.notes.iter().any(|note| note.fault == "way-skipped" && note.message.contains("way 14"));
            assert_eq!(told, roads == 1, "{side:?} {radius}");
        }
    }
}

#[test]
fn a_crossing_of_narrow_streets_is_no_larger_than_its_turns_need() {
    for side in SIDES {
        // The two halves of a street in line with each other, but for a hair, and at an angle that an eye sees.
        for off in [0.0, 0.01, 1.0] {
            let nodes = [
                (1, 0.0, 0.0, ""),
                (2, -150.0, off, ""),
                (3, 150.0, off, ""),
                (4, off, -150.0, ""),
                (5, off, 150.0, ""),
            ];
            let ways: [(i64, &[i64]); 4] = [(12, &[2, 1]), (13, &[3, 1]), (14, &[4, 1]), (15, &[5, 1])];
            let built = built(&network(side, &nodes, &ways, "highway=residential"), side, "");
            assert_eq!(found_of_geometry(&built.map, &built.settings), Vec::<String>::new(), "{side:?} {off}");
            let area = built.map.polygons.iter().next().unwrap();
            let places = area.points.iter().map(|&id| built.map.points.get(id).unwrap().position);
            let (low, high) = places.fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p.x), high.max(p.x)));
            // Streets of 6 m, and a turn of 6 m in the middle of lanes of 3 m at either side.
            assert!(high - low < 2.0 * (1.5 + 6.0) + 0.5, "{side:?} {off}: {}", high - low);
        }
    }
}

#[test]
fn who_leaves_a_driveway_below_a_bridge_crosses_nobody_on_it() {
    for side in SIDES {
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -120.0, 0.0, ""),
            (3, 120.0, 0.0, ""),
            (4, 0.0, 40.0, ""),
            (6, -150.0, -70.0, ""),
            (7, 150.0, 82.0, ""),
        ];
        let ways: [(i64, &[i64], &str); 3] = [
            (10, &[2, 1, 3], "highway=residential lanes=2 sidewalk=both"),
            (11, &[1, 4], "highway=service service=driveway"),
            (12, &[6, 7], "highway=primary lanes=2 bridge=yes layer=1"),
        ];
        let built = built(&network_of(side, &nodes, &ways), side, "");
        let walkways = built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "walkway"));
        let bridge = built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("road_id", "12:6-7:0"));
        let [walkways, bridge] = [walkways.collect::<Vec<_>>(), bridge.collect()];
        assert_eq!((walkways.len(), bridge.len()), (1, 2));
        let walkway = built.map.outline(walkways[0]);
        let above = |lane: &&Lanelet| polygon::common_area(&built.map.outline(lane), &walkway) > 1.0;
        assert!(bridge.iter().any(above), "the bridge leads over the walkway");
        let found = found(&built.map, &built.settings);
        assert!(!found.iter().any(|code| code.starts_with("vm-03-13")), "{found:?}");
    }
}

#[test]
fn only_who_leaves_private_ground_needs_an_area_at_a_roundabout() {
    for side in SIDES {
        let ring: Vec<(i64, f64, f64, &str)> = (0..12)
            .map(|i| {
                let angle = f64::from(i) * std::f64::consts::TAU / 12.0;
                (i64::from(i) + 1, 18.0 * angle.cos(), 18.0 * angle.sin(), "")
            })
            .collect();
        let far = [(21, 120.0, 0.0, ""), (22, -120.0, 0.0, ""), (23, 0.0, 120.0, "")];
        let nodes: Vec<_> = ring.into_iter().chain(far).collect();
        let around: Vec<i64> = (1..=12).chain([1]).collect();
        let turns_of = |third: &str| {
            let street = "highway=residential lanes=2";
            let ways: [(i64, &[i64], &str); 4] = [
                (30, &around, "highway=residential junction=roundabout oneway=yes lanes=1"),
                (31, &[21, 1], street),
                (32, &[22, 7], street),
                (33, &[23, 4], third),
            ];
            let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
            let mut found = found_of_geometry(&map, &settings);
            // Who leaves the roundabout meets nobody.
            found.retain(|code| code != "vm-03-12/no-conflict");
            assert_eq!(found, Vec::<String>::new(), "{side:?} {third}");
            let turns = map.lanelets.iter().filter(|lanelet| lanelet.attributes.has("turn_direction"));
            let private = |lanelet: &&Lanelet| lanelet.attributes.is("location", "private");
            let [private, all] = [turns.clone().filter(private).count(), turns.count()];
            // All others wait by the rules of the roundabout.
            let rings = elements(&map, "roundabout");
            assert_eq!(rings.len(), 1, "{side:?} {third}");
            let count = |role: &str| rings[0].lanelets(role).count();
            (private > 0, all > 0, [count("entry"), count("exit")])
        };
        assert_eq!(turns_of("highway=residential lanes=2"), (false, false, [3, 3]), "{side:?}");
        assert_eq!(turns_of("highway=service access=private"), (true, true, [2, 3]), "{side:?}");
    }
}

#[test]
fn a_roundabout_with_two_lanes_is_no_unmarked_intersection_though_its_outer_lane_only_leads_out() {
    const RING: i64 = 24;
    for side in SIDES {
        let ring = (0..RING).map(|i| {
            let angle = i as f64 * std::f64::consts::TAU / RING as f64;
            (i + 1, 25.0 * angle.cos(), 25.0 * angle.sin(), "")
        });
        let far = [(31, 120.0, 14.0), (32, 120.0, -14.0), (33, -120.0, -14.0), (34, -120.0, 14.0)];
        let nodes: Vec<_> = ring.chain(far.map(|(id, east, north)| (id, east, north, ""))).collect();
        let around: Vec<i64> = (1..=RING).chain([1]).collect();
        let (leaving, joining) = ("highway=secondary oneway=yes lanes=2", "highway=secondary oneway=yes lanes=1");
        let ways: [(i64, &[i64], &str); 5] = [
            (40, &around, "highway=secondary junction=roundabout oneway=yes lanes=2"),
            (41, &[2, 31], leaving),
            (42, &[32, 24], joining),
            (43, &[14, 33], leaving),
            (44, &[34, 12], joining),
        ];
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let found = found(&map, &settings);
        assert!(map.lanelets.len() > 20, "{side:?}");
        assert!(!found.iter().any(|code| code == "vm-03-01/unmarked"), "{side:?} {found:?}");
    }
}

#[test]
fn vehicles_give_way_where_they_join_a_roundabout_and_show_where_they_leave_it() {
    for side in SIDES {
        let around: Vec<i64> = (1..=12).chain([1]).collect();
        let street = "highway=residential lanes=2";
        let carriageway = "highway=residential lanes=1 oneway=yes";
        // As usual vehicles around the island pass the carriageway that leads out first. The other way around, one comes from the one
        // that leads in right into the one that leads out.
        for is_first_out in [true, false] {
            let ring = (0..12).map(|i| {
                let angle = f64::from(i) * std::f64::consts::TAU / 12.0;
                (i64::from(i) + 1, 18.0 * angle.cos(), 18.0 * angle.sin(), "")
            });
            // The third street is divided: its carriageways meet the ring in one node.
            let (west, north) = if is_first_out { (15.0, 120.0) } else { (110.0, 80.0) };
            let far = [(21, 120.0, -60.0, ""), (22, -120.0, -60.0, ""), (23, -west, north, ""), (24, west, north, "")];
            let nodes: Vec<_> = ring.chain(far).collect();
            let (leading_in, leading_out) = if is_first_out { (23, 24) } else { (24, 23) };
            let ways: [(i64, &[i64], &str); 5] = [
                (30, &around, "highway=residential junction=roundabout oneway=yes lanes=1"),
                (31, &[21, 12], street),
                (32, &[22, 8], street),
                (33, &[leading_in, 4], carriageway),
                (34, &[4, leading_out], carriageway),
            ];
            let Built { map, settings, notes, .. } = built(&network_of(side, &nodes, &ways), side, "");
            assert!(notes.iter().any(|note| note.fault == "roundabout-module"), "{side:?}");
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?}");
            assert!(map.polygons.is_empty(), "{side:?}");
            let [ring] = elements(&map, "roundabout")[..] else { panic!("{side:?}") };
            let of_role = |role: &str| ring.lanelets(role).collect::<BTreeSet<_>>();
            let [entries, exits, internal] = ["entry", "exit", "internal"].map(of_role);
            let both = entries.intersection(&exits).count();
            let expected = if is_first_out { (3, 3, 0) } else { (4, 4, 1) };
            assert_eq!((entries.len(), exits.len(), both), expected, "{side:?}");
            let referrers: BTreeSet<_> = referrers(&map, ring).iter().map(|lanelet| lanelet.id).collect();
            assert_eq!(referrers, entries.union(&exits).copied().collect(), "{side:?}");
            let signalling = map.lanelets.iter().filter(|lanelet| lanelet.attributes.has("enable_exit_turn_signal"));
            let signalling: BTreeSet<_> = signalling.map(|lanelet| lanelet.id).collect();
            // The pieces of the ring between the streets; where one may leave, nobody who goes on shows that he leaves.
            assert_eq!((signalling.len(), internal.len()), (3, 6), "{side:?}");
            assert!(signalling.is_subset(&internal), "{side:?}");
            let stop_lines = map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line")).count();
            assert_eq!(stop_lines, 3, "{side:?}: one for each street that leads in");
        }
    }
}

#[test]
fn a_street_that_leads_over_a_ring_has_areas_where_it_crosses() {
    for side in SIDES {
        let ring = (0..24).map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 24.0;
            (i64::from(i) + 1, 60.0 * angle.cos(), 60.0 * angle.sin(), "")
        });
        let far = [(31, 180.0, 0.0, ""), (32, -180.0, 0.0, "")];
        let nodes: Vec<_> = ring.chain(far).collect();
        let around: Vec<i64> = (1..=24).chain([1]).collect();
        let ways: [(i64, &[i64], &str); 2] = [
            (40, &around, "highway=primary junction=roundabout oneway=yes lanes=2"),
            (41, &[31, 1, 13, 32], "highway=primary oneway=yes lanes=2"),
        ];
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let mut found = found_of_geometry(&map, &settings);
        found.retain(|code| code != "vm-03-12/no-conflict");
        assert_eq!(found, Vec::<String>::new(), "{side:?}");
        let areas = map.polygons.iter().filter(|polygon| polygon.attributes.is("type", "intersection_area")).count();
        assert_eq!(areas, 2, "{side:?}");
    }
}

#[test]
fn a_bicycle_lane_lies_at_either_kerb_of_a_one_way_street() {
    for side in SIDES {
        for kerb in ["left", "right"] {
            let nodes = [(1, -100.0, 0.0, ""), (2, 100.0, 0.0, "")];
            let tags = format!("highway=residential oneway=yes lanes=2 cycleway:{kerb}=lane");
            let Built { map, settings, .. } = built(&network(side, &nodes, &[(12, &[1, 2])], &tags), side, "");
            let bicycles =
                map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "bicycle_lane")).count();
            assert_eq!((bicycles, found(&map, &settings)), (1, Vec::new()), "{side:?} {kerb}");
        }
    }
}

#[test]
fn lanes_that_restrictions_close_are_no_fault() {
    for side in SIDES {
        // Nobody may go on south, over two lanes; those who come from there may leave.
        let nodes =
            [(1, 0.0, 0.0, ""), (2, -90.0, 0.0, ""), (3, 90.0, 0.0, ""), (4, 0.0, -90.0, ""), (5, 0.0, 90.0, "")];
        let ways: [(i64, &[i64], &str); 4] = [
            (12, &[2, 1], "highway=residential lanes=2"),
            (13, &[1, 3], "highway=residential lanes=2"),
            (14, &[1, 4], "highway=residential lanes=4"),
            (15, &[1, 5], "highway=residential lanes=2"),
        ];
        let relations: String = [(12, 20), (13, 21), (15, 22)]
            .map(|(from, id)| {
                format!(
                    "<relation id='{id}'><member type='way' role='from' ref='{from}'/><member type='node' role='via' ref='1'/>\
                     <member type='way' role='to' ref='14'/><tag k='type' v='restriction'/>\
                     <tag k='restriction' v='no_entry'/></relation>"
                )
            })
            .concat();
        let xml = network_of(side, &nodes, &ways).replace("</osm>", &format!("{relations}</osm>"));
        let Built { map, settings, .. } = built(&xml, side, "");
        let found = found_of_geometry(&map, &settings);
        assert!(!found.iter().any(|code| code.starts_with("vm-03-04")), "{side:?}: {found:?}");
    }
}

#[test]
fn an_aisle_that_no_car_can_turn_into_ends_before_the_street() {
    for side in SIDES {
        // Between a street and an aisle that are one-way to the north another leads back.
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, 0.0, -90.0, ""),
            (3, 0.0, 90.0, ""),
            (4, 6.0, -9.0, ""),
            (5, 6.0, -70.0, ""),
            (6, 10.0, -3.0, ""),
            (7, 11.0, -70.0, ""),
        ];
        let ways: [(i64, &[i64], &str); 4] = [
            (12, &[2, 1], "highway=secondary oneway=yes"),
            (13, &[1, 3], "highway=secondary oneway=yes"),
            (14, &[1, 4, 5], "highway=service service=parking_aisle oneway=yes"),
            (15, &[7, 6, 1], "highway=service service=parking_aisle oneway=yes"),
        ];
        let Built { map, settings, notes, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let found = found_of_geometry(&map, &settings);
        assert!(!found.iter().any(|code| code.starts_with("vm-03-04")), "{side:?}: {found:?}");
        let told = "nobody can enter the lanes of way 14 with its line, nodes 1 to 5, at node 1: there is no room for the turns";
        assert!(notes.iter().any(|note| note.message.ends_with(told)), "{side:?}: {notes:?}");
    }
}

#[test]
fn the_stop_line_of_a_carriageway_goes_on_to_the_middle_of_the_other_one() {
    // A street parts into two carriageways, at an angle of 7 degrees, before it meets another.
    for side in SIDES {
        let nodes = [
            (1, 0.0, -100.0, ""),
            (2, 0.0, 0.0, ""),
            (3, 0.0, 8.0, ""),
            (4, 0.0, 100.0, ""),
            (5, 66.0, 4.0, ""),
            (6, 166.0, 4.0, ""),
        ];
        let one_way = "highway=secondary oneway=yes lanes=1";
        let (south, north): (&[i64], &[i64]) = match side {
            DrivingSide::Right => (&[2, 5], &[5, 3]),
            DrivingSide::Left => (&[5, 2], &[3, 5]),
        };
        let ways: [(i64, &[i64], &str); 4] = [
            (12, &[1, 2, 3, 4], "highway=secondary"),
            (13, south, one_way),
            (14, north, one_way),
            (15, &[5, 6], "highway=secondary"),
        ];
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let found = found_of_geometry(&map, &settings);
        assert!(!found.iter().any(|code| code == "vm-03-09/end-misaligned"), "{side:?}: {found:?}");
    }
}

#[test]
fn a_place_joins_as_many_roads_as_it_has_room_for_directions() {
    // Two directions of each street, one of a one-way street: 32 are joined.
    for (tags, roads, joined) in [("oneway=no", 18_i64, Some(16)), ("oneway=yes", 18, None)] {
        let mut nodes = vec![(1, 0.0, 0.0, "")];
        let ends: Vec<[i64; 2]> = (0..roads).map(|i| if i % 2 == 0 { [i + 2, 1] } else { [1, i + 2] }).collect();
        for i in 0..roads {
            let angle = std::f64::consts::TAU * i as f64 / roads as f64;
            nodes.push((i + 2, 150.0 * angle.cos(), 150.0 * angle.sin(), ""));
        }
        let ways: Vec<(i64, &[i64])> = (100..).zip(ends.iter().map(|ends| &ends[..])).collect();
        let xml = network(DrivingSide::Right, &nodes, &ways, &format!("highway=residential {tags}"));
        let built = built(&xml, DrivingSide::Right, "");
        let told = built.notes.iter().find(|note| note.fault == "too-many-roads");
        let said = joined.map(|joined| format!("; {joined} of them are joined,"));
        assert_eq!(told.is_some(), said.is_some(), "{roads} {tags}");
        if let (Some(told), Some(said)) = (told, said) {
            assert!(told.message.contains(&said), "{}", told.message);
        }
    }
}

#[test]
fn a_street_that_joins_a_ring_where_another_leaves_lies_beside_it_without_an_area() {
    for side in SIDES {
        // One street runs onto the ring and another from it, both nearly along it, so that who stays on the ring and who crosses from
        // street to street drive side by side.
        let nodes = [
            (1, 0.0, 0.0, ""),
            (10, -19.6, 3.8, ""),
            (11, -35.8, 15.6, ""),
            (12, -45.5, 33.1, ""),
            (13, -30.0, 75.0, ""),
            (20, 19.6, 3.8, ""),
            (21, 35.8, 15.6, ""),
            (22, 45.5, 33.1, ""),
            (23, 30.0, 75.0, ""),
            (30, -28.0, 1.0, ""),
            (31, -67.8, -3.2, ""),
            (32, -126.0, -17.7, ""),
            (40, 36.9, -3.2, ""),
            (41, 81.3, -15.1, ""),
        ];
        let ways: [(i64, &[i64], &str); 3] = [
            (50, &[1, 20, 21, 22, 23, 13, 12, 11, 10, 1], "highway=primary_link junction=roundabout"),
            (51, &[32, 31, 30, 1], "highway=primary oneway=yes"),
            (52, &[1, 40, 41], "highway=primary_link oneway=yes"),
        ];
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
        assert_eq!(map.polygons.len(), 0, "{side:?}");
        assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?}");
    }
}

#[test]
fn who_turns_from_one_street_into_the_next_keeps_to_the_road_between_them() {
    for side in SIDES {
        // Four streets 11 m apart end in a slanting one: too near each other for intersections of their own. Semicircles from one to
        // another would cover 917 m2.
        let mut nodes: Vec<(i64, f64, f64, &str)> = vec![(30, -30.0, -51.0, ""), (31, 93.0, -27.9, "")];
        for (i, x) in [0.0, 11.0, 22.0, 33.0].into_iter().enumerate() {
            let (id, y) = (i as i64, -0.3 * x);
            nodes.extend([(1 + id, x, y, ""), (11 + id, x + 30.0, y + 80.0, "")]);
        }
        let ways: [(i64, &[i64]); 6] = [
            (101, &[1, 2, 3, 4, 31]),
            (110, &[1, 11]),
            (111, &[2, 12]),
            (112, &[3, 13]),
            (113, &[4, 14]),
            (130, &[30, 1]),
        ];
        let Built { map, .. } = built(&network(side, &nodes, &ways, "highway=residential lanes=2"), side, "");
        let ring =
            |points: &[PointId]| points.iter().map(|id| map.points.get(*id).unwrap().position).collect::<Vec<_>>();
        let areas: Vec<f64> =
            map.polygons.iter().map(|area| polygon::area_around(ring(&area.points).iter()).abs()).collect();
        assert_eq!(areas.len(), 1, "{side:?}");
        assert!(areas[0] < 870.0, "{side:?}: {areas:?} m2");
    }
}
