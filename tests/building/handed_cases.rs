//! What is built of the small inputs in `../shared/cases/build`, each of a whole kind.

use std::collections::{BTreeMap, BTreeSet};

use lanewright::builder::network::NetworkError;
use lanewright::builder::{BuildError, BuildOptions, Built, build, build_plan, geojson};
use lanewright::diagnostic::Severity;
use lanewright::geometry::{Vector, cross, polygon};
use lanewright::lanelet::{Lanelet, LaneletMap, Loaded};
use lanewright::osm::{OsmData, read_file};
use lanewright::settings::Document;

use crate::common::judging::judge;
use crate::common::needs::shared;

/// The data of a case; `None`, noted as skipped, without it.
fn case(name: &str) -> Option<OsmData> {
    Some(read_file(&shared(&format!("cases/build/{name}.osm"))?).unwrap())
}

fn built(data: &OsmData) -> Built {
    build(data, &BuildOptions::default()).unwrap()
}

/// Direction and middle of a lanelet, metres.
fn course(map: &LaneletMap, lanelet: &Lanelet) -> (Vector, Vector) {
    let [left, right] = [lanelet.left, lanelet.right].map(|bound| {
        let points: Vec<_> = map.bound_points(bound).map(|point| point.position.coords).collect();
        [points[0], points[points.len() - 1]]
    });
    let [start, end] = [0, 1].map(|i| (left[i] + right[i]) / 2.0);
    ((end - start).normalize(), (start + end) / 2.0)
}

