//! Every sample map builds, without findings of our rules; the real Lanelet2 library accepts it; its bytes are always the same.

use std::fs;
use std::path::Path;

use crate::common::needs::accept;
use crate::common::program::{Run, command, lanewright};
use crate::common::{samples, stem};

/// What `build` writes.
const FILES: [&str; 3] = ["lanelet2_map.osm", "map_projector_info.yaml", "lanewright.toml"];

fn build(sample: &Path, dir: &Path, threads: &str) -> Vec<Vec<u8>> {
    let out = dir.to_str().unwrap();
    let mut build = command(dir.parent().unwrap(), &["build", sample.to_str().unwrap(), "-o", out]);
    Run::from(build.env("RAYON_NUM_THREADS", threads).output().unwrap()).exits(0);
    FILES.iter().map(|file| fs::read(dir.join(file)).unwrap()).collect()
}

#[test]
fn there_are_samples_for_either_side() {
    let names: Vec<String> = samples().iter().map(|s| stem(s)).collect();
    for wanted in ["crossing_left", "crossing_right", "tjunction_left", "tjunction_right"] {
        assert!(names.iter().any(|n| n == wanted), "{wanted} is missing in {names:?}");
    }
}

#[test]
fn our_rules_find_nothing_in_any_sample() {
    let dir = tempfile::tempdir().unwrap();
    let mut loud = Vec::new();
    for sample in samples() {
        let map = dir.path().join(stem(&sample));
        build(&sample, &map, "2");
        let run =
            lanewright(dir.path(), &["check", map.to_str().unwrap(), "--fail-on", "warning", "--format", "concise"]);
        if run.code != 0 {
            loud.push(format!("{}:\n{}{}", stem(&sample), run.stdout, run.stderr));
        }
    }
    assert!(loud.is_empty(), "{}", loud.join("\n"));
}

#[test]
fn the_lanelet2_library_accepts_every_sample() {
    let dir = tempfile::tempdir().unwrap();
    let mut refused = Vec::new();
    for sample in samples() {
        let map = dir.path().join(stem(&sample));
        build(&sample, &map, "2");
        let Some(run) = accept(&map.join(FILES[0]), true) else { return };
        if run.code != 0 {
            refused.push(format!("{}:\n{}{}", stem(&sample), run.stdout, run.stderr));
        }
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

#[test]
fn the_same_input_gives_the_same_bytes_whatever_the_threads() {
    let dir = tempfile::tempdir().unwrap();
    for sample in samples() {
        let first = build(&sample, &dir.path().join("a"), "1");
        for (again, threads) in [("b", "1"), ("c", "7")] {
            let other = build(&sample, &dir.path().join(again), threads);
            for ((file, a), b) in FILES.iter().zip(&first).zip(&other) {
                assert!(a == b, "{file} of {} differs with {threads} threads", stem(&sample));
            }
        }
    }
}

#[test]
fn every_sample_can_be_drawn() {
    let dir = tempfile::tempdir().unwrap();
    for sample in samples() {
        let map = dir.path().join(stem(&sample));
        build(&sample, &map, "2");
        let picture = dir.path().join("picture.png");
        lanewright(dir.path(), &["draw", map.to_str().unwrap(), "-o", picture.to_str().unwrap(), "--ids"]).exits(0);
        assert!(fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
    }
}
