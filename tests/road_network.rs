//! The road network of every extract in `../shared/corpus/osm`, and what must hold for any network.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::PathBuf;
use std::time::Instant;

use lanewright::builder::road_network::{End, Network, NetworkOptions, road_network};
use lanewright::geometry::Point;
use lanewright::osm::{OsmData, read_file};
use lanewright::projection::LonLat;

/// A plane good enough for a test: equirectangular around the first place.
fn plane(places: &[LonLat]) -> Vec<Point> {
    const METRES_PER_DEGREE: f64 = 111_195.0;
    let Some(origin) = places.first() else { return Vec::new() };
    let squeeze = origin.lat.to_radians().cos();
    places.iter().map(|p| Point::new((p.lon - origin.lon) * squeeze, p.lat - origin.lat) * METRES_PER_DEGREE).collect()
}

fn build(osm: &OsmData) -> Network {
    road_network(osm, &plane, &NetworkOptions::default()).unwrap()
}

fn shared() -> Option<PathBuf> {
    let given = std::env::var_os("LANEWRIGHT_SHARED").map(PathBuf::from);
    let shared = given.unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"));
    let there = shared.join("corpus/osm").is_dir();
    if !there {
        println!("skipped: ../shared is not here");
    }
    there.then_some(shared)
}

fn assert_sound(name: &str, Network { network, .. }: &Network) {
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
    let Some(shared) = shared() else { return };
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(shared.join("corpus/osm")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "osm"));
    files.sort();
    assert!(!files.is_empty());
    for path in files {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let osm = read_file(&path).unwrap();
        let start = Instant::now();
        let built = build(&osm);
        let time = start.elapsed();
        assert_sound(&name, &built);
        let Network { network, notes } = &built;
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
