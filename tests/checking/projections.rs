//! Autoware's projections as the C++ Lanelet2 library and PROJ do them, over whole zones and both hemispheres, to a
//! millimetre.

use std::io::Write;
use std::process::Stdio;

use lanewright::geometry::Point;
use lanewright::lanelet::from_osm;
use lanewright::projection::LonLat;
use lanewright::projection::{DEFAULT_SCALE_FACTOR, Projector};
use serde_json::{Value, json};

use crate::common::drawing::osm;
use crate::common::needs::{python, skip};
use crate::common::root;

/// Metres.
const EQUAL: f64 = 1e-3;

/// Zones by their central meridian: the first, the last, where UTM's zones are irregular, over land on both halves.
const MERIDIANS: [f64; 8] = [-177.0, -123.0, -69.0, -3.0, 9.0, 33.0, 141.0, 177.0];
/// Middle latitudes of bands from which places are taken, degrees.
const BANDS: [f64; 11] = [-78.0, -60.0, -45.0, -23.4, -0.2, 0.2, 35.6, 48.1, 60.3, 70.0, 82.0];

type Place = (LonLat, f64);

/// Places over a zone from edge to edge, with heights.
fn places(meridian: f64, middle: f64, width: f64, height: f64) -> Vec<Place> {
    let steps = |i: u32| f64::from(i) / 6.0 - 1.0;
    let grid = (0..13).flat_map(|i| (0..13).map(move |j| (i, j)));
    let place = |(i, j): (u32, u32)| {
        // The edges of a zone belong to its neighbours.
        let lon = meridian + steps(i) * width * 0.999_999;
        let lat = (middle + steps(j) * height).clamp(-80.0, 83.9);
        (LonLat { lon, lat }, f64::from(i * 40 + j) - 30.0)
    };
    grid.map(place).collect()
}

/// One question to the other implementations: a projector and places that it reaches.
struct Task {
    projector: Projector,
    origin: LonLat,
    places: Vec<Place>,
}

fn tasks() -> Vec<Task> {
    let mut tasks = Vec::new();
    for lon in MERIDIANS {
        for lat in BANDS {
            // Not on the meridian, nor in the middle of anything.
            let origin = LonLat { lon: lon + 0.7, lat: lat + 0.01 };
            let zone = places(lon, lat, 3.0, 4.0);
            tasks.push(Task { projector: Projector::mgrs("54SUE".parse().unwrap()), origin, places: zone.clone() });
            tasks.push(Task { projector: Projector::transverse_mercator(origin), origin, places: zone });
            // The plane of UTM has a half for the north and one for the south: Autoware transfers what lies beyond.
            let half = |place: &Place| (place.0.lat >= 0.0) == (origin.lat >= 0.0);
            let mut near = places(lon, lat, 3.0, 0.5);
            near.retain(half);
            tasks.push(Task { projector: Projector::LocalCartesianUtm { origin }, origin, places: near.clone() });
            tasks.push(Task { projector: Projector::LocalCartesian { origin }, origin, places: near });
        }
    }
    tasks
}

/// The answers of the other implementation, one for each task; `None` for a task that it cannot do. `None` without a Python.
fn asked(tasks: &[Task], by: &str) -> Option<Vec<Option<Vec<Point>>>> {
    let mut python = python()?;
    let questions: Vec<Value> = tasks
        .iter()
        .map(|Task { projector, origin, places }| {
            let places: Vec<_> = places.iter().map(|(place, ele)| [place.lat, place.lon, *ele]).collect();
            json!({ "by": by, "kind": projector.name(), "origin": [origin.lat, origin.lon], "places": places })
        })
        .collect();
    python.arg(root().join("tests/checking/projections.py"));
    let mut running = python.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    running.stdin.take().unwrap().write_all(Value::from(questions).to_string().as_bytes()).unwrap();
    let output = running.wait_with_output().unwrap();
    assert!(output.status.success(), "tests/checking/projections.py failed");
    let answers: Vec<Option<Vec<[f64; 2]>>> = serde_json::from_slice(&output.stdout).unwrap();
    Some(answers.into_iter().map(|one| one.map(|points| points.into_iter().map(Point::from).collect())).collect())
}

/// Metres between two points whose coordinates are modulo 100 km.
fn apart(projector: &Projector, a: Point, b: Point) -> f64 {
    let mut gap = a - b;
    if matches!(projector, Projector::Mgrs(_)) {
        // At a border the last digit decides on which side a place lies.
        gap = gap.map(|way| (way + 50_000.0).rem_euclid(100_000.0) - 50_000.0);
    }
    gap.norm()
}

