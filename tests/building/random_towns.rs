//! Random towns, built and judged by all rules, for layouts that the extracts do not contain. The towns are the same in every run.
//!
//! `make test` takes 40 of them, `make soak` (LANEWRIGHT_SOAK=1) ten times as many.

use std::collections::BTreeMap;

use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::builder::{BuildOptions, build};
use lanewright::diagnostic::Severity;
use lanewright::lanelet::Loaded;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

use crate::common::drawing::{self, osm};
use crate::common::judging::judge;
use crate::common::soak;

/// Streets of either direction at most.
const MOST: usize = 5;
/// Towns of the slice.
const TOWNS: usize = 40;
/// In one of so many towns, ways from lanes side by side may run into each other: their lanes end where no smooth curves lead past
/// each other. Nothing else may be wrong.
const OF: usize = 100;
const SIDE_BY_SIDE: &str = "vm-03-07/";

/// Streets with traffic both ways, then streets with one direction, which only lead from one of the others to another.
const TWO_WAY: [&str; 8] = [
    "highway=residential",
    "highway=tertiary lanes=2 sidewalk=both",
    "highway=secondary lanes=4",
    "highway=primary lanes=3 lanes:forward=2 lanes:backward=1",
    "highway=service",
    "highway=tertiary lanes=4 turn:lanes:forward=left|through;right",
    "highway=unclassified width=7 parking:right=lane",
    "highway=secondary lanes=2 cycleway:right=lane maxspeed=50",
];
const ONE_WAY: [&str; 2] = ["highway=residential oneway=yes", "highway=tertiary oneway=yes lanes=2"];
/// Tags of crossings; most have none.
const SIGNS: [&str; 8] =
    ["highway=traffic_signals", "highway=traffic_signals", "highway=stop", "highway=crossing", "", "", "", ""];

/// A grid of streets, moved and turned.
#[derive(Clone, Debug)]
struct Town {
    left_hand: bool,
    /// Streets in either direction, and how far apart, metres.
    side: usize,
    spacing: f64,
    turned: f64,
    /// Of each crossing, in parts of the spacing.
    moved: Vec<(f64, f64)>,
    signs: Vec<usize>,
    /// First those to the north, then those to the east.
    streets: Vec<Street>,
    /// Street and place on it, angle to it, and length, metres.
    driveways: Vec<(usize, f64, f64, f64)>,
}

#[derive(Clone, Debug)]
struct Street {
    kind: usize,
    /// Metres between the middles of two carriageways, and lanes of each.
    divided: Option<(f64, u8)>,
    /// How far each piece bends aside, in parts of its length.
    bends: Vec<f64>,
}

fn any_street() -> impl Strategy<Value = Street> {
    let divided = prop::option::weighted(0.2, (8.0..18.0_f64, 1_u8..=3));
    let bends = prop::collection::vec(prop_oneof![2 => Just(0.0), 1 => -0.08..0.08_f64], MOST);
    (0..TWO_WAY.len() + ONE_WAY.len(), divided, bends).prop_map(|(kind, divided, bends)| Street {
        kind,
        divided,
        bends,
    })
}

fn any_town() -> impl Strategy<Value = Town> {
    let moved = prop::collection::vec((-0.12..0.12_f64, -0.12..0.12_f64), MOST * MOST);
    let signs = prop::collection::vec(0..SIGNS.len(), MOST * MOST);
    let streets = prop::collection::vec(any_street(), 2 * MOST);
    let driveways = prop::collection::vec((0..2 * MOST, 0.3..0.7_f64, 0.7..2.4_f64, 8.0..22.0_f64), 0..6);
    (any::<bool>(), 3..=MOST, 70.0..140.0_f64, 0.0..1.5_f64, moved, signs, streets, driveways).prop_map(
        |(left_hand, side, spacing, turned, moved, signs, streets, driveways)| Town {
            left_hand,
            side,
            spacing,
            turned,
            moved,
            signs,
            streets,
            driveways,
        },
    )
}

/// The nodes and ways of a town, in metres.
#[derive(Default)]
struct Plan {
    nodes: Vec<(f64, f64, String)>,
    ways: Vec<(Vec<usize>, String)>,
}

impl Plan {
    fn node(&mut self, x: f64, y: f64, tags: &str) -> usize {
        self.nodes.push((x, y, tags.to_owned()));
        self.nodes.len() - 1
    }

    fn xml(&self, turned: f64) -> String {
        let (sine, cosine) = turned.sin_cos();
        let mut xml = drawing::Drawing::default();
        for (id, (x, y, tags)) in (1..).zip(&self.nodes) {
            let (east, north) = (x * cosine - y * sine, x * sine + y * cosine);
            let place = [48.1 + north / 111_200.0, 11.5 + east / 74_340.0];
            xml.node(id, place.map(|degrees| format!("{degrees:.7}")), tags);
        }
        for (id, (nodes, tags)) in (1..).zip(&self.ways) {
            xml.way(id, nodes.iter().map(|node| node + 1), tags);
        }
        xml.xml()
    }
}

impl Town {
    fn street(&self, north: bool, at: usize) -> &Street {
        &self.streets[if north { at } else { MOST + at }]
    }

    /// How far to either side of its middle the carriageways of a street lie.
    fn offsets(&self, north: bool, at: usize) -> Vec<f64> {
        self.street(north, at).divided.map_or_else(|| vec![0.0], |(gap, _)| vec![-gap / 2.0, gap / 2.0])
    }

