//! Hand-drawn networks, built and judged. The rules find no fault in what is built; the tests count what must be there, which the
//! rules would not miss.

mod bridges;
mod close_intersections;
mod crossing_lights;
mod inside;
mod lane_openings;
mod lanes;
mod loose_ends;
mod mid_block_lights;
mod right_of_way;
mod shapes;
mod signals;

use lanewright::builder::UNDRAWN;
use lanewright::builder::options::Inside;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::builder::{BuildOptions, Built, build};
use lanewright::lanelet::{Lanelet, LaneletMap, Loaded, RegulatoryElement};
use lanewright::settings::{Document, Settings};

use crate::common::drawing::{Drawing, osm};
use crate::common::judging::judge;

/// Latitude and longitude of the crossing's middle.
const MIDDLE: [f64; 2] = [0.5, 9.5];

/// Roads of these tags that meet at places in metres, mirrored where people drive on the left.
fn network(side: DrivingSide, nodes: &[(i64, f64, f64, &str)], ways: &[(i64, &[i64])], tags: &str) -> String {
    let ways: Vec<(i64, &[i64], &str)> = ways.iter().map(|&(id, refs)| (id, refs, tags)).collect();
    network_of(side, nodes, &ways)
}

/// The same with tags for each road.
fn network_of(side: DrivingSide, nodes: &[(i64, f64, f64, &str)], ways: &[(i64, &[i64], &str)]) -> String {
    let east = if side == DrivingSide::Right { 1.0 } else { -1.0 };
    let mut drawing = Drawing::default();
    for &(id, x, y, tags) in nodes {
        drawing.node(id, place(x * east, y), tags);
    }
    for &(id, refs, tags) in ways {
        drawing.way(id, refs, tags);
    }
    drawing.xml()
}

/// Four roads of 150 m that meet at node 1.
fn crossing(side: DrivingSide, middle: &str, tags: &str) -> String {
    let nodes =
        [(1, 0.0, 0.0, middle), (2, -150.0, 0.0, ""), (3, 150.0, 0.0, ""), (4, 0.0, -150.0, ""), (5, 0.0, 150.0, "")];
    let ways: [(i64, &[i64]); 4] = [(12, &[2, 1]), (13, &[3, 1]), (14, &[4, 1]), (15, &[5, 1])];
    network(side, &nodes, &ways, tags)
}

/// A signalised crossing with four lanes in and two lanes out at each arm; two of the four are for far turns.
fn signalised_crossing(side: DrivingSide) -> String {
    let arrows = match side {
        DrivingSide::Right => "left|left|through|through;right",
        DrivingSide::Left => "left;through|through|right|right",
    };
    let tags = format!("highway=secondary lanes=6 lanes:forward=4 lanes:backward=2 turn:lanes:forward={arrows}");
    crossing(side, "highway=traffic_signals", &tags)
}

/// Degrees of a place in metres from the middle; near the equator a degree is about as long in either direction.
fn place(x: f64, y: f64) -> [f64; 2] {
    [MIDDLE[0] + y / 110_574.0, MIDDLE[1] + x / 111_320.0]
}

fn built(xml: &str, side: DrivingSide, settings: &str) -> Built {
    let Settings { inside, lights, intersection, .. } = Document::parse("lanewright.toml", settings).unwrap().settings;
    let inside = Inside { everywhere: inside, lights: lights.unwrap_or_default(), intersections: intersection };
    let options = BuildOptions { driving_side: Some(side), inside, ..BuildOptions::default() };
    build(&osm(xml), &options).unwrap()
}

/// The codes of what the rules find in a map. Drawn streets end before Autoware's planner has looked as far as it wants to.
fn found(map: &LaneletMap, settings: &Settings) -> Vec<String> {
    let loaded = Loaded { map: map.clone(), faults: Vec::new() };
    let codes = judge(&loaded, settings).into_iter().map(|one| one.code.to_string());
    codes.filter(|code| code != "planner/attention-cut").collect()
}

/// The same, without what streets that are drawn without signs, and short, are told of in any case.
fn found_of_geometry(map: &LaneletMap, settings: &Settings) -> Vec<String> {
    let told = ["vm-03-11/priority-unknown", "vm-07-01/short-approach"];
    found(map, settings).into_iter().filter(|code| !told.contains(&code.as_str())).collect()
}

pub fn elements<'a>(map: &'a LaneletMap, subtype: &'a str) -> Vec<&'a RegulatoryElement> {
    map.regulatory_elements.iter().filter(|element| element.subtype == subtype).collect()
}

pub fn referrers<'a>(map: &'a LaneletMap, element: &RegulatoryElement) -> Vec<&'a Lanelet> {
    map.lanelets.iter().filter(|lanelet| lanelet.regulatory_elements.contains(&element.id)).collect()
}

fn undrawn(built: &Built) -> Vec<&str> {
    built.notes.iter().filter(|note| note.fault == UNDRAWN).map(|note| note.message.as_str()).collect()
}

const SIDES: [DrivingSide; 2] = [DrivingSide::Right, DrivingSide::Left];

/// Nodes 1, 2 and 3 of a street, which is one-way, and from node 2 to node 8 those of another that meets it at an angle of 20 degrees,
/// against its direction.
const AGAINST_A_ONE_WAY_STREET: [(i64, f64, f64, &str); 8] = [
    (1, -147.0, -172.0, ""),
    (2, 0.0, 0.0, ""),
    (3, 147.0, 172.0, ""),
    (4, 15.0, 8.5, ""),
    (5, 24.0, 11.0, ""),
    (6, 31.0, 14.0, ""),
    (7, 64.0, 24.0, ""),
    (8, 120.0, 24.0, ""),
];
