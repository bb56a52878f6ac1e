//! The road network of every extract in `../shared/corpus/osm` and of random data, and what must hold for any.

use std::time::Instant;

use lanewright::builder::network::{End, NetworkOptions, NetworkReading, road_network};
use lanewright::diagnostic::SourceSpan;
use lanewright::geometry::Point;
use lanewright::osm::{Node, OsmData, Tags, Way, read_file};
use lanewright::projection::LonLat;
use proptest::prelude::*;
use proptest::sample::select;

use crate::common::extracts;

/// An equirectangular projection around the first place.
fn plane(places: &[LonLat]) -> Vec<Point> {
    const METRES_PER_DEGREE: f64 = 111_195.0;
    let Some(origin) = places.first() else { return Vec::new() };
    let squeeze = origin.lat.to_radians().cos();
    places.iter().map(|p| Point::new((p.lon - origin.lon) * squeeze, p.lat - origin.lat) * METRES_PER_DEGREE).collect()
}

fn build(osm: &OsmData) -> NetworkReading {
    road_network(osm, &plane, &NetworkOptions::default()).unwrap()
}

fn assert_sound(name: &str, NetworkReading { network, .. }: &NetworkReading) {
    let keys: Vec<_> = network.roads.iter().map(|road| road.key).collect();
    assert!(keys.is_sorted() && keys.windows(2).all(|w| w[0] != w[1]), "{name}: keys are in order and distinct");
    let mut ends = 0;
    for (i, intersection) in network.intersections.iter().enumerate() {
        assert!(!intersection.arms.is_empty(), "{name}: an intersection has an arm");
        for arm in &intersection.arms {
            let road = network.road(arm.road);
            assert_eq!(road.intersection(arm.end).0 as usize, i, "{name}: arms and roads agree");
            ends += 1;
        }
        let first = intersection.arms.iter().map(|arm| (network.road(arm.road).key, arm.end)).min();
        let arm = intersection.arms[0];
        assert_eq!(first, Some((network.road(arm.road).key, arm.end)), "{name}: arms begin at the smallest key");
    }
    assert_eq!(ends, network.roads.len() * 2, "{name}: each road end is an arm once");
    for road in &network.roads {
        assert!(road.line.points().iter().all(|p| p.x.is_finite() && p.y.is_finite()), "{name}: finite");
        assert!(road.section.driven().count() > 0, "{name}: {:?} can be driven", road.key);
        let (a, b) = (network.intersection(road.from), network.intersection(road.to));
        // The line may be shifted sideways by no more than the road is wide.
        let reach = road.section.width() * 3.0 + 0.1;
        assert!((road.line.first() - a.position).norm() < reach, "{name}: {:?} starts at its intersection", road.key);
        assert!((road.line.last() - b.position).norm() < reach, "{name}: {:?} ends at its intersection", road.key);
        let length = road.line.length();
        for feature in &road.features {
            assert!((0.0..=length + 1e-6).contains(&feature.station), "{name}: {:?} on {:?}", feature, road.key);
        }
        assert!(End::Start < End::End && road.speed.iter().all(|v| *v > 0.0 && v.is_finite()));
    }
}

#[test]
fn every_extract_of_the_corpus_has_a_network() {
    for path in extracts(u64::MAX) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let osm = read_file(&path).unwrap();
        let start = Instant::now();
        let built = build(&osm);
        let time = start.elapsed();
        assert_sound(&name, &built);
        let NetworkReading { network, notes } = &built;
        let kilometres = network.roads.iter().map(|road| road.line.length()).sum::<f64>() / 1000.0;
        println!(
            "{name}: {} {:?}, {} roads, {kilometres:.1} km, {} intersections, {} restrictions, {} notes, {} ms",
            network.country.as_deref().unwrap_or("-"),
            network.side,
            network.roads.len(),
            network.intersections.len(),
            network.restrictions.len(),
            notes.len(),
            time.as_millis(),
        );
    }
}

