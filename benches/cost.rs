//! Whether the cost of a road grows with the number of roads: `cargo bench --bench cost` says how much processor time
//! building and checking take over grids of streets, each four times as large as the one before, and over the extracts
//! that stand in `../shared/corpus/osm`. It fails where a road of the largest grid costs far more than one of the
//! smallest.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark that cannot go on must stop")]

mod clock;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use clock::processor_time;
use lanewright::builder::network::{NetworkOptions, road_network};
use lanewright::builder::streets::{StreetOptions, streets};
use lanewright::builder::{BuildOptions, build};
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{from_osm, projector_for, to_osm};
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::Projector;
use lanewright::rules::{self, Config};
use lanewright::settings::Settings;

/// As in the program.
#[cfg(not(target_env = "msvc"))]
#[global_allocator]
static ALLOCATOR: tikv_jemallocator::Jemalloc = tikv_jemallocator::Jemalloc;

/// Streets in one direction of the smallest grid; each next one has twice as many.
const SMALLEST: usize = 8;
/// How many grids.
const GRIDS: u32 = 4;
/// Each time is the least of so many runs; the first also makes what is made once, as the projections.
const RUNS: usize = 3;
/// A road of the largest grid may cost so many times what one of the smallest costs. A small grid lies in the
/// processor's caches and a large one does not; what grows with the logarithm of the size is no matter either. A cost
/// that grows as the size does would come out at 64.
const MOST: f64 = 2.0;

/// Seconds of processor time by stage.
#[derive(Clone, Copy, Debug)]
struct Times {
    roads: usize,
    geometry: f64,
    build: f64,
    check: f64,
}

fn main() {
    println!("| input | roads | geometry, µs/road | build, µs/road | check, µs/road |");
    println!("|---|---:|---:|---:|---:|");
    let grids: Vec<Times> = (0..GRIDS)
        .map(|i| SMALLEST << i)
        .map(|side| row(&format!("grid {side} x {side}"), grid(side).into_bytes()))
        .collect();
    for (name, bytes) in extracts() {
        row(&name, bytes);
    }
    let (Some(smallest), Some(largest)) = (grids.first(), grids.last()) else { return };
    let per_road = |times: &Times| [times.geometry, times.build, times.check].map(|t| t / times.roads as f64);
    for ((stage, small), large) in ["geometry", "build", "check"].iter().zip(per_road(smallest)).zip(per_road(largest))
    {
        let growth = large / small;
        println!("{stage}: a road of the largest grid costs {growth:.2} times one of the smallest");
        assert!(growth <= MOST, "the cost of a road grows with the number of roads");
    }
}

fn row(name: &str, bytes: Vec<u8>) -> Times {
    let times = measure(&bytes);
    let per_road = |seconds: f64| seconds * 1e6 / times.roads as f64;
    println!(
        "| {name} | {} | {:.0} | {:.0} | {:.0} |",
        times.roads,
        per_road(times.geometry),
        per_road(times.build),
        per_road(times.check)
    );
    times
}

/// From the text of an extract to its geometry, to the text of its map, and from that to findings.
fn measure(bytes: &[u8]) -> Times {
    let read = |bytes: &[u8]| {
        let mut osm = OsmData::default();
        read_bytes(&mut osm, "bench", bytes.to_vec()).unwrap();
        osm
    };
    let (geometry, roads) = least(|| {
        let osm = read(bytes);
        let projector = Projector::for_extent(&extent(&osm));
        let plane = |places: &[_]| projector.forward_all(places);
        let network = road_network(&osm, &plane, &NetworkOptions::default()).unwrap().network;
        streets(network, &StreetOptions::default()).network.roads.len()
    });
    let (build, map) = least(|| {
        let built = build(&read(bytes), &BuildOptions::default()).unwrap();
        let mut map = Vec::new();
        to_osm(&built.map, &built.projector, &mut map).unwrap();
        map
    });
    let (check, _) = least(|| {
        let osm = read(&map);
        let loaded = from_osm(&osm, &projector_for(&osm));
        let settings = Settings::default();
        let index = MapIndex::new(&loaded.map, &loaded.faults, &settings);
        rules::run(&index, &Config::from(&settings)).unwrap().len()
    });
    Times { roads, geometry, build, check }
}

