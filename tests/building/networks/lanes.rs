//! Which lanes there are, who may use them, and where they lead.

use std::collections::BTreeSet;

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::geometry::Polyline;
use lanewright::lanelet::{Lanelet, LaneletMap, PointId};

use super::{AGAINST_A_ONE_WAY_STREET, SIDES, built, crossing, found, found_of_geometry, network_of};

/// The bus lanes outside and inside the intersection that bicycles may use, and those that they may not.
fn bus_lanes(map: &LaneletMap) -> [[usize; 2]; 2] {
    let mut count = [[0; 2]; 2];
    for lanelet in map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "bus_lane")) {
        let tags = &lanelet.attributes;
        assert!(tags.is("participant:vehicle:bus", "yes") && !tags.has("participant:vehicle"), "buses only");
        let inside = usize::from(tags.has("intersection_area"));
        count[inside][usize::from(!tags.is("participant:bicycle", "yes"))] += 1;
    }
    count
}

/// A link leaves a one-way street at an angle, and fewer lanes go on: they lead straight on.
#[test]
fn lanes_lead_straight_on_where_a_link_leaves() {
    for side in SIDES {
        for (class, link) in
            [("primary", "primary_link"), ("residential", "residential"), ("trunk", "trunk_link lanes=2")]
        {
            for degrees in [12.0_f64, 22.0, 26.0, -26.0, 35.0, 60.0] {
                let end = [degrees.to_radians().cos() * 150.0, degrees.to_radians().sin() * 150.0];
                let nodes = [(1, 0.0, 0.0, ""), (2, -150.0, 0.0, ""), (3, 150.0, 0.0, ""), (4, end[0], end[1], "")];
                let street = format!("highway={class} oneway=yes");
                let before = format!("{street} lanes=3 turn:lanes:forward=reverse|through|through");
                let link = format!("highway={link} oneway=yes");
                let ways: [(i64, &[i64], &str); 3] =
                    [(12, &[2, 1], &before), (13, &[1, 3], &street), (14, &[1, 4], &link)];
                let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
                // Where one leaves at a wide angle, the fork is an intersection; nobody meets another there. Of three lanes, one goes on.
                let harmless = ["vm-03-01/no-right-of-way", "vm-03-12/no-conflict", "health/fan"];
                let found = found_of_geometry(&map, &settings);
                assert!(
                    found.iter().all(|one| harmless.contains(&one.as_str())),
                    "{side:?} {class} {degrees}: {found:?}"
                );
            }
        }
    }
}

/// The left and the right node at which a lanelet begins (`first`) or ends.
fn ends(map: &LaneletMap, lane: &Lanelet, first: bool) -> [PointId; 2] {
    [lane.left, lane.right].map(|bound| {
        let points = &map.linestrings.get(bound.line).unwrap().points;
        if first == bound.inverted { points[points.len() - 1] } else { points[0] }
    })
}

#[test]
fn bicycles_share_the_bus_lanes_of_their_side_of_the_road() {
    for side in SIDES {
        let shared = |tags: &str| {
            let xml = crossing(side, "", &format!("highway=secondary lanes=4 busway=lane {tags}"));
            let Built { map, settings, .. } = built(&xml, side, "");
            let mut found = found(&map, &settings);
            // Nothing says which of them has priority.
            found.retain(|code| code != "vm-03-11/priority-unknown");
            assert_eq!(found, Vec::<String>::new(), "{side:?} {tags}");
            bus_lanes(&map)
        };
        // Each of the four roads has one in either direction.
        let [outside, inside] = shared("");
        assert_eq!(outside, [0, 8], "{side:?}");
        assert!(inside[0] == 0 && inside[1] > 0, "{side:?} {inside:?}");
        for tags in ["cycleway=share_busway", "cycleway:both=share_busway"] {
            assert_eq!(shared(tags), [[8, 0], [inside[1], 0]], "{side:?} {tags}");
        }
        assert_eq!(shared("cycleway:right=share_busway")[0], [4, 4], "{side:?}");
        assert_eq!(shared("cycleway:left=share_busway")[0], [4, 4], "{side:?}");
    }
}

