//! Every intersection area is a simple polygon that runs along the ends of its lanes for cars, contains all its lanes, and does
//! not overlap other areas: in sample maps, in real extracts, and around roads too short for a vehicle.
//!
//! `make test` takes the small extracts, `make soak` (LANEWRIGHT_SOAK=1) all of them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use lanewright::builder::{BuildOptions, Built, build};
use lanewright::geometry::{Point, polygon, simple_ring as ring};
use lanewright::lanelet::{Lanelet, LaneletMap, PointId, Polygon};
use lanewright::osm::{OsmData, Way, read_file};
use proptest::prelude::*;

use crate::common::drawing::Drawing;
use crate::common::{extracts, root, samples};

/// Largest extract that `make test` takes, bytes.
const SLICE: u64 = 750_000;
/// Part of a lanelet that lies in its area at least.
const COVERED: f64 = 0.99;
/// Two areas share less than this, square metres, ...
const SHARED: f64 = 1.0;
/// ... unless one lies so far above the other, metres.
const ABOVE: f64 = 3.0;

/// What is wrong with the areas of the map that is built from this.
fn faults(data: &OsmData) -> String {
    let map = build(data, &BuildOptions::default()).unwrap().map;
    let mut members: BTreeMap<String, Vec<&Lanelet>> = BTreeMap::new();
    for lanelet in map.lanelets.iter() {
        if let Some(area) = lanelet.attributes.get("intersection_area") {
            members.entry(area.to_string()).or_default().push(lanelet);
        }
    }
    let mut said = String::new();
    let areas: Vec<(&Polygon, Vec<Point>)> = map
        .polygons
        .iter()
        .filter(|area| area.attributes.is("type", "intersection_area"))
        .map(|area| (area, area.points.iter().map(|&id| map.points.get(id).unwrap().position).collect()))
        .collect();
    for (i, (area, outline)) in areas.iter().enumerate() {
        if !ring::is_simple(outline) {
            let _ = writeln!(said, "area {} is no simple polygon", area.id);
        }
        for lanelet in &members[&area.id.to_string()] {
            judge(&map, area, outline, lanelet, &mut said);
        }
        let on_one_level = |other: &Polygon| {
            let [(low, high), (others_low, others_high)] = [area, other].map(|area| heights(&map, area));
            low < others_high + ABOVE && others_low < high + ABOVE
        };
        for (other, beside) in areas[i + 1..].iter().filter(|(other, _)| on_one_level(other)) {
            let shared = polygon::common_area(outline, beside);
            if shared > SHARED {
                let _ = writeln!(said, "areas {} and {} share {shared:.2} m2", area.id, other.id);
            }
        }
    }
    said
}

/// How low and how high the outline of an area lies, metres.
fn heights(map: &LaneletMap, area: &Polygon) -> (f64, f64) {
    let heights = area.points.iter().filter_map(|&id| map.points.get(id)?.ele());
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), ele| (low.min(ele), high.max(ele)))
}

/// Both ends of a lanelet for cars are edges of the outline, and the outline holds the lanelet.
fn judge(map: &LaneletMap, area: &Polygon, outline: &[Point], lanelet: &Lanelet, said: &mut String) {
    let sides = [lanelet.left, lanelet.right].map(|bound| map.bound_points(bound).map(|p| p.id).collect::<Vec<_>>());
    let count = area.points.len();
    let edge = |a: PointId, b: PointId| {
        (0..count).any(|i| [[a, b], [b, a]].contains(&[area.points[i], area.points[(i + 1) % count]]))
    };
    let ends = [[sides[0][0], sides[1][0]], [sides[0][sides[0].len() - 1], sides[1][sides[1].len() - 1]]];
    for [a, b] in ends {
        if lanelet.attributes.is("subtype", "road") && !edge(a, b) {
            let _ = writeln!(said, "{a} to {b}, an end of lanelet {}, is no edge of area {}", lanelet.id, area.id);
        }
    }
    let ground = map.outline(lanelet);
    let covered = polygon::common_area(&ground, outline) / polygon::signed_area(&ground).abs();
    if covered < COVERED {
        let _ = writeln!(said, "area {} covers {covered:.3} of lanelet {}", area.id, lanelet.id);
    }
}

#[test]
fn areas_of_samples_and_extracts_lead_along_the_ends_of_lanes() {
    let mut said = String::new();
    for input in samples().into_iter().chain(extracts(SLICE)) {
        let faults = faults(&read_file(&input).unwrap());
        if !faults.is_empty() {
            let _ = writeln!(said, "{}:\n{faults}", input.display());
        }
    }
    assert!(said.is_empty(), "{said}");
}

/// A network of nodes in metres and roads with tags between them, by the nodes' numbers from 1.
fn network(nodes: &[(f64, f64)], roads: &[(usize, usize, &str)]) -> OsmData {
    drawing(nodes, roads).data()
}

fn drawing(nodes: &[(f64, f64)], roads: &[(usize, usize, &str)]) -> Drawing {
    let mut drawing = Drawing::default();
    for (id, (x, y)) in (1..).zip(nodes) {
        drawing.node(id, [48.0 + y / 111_320.0, 9.5 + x / 111_320.0], "");
    }
    for (id, (from, to, tags)) in (1..).zip(roads) {
        drawing.way(id, [from, to], &format!("highway=residential {tags}"));
    }
    drawing
}

#[test]
fn a_stub_between_two_carriageways_of_a_fork_lies_inside() {
    // Two one-way roads part side by side and meet again ten metres on.
    let nodes = [(-60.0, -8.0), (0.0, 0.0), (14.0, 2.0), (70.0, 0.0), (7.0, 4.0), (-50.0, 40.0), (60.0, -40.0)];
    let one = "oneway=yes";
    let roads = [(1, 2, one), (2, 3, one), (3, 4, one), (2, 5, one), (5, 3, one), (6, 2, "lanes=2"), (3, 7, "lanes=4")];
    assert_eq!(faults(&network(&nodes, &roads)), "");
}

