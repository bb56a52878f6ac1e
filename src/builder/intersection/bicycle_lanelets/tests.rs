//! Bicycle lanes through intersections, on small networks.

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tests::{Asked, built_as, driven_on, ends};
use crate::builder::{BuildOptions, Built};
use crate::geometry::Point;
use crate::lanelet::{Lanelet, LaneletMap};
use crate::settings::{BesideSettings, BicycleLanes};

use super::is_even;

const LANES: &str = "highway=tertiary lanes=2 cycleway:both=lane";

/// Four roads with these tags that meet: from the west, to the east, from the south, to the north.
fn crossing(side: DrivingSide, bicycle_lanes: BicycleLanes, [west, east, south, north]: [&str; 4]) -> Built {
    let beside = BesideSettings { bicycle_lanes, ..BesideSettings::default() };
    let options = BuildOptions { beside, ..driven_on(side) };
    let middle = (1, 0.0, 0.0, "highway=traffic_signals");
    let nodes = [middle, (2, -80.0, 0.0, ""), (3, 80.0, 0.0, ""), (4, 0.0, -80.0, ""), (5, 0.0, 80.0, "")];
    let ways: [(i64, &[i64], &str); 4] =
        [(10, &[2, 1], west), (11, &[1, 3], east), (12, &[4, 1], south), (13, &[1, 5], north)];
    built_as(&Asked { nodes: &nodes, ways: &ways, options })
}

fn inside<'a>(map: &'a LaneletMap, subtype: &str) -> Vec<&'a Lanelet> {
    let inside = |l: &&Lanelet| l.attributes.has("intersection_area") && l.attributes.is("subtype", subtype);
    map.lanelets.iter().filter(inside).collect()
}

#[test]
fn bicycles_ride_straight_on_and_around_the_near_corner() {
    for (side, near) in [(DrivingSide::Right, "right"), (DrivingSide::Left, "left")] {
        let built = crossing(side, BicycleLanes::BicycleLane, [LANES; 4]);
        let map = &built.map;
        let lanelets = inside(map, "bicycle_lane");
        let turn = |turn: &str| lanelets.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", turn)).count();
        assert_eq!((lanelets.len(), turn("straight"), turn(near)), (8, 4, 4));
        let area = map.polygons.iter().next().unwrap();
        for lanelet in lanelets {
            let [start, end] = ends(map, lanelet);
            assert!(start.iter().chain(&end).all(|node| area.points.contains(node)));
            let own = |other: &&Lanelet| other.id != lanelet.id && ends(map, other)[1] == start;
            let before: Vec<&Lanelet> = map.lanelets.iter().filter(own).collect();
            assert!(!before.is_empty() && before.iter().all(|lane| lane.attributes.is("subtype", "bicycle_lane")));
        }
        assert!(built.settings.bicycle_lanes.is_empty());
    }
}

#[test]
fn nothing_leads_to_a_road_without_bicycle_lanes() {
    let map =
        crossing(DrivingSide::Right, BicycleLanes::BicycleLane, [LANES, LANES, LANES, "highway=tertiary lanes=2"]).map;
    // West and east straight on, and around the two corners in the south.
    assert_eq!(inside(&map, "bicycle_lane").len(), 4);
    let none = crossing(DrivingSide::Right, BicycleLanes::None, [LANES; 4]).map;
    assert!(none.lanelets.iter().all(|lanelet| !lanelet.attributes.is("subtype", "bicycle_lane")));
}

