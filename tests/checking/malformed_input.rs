//! Reading, judging, reporting and building neither panic nor hang, whatever is in a file. This is a short version of what the
//! fuzzers in `fuzz/` do for hours.

use lanewright::builder::{BuildOptions, build};
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm, to_osm};
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::report::{self, Report, Sources, TextStyle};
use lanewright::rules::{self, Config};
use lanewright::settings::{Document, Settings};
use lanewright::triage::{self, Suppressions};
use proptest::prelude::*;

use super::fault_injection::{self, ODD, changed, with_value};
use crate::common::drawing::osm;
use crate::common::{root, soak};

fn text_of(file: &str) -> String {
    std::fs::read_to_string(root().join(file)).unwrap()
}

/// Reads, loads, judges and reports, with projection and without.
fn judge_whatever(bytes: Vec<u8>) {
    let mut data = OsmData::default();
    if read_bytes(&mut data, "odd.osm", bytes).is_ok() {
        judge_all(&data);
    }
}

/// Loads, judges and reports, with projection and without.
fn judge_all(data: &OsmData) {
    let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
    for projector in [first.map_or(Projector::Local, Projector::mgrs), Projector::Local] {
        let Loaded { map, faults } = from_osm(data, &projector);
        let settings = Settings::default();
        let index = MapIndex::new(&map, &faults, &settings);
        let found = rules::run(&index, &Config::default()).unwrap();
        let sorted = triage::sort(found, &settings, Suppressions::of(&settings, data), &map, None);
        let sources = Sources::new(data.sources.iter().map(|source| (source.name.as_str(), source.text.as_str())));
        let to_globe = |points: &[_]| projector.inverse_each(points, |_| 0.0).into_iter().collect();
        let mut report = Report::new(&sorted.left, &sources, &map);
        report.unproject = Some(&to_globe);
        type Write = fn(&Report<'_>, &mut dyn std::io::Write) -> std::io::Result<()>;
        let writers: [Write; 6] = [
            report::json::write,
            report::sarif::write,
            report::github::write,
            report::gitlab::write,
            report::junit::write,
            report::geojson::write,
        ];
        for write in writers {
            write(&report, &mut std::io::sink()).unwrap();
        }
        report::full(&mut std::io::sink(), &report, TextStyle::default()).unwrap();
    }
}

/// Builds, and writes what was built.
fn build_whatever(bytes: Vec<u8>) {
    let mut data = OsmData::default();
    if read_bytes(&mut data, "odd.osm", bytes).is_err() {
        return;
    }
    if let Ok(built) = build(&data, &BuildOptions::default()) {
        to_osm(&built.map, &built.projector, std::io::sink()).unwrap();
    }
}

/// Cases of each test; a soak has more.
fn cases() -> u32 {
    if soak() { 2_000 } else { 32 }
}

const MAPS: [&str; 4] = [
    "tests/rules/vm-03-08/good.osm",
    "tests/rules/vm-03-10/good.osm",
    "tests/rules/vm-03-15/good.osm",
    "tests/rules/node/good.osm",
];

const EXTRACTS: [&str; 3] =
    ["sample_maps/crossing_left.osm", "sample_maps/staggered_left.osm", "sample_maps/turn_lanes_right.osm"];

/// Roads of many kilometres, as in a map whose unit was taken for another: every lane of an intersection is longer than the paths
/// that are judged.
#[test]
fn a_map_hundreds_of_times_too_large_causes_no_panic() {
    for file in ["tests/rules/vm-03-13/good.osm", "tests/rules/planner/good.osm"] {
        for factor in [600.0, 5_000.0] {
            let mut data = osm(text_of(file));
            let origin = data.nodes[0].position.unwrap();
            for node in &mut data.nodes {
                let position = node.position.as_mut().unwrap();
                position.lat = origin.lat + (position.lat - origin.lat) * factor;
                position.lon = origin.lon + (position.lon - origin.lon) * factor;
            }
            judge_all(&data);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn broken_values_cause_no_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), 0..ODD.len(), any::<bool>()), 1..12)) {
        let mut text = text_of(MAPS[changes.len() % MAPS.len()]);
        let values = text.matches('"').count() / 2;
        for (at, odd, swap) in changes {
            // Either an odd value, or one from elsewhere in the map.
            let value = match swap {
                true => text.split('"').nth(2 * at.index(values) + 1).unwrap_or_default().to_owned(),
                false => ODD[odd].to_owned(),
            };
            text = with_value(&text, at.index(values).wrapping_mul(7919), &value);
        }
        judge_whatever(text.into_bytes());
    }

    #[test]
    fn broken_maps_cause_no_panic(map in 0..MAPS.len(), bytes in prop::collection::vec(any::<u8>(), 1..120)) {
        judge_whatever(changed(&text_of(MAPS[map]), &bytes, 12));
    }

    #[test]
    fn broken_extracts_cause_no_panic(map in 0..EXTRACTS.len(), bytes in prop::collection::vec(any::<u8>(), 1..60)) {
        build_whatever(changed(&text_of(EXTRACTS[map]), &bytes, 6));
    }

    #[test]
    fn cut_and_spliced_text_causes_no_panic(from in any::<prop::sample::Index>(), to in any::<prop::sample::Index>(), junk in prop::collection::vec(any::<u8>(), 0..8)) {
        let mut bytes = text_of(MAPS[3]).into_bytes();
        let (from, to) = (from.index(bytes.len()), to.index(bytes.len()));
        bytes.splice(from.min(to)..from.max(to), junk);
        judge_whatever(bytes);
    }

    #[test]
    fn broken_pbf_causes_no_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6), cut in any::<prop::sample::Index>()) {
        let mut block = fault_injection::pbf::block();
        for (at, byte) in changes {
            let at = at.index(block.len());
            block[at] = byte;
        }
        build_whatever(fault_injection::pbf::file(&block));
        block.truncate(cut.index(block.len()));
        let whole = fault_injection::pbf::file(&block);
        build_whatever(whole[..cut.index(whole.len())].to_vec());
        build_whatever(whole);
    }

    #[test]
    fn broken_settings_cause_no_panic(at in any::<prop::sample::Index>(), length in 0_usize..20, word in prop::sample::select(&ODD[..])) {
        let text = text_of("docs/configuration.md");
        let text = text.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
        let letters: Vec<char> = text.chars().collect();
        let at = at.index(letters.len());
        let head: String = letters[..at].iter().collect();
        let tail: String = letters[(at + length).min(letters.len())..].iter().collect();
        if let Ok(document) = Document::parse("lanewright.toml", &format!("{head}{word}{tail}")) {
            let requirements: Vec<_> = rules::table().unwrap().iter().map(|row| &row.requirement).collect();
            if let Some(unknown) = rules::vet(&document.settings, &requirements) {
                document.offset(&unknown.path);
            }
        }
    }
}

#[test]
fn the_pbf_of_these_tests_is_valid() {
    let mut data = OsmData::default();
    read_bytes(&mut data, "a.osm.pbf", fault_injection::pbf::file(&fault_injection::pbf::block())).unwrap();
    assert_eq!((data.nodes.len(), data.ways.len(), data.relations.len()), (3, 1, 1));
    assert_eq!(data.ways[0].nodes, [1, 2]);
    assert_eq!(data.ways[0].tags.get("highway"), Some("residential"));
    assert_eq!(data.nodes[1].tags.get("name").or(data.nodes[2].tags.get("name")), Some("é"));
    assert_eq!(data.relations[0].members[0].id, 20);
}

#[test]
fn a_member_of_an_unknown_kind_is_an_error() {
    let mut block = fault_injection::pbf::block();
    // The last byte is the kind of the relation's member.
    *block.last_mut().unwrap() = b'e';
    let mut data = OsmData::default();
    let error = read_bytes(&mut data, "a.osm.pbf", fault_injection::pbf::file(&block)).unwrap_err();
    assert!(error.to_string().contains("a.osm.pbf is not a usable PBF file"), "{error}");
}
