//! Any text as lanewright.toml, held against the rules, and a map judged by it.

#![no_main]

use std::sync::LazyLock;

use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::rules::{self, Config};
use lanewright::settings::Document;
use libfuzzer_sys::fuzz_target;

static MAP: LazyLock<Loaded> = LazyLock::new(|| {
    let mut data = OsmData::default();
    let text = include_str!("../../tests/rules/vm-03-08/good.osm").as_bytes().to_vec();
    read_bytes(&mut data, "good.osm", text).expect("a sound map");
    let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
    from_osm(&data, &first.map_or(Projector::Local, Projector::mgrs))
});

fuzz_target!(|text: &str| {
    let Ok(document) = Document::parse("lanewright.toml", text) else { return };
    let requirements: Vec<_> = rules::table().expect("sound documents").iter().map(|row| &row.requirement).collect();
    if let Some(unknown) = rules::vet(&document.settings, &requirements) {
        document.offset(&unknown.path);
        return;
    }
    let Loaded { map, faults } = &*MAP;
    let index = MapIndex::new(map, faults, &document.settings);
    let _ = rules::run(&index, &Config::from(&document.settings));
});
