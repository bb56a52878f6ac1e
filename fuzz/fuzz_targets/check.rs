//! A sound map, damaged as the bytes say, or any bytes as a map: loaded and judged by all rules. The first byte chooses.

#![no_main]

#[path = "../../tests/fault_injection/mod.rs"]
mod fault_injection;

use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::rules::{self, Config};
use lanewright::settings::Settings;
use libfuzzer_sys::fuzz_target;

const MAPS: [&str; 9] = [
    include_str!("../../tests/rules/vm-03-01/good-two.osm"),
    include_str!("../../tests/rules/vm-03-04/good.osm"),
    include_str!("../../tests/rules/vm-03-06/good.osm"),
    include_str!("../../tests/rules/vm-03-07/good.osm"),
    include_str!("../../tests/rules/vm-03-08/good.osm"),
    include_str!("../../tests/rules/vm-03-11/good.osm"),
    include_str!("../../tests/rules/vm-03-13/good.osm"),
    include_str!("../../tests/rules/vm-03-15/good.osm"),
    include_str!("../../tests/rules/node/good.osm"),
];

fuzz_target!(|bytes: &[u8]| {
    let Some((&choice, bytes)) = bytes.split_first() else { return };
    let text = match MAPS.get(usize::from(choice) % (MAPS.len() + 1)) {
        Some(map) => fault_injection::changed(map, bytes, 16),
        None => bytes.to_vec(),
    };
    let mut data = OsmData::default();
    if read_bytes(&mut data, "fuzz.osm", text).is_err() {
        return;
    }
    let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
    let projector = first.filter(|_| choice < 200).map_or(Projector::Local, Projector::mgrs);
    let Loaded { map, faults } = from_osm(&data, &projector);
    let settings = Settings::default();
    let index = MapIndex::new(&map, &faults, &settings);
    rules::run(&index, &Config::default()).expect("the documents' own parameters fit");
});