fn agree_with(by: &str, kinds: usize) {
    let tasks = tasks();
    let Some(answers) = asked(&tasks, by) else { return };
    let mut worst: std::collections::BTreeMap<&str, (usize, f64)> = Default::default();
    for (task, answer) in tasks.iter().zip(answers) {
        let Some(theirs) = answer else { continue };
        let only: Vec<LonLat> = task.places.iter().map(|(place, _)| *place).collect();
        let ours = task.projector.forward_each(&only, |i| task.places[i].1);
        for ((ours, theirs), (place, ele)) in ours.iter().zip(&theirs).zip(&task.places) {
            let ours = ours.unwrap_or_else(|| panic!("{} does not reach {place:?}", task.projector));
            let gap = apart(&task.projector, ours, *theirs);
            assert!(gap <= EQUAL, "{}: {place:?} at {ele} m: {ours} and {theirs}, {gap} m apart", task.projector);
            let (count, most) = worst.entry(task.projector.name()).or_default();
            (*count, *most) = (*count + 1, most.max(gap));
        }
    }
    for (name, (count, most)) in &worst {
        println!("{by}: {name}: {count} places, at most {:.6} mm apart", most * 1e3);
    }
    if worst.is_empty() {
        skip::<()>(&format!("the Python with the Lanelet2 library has no {by}"));
    } else {
        assert_eq!(worst.len(), kinds, "{by}");
    }
}

#[test]
fn projections_are_those_of_lanelet2() {
    // Its own wheel knows no TransverseMercator: that is Autoware's.
    agree_with("lanelet2", 3);
}

#[test]
fn projections_are_those_of_proj() {
    agree_with("proj", 4);
}

#[test]
fn every_place_of_a_zone_comes_back() {
    for Task { projector, places, .. } in tasks() {
        let only: Vec<LonLat> = places.iter().map(|(place, _)| *place).collect();
        if matches!(projector, Projector::Mgrs(_)) {
            // Each square has its own way back.
            for (place, square) in only.iter().zip(Projector::squares(&only)) {
                let projector = Projector::mgrs(square.unwrap());
                let there = projector.forward(*place, 0.0).unwrap();
                let back = projector.forward(projector.inverse(there).unwrap(), 0.0).unwrap();
                assert!(apart(&projector, there, back) <= EQUAL, "{projector}: {place:?}");
            }
            continue;
        }
        let ele = |i: usize| places[i].1;
        let there: Vec<Point> = projector.forward_each(&only, ele).into_iter().map(Option::unwrap).collect();
        let back: Vec<LonLat> = projector.inverse_each(&there, ele).into_iter().map(Option::unwrap).collect();
        for (again, (there, place)) in projector.forward_each(&back, ele).into_iter().zip(there.iter().zip(&only)) {
            assert!((again.unwrap() - there).norm() <= EQUAL, "{projector}: {place:?}");
        }
    }
}

#[test]
fn the_scale_is_a_float_of_32_bits() {
    assert_eq!(f64::from(DEFAULT_SCALE_FACTOR), 0.999_599_993_228_912_4);
    let origin = LonLat { lon: 9.0, lat: 0.0 };
    let wide = |scale_factor| Projector::TransverseMercator { origin, scale_factor };
    let far = LonLat { lon: 9.0, lat: 0.9 };
    let [as_float, one] = [DEFAULT_SCALE_FACTOR, 1.0].map(|scale| wide(scale).forward(far, 0.0).unwrap().y);
    // What the decimal 0.9996 would give lies 0.68 mm in 100 km beyond.
    let per_100_km = (0.9996 * one - as_float) / one * 1e5;
    assert!((per_100_km - 0.68e-3).abs() < 1e-5, "{per_100_km}");
}

#[test]
fn local_takes_the_metres_of_the_map() {
    let text = r#"<osm><node id="1" lat="35" lon="139"><tag k="local_x" v="12.3456"/><tag k="local_y" v="-7.8"/></node>
        <node id="2" lat="" lon=""><tag k="local_x" v="1"/></node></osm>"#;
    let map = from_osm(&osm(text), &Projector::Local).map;
    let places: Vec<Point> = map.points.iter().map(|point| point.position).collect();
    assert_eq!(places, [Point::new(12.3456, -7.8), Point::new(1.0, 0.0)]);
}