/// How many lanelets for buses alone turn to the left, go straight on and turn to the right.
fn bus_turns(map: &LaneletMap) -> [usize; 3] {
    ["left", "straight", "right"].map(|turn| {
        let turns = |lanelet: &&Lanelet| {
            let tags = &lanelet.attributes;
            tags.is("subtype", "bus_lane") && tags.is("turn_direction", turn)
        };
        map.lanelets.iter().filter(turns).count()
    })
}

#[test]
fn buses_turn_from_a_road_of_their_own() {
    for side in SIDES {
        let nodes = [(1, 0.0, 0.0, ""), (2, -90.0, 0.0, ""), (3, 90.0, 0.0, ""), (4, 0.0, -90.0, "")];
        let busway = "highway=service access=no bus=yes oneway=yes";
        let ways: [(i64, &[i64], &str); 3] =
            [(12, &[2, 1], busway), (13, &[1, 3], busway), (14, &[1, 4], "highway=residential lanes=2")];
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
        assert_eq!(found_of_geometry(&map, &settings), Vec::<String>::new(), "{side:?}");
        // From the west straight on and into the street, from the street to the east.
        let [left, straight, right] = bus_turns(&map);
        assert_eq!((straight, left + right), (1, 2), "{side:?}");
    }
}

/// The arrow into the side street is on the bus lane at the kerb: cars turn off across it.
#[test]
fn cars_turn_off_over_the_bus_lane_whose_arrow_points_there() {
    for (side, [left, right]) in SIDES.into_iter().zip([["", "|through;right"], ["through;left|", ""]]) {
        let nodes = [(1, 0.0, 0.0, ""), (2, -150.0, 0.0, ""), (3, 150.0, 0.0, ""), (4, 0.0, -150.0, "")];
        let street = "highway=primary oneway=yes lanes=3 busway=lane";
        let before = format!("{street} turn:lanes={left}through|through{right}");
        let ways: [(i64, &[i64], &str); 3] =
            [(12, &[2, 1], &before), (13, &[1, 3], street), (14, &[1, 4], "highway=residential lanes=2")];
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
        // Nobody meets another there but where they merge.
        let harmless = ["vm-03-01/no-right-of-way", "vm-03-12/no-conflict"];
        let found = found_of_geometry(&map, &settings);
        assert!(found.iter().all(|one| harmless.contains(&one.as_str())), "{side:?} {found:?}");
        let turn = if left.is_empty() { "right" } else { "left" };
        let turns = |kind: &str| {
            let tags = map.lanelets.iter().map(|lanelet| &lanelet.attributes);
            tags.filter(|tags| tags.is("subtype", kind) && tags.is("turn_direction", turn)).count()
        };
        // From the west and from the side street.
        assert_eq!((turns("bus_lane") > 0, turns("road")), (true, 2), "{side:?}");
    }
}

#[test]
fn a_shoulder_beyond_a_bicycle_lane_against_the_street_runs_with_it() {
    for (side, kerb) in SIDES.into_iter().zip(["left", "right"]) {
        let nodes = [(1, -100.0, 0.0, ""), (2, 100.0, 0.0, "")];
        let tags = format!(
            "highway=residential oneway=yes lanes=1 oneway:bicycle=no cycleway:{kerb}=lane cycleway:{kerb}:oneway=-1 \
             parking:both=street_side"
        );
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &[(12, &[1, 2], &tags)]), side, "");
        let shoulders = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road_shoulder")).count();
        assert_eq!((shoulders, found(&map, &settings)), (2, Vec::new()), "{side:?}");
    }
}

