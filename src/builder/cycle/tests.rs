//! Bicycle lanes through intersections, on small networks.

use crate::builder::road_network::DrivingSide;
use crate::builder::tests::{Asked, built_as, ends};
use crate::builder::{BuildOptions, Built};
use crate::lanelet::{Lanelet, LaneletMap};
use crate::settings::{BesideSettings, BicycleLanes};

const LANES: &str = "highway=tertiary lanes=2 cycleway:both=lane";

/// A crossing of four roads with bicycle lanes, the last with these tags instead.
fn crossing(side: DrivingSide, last: &str, lanes: BicycleLanes) -> Built {
    let beside = BesideSettings { bicycle_lanes: lanes, ..BesideSettings::default() };
    let options = BuildOptions { driving_side: Some(side), beside, ..BuildOptions::default() };
    let nodes = [
        (1, 0.0, 0.0, "highway=traffic_signals"),
        (2, -80.0, 0.0, ""),
        (3, 80.0, 0.0, ""),
        (4, 0.0, -80.0, ""),
        (5, 0.0, 80.0, ""),
    ];
    let ways: [(i64, &[i64], &str); 4] =
        [(10, &[2, 1], LANES), (11, &[1, 3], LANES), (12, &[4, 1], LANES), (13, &[1, 5], last)];
    built_as(&Asked { nodes: &nodes, ways: &ways, options })
}

fn inside<'a>(map: &'a LaneletMap, subtype: &str) -> Vec<&'a Lanelet> {
    let inside = |l: &&Lanelet| l.attributes.has("intersection_area") && l.attributes.is("subtype", subtype);
    map.lanelets.iter().filter(inside).collect()
}

#[test]
fn bicycles_ride_straight_on_and_around_the_near_corner() {
    for (side, near) in [(DrivingSide::Right, "right"), (DrivingSide::Left, "left")] {
        let built = crossing(side, LANES, BicycleLanes::BicycleLane);
        let map = &built.map;
        let ways = inside(map, "bicycle_lane");
        let turn = |turn: &str| ways.iter().filter(|way| way.attributes.is("turn_direction", turn)).count();
        assert_eq!((ways.len(), turn("straight"), turn(near)), (8, 4, 4));
        let area = map.polygons.iter().next().unwrap();
        for way in ways {
            let [start, end] = ends(map, way);
            assert!(start.iter().chain(&end).all(|node| area.points.contains(node)));
            let own = |lanelet: &&Lanelet| lanelet.id != way.id && ends(map, lanelet)[1] == start;
            let before: Vec<&Lanelet> = map.lanelets.iter().filter(own).collect();
            assert!(!before.is_empty() && before.iter().all(|lane| lane.attributes.is("subtype", "bicycle_lane")));
        }
        assert!(built.settings.bicycle_lanes.is_empty());
    }
}

#[test]
fn where_the_bicycle_lane_ends_nothing_leads_on() {
    let map = crossing(DrivingSide::Right, "highway=tertiary lanes=2", BicycleLanes::BicycleLane).map;
    // West and east straight on, and around the two corners in the south.
    assert_eq!(inside(&map, "bicycle_lane").len(), 4);
    let none = crossing(DrivingSide::Right, LANES, BicycleLanes::None).map;
    assert!(none.lanelets.iter().all(|lanelet| !lanelet.attributes.is("subtype", "bicycle_lane")));
}

#[test]
fn as_roads_they_have_lights_and_near_turns_yield_to_them() {
    for side in [DrivingSide::Right, DrivingSide::Left] {
        let built = crossing(side, LANES, BicycleLanes::Road);
        let bicycles = &built.settings.bicycle_lanes;
        let (own, cars): (Vec<&Lanelet>, Vec<&Lanelet>) =
            inside(&built.map, "road").into_iter().partition(|lanelet| bicycles.contains(&lanelet.id.0));
        assert_eq!((own.len(), cars.len(), bicycles.len()), (8, 12, 16));
        let elements = |lanelet: &Lanelet, subtype: &str| -> Vec<_> {
            let all = lanelet.regulatory_elements.iter().filter_map(|id| built.map.regulatory_elements.get(*id));
            all.filter(|element| element.subtype == *subtype).collect()
        };
        assert!(own.iter().all(|way| elements(way, "traffic_light").len() == 1));
        let near = if side == DrivingSide::Right { "right" } else { "left" };
        for turn in cars.iter().filter(|way| way.attributes.is("turn_direction", near)) {
            let rights = elements(turn, "right_of_way");
            let yields = rights.iter().flat_map(|element| element.lanelets("yield"));
            assert!(yields.filter(|id| own.iter().any(|way| way.id == *id)).count() >= 1);
        }
    }
}
