//! Any bytes as a PBF file, and as one block inside a sound one.

#![no_main]

#[path = "../../tests/fault_injection/mod.rs"]
mod fault_injection;

use lanewright::osm::{OsmData, read_bytes};
use libfuzzer_sys::fuzz_target;

// The decoder's own panics are caught by the reader; libFuzzer's hook would end the run before that.
fuzz_target!(init: std::panic::set_hook(Box::new(|_| ())), |bytes: &[u8]| {
    for file in [bytes.to_vec(), fault_injection::pbf::file(bytes)] {
        let mut data = OsmData::default();
        let _ = read_bytes(&mut data, "fuzz.osm.pbf", file);
    }
});
