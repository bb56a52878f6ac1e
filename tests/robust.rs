//! Whatever stands in a map, judging it neither panics nor hangs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

use std::path::Path;

use lanewright::lanelet::from_osm;
use lanewright::lanelet::index::{MapIndex, Thresholds};
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::rules::{self, Config};
use lanewright::settings::Settings;
use proptest::prelude::*;

/// Values that tools write by mistake, or that mean to harm.
const ODD: [&str; 16] = [
    "",
    "0",
    "-1",
    "1",
    "2",
    "nan",
    "inf",
    "1e308",
    "-1e308",
    "1e-320",
    "150",
    "2147483648",
    "left",
    "virtual",
    "yes",
    "é",
];

/// The text with the `nth` quoted value replaced.
fn with_value(text: &str, nth: usize, value: &str) -> String {
    let quotes: Vec<usize> = text.match_indices('"').map(|(at, _)| at).collect();
    let pairs: Vec<(usize, usize)> = quotes.chunks_exact(2).map(|pair| (pair[0] + 1, pair[1])).collect();
    let (from, to) = pairs[nth % pairs.len()];
    format!("{}{value}{}", &text[..from], &text[to..])
}

fn judge_whatever(text: String) {
    let mut data = OsmData::default();
    if read_bytes(&mut data, "odd.osm", text.into_bytes()).is_err() {
        return;
    }
    let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
    for projector in [first.map_or(Projector::Local, Projector::mgrs), Projector::Local] {
        let loaded = from_osm(&data, &projector);
        let settings = Settings::default();
        let index = MapIndex::new(&loaded.map, &loaded.faults, &settings, Thresholds::default());
        rules::run(&index, &Config::default()).unwrap();
    }
}

proptest! {
    #[test]
    fn broken_values_are_survived(changes in prop::collection::vec((any::<prop::sample::Index>(), 0..ODD.len(), any::<bool>()), 1..12)) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/rules");
        let mut text = std::fs::read_to_string(folder.join("vm-03-08/good.osm")).unwrap();
        let local = std::fs::read_to_string(folder.join("node/good.osm")).unwrap();
        if changes.len() % 3 == 0 {
            text = local;
        }
        let values = text.matches('"').count() / 2;
        for (at, odd, swap) in changes {
            // Either an odd value, or one from elsewhere in the map.
            let value = match swap {
                true => text.split('"').nth(2 * at.index(values) + 1).unwrap_or_default().to_owned(),
                false => ODD[odd].to_owned(),
            };
            text = with_value(&text, at.index(values).wrapping_mul(7919), &value);
        }
        judge_whatever(text);
    }
}