/// The least time of some runs, and what the last of them made.
fn least<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    let start = Instant::now();
    let now = || processor_time().unwrap_or_else(|| start.elapsed().as_secs_f64());
    let mut timed = || {
        let before = now();
        let made = run();
        (now() - before, made)
    };
    let mut least = timed();
    for _ in 1..RUNS {
        let (seconds, made) = timed();
        least = (least.0.min(seconds), made);
    }
    least
}

fn extent(osm: &OsmData) -> lanewright::projection::Extent {
    lanewright::projection::Extent::of(osm.nodes.iter().filter_map(|node| node.position)).unwrap()
}

/// A town of crossing streets: every fourth is wide, has lights where it meets its like and carries the right of way;
/// every fifth of the others is one-way. Streets bend a little between their crossings.
fn grid(side: usize) -> String {
    /// Between two streets, degrees: some 110 m.
    const STEP: f64 = 0.001;
    let id = |row: usize, column: usize| 1 + row * side + column;
    let bend = |row: usize, column: usize, along: usize| 1 + side * side * (1 + along) + row * side + column;
    let wide = |street: usize| street.is_multiple_of(4);
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<osm version=\"0.6\">\n");
    let mut node = |id: usize, lat: f64, lon: f64, signals: bool| {
        let tag = if signals { "><tag k=\"highway\" v=\"traffic_signals\"/></node>" } else { "/>" };
        let _ = writeln!(text, "<node id=\"{id}\" lat=\"{:.7}\" lon=\"{:.7}\"{tag}", 48.0 + lat, 9.2 + lon);
    };
    for row in 0..side {
        for column in 0..side {
            let (lat, lon) = (row as f64 * STEP, column as f64 * STEP * 1.5);
            node(id(row, column), lat, lon, wide(row) && wide(column));
            node(bend(row, column, 0), lat + STEP / 20.0, lon + STEP * 0.75, false);
            node(bend(row, column, 1), lat + STEP / 2.0, lon + STEP / 20.0, false);
        }
    }
    for along in 0..2 {
        for street in 0..side {
            let _ = writeln!(text, "<way id=\"{}\">", 1 + street + along * side);
            for i in 0..side {
                let (row, column) = if along == 0 { (street, i) } else { (i, street) };
                let _ = writeln!(text, "<nd ref=\"{}\"/>", id(row, column));
                if i + 1 < side {
                    let _ = writeln!(text, "<nd ref=\"{}\"/>", bend(row, column, along));
                }
            }
            let tags: &[(&str, &str)] = match street {
                s if wide(s) => &[("highway", "secondary"), ("lanes", "4")],
                s if s.is_multiple_of(5) => &[("highway", "residential"), ("oneway", "yes")],
                _ => &[("highway", "residential")],
            };
            for (k, v) in tags {
                let _ = writeln!(text, "<tag k=\"{k}\" v=\"{v}\"/>");
            }
            text.push_str("</way>\n");
        }
    }
    text.push_str("</osm>\n");
    text
}

/// Extracts of the corpus, from the smallest on, where it is here; those too small to time are left out.
fn extracts() -> Vec<(String, Vec<u8>)> {
    const LEAST: u64 = 500_000;
    let Ok(files) = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/corpus/osm").read_dir() else {
        return Vec::new();
    };
    let mut files: Vec<_> = files
        .flatten()
        .map(|entry| (entry.metadata().map_or(0, |m| m.len()), entry.path()))
        .filter(|(size, path)| *size >= LEAST && path.extension().is_some_and(|e| e == "osm"))
        .collect();
    files.sort();
    let named = |path: &Path| path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    files.iter().filter_map(|(_, path)| Some((named(path), std::fs::read(path).ok()?))).collect()
}
