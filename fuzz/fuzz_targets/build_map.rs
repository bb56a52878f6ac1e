//! A sound extract, damaged as the bytes say, or any bytes as an extract: built and written. The first byte chooses.

#![no_main]

#[path = "../../tests/fault_injection/mod.rs"]
mod fault_injection;

use lanewright::builder::{BuildOptions, build};
use lanewright::lanelet::to_osm;
use lanewright::osm::{OsmData, read_bytes};
use libfuzzer_sys::fuzz_target;

const EXTRACTS: [&str; 7] = [
    include_str!("../../sample_maps/crossing_left.osm"),
    include_str!("../../sample_maps/crossing_right.osm"),
    include_str!("../../sample_maps/roundabout_right.osm"),
    include_str!("../../sample_maps/staggered_left.osm"),
    include_str!("../../sample_maps/tjunction_left.osm"),
    include_str!("../../sample_maps/tjunction_right.osm"),
    include_str!("../../sample_maps/turn_lanes_right.osm"),
];

fuzz_target!(|bytes: &[u8]| {
    let Some((&choice, bytes)) = bytes.split_first() else { return };
    let text = match EXTRACTS.get(usize::from(choice) % (EXTRACTS.len() + 1)) {
        Some(extract) => fault_injection::changed(extract, bytes, 10),
        None => bytes.to_vec(),
    };
    let mut data = OsmData::default();
    if read_bytes(&mut data, "fuzz.osm", text).is_err() {
        return;
    }
    if let Ok(built) = build(&data, &BuildOptions::default()) {
        to_osm(&built.map, &built.projector, std::io::sink()).expect("a sink takes everything");
    }
});