#[test]
fn bicycle_lanes_as_roads_have_lights_and_near_turns_yield_to_them() {
    for side in [DrivingSide::Right, DrivingSide::Left] {
        let built = crossing(side, BicycleLanes::Road, [LANES; 4]);
        let bicycles = &built.settings.bicycle_lanes;
        let (own, cars): (Vec<&Lanelet>, Vec<&Lanelet>) =
            inside(&built.map, "road").into_iter().partition(|lanelet| bicycles.contains(&lanelet.id.0));
        assert_eq!((own.len(), cars.len(), bicycles.len()), (8, 12, 16));
        let elements = |lanelet: &Lanelet, subtype: &str| -> Vec<_> {
            let all = lanelet.regulatory_elements.iter().filter_map(|id| built.map.regulatory_elements.get(*id));
            all.filter(|element| element.subtype == *subtype).collect()
        };
        assert!(own.iter().all(|lanelet| elements(lanelet, "traffic_light").len() == 1));
        let near = if side == DrivingSide::Right { "right" } else { "left" };
        for turn in cars.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", near)) {
            let rights = elements(turn, "right_of_way");
            let yields = rights.iter().flat_map(|element| element.lanelets("yield"));
            assert!(yields.filter(|id| own.iter().any(|lanelet| lanelet.id == *id)).count() >= 1);
        }
    }
}

/// The turns that bicycles have through an intersection, sorted.
fn turns<'a>(lanelets: &[&'a Lanelet]) -> Vec<&'a str> {
    let mut turns: Vec<&str> = lanelets.iter().filter_map(|lanelet| lanelet.attributes.get("turn_direction")).collect();
    turns.sort_unstable();
    turns
}

#[test]
fn two_way_bicycle_lanes_lead_through_in_both_directions() {
    for (side, far) in [(DrivingSide::Right, "left"), (DrivingSide::Left, "right")] {
        for (lanes, subtype) in [(BicycleLanes::BicycleLane, "bicycle_lane"), (BicycleLanes::Road, "road")] {
            let tags = format!("highway=tertiary lanes=2 cycleway:{far}=track cycleway:{far}:oneway=no");
            let Built { map, settings, .. } = crossing(side, lanes, [&tags; 4]);
            let for_bicycles =
                |lanelet: &&Lanelet| subtype == "bicycle_lane" || settings.bicycle_lanes.contains(&lanelet.id.0);
            let inside: Vec<&Lanelet> = inside(&map, subtype).into_iter().filter(for_bicycles).collect();
            // Straight on over both roads, and around the one corner that both tracks touch, all to and fro.
            assert_eq!(turns(&inside), ["left", "right", "straight", "straight", "straight", "straight"], "{side:?}");
            let bicycles: Vec<&Lanelet> =
                map.lanelets.iter().filter(|l| l.attributes.is("subtype", subtype)).filter(for_bicycles).collect();
            assert_eq!(bicycles.len(), 8 + 6);
            for lanelet in &bicycles {
                assert!(lanelet.attributes.is("one_way", "yes"));
                let against =
                    |other: &&&Lanelet| (other.left.line, other.right.line) == (lanelet.right.line, lanelet.left.line);
                assert_eq!(bicycles.iter().filter(against).count(), 1, "another runs against it on the same bounds");
                let (begin, end) = (ends(&map, lanelet)[0], ends(&map, lanelet)[1]);
                if lanelet.attributes.has("turn_direction") {
                    let before = bicycles.iter().filter(|other| ends(&map, other)[1] == begin);
                    let behind = bicycles.iter().filter(|other| ends(&map, other)[0] == end);
                    assert_eq!((before.count(), behind.count()), (1, 1));
                }
            }
        }
    }
}

#[test]
fn no_bicycle_lanelet_crosses_the_traffic() {
    // West of the crossing bicycles ride both ways on the far side, elsewhere on the near sides.
    for (side, far) in [(DrivingSide::Right, "left"), (DrivingSide::Left, "right")] {
        let west = format!("highway=tertiary lanes=2 cycleway:{far}=lane cycleway:{far}:oneway=no");
        let map = crossing(side, BicycleLanes::BicycleLane, [&west, LANES, LANES, LANES]).map;
        let lanelets = inside(&map, "bicycle_lane");
        // To the west straight on and around the corner; between the other three as usual.
        let near = if side == DrivingSide::Right { "right" } else { "left" };
        let mut expected = vec![near; 3];
        expected.extend(["straight"; 3]);
        expected.sort_unstable();
        assert_eq!(turns(&lanelets), expected, "{side:?}");
    }
}

