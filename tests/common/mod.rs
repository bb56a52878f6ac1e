//! What the tests of the rules share: a map from a file, judged.

use std::path::{Path, PathBuf};

use lanewright::diagnostic::Diagnostic;
use lanewright::lanelet::index::{MapIndex, Thresholds};
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::rules::{self, Config};
use lanewright::settings::Settings;

/// A file's content and the map Autoware would make of it, in the MGRS square of its first node.
pub fn load(path: &Path) -> (OsmData, Loaded) {
    let mut data = OsmData::default();
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    read_bytes(&mut data, &name, std::fs::read(path).unwrap()).unwrap();
    let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
    let loaded = from_osm(&data, &first.map_or(Projector::Local, Projector::mgrs));
    (data, loaded)
}

/// The findings of all rules as their documents have them.
pub fn judge(loaded: &Loaded, settings: &Settings) -> Vec<Diagnostic> {
    let index = MapIndex::new(&loaded.map, &loaded.faults, settings, Thresholds::default());
    rules::run(&index, &Config::default()).unwrap()
}

/// A file of the material beside the project; `None`, said aloud, where it is not there.
#[allow(dead_code)]
pub fn shared(path: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let root = std::env::var_os("LANEWRIGHT_SHARED").map_or_else(beside, PathBuf::from);
    if root.is_dir() {
        return Some(root.join(path));
    }
    eprintln!("skipped: ../shared is not here");
    None
}