#[test]
fn lanes_keep_their_order_where_a_road_forks() {
    for side in SIDES {
        for [lanes, left, right] in [[5, 3, 3], [5, 2, 3], [5, 3, 2], [4, 2, 3], [6, 3, 3], [3, 2, 2]] {
            let nodes = [(1, 0.0, 0.0, ""), (2, -150.0, 0.0, ""), (3, 150.0, 25.0, ""), (4, 150.0, -25.0, "")];
            let tags = [lanes, left, right].map(|lanes| format!("highway=trunk oneway=yes lanes={lanes}"));
            let ways: [(i64, &[i64], &str); 3] =
                [(12, &[2, 1], &tags[0]), (13, &[1, 3], &tags[1]), (14, &[1, 4], &tags[2])];
            let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
            assert_eq!(
                found_of_geometry(&map, &settings),
                Vec::<String>::new(),
                "{side:?} {lanes}: {left} and {right}"
            );
        }
    }
}

/// Where lanes that go straight on from south to north begin and end, each counted from the left.
fn northbound(map: &LaneletMap) -> BTreeSet<[usize; 2]> {
    let middle = |lanelet: &Lanelet, last: bool| {
        let [left, right] = [lanelet.left, lanelet.right].map(|bound| {
            let mut points = map.bound_points(bound).map(|point| point.position);
            if last { points.next_back() } else { points.next() }
        });
        nalgebra::center(&left.unwrap(), &right.unwrap())
    };
    let straight = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "straight"));
    let ends = straight.map(|lanelet| [false, true].map(|last| middle(lanelet, last)));
    let ends: Vec<[f64; 2]> = ends.filter(|[a, b]| b.y > a.y + 10.0).map(|[a, b]| [a.x, b.x]).collect();
    let rank = |side: usize, x: f64| {
        let mut all: Vec<i64> = ends.iter().map(|end| end[side].round() as i64).collect();
        all.sort_unstable();
        all.dedup();
        1 + all.iter().position(|other| *other == x.round() as i64).unwrap()
    };
    ends.iter().map(|[a, b]| [rank(0, *a), rank(1, *b)]).collect()
}

#[test]
fn lanes_lead_where_a_relation_says() {
    let relation = |tags: &str| {
        format!(
            "<relation id='9'><member type='way' ref='14' role='from'/><member type='node' ref='1' role='via'/>\
             <member type='way' ref='15' role='to'/><tag k='type' v='connectivity'/>{tags}</relation></osm>"
        )
    };
    for side in SIDES {
        let plain = crossing(side, "highway=traffic_signals", "highway=secondary lanes=6");
        let judged = |tags: &str| {
            let built = built(&plain.replace("</osm>", &relation(tags)), side, "");
            assert_eq!(found(&built.map, &built.settings), Vec::<String>::new(), "{side:?} {tags}");
            let notes: Vec<_> = built.notes.iter().filter(|note| note.fault == "connectivity-skipped").collect();
            (northbound(&built.map), notes.len())
        };
        let usual = BTreeSet::from([[1, 1], [2, 2], [3, 3]]);
        let told = BTreeSet::from([[1, 1], [2, 2], [2, 3]]);
        assert_eq!(judged("<tag k='connectivity' v='1:1|2:2,3|3:(3)'/>"), (told, 0), "{side:?}");
        assert_eq!(judged("<tag k='connectivity' v='1:2|2:1'/>"), (usual.clone(), 1), "{side:?}: they would cross");
        assert_eq!(judged("<tag k='connectivity' v='1:1|4:3'/>"), (usual, 0), "{side:?}: there is no fourth lane");
    }
}

#[test]
fn lanes_fan_out_where_the_settings_have_it() {
    for side in SIDES {
        let xml = crossing(side, "highway=traffic_signals", "highway=secondary lanes=4");
        let turns = |settings: &str| {
            let built = built(&xml, side, settings);
            assert_eq!(found(&built.map, &built.settings), Vec::<String>::new(), "{side:?} {settings}");
            built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.has("turn_direction")).count()
        };
        assert_eq!(turns(""), 4 * (2 + 1 + 1), "{side:?}: straight on, and a lane to either side");
        assert_eq!(turns("[inside]\nfan_out = true\n"), 4 * (2 + 2 + 2), "{side:?}");
    }
}