/// The lanelets of the only road, from left to right along its way: who drives there and `>` along the way or `<` against it.
fn lanes(data: &OsmData) -> String {
    let Built { map, .. } = built(data);
    let ends = [0, 1].map(|end| {
        let nodes = &data.ways[0].nodes;
        let place = data.node(nodes[end * (nodes.len() - 1)]).unwrap().position.unwrap();
        Vector::new(place.lon * place.lat.to_radians().cos(), place.lat)
    });
    let along = (ends[1] - ends[0]).normalize();
    let mut found: Vec<(f64, String)> = map
        .lanelets
        .iter()
        .map(|lanelet| {
            let (heading, middle) = course(&map, lanelet);
            let who = match lanelet.attributes.get("subtype") {
                Some("road") => "car",
                Some("bus_lane") => "bus",
                Some("bicycle_lane") => "bicycle",
                other => panic!("{other:?}"),
            };
            (cross(along, middle), format!("{who}{}", if heading.dot(&along) > 0.0 { ">" } else { "<" }))
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|(_, lane)| lane).collect::<Vec<_>>().join(" ")
}

/// The codes of what the rules find at this severity or a worse one.
fn found(built: &Built, least: Severity) -> Vec<String> {
    let loaded = Loaded { map: built.map.clone(), faults: Vec::new() };
    let found = judge(&loaded, &built.settings).into_iter().filter(|one| one.severity >= least);
    found.map(|one| one.code.to_string()).collect()
}

fn notes<'a>(built: &'a Built, fault: &'a str) -> Vec<&'a str> {
    built.notes.iter().filter(|note| note.fault == fault).map(|note| note.message.as_str()).collect()
}

#[test]
fn lanes_are_for_those_who_may_drive_there() {
    let cases = [
        ("vb", "car<"),
        ("mvback", "car>"),
        ("contra1", "bus< car> car>"),
        ("contra3", "bus< car> car>"),
        ("contra_std", "bus< car>"),
        ("ct1", "bus< car> car>"),
        ("ct3", "bus< car> car>"),
        ("graz_3list", "car< car> car> bus>"),
        ("mid_cycle", "car> car> bicycle> car>"),
        ("bike", "car> bicycle> car>"),
        ("bus3", "bus< car< car>"),
        ("mslanes", "car> car> car>"),
    ];
    for (name, expected) in cases {
        let Some(data) = case(name) else { return };
        assert_eq!(lanes(&data), expected, "{name}");
        assert_eq!(found(&built(&data), Severity::Warning), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn shoulders_in_the_middle_of_a_road_cause_no_finding() {
    let Some(file) = shared("cases/streets/two_shoulders_in_the_middle.geojson") else { return };
    let streets = geojson::read(&std::fs::read_to_string(file).unwrap(), &BuildOptions::default()).unwrap();
    assert_eq!(found(&build_plan(streets), Severity::Warning), [""; 0]);
}

#[test]
fn lanes_have_their_own_limits() {
    let Some(data) = case("mslanes") else { return };
    let Built { map, .. } = built(&data);
    let mut limits: Vec<&str> = map.lanelets.iter().filter_map(|lane| lane.attributes.get("speed_limit")).collect();
    limits.sort_unstable();
    assert_eq!(limits, ["100", "100", "80"]);
}

#[test]
fn restrictions_that_cannot_be_built_are_told_and_those_at_red_forbid_nothing() {
    let Some(data) = case("onred") else { return };
    let on_red = built(&data);
    let turns =
        |turn: &str| on_red.map.lanelets.iter().filter(|lane| lane.attributes.is("turn_direction", turn)).count();
    assert_eq!(["left", "straight", "right"].map(turns), [2, 2, 2]);
    assert_eq!(notes(&on_red, "restriction-skipped").len(), 1);
    let joint = built(&case("ne2").unwrap());
    assert_eq!(notes(&joint, "restriction-not-built").len(), 1);
}

#[test]
fn closed_roads_are_left_out_with_the_tag_that_closes_them() {
    let Some(data) = case("emerg") else { return };
    match build(&data, &BuildOptions::default()) {
        Err(BuildError::Network(NetworkError::NoRoad { first: Some(first), .. })) => {
            assert!(first.contains("service=emergency_access"), "{first}");
        }
        other => panic!("{other:?}"),
    }
    let data = case("ped").unwrap();
    let closed = built(&data);
    let [note] = notes(&closed, "way-skipped")[..] else { panic!() };
    assert!(note.contains("motor_vehicle=yes") && note.contains("shared_paths"), "{note}");
    let Document { settings, .. } = Document::parse("lanewright.toml", "[[road]]\nshared_paths = true\n").unwrap();
    let opened = build(&data, &BuildOptions { roads: settings.road, ..BuildOptions::default() }).unwrap();
    let private = |lane: &&Lanelet| lane.attributes.is("location", "private") && !lane.attributes.has("turn_direction");
    assert_eq!(opened.map.lanelets.iter().filter(private).count(), 2);
}

#[test]
fn untagged_pieces_of_a_main_road_have_the_lanes_of_the_tagged_ones() {
    for name in ["untagged_cross", "untagged_end"] {
        let Some(data) = case(name) else { return };
        let built = built(&data);
        let mut lanes: BTreeMap<&str, usize> = BTreeMap::new();
        for piece in built.map.lanelets.iter().filter_map(|lane| lane.attributes.get("road_id")) {
            *lanes.entry(piece).or_default() += 1;
        }
        lanes.retain(|piece, _| !piece.starts_with("13:"));
        assert!(lanes.len() >= 2 && lanes.values().all(|lanes| *lanes >= 3), "{name}: {lanes:?}");
        assert_eq!(found(&built, Severity::Warning), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn bus_lanes_between_lanes_cross_none_of_them() {
    for name in ["bus4", "bus6none"] {
        let Some(data) = case(name) else { return };
        let built = built(&data);
        assert_eq!(found(&built, Severity::Warning), Vec::<String>::new(), "{name}");
        let map = &built.map;
        let outside: Vec<&Lanelet> =
            map.lanelets.iter().filter(|lane| !lane.attributes.has("turn_direction")).collect();
        let buses = outside.iter().filter(|lane| lane.attributes.is("subtype", "bus_lane"));
        for bus in buses {
            for car in outside.iter().filter(|lane| lane.attributes.is("subtype", "road")) {
                let common = polygon::overlap(&map.outline(bus), &map.outline(car));
                assert!(common < 1.0, "{name}: {} and {} share {common} m2", bus.id, car.id);
            }
        }
        assert!(notes(&built, "lanes-unreachable").is_empty(), "{name}: {:?}", built.notes);
    }
}

#[test]
fn small_roundabouts_are_rings() {
    for name in ["rb8", "rb13.7"] {
        let Some(data) = case(name) else { return };
        let built = built(&data);
        let ring = built
            .map
            .lanelets
            .iter()
            .filter(|lane| lane.attributes.get("road_id").is_some_and(|id| id.starts_with("10:")));
        assert!(ring.count() >= 4, "{name}: the pieces between the roads are lanelets");
        assert!(built.map.polygons.is_empty(), "{name}: nobody drives over the island");
        let element = built.map.regulatory_elements.iter().find(|element| element.subtype == "roundabout");
        let entries = element.map_or(0, |element| element.lanelets("entry").count());
        assert_eq!(entries, 4, "{name}: vehicles on the ring go first");
        assert_eq!(found(&built, Severity::Warning), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn wide_and_crowded_places_have_no_warning() {
    for name in ["crossing", "osna3", "osna6"] {
        let Some(data) = case(name) else { return };
        assert_eq!(found(&built(&data), Severity::Warning), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn seventeen_roads_most_of_them_one_way_meet_in_one_intersection() {
    let Some(data) = case("gang2") else { return };
    let built = built(&data);
    assert_eq!(found(&built, Severity::Error), Vec::<String>::new());
    // Beside the crossing, with its bus roads, slip lanes leave or join a carriageway of several lanes at four places.
    assert!(built.map.polygons.len() <= 5, "{} areas", built.map.polygons.len());
}

#[test]
fn lanes_side_by_side_turn_into_lanes_side_by_side() {
    let Some(data) = case("austin_min") else { return };
    let built = built(&data);
    assert_eq!(found(&built, Severity::Error), Vec::<String>::new());
    let (mut from, mut to) = (BTreeSet::new(), BTreeSet::new());
    // The four lanes from the south turn by about 100 degrees, the two others turn back.
    for lane in built.map.lanelets.iter().filter(|lane| lane.attributes.is("turn_direction", "left")) {
        let bounds = [lane.left, lane.right].map(|bound| built.map.bound_points(bound).collect::<Vec<_>>());
        let [first, last] = [0, 1].map(|end| bounds.each_ref().map(|bound| bound[end * (bound.len() - 1)].position));
        let ahead = bounds[0][1].position - first[0];
        if ahead.y > ahead.x.abs() {
            from.insert(first.map(|place| place.x.to_bits()));
            to.insert(last.map(|place| place.x.to_bits()));
        }
    }
    assert_eq!((from.len(), to.len()), (4, 4));
}
