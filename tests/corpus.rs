//! Real extracts of OpenStreetMap build, fast enough, and the real Lanelet2 library accepts what comes out.
//!
//! `make test` takes the small ones, `make soak` (LANEWRIGHT_SOAK=1) all of them.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

mod support;

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use support::{accept, lanewright, osm_files, shared};

/// Largest input of the slice, bytes: the Lanelet2 library's check of a larger one takes minutes.
const SLICE: u64 = 1_000_000;

fn corpus() -> Vec<PathBuf> {
    let Some(shared) = shared() else { return Vec::new() };
    let whole = std::env::var_os("LANEWRIGHT_SOAK").is_some();
    let small = |path: &PathBuf| whole || fs::metadata(path).is_ok_and(|m| m.len() <= SLICE);
    osm_files(&shared.join("corpus/osm")).into_iter().filter(small).collect()
}

#[test]
fn every_extract_builds_and_is_accepted() {
    let dir = tempfile::tempdir().unwrap();
    let mut faults = Vec::new();
    for input in corpus() {
        let name = input.file_name().unwrap().to_string_lossy().into_owned();
        let map = dir.path().join(&name);
        let start = Instant::now();
        let run = lanewright(dir.path(), &["build", input.to_str().unwrap(), "-o", map.to_str().unwrap()]);
        eprintln!("{name}: built in {:.2} s", start.elapsed().as_secs_f64());
        if run.code != 0 {
            faults.push(format!("{name} does not build:\n{}", run.stderr));
            continue;
        }
        let Some(verdict) = accept(&map.join("lanelet2_map.osm"), false) else { continue };
        if verdict.code != 0 {
            faults.push(format!("{name} is not accepted:\n{}{}", verdict.stdout, verdict.stderr));
        }
        let judged = lanewright(dir.path(), &["check", map.to_str().unwrap(), "--format", "concise"]);
        if judged.code == 2 || judged.code < 0 {
            faults.push(format!("{name} cannot be checked:\n{}", judged.stderr));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