#[test]
fn a_lane_in_the_middle_leads_only_where_it_is_needed() {
    let middle = "highway=primary lanes=5 lanes:forward=2 lanes:backward=2 lanes:both_ways=1";
    let one_way = "highway=primary lanes=2 oneway=yes";
    for side in SIDES {
        // Into two carriageways, with and without a side street at the end; beyond it, or into a road of five lanes.
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -200.0, 0.0, ""),
            (3, 200.0, -9.0, ""),
            (4, 200.0, 9.0, ""),
            (5, 0.0, 120.0, ""),
            (6, -400.0, 0.0, ""),
            (7, -200.0, 120.0, ""),
        ];
        let parts: [(i64, &[i64], &str); 3] = [(11, &[2, 1], middle), (12, &[1, 3], one_way), (13, &[4, 1], one_way)];
        let at_the_end: (i64, &[i64], &str) = (14, &[1, 5], "highway=residential");
        let before: [(i64, &[i64], &str); 2] = [(15, &[6, 2], middle), (16, &[2, 7], "highway=residential")];
        let of_ways = |map: &LaneletMap| {
            [11, 15].map(|way| {
                let of_way = |id: &str| id.starts_with(&format!("{way}:"));
                map.lanelets.iter().filter(|l| l.attributes.get("road_id").is_some_and(of_way)).count()
            })
        };
        let lanes = |ways: &[(i64, &[i64], &str)]| {
            let built = built(&network_of(side, &nodes, ways), side, "");
            let mut found = found_of_geometry(&built.map, &built.settings);
            // Beside a side street the lane at the far edge meets nobody.
            found.retain(|code| code != "vm-03-12/no-conflict");
            assert!(found.is_empty(), "{side:?} {}: {found:?}", ways.len());
            of_ways(&built.map)
        };
        assert_eq!(lanes(&parts), [5, 0], "{side:?}: not into the two carriageways");
        assert_eq!(lanes(&[&parts[..], &[at_the_end]].concat()), [6, 0], "{side:?}: to turn");
        assert_eq!(lanes(&[&parts[..], &before].concat()), [5, 6], "{side:?}: to turn before the end");
        // The road becomes narrower, and the lane in its middle goes on.
        let narrower = "highway=primary lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1";
        let narrowed = network_of(side, &nodes, &[(11, &[2, 1], middle), (15, &[6, 2], narrower)]);
        assert_eq!(of_ways(&built(&narrowed, side, "").map), [6, 4], "{side:?}: to go on");
    }
}

/// The roads of 150 m in the east, and with three lanes in the west, that meet at lights with a side street.
fn with_lane_drop(east: &str, lanes_of_west: &str, length: f64) -> [Built; 2] {
    SIDES.map(|side| {
        let nodes = [
            (1, 0.0, 0.0, "highway=traffic_signals"),
            (2, -150.0, 0.0, ""),
            (3, length, 0.0, ""),
            (4, 0.0, -90.0, ""),
            (5, 0.0, 90.0, ""),
            (6, length, 90.0, ""),
            (7, length + 100.0, 0.0, ""),
        ];
        let west = format!("highway=primary {lanes_of_west}");
        let ways: [(i64, &[i64], &str); 6] = [
            (12, &[2, 1], &west),
            (13, &[1, 3], east),
            (14, &[4, 1], "highway=secondary lanes=2"),
            (15, &[1, 5], "highway=secondary lanes=2"),
            (16, &[6, 3], "highway=residential lanes=2"),
            (17, &[3, 7], east),
        ];
        built(&network_of(side, &nodes, &ways), side, "")
    })
}