    fn drawn(&self) -> Plan {
        let mut drawing = Plan::default();
        // By the streets that cross, and their carriageways.
        let mut crossings: BTreeMap<[usize; 4], usize> = BTreeMap::new();
        for (x, y) in (0..self.side).flat_map(|x| (0..self.side).map(move |y| (x, y))) {
            let (at, (east, north)) = (x * MOST + y, self.moved[x * MOST + y]);
            for (a, aside) in self.offsets(true, x).into_iter().enumerate() {
                for (b, up) in self.offsets(false, y).into_iter().enumerate() {
                    let place = [(x as f64 + east) * self.spacing + aside, (y as f64 + north) * self.spacing + up];
                    let node = drawing.node(place[0], place[1], SIGNS[self.signs[at]]);
                    crossings.insert([x, a, y, b], node);
                }
            }
        }
        for (north, at) in [true, false].into_iter().flat_map(|north| (0..self.side).map(move |at| (north, at))) {
            for carriageway in 0..self.offsets(north, at).len() {
                let passed = |[x, a, y, b]: &[usize; 4]| {
                    if north { (*x, *a) == (at, carriageway) } else { (*y, *b) == (at, carriageway) }
                };
                let nodes: Vec<usize> =
                    crossings.iter().filter(|(key, _)| passed(key)).map(|(_, node)| *node).collect();
                self.draw(&mut drawing, (north, at, carriageway), &nodes);
            }
        }
        for (street, part, angle, length) in &self.driveways {
            let Some((nodes, _)) = drawing.ways.get(*street).filter(|(_, tags)| !tags.contains("oneway")) else {
                continue;
            };
            let [a, b] = [nodes[0], nodes[1]].map(|node| (drawing.nodes[node].0, drawing.nodes[node].1));
            let (along, up) = (b.0 - a.0, b.1 - a.1);
            if along.hypot(up) < 40.0 {
                continue;
            }
            let (x, y) = (a.0 + along * part, a.1 + up * part);
            let heading = up.atan2(along) + angle;
            let [begin, end] =
                [0.0, *length].map(|far| drawing.node(x + far * heading.cos(), y + far * heading.sin(), ""));
            drawing.ways[*street].0.insert(1, begin);
            drawing.ways.push((vec![begin, end], "highway=service service=driveway".to_owned()));
        }
        drawing
    }

    /// One carriageway of a street over these crossings.
    fn draw(&self, drawing: &mut Plan, (north, at, carriageway): (bool, usize, usize), crossings: &[usize]) {
        let street = self.street(north, at);
        let outermost = at == 0 || at + 1 == self.side;
        let mut nodes = vec![crossings[0]];
        for (pair, bend) in crossings.windows(2).zip(street.bends.iter().cycle()) {
            let [a, b] = [pair[0], pair[1]].map(|node| (drawing.nodes[node].0, drawing.nodes[node].1));
            let (along, up) = (b.0 - a.0, b.1 - a.1);
            if *bend != 0.0 && along.hypot(up) > 40.0 {
                nodes.push(drawing.node(a.0 + along / 2.0 - up * bend, a.1 + up / 2.0 + along * bend, ""));
            }
            nodes.push(pair[1]);
        }
        let tags = match street.divided {
            Some((_, lanes)) => {
                // To the north one drives on the eastern carriageway, to the east on the southern one.
                if (carriageway == 1) != north ^ self.left_hand {
                    nodes.reverse();
                }
                format!("highway=secondary oneway=yes lanes={lanes}")
            }
            None if outermost => TWO_WAY[street.kind % TWO_WAY.len()].to_owned(),
            None => TWO_WAY.iter().chain(&ONE_WAY).nth(street.kind).unwrap().to_string(),
        };
        drawing.ways.push((nodes, tags));
    }
}

/// The errors in the map of a town, with how often each comes.
fn errors(town: &Town) -> BTreeMap<String, usize> {
    let data = osm(town.drawn().xml(town.turned));
    let side = if town.left_hand { DrivingSide::Left } else { DrivingSide::Right };
    let built = build(&data, &BuildOptions { driving_side: Some(side), ..BuildOptions::default() }).unwrap();
    let found = judge(&Loaded { map: built.map, faults: Vec::new() }, &built.settings);
    let mut errors = BTreeMap::new();
    for one in found.iter().filter(|one| one.severity == Severity::Error) {
        *errors.entry(one.code.to_string()).or_default() += 1;
    }
    errors
}

#[test]
fn towns_have_no_errors_but_for_a_few_lanes_side_by_side() {
    let count = if soak() { 10 * TOWNS } else { TOWNS };
    let mut runner = TestRunner::deterministic();
    let towns: Vec<Town> = (0..count).map(|_| any_town().new_tree(&mut runner).unwrap().current()).collect();
    let (mut wrong, mut side_by_side) = (Vec::new(), 0);
    for (i, town) in towns.iter().enumerate() {
        let errors = errors(town);
        if errors.is_empty() {
            continue;
        }
        // To look at: `LANEWRIGHT_TOWNS` names a directory.
        if let Some(dir) = std::env::var_os("LANEWRIGHT_TOWNS") {
            let file = std::path::Path::new(&dir).join(format!("town_{i}.osm"));
            std::fs::write(file, town.drawn().xml(town.turned)).unwrap();
        }
        let said = format!("town {i}, left-hand {}: {errors:?}", town.left_hand);
        println!("{said}");
        if errors.keys().all(|code| code.starts_with(SIDE_BY_SIDE)) {
            side_by_side += 1;
        } else {
            wrong.push(said);
        }
    }
    assert!(wrong.is_empty(), "of {count} towns:\n{}", wrong.join("\n"));
    assert!(side_by_side * OF <= count, "in {side_by_side} of {count} towns");
}