/// Valid tags, wrong tags and nonsense.
const KEYS: [&str; 24] = [
    "lanes",
    "lanes:forward",
    "lanes:backward",
    "lanes:both_ways",
    "oneway",
    "turn:lanes",
    "turn:lanes:forward",
    "bicycle:lanes",
    "access:lanes:backward",
    "bus:lanes:forward",
    "width",
    "width:lanes",
    "cycleway",
    "cycleway:left",
    "sidewalk",
    "parking:both",
    "parking:lane:left",
    "shoulder",
    "busway",
    "lanes:psv",
    "placement",
    "junction",
    "maxspeed",
    "layer",
];
const VALUES: [&str; 24] = [
    "",
    "yes",
    "no",
    "0",
    "1",
    "2",
    "3",
    "-1",
    "999999999999",
    "nan",
    "1e300",
    "lane",
    "track",
    "both",
    "left",
    "opposite_lane",
    "left|through|",
    "no||designated",
    "3|2.5",
    "right_of:2",
    "middle_of:0",
    "roundabout",
    "|||||||",
    "reversible",
];
const HIGHWAYS: [&str; 5] = ["residential", "motorway", "service", "primary_link", "footway"];
const NODE_TAGS: [&str; 5] = ["crossing", "traffic_signals", "stop", "give_way", "mini_roundabout"];

/// Up to 14 nodes on a small grid, so that some coincide, and ways over them and over nodes that are not there.
fn anything() -> impl Strategy<Value = (Vec<(i8, i8, &'static str)>, Vec<RandomWay>)> {
    let nodes = prop::collection::vec((-3..4_i8, -3..4_i8, select(&NODE_TAGS[..])), 2..14);
    let tags = prop::collection::vec((select(&KEYS[..]), select(&VALUES[..])), 0..5);
    let way = (prop::collection::vec(0..15_i64, 0..9), select(&HIGHWAYS[..]), tags);
    (nodes, prop::collection::vec(way, 1..8))
}

type RandomWay = (Vec<i64>, &'static str, Vec<(&'static str, &'static str)>);

fn data(nodes: &[(i8, i8, &'static str)], ways: &[RandomWay], reversed: bool) -> OsmData {
    let span = || SourceSpan { file: 0, start: 0, end: 0 };
    let mut osm = OsmData::default();
    let mut all_nodes: Vec<Node> = nodes
        .iter()
        .zip(0..)
        .map(|((x, y, highway), id)| {
            let position = Some(LonLat { lon: f64::from(*x) * 1e-4, lat: f64::from(*y) * 1e-4 });
            Node { id, position, tags: [("highway", *highway)].into_iter().collect(), span: span() }
        })
        .collect();
    let mut all_ways: Vec<Way> = ways
        .iter()
        .zip(100..)
        .map(|((nodes, highway, pairs), id)| {
            let mut tags: Tags = pairs.iter().copied().collect();
            tags.set("highway", *highway);
            Way { id, nodes: nodes.clone(), tags, span: span() }
        })
        .collect();
    if reversed {
        all_nodes.reverse();
        all_ways.reverse();
    }
    all_nodes.into_iter().for_each(|node| osm.push_node(node));
    all_ways.into_iter().for_each(|way| osm.push_way(way));
    osm
}

proptest! {
    #[test]
    fn any_data_gives_a_valid_network_or_an_error((nodes, ways) in anything()) {
        let network = |reversed| road_network(&data(&nodes, &ways, reversed), &plane_at_zero, &NetworkOptions::default());
        match (network(false), network(true)) {
            (Ok(first), Ok(second)) => {
                assert_sound("random data", &first);
                prop_assert_eq!(format!("{first:?}"), format!("{second:?}"), "the order of the input does not matter");
            }
            (first, second) => prop_assert_eq!(first.err(), second.err()),
        }
    }
}

/// A projection that does not depend on which place comes first.
fn plane_at_zero(places: &[LonLat]) -> Vec<Point> {
    places.iter().map(|p| Point::new(p.lon, p.lat) * 100_000.0).collect()
}
