//! Maps that are built for TIER IV's validator: what is left of its errors, and that our own rules find no more than else.

use std::collections::BTreeMap;
use std::path::Path;

use crate::common::program::lanewright;
use crate::common::{extracts, samples};
use crate::extracts::SLICE;

/// The errors that remain, each with both texts in `docs/tier4.md`.
const REMAIN: [&str; 7] = [
    "vm-01-03/not-shared",
    "vm-01-03/partly-shared",
    "vm-03-01/no-right-of-way",
    "vm-03-08/edge-not-border",
    "vm-03-10/re-missing",
    "vm-03-10/yield-missing",
    "vm-03-10/yield-needless",
];

/// How many errors of each code there are in a map.
fn errors(dir: &Path, map: &Path, profile: &str) -> BTreeMap<String, usize> {
    let arguments = ["check", map.to_str().unwrap(), "--isolated", "--profile", profile, "--format", "concise"];
    let run = lanewright(dir, &arguments);
    let mut found = BTreeMap::new();
    for line in run.stdout.lines() {
        let code = line.split_once(": error[").and_then(|(_, rest)| rest.split_once(']'));
        if let Some((code, _)) = code {
            *found.entry(code.to_owned()).or_default() += 1;
        }
    }
    found
}

/// The map of an input, built as a profile reads the requirements.
fn built(dir: &Path, input: &Path, profile: &str) -> std::path::PathBuf {
    let map = dir.join(profile).join(input.file_stem().unwrap());
    let arguments = ["build", input.to_str().unwrap(), "--isolated", "--profile", profile, "-o", map.to_str().unwrap()];
    lanewright(dir, &arguments).exits(0);
    map
}

#[test]
fn a_sample_for_the_validator_has_only_errors_that_contradict_autoware() {
    let dir = tempfile::tempdir().unwrap();
    for input in samples() {
        let map = built(dir.path(), &input, "tier4");
        let left = errors(dir.path(), &map, "tier4");
        // Where people drive on the right, the validator lets a turn to the left ignore the oncoming turn to the right. Where
        // bicycles have lanes, the edge of an area lies between these and the lanes for cars.
        let name = input.file_stem().unwrap().to_string_lossy();
        let remains = |code: &String| match code.as_str() {
            "vm-03-10/yield-missing" => name.ends_with("right"),
            "vm-03-08/edge-not-border" => name.starts_with("bicycles"),
            _ => false,
        };
        assert!(left.keys().all(remains), "{}: {left:?}", input.display());
        let ours = errors(dir.path(), &map, "ours");
        assert!(ours.is_empty(), "{}: {ours:?}", input.display());
    }
}

#[test]
fn an_extract_for_the_validator_has_only_errors_that_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    for input in extracts(SLICE) {
        let [plain, map] = ["ours", "tier4"].map(|profile| built(dir.path(), &input, profile));
        let mut left = errors(dir.path(), &map, "tier4");
        left.retain(|code, _| !REMAIN.contains(&code.as_str()));
        let before = errors(dir.path(), &plain, "ours");
        let mut more = errors(dir.path(), &map, "ours");
        more.retain(|code, count| *count > before.get(code).copied().unwrap_or(0) && !REMAIN.contains(&code.as_str()));
        if !left.is_empty() || !more.is_empty() {
            wrong.push(format!("{}: theirs {left:?}, ours {more:?}", input.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