#[test]
fn a_dead_end_under_a_bend_is_no_road() {
    let nodes = [(-20.0, 60.0), (-6.0, 12.0), (0.0, 8.0), (6.0, 12.0), (14.0, 60.0), (-2.0, 5.0)];
    let roads = [(1, 2, ""), (2, 3, ""), (3, 4, ""), (4, 5, ""), (3, 6, "")];
    assert_eq!(faults(&network(&nodes, &roads)), "");
}

/// The ways around islands that areas cover nevertheless, as the notes of the build say.
fn covered(built: &Built) -> Vec<i64> {
    let notes = built.notes.iter().filter(|note| note.fault == "island-covered");
    notes.flat_map(|note| note.related.iter().filter_map(|related| related.subject.id())).collect()
}

#[test]
fn medians_that_reach_into_an_area_are_cut_out() {
    let data = read_file(&root().join("tests/street_layouts/medians.osm")).unwrap();
    assert_eq!(faults(&data), "");
    let built = build(&data, &BuildOptions::default()).unwrap();
    let of_ring = |way: &Way| -> Vec<Point> {
        let places = way.nodes[1..].iter().filter_map(|id| data.node(*id)?.position);
        places.filter_map(|place| built.projector.forward(place, 0.0)).collect()
    };
    let area = built.map.polygons.iter().find(|area| area.attributes.is("type", "intersection_area")).unwrap();
    let outline: Vec<Point> = area.points.iter().map(|id| built.map.points.get(*id).unwrap().position).collect();
    let islands: Vec<&Way> = data.ways.iter().filter(|way| !way.tags.has("highway")).collect();
    assert_eq!(islands.len(), 5);
    for island in islands {
        let ring = of_ring(island);
        let inside = polygon::common_area(&ring, &outline);
        match island.tags.is("traffic_calming", "island") {
            true => assert!((inside - polygon::signed_area(&ring).abs()).abs() < 0.01, "in the middle it stays"),
            false => assert!(inside < 0.1, "{inside:.2} m2 of way {} lie in the area", island.id),
        }
    }
    assert_eq!(covered(&built), [305]);
    let borders = built.map.linestrings.iter().filter(|line| line.attributes.is("type", "road_border"));
    let on_border: BTreeSet<PointId> = borders.flat_map(|line| line.points.clone()).collect();
    let lanes = built.map.lanelets.iter().flat_map(|lane| [lane.left, lane.right]);
    let ends = lanes.flat_map(|bound| built.map.bound_points(bound).map(|p| p.id).collect::<Vec<_>>());
    let known: BTreeSet<PointId> = on_border.into_iter().chain(ends).collect();
    assert!(area.points.iter().all(|id| known.contains(id)), "each vertex is one of a kerb or of a lane");
}

#[test]
fn an_island_that_ways_cross_is_not_cut_out() {
    let middle = data_with_median(1.0);
    assert_eq!(faults(&middle), "");
    assert_eq!(covered(&build(&middle, &BuildOptions::default()).unwrap()), [9]);
}

/// A crossing of two streets with a kerb around a strip along the middle of one, from the middle of the crossing outwards.
fn data_with_median(half: f64) -> OsmData {
    let tip = [(8.0, half), (40.0, half), (40.0, -half), (8.0, -half)];
    let mut nodes = vec![(0.0, 0.0), (70.0, 0.0), (0.0, 70.0), (-70.0, 0.0), (0.0, -70.0)];
    nodes.extend(tip);
    let mut drawing = drawing(&nodes, &[(1, 2, ""), (1, 3, ""), (1, 4, ""), (1, 5, "")]);
    drawing.way(9, [6, 7, 8, 9, 6], "barrier=kerb");
    drawing.data()
}

/// Roads beside each other part at twice this angle at least, radians; else they would lie on each other.
const PART: f64 = 0.15;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Two junctions, one road between them that is as short as can be, arms at any angle that roads really have.
    #[test]
    fn any_stub_keeps_its_areas_whole(
        length in 1.0..30.0_f64,
        angles in prop::collection::vec(-0.6..0.6_f64, 6),
        lanes in prop::collection::vec(1_u8..5, 7),
        arms in 3_usize..=6,
        one_way in 0_usize..8,
    ) {
        use std::f64::consts::FRAC_PI_2;
        let base = [2.0, 0.0, 1.0, -1.0, 1.0, -1.0].map(|quarter| quarter * FRAC_PI_2);
        let at = [0, 1, 0, 1, 1, 0];
        // Arms on the same side of the stub part from each other: those of one end lean away from the other end.
        let lean = [0.0, 0.0, 1.0, 1.0, -1.0, -1.0];
        let mut nodes = vec![(0.0, 0.0), (length, 0.0)];
        let tags: Vec<String> = (0..7)
            .map(|i| format!("lanes={} oneway={}", lanes[i], if one_way == i { "yes" } else { "no" }))
            .collect();
        let mut roads = vec![(1, 2, tags[6].as_str())];
        for i in 0..arms {
            let turn = if i < 2 { angles[i] } else { lean[i] * (angles[i].abs() + PART) };
            let (angle, from) = (base[i] + turn, at[i]);
            nodes.push((length * from as f64 + 70.0 * angle.cos(), 70.0 * angle.sin()));
            roads.push((from + 1, nodes.len(), tags[i].as_str()));
        }
        prop_assert_eq!(faults(&network(&nodes, &roads)), "");
    }
}
