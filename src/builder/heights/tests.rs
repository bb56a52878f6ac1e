//! Heights of hand-written networks.

use super::*;
use crate::builder::road_network::{NetworkOptions, road_network};
use crate::osm::{OsmData, read_bytes};
use crate::projection::LonLat;

/// Metres east and north of a corner of the world where a degree is as long as this.
const DEGREE: f64 = 1e5;

/// A way: its id, its nodes, its tags.
type Way<'a> = (i64, &'a [i64], &'a [(&'a str, &'a str)]);

/// Ways through nodes; a node is a place in metres and a height, if known.
fn network(nodes: &[(i64, f64, f64, Option<f64>)], ways: &[Way<'_>]) -> (RoadNetwork, Spots) {
    let mut text = String::from("<osm version='0.6'>");
    for (id, x, y, ele) in nodes {
        let tag = ele.map_or_else(String::new, |ele| format!("<tag k='ele' v='{ele}'/>"));
        text += &format!("<node id='{id}' lat='{:.9}' lon='{:.9}'>{tag}</node>", y / DEGREE, x / DEGREE);
    }
    for (id, refs, tags) in ways {
        text += &format!("<way id='{id}'>");
        refs.iter().for_each(|node| text += &format!("<nd ref='{node}'/>"));
        tags.iter().for_each(|(k, v)| text += &format!("<tag k='{k}' v='{v}'/>"));
        text += "</way>";
    }
    text += "</osm>";
    let mut osm = OsmData::default();
    read_bytes(&mut osm, "test", text.into_bytes()).unwrap();
    let metres = |places: &[LonLat]| -> Vec<Point> {
        places.iter().map(|place| Point::new(place.lon * DEGREE, place.lat * DEGREE)).collect()
    };
    let options =
        NetworkOptions { driving_side: Some(crate::builder::road_network::DrivingSide::Right), country: None };
    (road_network(&osm, &metres, &options).unwrap().network, spots(&osm, &metres))
}

/// A road along x from 0 to 1000 m with a bridge from 400 to 460 m, and a road under it.
fn overpass() -> RoadNetwork {
    let nodes = [
        (1, 0.0, 0.0, None),
        (2, 400.0, 0.0, None),
        (3, 460.0, 0.0, None),
        (4, 1000.0, 0.0, None),
        (5, 430.0, -300.0, None),
        (6, 430.0, 300.0, None),
    ];
    let road = ("highway", "primary");
    let ways: [Way<'_>; 4] = [
        (10, &[1, 2], &[road]),
        (11, &[2, 3], &[road, ("bridge", "yes"), ("layer", "1")]),
        (12, &[3, 4], &[road]),
        (13, &[5, 6], &[("highway", "residential")]),
    ];
    network(&nodes, &ways).0
}

/// The network at its height, no road of it cut back.
fn laid(network: RoadNetwork, options: &HeightOptions) -> (RoadNetwork, Vec<Finding>) {
    let kept: Vec<[f64; 2]> = network.roads.iter().map(|road| [0.0, road.line.length()]).collect();
    raised(network, &kept, options)
}

fn road(network: &RoadNetwork, way: i64) -> &Road {
    network.roads.iter().find(|road| road.key.way == way).unwrap()
}

fn height(road: &Road, station: f64) -> f64 {
    Ground::under(road).at(road.line.at(station))
}

fn steepest(road: &Road) -> f64 {
    let stations = road.line.stations();
    let climbs = stations.windows(2).zip(road.heights.windows(2));
    climbs.map(|(s, h)| ((h[1] - h[0]) / (s[1] - s[0])).abs()).fold(0.0, f64::max)
}

#[test]
fn a_bridge_lies_a_storey_up_and_the_road_climbs_there_within_its_grade() {
    let (network, findings) = laid(overpass(), &HeightOptions::default());
    assert!(findings.is_empty(), "{findings:?}");
    let [west, bridge, east, under] = [10, 11, 12, 13].map(|way| road(&network, way));
    for station in [0.0, 30.0, 60.0] {
        assert_eq!(height(bridge, station), STOREY);
    }
    assert_eq!((height(west, 0.0), height(west, 400.0)), (0.0, STOREY));
    assert_eq!((height(east, 0.0), height(east, 540.0)), (STOREY, 0.0));
    assert!(under.heights.iter().all(|height| *height == 0.0));
    assert!(steepest(west) <= 0.07 + 1e-6, "{}", steepest(west));
    assert!(west.heights.windows(2).all(|h| h[1] >= h[0] - 1e-9), "it climbs all the way");
}

#[test]
fn a_tunnel_mirrors_a_bridge() {
    let mut deep = overpass();
    deep.roads.iter_mut().for_each(|road| road.level = -road.level);
    let (up, _) = laid(overpass(), &HeightOptions::default());
    let (down, _) = laid(deep, &HeightOptions::default());
    for (a, b) in up.roads.iter().zip(&down.roads) {
        let mirrored: Vec<f64> = b.heights.iter().map(|height| 0.0 - height).collect();
        assert!(a.heights.iter().zip(&mirrored).all(|(a, b)| (a - b).abs() < 1e-9), "{:?} {mirrored:?}", a.heights);
    }
}

#[test]
fn a_ramp_goes_on_beyond_an_intersection_where_all_roads_have_its_height() {
    let nodes = [
        (1, 0.0, 0.0, None),
        (2, 60.0, 0.0, None),
        (3, 100.0, 0.0, None),
        (4, 500.0, 0.0, None),
        (5, 100.0, 300.0, None),
    ];
    let street = ("highway", "tertiary");
    let ways: [Way<'_>; 4] = [
        (10, &[1, 2], &[street, ("bridge", "yes")]),
        (11, &[2, 3], &[street]),
        (12, &[3, 4], &[street]),
        (13, &[3, 5], &[street]),
    ];
    let (network, findings) = laid(network(&nodes, &ways).0, &HeightOptions::default());
    assert!(findings.is_empty(), "{findings:?}");
    let crossing = STOREY - 0.08 * (40.0 - 2.0 * 6.0);
    for (way, station) in [(11, 40.0), (12, 0.0), (13, 0.0)] {
        let found = height(road(&network, way), station);
        assert!((found - crossing).abs() < 0.03, "{way}: {found}");
    }
    assert_eq!(height(road(&network, 13), 300.0), 0.0);
}

#[test]
fn a_ramp_without_room_is_told() {
    let nodes = [(1, 0.0, 0.0, None), (2, 60.0, 0.0, None), (3, 90.0, 0.0, None), (4, 150.0, 0.0, None)];
    let street = ("highway", "tertiary");
    let ways: [Way<'_>; 3] = [
        (10, &[1, 2], &[street, ("bridge", "yes")]),
        (11, &[2, 3], &[street]),
        (12, &[3, 4], &[street, ("tunnel", "yes")]),
    ];
    let (network, findings) = laid(network(&nodes, &ways).0, &HeightOptions::default());
    assert_eq!(findings.iter().map(|f| f.fault).collect::<Vec<_>>(), ["grade-steep"]);
    let between = road(&network, 11);
    assert_eq!((height(between, 0.0), height(between, 30.0)), (STOREY, -STOREY));
}

#[test]
fn known_heights_hold_and_what_lies_between_is_even() {
    let nodes =
        [(1, 0.0, 0.0, Some(10.0)), (2, 200.0, 0.0, None), (3, 400.0, 0.0, Some(20.0)), (4, 200.0, 300.0, None)];
    let street = ("highway", "tertiary");
    let ways: [Way<'_>; 2] = [(10, &[1, 2, 3], &[street]), (11, &[2, 4], &[street])];
    let (network, known) = network(&nodes, &ways);
    let (network, _) = laid(network, &HeightOptions { spots: known, ..HeightOptions::default() });
    let [west, side] = [10, 11].map(|way| road(&network, way));
    assert_eq!(height(west, 0.0), 10.0);
    assert!((height(west, 100.0) - 12.5).abs() < 0.05, "{}", height(west, 100.0));
    assert!((height(side, 0.0) - 15.0).abs() < 0.05);
    assert!((height(side, 300.0) - 15.0).abs() < 0.3, "{}", height(side, 300.0));
}

#[test]
fn terrain_is_followed_but_not_under_a_bridge() {
    // A valley under the bridge: no road needs more room than it has.
    let valley = |places: &[Point]| -> Vec<Option<f64>> {
        places.iter().map(|p| Some(if (405.0..455.0).contains(&p.x) { 80.0 } else { 100.0 + p.x * 0.01 })).collect()
    };
    let terrain: Arc<Surface> = Arc::new(valley);
    let (network, _) = laid(overpass(), &HeightOptions { terrain: Some(terrain), ..HeightOptions::default() });
    let [west, bridge, under] = [10, 11, 13].map(|way| road(&network, way));
    assert!((height(west, 200.0) - 102.0).abs() < 0.05);
    assert!((height(bridge, 30.0) - 104.3).abs() < 0.05, "{}", height(bridge, 30.0));
    assert!((height(under, 300.0) - 80.0).abs() < 0.05);
    // On flat ground the bridge must be raised.
    let flat: Arc<Surface> = Arc::new(|places: &[Point]| vec![Some(50.0); places.len()]);
    let (network, _) = laid(overpass(), &HeightOptions { terrain: Some(flat), ..HeightOptions::default() });
    assert!((height(road(&network, 11), 30.0) - 56.0).abs() < 1e-3);
}

#[test]
fn flat_ground_costs_nothing() {
    let nodes = [(1, 0.0, 0.0, None), (2, 100.0, 0.0, None)];
    let ways: [Way<'_>; 1] = [(10, &[1, 2], &[("highway", "tertiary")])];
    let (flat, _) = laid(network(&nodes, &ways).0, &HeightOptions::default());
    assert!(flat.roads[0].heights.is_empty());
    let (lifted, _) = laid(network(&nodes, &ways).0, &HeightOptions { ground: 40.0, ..HeightOptions::default() });
    assert_eq!(lifted.roads[0].heights, [40.0, 40.0]);
}

#[test]
fn between_known_places_the_nearest_counts_most() {
    let ground = Ground::between(vec![(Point::new(0.0, 0.0), 1.0), (Point::new(10.0, 0.0), 3.0)]);
    assert_eq!(ground.at(Point::new(0.0, 0.0)), 1.0);
    assert_eq!(ground.at(Point::new(5.0, 0.0)), 2.0);
    assert!(ground.at(Point::new(2.0, 0.0)) < 1.2);
}