#[test]
fn lanes_merge_behind_the_intersection_and_not_in_it() {
    let three = "oneway=yes lanes=3 turn:lanes=through|through|through";
    let two = "lanes=3 lanes:forward=2 lanes:backward=1 turn:lanes:forward=through|through";
    let merging = |built: &Built| {
        let added = built.notes.iter().filter(|note| note.fault == "lanes-added").count();
        let found = found(&built.map, &built.settings);
        (added, found.iter().filter(|code| *code == "vm-03-07/overlap").count())
    };
    for (east, west) in [("highway=primary oneway=yes lanes=2", three), ("highway=primary lanes=2", two)] {
        assert_eq!(with_lane_drop(east, west, 150.0).each_ref().map(merging), [(1, 0); 2], "{west}");
        // The next intersection is too near.
        assert_eq!(with_lane_drop(east, west, 40.0).each_ref().map(merging), [(0, 1); 2], "{west}");
    }
    // As many lanes lead on as lead in.
    let [one, other] = with_lane_drop("highway=primary oneway=yes lanes=3", three, 150.0);
    assert_eq!([merging(&one), merging(&other)], [(0, 0); 2]);
}

#[test]
fn lanes_marked_straight_on_part_to_all_roads_ahead() {
    // Three lanes, each for one of three roads that part within 30 degrees; another road leads to all three of them, too.
    for side in SIDES {
        let nodes = [
            (1, 0.0, -120.0, ""),
            (2, 0.0, 0.0, ""),
            (3, -40.0, 110.0, ""),
            (4, 0.0, 120.0, ""),
            (5, 40.0, 110.0, ""),
            (6, -120.0, 0.0, ""),
        ];
        let one_way = "highway=secondary oneway=yes lanes=1";
        let ways: [(i64, &[i64], &str); 5] = [
            (10, &[1, 2], "highway=secondary oneway=yes lanes=3 turn:lanes=through|through|through"),
            (11, &[2, 3], one_way),
            (12, &[2, 4], one_way),
            (13, &[2, 5], one_way),
            (14, &[6, 2], one_way),
        ];
        let Built { map, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let of = |way: &str| -> Vec<&Lanelet> {
            let of_way = |l: &&Lanelet| l.attributes.get("road_id").is_some_and(|id| id.starts_with(way));
            map.lanelets.iter().filter(of_way).collect()
        };
        let ends = |lane: &Lanelet, first: bool| ends(&map, lane, first);
        let lanes = of("10:");
        let leads = |way: &str| {
            let from = |l: &&Lanelet| lanes.iter().any(|lane| ends(lane, false) == ends(l, true));
            let onto = of(way);
            let to = |l: &&Lanelet| onto.iter().any(|lane| ends(l, false) == ends(lane, true));
            map.lanelets.iter().filter(from).filter(to).count()
        };
        assert_eq!([leads("11:"), leads("12:"), leads("13:")], [1; 3], "{side:?}");
    }
}

#[test]
fn a_single_track_has_only_the_direction_in_which_cars_can_turn_into_it() {
    for side in SIDES {
        // A drive beside a one-way street. At its northern end cars would have to turn almost back into it.
        let nodes = [
            (1, 0.0, -100.0, ""),
            (2, 0.0, -20.0, ""),
            (3, 0.0, 20.0, ""),
            (4, 0.0, 100.0, ""),
            (5, -8.0, 8.0, ""),
            (6, -8.0, -20.0, ""),
        ];
        let ways: [(i64, &[i64], &str); 2] = [
            (11, &[1, 2, 3, 4], "highway=residential oneway=yes"),
            (12, &[3, 5, 6, 2], "highway=service service=driveway lanes=1"),
        ];
        let Built { map, notes, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let drive = |id: &str| id.starts_with("12:");
        let lanelets = map.lanelets.iter().filter(|l| l.attributes.get("road_id").is_some_and(drive)).count();
        let told = "nobody can enter the lanes of way 12 with its line, nodes 3 to 2, at node 3: there is no room for the turns";
        let told = notes.iter().filter(|note| note.message.ends_with(told)).count();
        assert_eq!((lanelets, told), (1, 1), "{side:?}: {notes:?}");
    }
}

#[test]
fn a_centre_lane_for_turns_ends_where_the_road_goes_on_without_it() {
    for side in SIDES {
        let nodes = [(1, -200.0, 0.0, ""), (2, -100.0, 0.0, ""), (3, 100.0, 0.0, ""), (4, 200.0, 0.0, "")];
        let with_centre_lane = "highway=tertiary lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1";
        let without = "highway=tertiary lanes=2";
        let ways: [(i64, &[i64], &str); 3] =
            [(11, &[1, 2], without), (12, &[2, 3], with_centre_lane), (13, &[3, 4], without)];
        let Built { map, settings, notes, .. } = built(&network_of(side, &nodes, &ways), side, "");
        assert!(notes.iter().all(|note| note.fault != "lane-closed"), "{side:?}: {notes:?}");
        assert_eq!(map.polygons.len(), 0, "{side:?}: no intersection");
        let ends = |lane: &Lanelet, first: bool| ends(&map, lane, first);
        let follows = |lane: &Lanelet| map.lanelets.iter().filter(|next| ends(next, true) == ends(lane, false)).count();
        let mut followers: Vec<usize> = map.lanelets.iter().map(follows).collect();
        followers.sort_unstable();
        // Both ways over the centre lane and both last lanes of the map lead nowhere; no lane has two followers.
        assert_eq!(followers.iter().filter(|&&count| count > 1).count(), 0, "{side:?}: {followers:?}");
        assert_eq!(followers.iter().filter(|&&count| count == 0).count(), 4, "{side:?}: {followers:?}");
        assert_eq!(found_of_geometry(&map, &settings), Vec::<&str>::new(), "{side:?}");
    }
}

#[test]
fn a_road_loses_the_direction_in_which_cars_would_have_to_turn_back_on_the_spot() {
    for side in SIDES {
        // A street for both directions.
        let ways: [(i64, &[i64], &str); 2] =
            [(11, &[1, 2, 3], "highway=secondary oneway=yes"), (12, &[2, 4, 5, 6, 7, 8], "highway=residential")];
        let Built { map, settings, notes, .. } = built(&network_of(side, &AGAINST_A_ONE_WAY_STREET, &ways), side, "");
        let street = |id: &str| id.starts_with("12:");
        let lanelets = map.lanelets.iter().filter(|l| l.attributes.get("road_id").is_some_and(street)).count();
        let told = "nobody can leave the lanes of way 12 against its line, nodes 2 to 8, at node 2: there is no room for the turns";
        let told = notes.iter().filter(|note| note.message.ends_with(told)).count();
        assert_eq!((lanelets, told), (1, 1), "{side:?}: {notes:?}");
        assert_eq!(found_of_geometry(&map, &settings), Vec::<&str>::new(), "{side:?}");
    }
}

#[test]
fn a_road_keeps_its_bend_and_its_width_where_a_stub_is_left_out() {
    for side in SIDES {
        // Behind a right angle a stub of a few metres leaves the road, for which the roads there were to be cut far back.
        let nodes = [
            (1, -3.5, -74.3, ""),
            (2, 7.4, -7.3, ""),
            (3, 8.7, 0.8, ""),
            (4, 0.4, 1.9, ""),
            (5, -22.6, 5.2, ""),
            (6, -80.0, 13.0, ""),
            (7, 1.1, 9.2, ""),
            (8, -18.0, 60.0, ""),
        ];
        let street = "highway=service";
        let ways: [(i64, &[i64], &str); 3] =
            [(11, &[1, 2, 3, 4, 5, 6], street), (12, &[7, 4], street), (13, &[8, 5], street)];
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
        assert_eq!(found_of_geometry(&map, &settings), Vec::<&str>::new(), "{side:?}");
        let stub = |lane: &Lanelet| lane.attributes.get("road_id").is_some_and(|id| id.starts_with("12:"));
        assert!(!map.lanelets.iter().any(stub), "{side:?}");
        for lane in map.lanelets.iter() {
            let line = |bound| Polyline::new(map.bound_points(bound).map(|point| point.position)).unwrap();
            let (left, right) = (line(lane.left), line(lane.right).resampled(1.0));
            let width = right.points().iter().map(|&point| left.distance(point)).fold(f64::INFINITY, f64::min);
            assert!(width > 2.5, "{side:?}: {} is {width} m wide", lane.id);
        }
    }
}

#[test]
fn no_border_runs_between_the_lanes_that_one_lane_becomes() {
    let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 100.0, 0.0, "")];
    let ways: [(i64, &[i64], &str); 2] =
        [(11, &[1, 2], "highway=primary oneway=yes lanes=1"), (12, &[2, 3], "highway=primary oneway=yes lanes=3")];
    for side in SIDES {
        let Built { map, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let bounds = |lane: &Lanelet| [lane.left, lane.right].map(|bound| map.linestrings.get(bound.line).unwrap());
        let is_border = |lane: &Lanelet| bounds(lane).map(|line| line.attributes.is("type", "road_border"));
        let mut fan: Vec<[bool; 2]> =
            map.lanelets.iter().filter(|lane| !lane.attributes.has("road_id")).map(is_border).collect();
        fan.sort_unstable();
        // One lane becomes two, and one of these two farther on.
        assert_eq!(fan, [[false, false], [false, true], [false, true], [true, false], [true, false]], "{side:?}");
    }
}

/// The main and the service carriageway of a street arrive side by side at a street with lights, and go on as `exits` says.
fn beside_the_main_carriageway(side: DrivingSide, exits: &[(i64, &[i64], &str)]) -> Built {
    let signal = "highway=traffic_signals";
    let main = "highway=primary oneway=yes lanes=2 name=Main";
    let nodes = [
        (1, 0.0, 0.0, signal),
        (2, 0.0, -120.0, ""),
        (3, 0.0, 120.0, ""),
        (4, 12.0, -120.0, ""),
        (5, 12.0, 0.0, signal),
        (6, 12.0, 120.0, ""),
        (7, -120.0, 0.0, ""),
        (8, 120.0, 0.0, ""),
    ];
    let mut ways: Vec<(i64, &[i64], &str)> = vec![
        (20, &[2, 1], main),
        (21, &[4, 5], "highway=tertiary oneway=yes lanes=2 name=Main"),
        (22, &[7, 1, 5, 8], "highway=secondary lanes=2 name=Across"),
    ];
    ways.extend(exits);
    built(&network_of(side, &nodes, &ways), side, "")
}

/// Lanelets that go straight on from south to north: how far east, metres, the middle of their south and north ends lies, in order.
fn straight_ways(built: &Built) -> Vec<[f64; 2]> {
    let map = &built.map;
    let straight = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "straight"));
    let mut ways: Vec<[f64; 2]> = Vec::new();
    for lanelet in straight {
        let mut places: Vec<_> = [true, false]
            .into_iter()
            .flat_map(|first| ends(map, lanelet, first))
            .map(|id| map.points.get(id).unwrap().position)
            .collect();
        places.sort_by(|a, b| a.y.total_cmp(&b.y));
        if places[3].y - places[0].y > 15.0 {
            ways.push([places[0].x + places[1].x, places[2].x + places[3].x].map(|sum| sum / 2.0));
        }
    }
    ways.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    ways
}

/// With a light, Autoware watches nobody on a straight lanelet: where two of them cross, vehicles would collide.
#[test]
fn lanes_of_carriageways_side_by_side_cross_no_others() {
    let main: &[i64] = &[1, 3];
    for side in SIDES {
        for exits in [
            vec![(23, main, "highway=primary oneway=yes lanes=3 name=Main")],
            vec![
                (23, main, "highway=primary oneway=yes lanes=2 name=Main"),
                (24, &[5, 6], "highway=tertiary oneway=yes lanes=2 name=Main"),
            ],
        ] {
            let built = beside_the_main_carriageway(side, &exits);
            let ways = straight_ways(&built);
            assert!(ways.len() > exits.len(), "{side:?} {ways:?}");
            assert!(ways.windows(2).all(|two| two[0][1] < two[1][1] + 0.1), "{side:?} {ways:?}");
            let found = found(&built.map, &built.settings);
            assert!(!found.iter().any(|code| code == "planner/nobody-waits"), "{side:?} {found:?}");
        }
    }
}