#[test]
fn bicycle_lanes_lead_through_merged_intersections_in_both_directions() {
    // A road of two carriageways 12 m apart, merged with the piece of the crossing road between them.
    let main = |track: &str| format!("highway=secondary oneway=yes lanes=2 name=Main {track}");
    for (side, north, near) in [(DrivingSide::Right, 6.0, "right"), (DrivingSide::Left, -6.0, "left")] {
        for (ridden, straight) in [("yes", 4), ("no", 6)] {
            let main = main(&format!("cycleway:{near}=track cycleway:{near}:oneway={ridden}"));
            let nodes = [
                (1, 0.0, -north, "highway=traffic_signals"),
                (2, 0.0, north, "highway=traffic_signals"),
                (3, -100.0, -north, ""),
                (4, 100.0, -north, ""),
                (5, -100.0, north, ""),
                (6, 100.0, north, ""),
                (7, 0.0, -15.0 * north, ""),
                (8, 0.0, 15.0 * north, ""),
            ];
            let ways: [(i64, &[i64], &str); 7] = [
                (10, &[3, 1], &main),
                (11, &[1, 4], &main),
                (12, &[6, 2], &main),
                (13, &[2, 5], &main),
                (14, &[7, 1], LANES),
                (15, &[1, 2], LANES),
                (16, &[2, 8], LANES),
            ];
            let built = built_as(&Asked { nodes: &nodes, ways: &ways, options: driven_on(side) });
            assert_eq!(built.summary.intersections, 1, "merged");
            let lanelets = inside(&built.map, "bicycle_lane");
            let mut expected = vec![near; 4];
            expected.extend(vec!["straight"; straight]);
            assert_eq!(turns(&lanelets), expected, "{side:?} {ridden}");
        }
    }
}

#[test]
fn a_track_lies_behind_a_kerb() {
    for side in [DrivingSide::Right, DrivingSide::Left] {
        let kerb = "highway=tertiary lanes=2 cycleway:both=lane cycleway:both:separation=kerb";
        for (tags, between) in [
            ("highway=tertiary lanes=2 cycleway:both=track", "road_border"),
            (kerb, "road_border"),
            (LANES, "line_thin"),
        ] {
            let nodes = [(1, 0.0, 0.0, ""), (2, 80.0, 0.0, "")];
            let map = built_as(&Asked { nodes: &nodes, ways: &[(10, &[1, 2], tags)], options: driven_on(side) }).map;
            let of = |subtype: &'static str| map.lanelets.iter().filter(move |l| l.attributes.is("subtype", subtype));
            assert_eq!((of("bicycle_lane").count(), of("road").count()), (2, 2));
            for bicycle in of("bicycle_lane") {
                let own = [bicycle.left.line, bicycle.right.line];
                let shared = of("road").flat_map(|road| [road.left.line, road.right.line]).find(|id| own.contains(id));
                let line = map.linestrings.get(shared.unwrap()).unwrap();
                assert!(line.attributes.is("type", between) && line.attributes.is("lane_change", "no"), "{tags}");
            }
        }
    }
}

#[test]
fn a_lanelet_that_is_squeezed_or_swells_is_uneven() {
    let line = |places: &[[f64; 2]]| places.iter().map(|[x, y]| Point::new(*x, *y)).collect::<Vec<_>>();
    let right = line(&[[0.0, 0.0], [20.0, 0.0]]);
    for (middle, even) in [(1.5, true), (1.0, true), (2.0, true), (0.5, false), (3.0, false)] {
        assert_eq!(is_even([&line(&[[0.0, 1.5], [10.0, middle], [20.0, 1.5]]), &right]), even, "{middle} m wide");
    }
    let taper = line(&[[0.0, 1.0], [20.0, 3.0]]);
    assert!(is_even([&taper, &right]), "a linear change from end to end");
}
