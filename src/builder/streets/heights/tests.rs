//! Heights of hand-written networks.

use std::sync::Arc;

use crate::builder::network::{RoadIx, Stations, hand_drawn};
use crate::geometry::Point;

use super::options::{STOREY, Surface};
use super::surface::eased;
use super::*;

/// A way: its id, its nodes, its tags.
type Way<'a> = (i64, &'a [i64], &'a [(&'a str, &'a str)]);

/// The network of nodes with a height, if known, and ways.
fn network(nodes: &[(i64, f64, f64, Option<f64>)], ways: &[Way<'_>]) -> (RoadNetwork, ElevationTags) {
    let ele = nodes.iter().map(|node| node.3.map_or_else(String::new, |ele| format!("ele={ele}")));
    let ele: Vec<String> = ele.collect();
    let nodes: Vec<_> = nodes.iter().zip(&ele).map(|((id, x, y, _), ele)| (*id, *x, *y, ele.as_str())).collect();
    let tags = ways.iter().map(|way| way.2.iter().map(|(k, v)| format!("{k}={v} ")).collect());
    let tags: Vec<String> = tags.collect();
    let ways: Vec<_> = ways.iter().zip(&tags).map(|((id, nodes, _), tags)| (*id, *nodes, tags.as_str())).collect();
    let osm = hand_drawn::osm(&nodes, &ways);
    (hand_drawn::network(&osm), elevation_tags(&osm, &hand_drawn::plane, |_| true, true))
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

/// The network with heights, for uncut roads.
fn raise(network: RoadNetwork, options: &HeightOptions) -> (RoadNetwork, Vec<Finding>) {
    let kept: Vec<Stations> = network.roads.iter().map(|road| [0.0, road.line.length()]).collect();
    with_heights(network, &kept, options)
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
    let (network, findings) = raise(overpass(), &HeightOptions::default());
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
    let (up, _) = raise(overpass(), &HeightOptions::default());
    let (down, _) = raise(deep, &HeightOptions::default());
    for (a, b) in up.roads.iter().zip(&down.roads) {
        let mirrored: Vec<f64> = b.heights.iter().map(|height| 0.0 - height).collect();
        assert!(a.heights.iter().zip(&mirrored).all(|(a, b)| (a - b).abs() < 1e-9), "{:?} {mirrored:?}", a.heights);
    }
}

#[test]
fn a_tunnel_keeps_a_storey_below_the_road_over_it_although_their_lines_do_not_cross() {
    // The road goes down to an underpass; a longer tunnel, 3 m beside its line, runs on below both.
    let nodes = [
        (1, 0.0, 0.0, None),
        (2, 1000.0, 0.0, None),
        (3, 1040.0, 0.0, None),
        (4, 1400.0, 0.0, None),
        (5, -600.0, -3.0, None),
        (6, 990.0, -3.0, None),
        (7, 1400.0, -400.0, None),
    ];
    let ways: [Way<'_>; 4] = [
        (10, &[1, 2], &[("highway", "primary")]),
        (11, &[2, 3], &[("highway", "primary"), ("tunnel", "yes")]),
        (12, &[3, 4], &[("highway", "primary")]),
        (13, &[5, 6, 7], &[("highway", "motorway"), ("tunnel", "yes"), ("oneway", "yes")]),
    ];
    let (network, findings) = raise(network(&nodes, &ways).0, &HeightOptions::default());
    assert!(findings.iter().all(|finding| finding.fault != "clearance-short"), "{findings:?}");
    let [primary, tunnel] = [10, 13].map(|way| road(&network, way));
    for station in (50..980).step_by(10).map(f64::from) {
        let room = height(primary, station) - height(tunnel, station + 600.0);
        assert!(room > STOREY - LACKING, "{room} m between them at {station}");
    }
}

#[test]
fn a_ramp_beside_its_road_is_not_lifted_over_it() {
    // Both leave one node, the ramp on to a bridge.
    let nodes = [
        (1, 0.0, 0.0, None),
        (2, 300.0, 0.0, None),
        (3, 700.0, 0.0, None),
        (4, 450.0, 6.0, None),
        (5, 700.0, 60.0, None),
    ];
    let ways: [Way<'_>; 4] = [
        (10, &[1, 2], &[("highway", "primary")]),
        (11, &[2, 3], &[("highway", "primary")]),
        (12, &[2, 4], &[("highway", "primary"), ("oneway", "yes")]),
        (13, &[4, 5], &[("highway", "primary"), ("oneway", "yes"), ("bridge", "yes")]),
    ];
    let (network, findings) = raise(network(&nodes, &ways).0, &HeightOptions::default());
    assert!(findings.is_empty(), "{findings:?}");
    assert!(road(&network, 11).heights.iter().all(|height| height.abs() < 0.05));
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
    let (network, findings) = raise(network(&nodes, &ways).0, &HeightOptions::default());
    assert!(findings.is_empty(), "{findings:?}");
    let crossing = STOREY - 0.08 * (40.0 - 2.0 * 6.0);
    for (way, station) in [(11, 40.0), (12, 0.0), (13, 0.0)] {
        let found = height(road(&network, way), station);
        assert!((found - crossing).abs() < 0.03, "{way}: {found}");
    }
    assert_eq!(height(road(&network, 13), 300.0), 0.0);
}

#[test]
fn a_climb_without_room_is_spread_over_the_roads_around() {
    // 30 m of street between a bridge and a tunnel, 12 m of height.
    let nodes = [(1, 0.0, 0.0, None), (2, 160.0, 0.0, None), (3, 190.0, 0.0, None), (4, 350.0, 0.0, None)];
    let street = ("highway", "tertiary");
    let ways: [Way<'_>; 3] = [
        (10, &[1, 2], &[street, ("bridge", "yes")]),
        (11, &[2, 3], &[street]),
        (12, &[3, 4], &[street, ("tunnel", "yes")]),
    ];
    let (network, findings) = raise(network(&nodes, &ways).0, &HeightOptions::default());
    assert_eq!(findings.iter().map(|f| f.fault).collect::<Vec<_>>(), ["grade-held"; 3]);
    let [bridge, between, tunnel] = [10, 11, 12].map(|way| road(&network, way));
    for road in [bridge, between, tunnel] {
        assert!(steepest(road) <= 0.08 * 1.05, "{} {}", road.key, steepest(road));
    }
    assert!(
        (height(bridge, 160.0) - 1.2).abs() < 0.05,
        "half of the climb that 30 m allow, not {}",
        height(bridge, 160.0)
    );
    assert!((height(tunnel, 0.0) + 1.2).abs() < 0.05);
    assert_eq!((height(bridge, 80.0), height(tunnel, 80.0)), (STOREY, -STOREY), "far away nothing changes");
}

/// A road on ground that rises by `rise` metres under a bridge.
fn under_a_bridge(rise: f64) -> (RoadNetwork, Vec<Finding>) {
    let known = overpass();
    let terrain: Arc<Surface> = Arc::new(move |places: &[Point]| {
        places
            .iter()
            .map(|p| Some(50.0 + if p.y.abs() < 30.0 && (p.x - 430.0).abs() < 5.0 { rise } else { 0.0 }))
            .collect()
    });
    raise(known, &HeightOptions { terrain: Some(terrain), ..HeightOptions::default() })
}

#[test]
fn terrain_too_steep_for_a_road_is_flattened_and_the_bridge_keeps_its_clearance() {
    let (network, findings) = under_a_bridge(20.0);
    assert!(findings.iter().all(|finding| finding.fault == "grade-held"), "{findings:?}");
    let [west, bridge, under] = [10, 11, 13].map(|way| road(&network, way));
    assert!(steepest(under) <= 0.3 * 1.05, "{}", steepest(under));
    assert!(steepest(west) <= 0.07 * 1.05, "{}", steepest(west));
    let room = height(bridge, 30.0) - height(under, 300.0);
    assert!(room > STOREY - LACKING, "{room}");
    assert_eq!(height(under, 0.0), 50.0);
}

#[test]
fn a_crossing_without_room_to_climb_gets_less_clearance_and_a_finding() {
    // The upper road leaves the lower one and crosses it after 30 m: too short to climb 6 m.
    let nodes = [
        (1, 0.0, 0.0, None),
        (2, 100.0, 0.0, None),
        (3, 100.0, 10.0, None),
        (4, 90.0, 10.0, None),
        (5, 90.0, -10.0, None),
    ];
    let street = ("highway", "tertiary");
    let ways: [Way<'_>; 2] =
        [(10, &[1, 2], &[street]), (11, &[2, 3, 4, 5], &[street, ("bridge", "yes"), ("layer", "1")])];
    let (network, findings) = raise(network(&nodes, &ways).0, &HeightOptions::default());
    let faults: Vec<_> = findings.iter().map(|f| f.fault).collect();
    assert!(faults.contains(&"clearance-short"), "{faults:?}");
    assert!(network.roads.iter().all(|road| steepest(road) <= 0.08 * 1.05), "the grades hold");
    let room = height(road(&network, 11), 30.0) - height(road(&network, 10), 90.0);
    assert!(room > 2.0, "{room}");
}

#[test]
fn the_user_may_limit_the_grade_of_roads() {
    let slope: Arc<Surface> =
        Arc::new(|places: &[Point]| places.iter().map(|p| Some((p.x.clamp(100.0, 300.0) - 100.0) * 0.25)).collect());
    let nodes = [(1, 0.0, 0.0, None), (2, 400.0, 0.0, None)];
    let ways: [Way<'_>; 1] = [(10, &[1, 2], &[("highway", "residential")])];
    let options = HeightOptions { terrain: Some(slope), steepest: Some(0.2), ..HeightOptions::default() };
    let (network, _) = raise(network(&nodes, &ways).0, &options);
    assert!((0.19..=0.21).contains(&steepest(&network.roads[0])), "{}", steepest(&network.roads[0]));
}

#[test]
fn known_heights_hold_and_are_interpolated() {
    let nodes =
        [(1, 0.0, 0.0, Some(10.0)), (2, 200.0, 0.0, None), (3, 400.0, 0.0, Some(20.0)), (4, 200.0, 300.0, None)];
    let street = ("highway", "tertiary");
    let ways: [Way<'_>; 2] = [(10, &[1, 2, 3], &[street]), (11, &[2, 4], &[street])];
    let (network, known) = network(&nodes, &ways);
    let (network, _) = raise(network, &HeightOptions { spots: known, ..HeightOptions::default() });
    let [west, side] = [10, 11].map(|way| road(&network, way));
    assert_eq!(height(west, 0.0), 10.0);
    assert!((height(west, 100.0) - 12.5).abs() < 0.05, "{}", height(west, 100.0));
    assert!((height(side, 0.0) - 15.0).abs() < 0.05);
    assert!((height(side, 300.0) - 15.0).abs() < 0.3, "{}", height(side, 300.0));
}

#[test]
fn terrain_is_followed_but_not_under_a_bridge() {
    // A valley under the bridge has enough clearance.
    let valley = |places: &[Point]| -> Vec<Option<f64>> {
        places.iter().map(|p| Some(if (405.0..455.0).contains(&p.x) { 80.0 } else { 100.0 + p.x * 0.01 })).collect()
    };
    let terrain: Arc<Surface> = Arc::new(valley);
    let (network, _) = raise(overpass(), &HeightOptions { terrain: Some(terrain), ..HeightOptions::default() });
    let [west, bridge, under] = [10, 11, 13].map(|way| road(&network, way));
    assert!((height(west, 200.0) - 102.0).abs() < 0.05);
    assert!((height(bridge, 30.0) - 104.3).abs() < 0.05, "{}", height(bridge, 30.0));
    assert!((height(under, 300.0) - 80.0).abs() < 0.05);
    // On flat ground the bridge must be raised.
    let flat: Arc<Surface> = Arc::new(|places: &[Point]| vec![Some(50.0); places.len()]);
    let (network, _) = raise(overpass(), &HeightOptions { terrain: Some(flat), ..HeightOptions::default() });
    assert!((height(road(&network, 11), 30.0) - 56.0).abs() < 1e-3);
}

/// Two streets that leave node 2 side by side, of which one climbs to a bridge 90 m from there.
fn beside_a_ramp() -> RoadNetwork {
    let nodes = [
        (1, -100.0, 0.0, None),
        (2, 0.0, 0.0, None),
        (3, 90.0, 9.0, None),
        (4, 300.0, 30.0, None),
        (5, 400.0, -40.0, None),
    ];
    let street = ("highway", "tertiary");
    let ways: [Way<'_>; 4] = [
        (10, &[1, 2], &[street]),
        (11, &[2, 3], &[street]),
        (12, &[3, 4], &[street, ("bridge", "yes")]),
        (13, &[2, 5], &[street]),
    ];
    raise(network(&nodes, &ways).0, &HeightOptions::default()).0
}

#[test]
fn roads_cut_back_farther_than_their_outlines_end_without_a_step() {
    let mut network = beside_a_ramp();
    let at = |way: i64| network.roads.iter().position(|road| road.key.way == way).unwrap();
    let (ramp, beside) = (at(11), at(13));
    let mut kept: Vec<Stations> = network.roads.iter().map(|road| [0.0, road.line.length()]).collect();
    kept[ramp][0] = 45.0;
    kept[beside][0] = 45.0;
    let step =
        |network: &RoadNetwork| (height(&network.roads[ramp], 45.0) - height(&network.roads[beside], 45.0)).abs();
    assert!(step(&network) > 1.5, "{}", step(&network));
    let before = network.clone();
    let changed = level_at_cuts(&mut network, &kept, &HeightOptions::default());
    assert!(changed.contains(&RoadIx::new(ramp)) && changed.contains(&RoadIx::new(beside)), "{changed:?}");
    // Their kerbs are less than 3 m apart there.
    assert!(step(&network) < 0.3, "{}", step(&network));
    assert!(network.roads.iter().all(|road| steepest(road) <= 0.08 * 1.05), "the grades hold");
    for (way, station) in [(10, 0.0), (12, 200.0), (13, 400.0)] {
        let [old, new] = [&before, &network].map(|network| height(road(network, way), station));
        assert!((old - new).abs() < 1e-9, "{way}: far away nothing changes");
    }
}

#[test]
fn roads_without_a_step_between_their_ends_stay_as_they_are() {
    let mut network = beside_a_ramp();
    let kept: Vec<Stations> = network.roads.iter().map(|road| [0.0, road.line.length()]).collect();
    assert!(level_at_cuts(&mut network, &kept, &HeightOptions::default()).is_empty());
}

#[test]
fn a_bound_climbs_no_more_than_it_must() {
    let stations = [0.0, 10.0, 10.2, 20.0, 30.0];
    // Inside a bend: 1 m of height between two places 0.2 m apart.
    let heights = eased(&stations, vec![0.0, 1.0, 2.0, 3.0, 3.5]);
    for (s, h) in stations.windows(2).zip(heights.windows(2)) {
        assert!((h[1] - h[0]).abs() <= 0.46 * (s[1] - s[0]), "{heights:?}");
    }
    assert_eq!([heights[0], heights[3], heights[4]], [0.0, 3.0, 3.5], "level parts stay");
    assert_eq!(eased(&[0.0, 1.0, 2.0], vec![0.0, 5.0, 2.0]), [0.0, 1.0, 2.0], "the grade between the ends is steeper");
}

#[test]
fn flat_ground_gives_no_heights() {
    let nodes = [(1, 0.0, 0.0, None), (2, 100.0, 0.0, None)];
    let ways: [Way<'_>; 1] = [(10, &[1, 2], &[("highway", "tertiary")])];
    let (flat, _) = raise(network(&nodes, &ways).0, &HeightOptions::default());
    assert!(flat.roads[0].heights.is_empty());
    let (lifted, _) = raise(network(&nodes, &ways).0, &HeightOptions { ground: 40.0, ..HeightOptions::default() });
    assert_eq!(lifted.roads[0].heights, [40.0, 40.0]);
}

#[test]
fn between_places_on_a_plane_the_ground_is_that_plane() {
    let known = [(0.0, 0.0, 1.0), (10.0, 0.0, 3.0), (10.0, 8.0, 3.0), (0.0, 8.0, 1.0)];
    let ground = Ground::between(known.map(|(x, y, h)| (Point::new(x, y), h)).to_vec());
    assert_eq!(ground.at(Point::new(0.0, 0.0)), 1.0);
    assert!((ground.at(Point::new(5.0, 3.0)) - 2.0).abs() < 2e-3);
    assert!((ground.at(Point::new(2.5, 7.0)) - 1.5).abs() < 2e-3);
    let row = Ground::between(vec![(Point::new(0.0, 0.0), 1.0), (Point::new(10.0, 0.0), 3.0)]);
    assert!((row.at(Point::new(5.0, 5.0)) - 2.0).abs() < 0.01, "level across collinear places");
}

#[test]
fn differences_from_the_plane_are_interpolated_by_distance() {
    let known = [(0.0, 0.0, 1.0), (10.0, 0.0, 0.0), (10.0, 10.0, 1.0), (0.0, 10.0, 0.0)];
    let ground = Ground::between(known.map(|(x, y, h)| (Point::new(x, y), h)).to_vec());
    assert_eq!(ground.at(Point::new(10.0, 10.0)), 1.0);
    assert_eq!(ground.at(Point::new(5.0, 5.0)), 0.5);
    assert!(ground.at(Point::new(1.0, 1.0)) > 0.9);
}
