//! What the test binaries share: files of the project, how much is to be tested, and files that tests can write anew.

#![allow(dead_code, reason = "no test binary uses all of it")]

pub mod drawing;
pub mod judging;
pub mod needs;
pub mod program;
pub mod routes;

use std::fs;
use std::path::{Path, PathBuf};

use needs::shared;

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The `.osm` files below a directory, sorted; there is at least one.
pub fn osm_files(dir: &Path) -> Vec<PathBuf> {
    let (mut open, mut files) = (vec![dir.to_path_buf()], Vec::new());
    while let Some(dir) = open.pop() {
        let (dirs, others): (Vec<PathBuf>, Vec<PathBuf>) =
            fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()).partition(|path| path.is_dir());
        open.extend(dirs);
        files.extend(others.into_iter().filter(|path| path.extension().is_some_and(|extension| extension == "osm")));
    }
    files.sort();
    assert!(!files.is_empty(), "no .osm file in {}", dir.display());
    files
}

/// What lies in a directory, by name.
pub fn names(dir: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort_unstable();
    names
}

/// The name of a file without its extension.
pub fn stem(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

/// The sample maps, sorted.
pub fn samples() -> Vec<PathBuf> {
    osm_files(&root().join("sample_maps"))
}

/// The maps of the rules' tests whose names start with this, sorted.
pub fn rule_maps(start: &str) -> Vec<PathBuf> {
    let mut maps = osm_files(&root().join("tests/rules"));
    maps.retain(|path| path.file_name().unwrap().to_string_lossy().starts_with(start));
    maps
}

/// The `.osm` files below a folder of `../shared`, which are so many; none, noted as skipped, without `../shared`.
pub fn shared_maps(folder: &str, count: usize) -> Vec<PathBuf> {
    let Some(folder) = shared(folder) else { return Vec::new() };
    let files = osm_files(&folder);
    assert_eq!(files.len(), count, "in {}", folder.display());
    files
}

/// Autoware's and other hand-made Lanelet2 maps.
pub fn hand_made_maps() -> Vec<PathBuf> {
    shared_maps("corpus/lanelet2", 13)
}

/// Extracts of OpenStreetMap up to this size in bytes, or all of them in a soak.
pub fn extracts(most: u64) -> Vec<PathBuf> {
    up_to(most, shared_maps("corpus/osm", 21))
}

/// The same with the extracts that the builder did not grow up with.
pub fn all_extracts(most: u64) -> Vec<PathBuf> {
    up_to(most, [shared_maps("corpus/osm", 21), shared_maps("corpus/osm_more", 22)].concat())
}

fn up_to(most: u64, mut files: Vec<PathBuf>) -> Vec<PathBuf> {
    if files.is_empty() {
        return files;
    }
    files.retain(|path| soak() || fs::metadata(path).unwrap().len() <= most);
    assert!(!files.is_empty(), "no extract has {most} bytes or less");
    files
}

/// Whether the long tests are to run whole: `make soak` sets LANEWRIGHT_SOAK.
pub fn soak() -> bool {
    std::env::var_os("LANEWRIGHT_SOAK").is_some()
}

/// Whether expected files are to be written anew instead of compared: LANEWRIGHT_UPDATE=1.
pub fn updating() -> bool {
    std::env::var_os("LANEWRIGHT_UPDATE").is_some()
}

/// Compares a file with what it should hold, or writes it with LANEWRIGHT_UPDATE; whether the file holds it now.
pub fn is_fresh(path: &Path, wanted: &str) -> bool {
    if updating() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, wanted).unwrap();
    }
    fs::read_to_string(path).unwrap_or_default() == wanted
}
