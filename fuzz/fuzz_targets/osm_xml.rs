//! Any bytes as a file: XML, gzip, or neither. What is read is loaded as a map, with projection and without.

#![no_main]

use lanewright::lanelet::from_osm;
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::{MgrsGrid, Projector};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut data = OsmData::default();
    if read_bytes(&mut data, "fuzz.osm", bytes.to_vec()).is_ok() {
        let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
        from_osm(&data, &first.map_or(Projector::Local, Projector::mgrs));
        from_osm(&data, &Projector::Local);
    }
});
