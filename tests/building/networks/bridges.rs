//! Bridges and tunnels that the input lacks.

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::lanelet::LaneletMap;

use super::{built, found, network_of};

/// A street of 400 m across another way of these tags and these ends, 200 m from its ends, and more ways.
fn crossed(street: &str, other: &str, ends: [(f64, f64); 2], more: &[(&str, f64)]) -> Built {
    let [from, to] = ends;
    let mut nodes = vec![(1, -200.0, 0.0, ""), (2, 200.0, 0.0, ""), (3, from.0, from.1, ""), (4, to.0, to.1, "")];
    let mut places: Vec<[i64; 2]> = Vec::new();
    for (i, (_, x)) in (5..).step_by(2).zip(more) {
        nodes.extend([(i, *x, -200.0, ""), (i + 1, *x, 200.0, "")]);
        places.push([i, i + 1]);
    }
    let mut ways: Vec<(i64, &[i64], &str)> = vec![(10, &[1, 2], street), (11, &[3, 4], other)];
    ways.extend((12..).zip(&places).zip(more).map(|((id, places), (tags, _))| (id, &places[..], *tags)));
    built(&network_of(DrivingSide::Right, &nodes, &ways), DrivingSide::Right, "")
}

/// The ways that are assumed to lie on a bridge or in a tunnel, each with that.
fn assumed(built: &Built) -> Vec<(i64, bool)> {
    let notes = built.notes.iter().filter(|note| note.fault == "bridge-assumed");
    let way = |message: &str| message.split("way ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok());
    notes.map(|note| (way(&note.message).unwrap(), note.message.contains("on a bridge"))).collect()
}

/// The largest and the smallest height of the lanes of a way, metres.
fn heights(map: &LaneletMap, way: &str) -> [f64; 2] {
    let own = map.lanelets.iter().filter(|it| it.attributes.get("road_id").is_some_and(|id| id.starts_with(way)));
    let heights = own.flat_map(|lanelet| map.bound_points(lanelet.left)).map(|point| point.ele().unwrap());
    heights.fold([f64::NEG_INFINITY, f64::INFINITY], |[most, least], height| [most.max(height), least.min(height)])
}

const NORTH: [(f64, f64); 2] = [(0.0, -200.0), (0.0, 200.0)];

#[test]
fn a_street_that_crosses_a_motorway_lies_on_a_bridge() {
    for motorway in ["highway=motorway lanes=3", "highway=trunk lanes=2 oneway=yes", "highway=motorway_link lanes=1"] {
        let built = crossed("highway=tertiary lanes=2", motorway, NORTH, &[]);
        assert_eq!(assumed(&built), [(10, true)], "{motorway}");
        assert_eq!(found(&built.map, &built.settings), Vec::<String>::new(), "{motorway}");
        let ([high, low], [motorway, _]) = (heights(&built.map, "10:"), heights(&built.map, "11:"));
        assert!(high - motorway > 4.5 && low < 0.5, "{high} {low} over {motorway}");
    }
}

#[test]
fn the_bridge_of_two_ways_at_one_level_lies_above() {
    let bridge = "highway=primary lanes=2 bridge=yes layer=1";
    let built = crossed(bridge, "highway=tertiary lanes=2 layer=1", NORTH, &[]);
    assert_eq!(assumed(&built), [(10, true)]);
    assert_eq!(found(&built.map, &built.settings), Vec::<String>::new());
}

#[test]
fn no_bridge_comes_to_the_level_of_another() {
    let street = "highway=tertiary lanes=2";
    // Above the motorway, beside the crossing, passes a bridge that has its tags.
    let built = crossed(street, "highway=motorway lanes=2", NORTH, &[("highway=primary lanes=2 bridge=yes", 15.0)]);
    assert_eq!(assumed(&built), [(11, false)], "the motorway lies in a tunnel");
    assert_eq!(found(&built.map, &built.settings), Vec::<String>::new());
}

#[test]
fn no_bridge_is_assumed_where_streets_can_meet_or_ways_lead_beside_each_other() {
    let ramp = [(-60.0, -15.0), (60.0, 15.0)];
    let street = "highway=tertiary lanes=2";
    for (other, ends) in [("highway=residential lanes=2", NORTH), ("highway=motorway_link lanes=1", ramp)] {
        assert_eq!(assumed(&crossed(street, other, ends, &[])), [], "{other}");
    }
    assert_eq!(assumed(&crossed(street, "highway=motorway lanes=2 bridge=yes", NORTH, &[])), []);
}
