//! Walks `tests/rules/`: good maps are silent, bad maps say what stands beside them.
//!
//! `LANEWRIGHT_BLESS=1 cargo test --test rules` writes what is said now; look at the difference before you keep it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

mod common;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use common::{beside, judge_as, load};
use lanewright::report::{Sources, TextStyle, text};
use lanewright::rules;

/// The maps of one rule whose names start with `good` or `bad`.
fn maps(rule: &str, start: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/rules").join(rule);
    let Ok(entries) = std::fs::read_dir(&folder) else { return Vec::new() };
    let mut maps: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    maps.retain(|path| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with(start) && name.ends_with(".osm")
    });
    maps.sort();
    maps
}

fn rule_ids() -> Vec<&'static str> {
    rules::table().unwrap().iter().map(|row| row.requirement.id.as_str()).collect()
}

#[test]
fn every_rule_has_a_good_map_and_every_fault_a_bad_one() {
    for rule in rule_ids() {
        assert!(!maps(rule, "good").is_empty(), "tests/rules/{rule}/good.osm is missing");
        let bad: Vec<String> =
            maps(rule, "bad-").iter().map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect();
        for (slug, _) in &rules::find(rule).unwrap().faults {
            let shown = |name: &String| name.strip_prefix("bad-").is_some_and(|rest| rest.starts_with(slug.as_str()));
            assert!(bad.iter().any(shown), "tests/rules/{rule}/bad-{slug}.osm is missing");
        }
    }
}

#[test]
fn every_folder_belongs_to_a_rule() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/rules");
    let known: BTreeSet<&str> = rule_ids().into_iter().collect();
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        assert!(known.contains(name.as_str()), "tests/rules/{name} belongs to no row of the table in src/rules/mod.rs");
    }
}

#[test]
fn good_maps_are_silent() {
    for path in rule_ids().into_iter().flat_map(|rule| maps(rule, "good")) {
        let (_, loaded) = load(&path);
        let (settings, config) = beside(&path);
        let said: Vec<String> = judge_as(&loaded, &settings, &config)
            .iter()
            .map(|d| format!("{}: {}", d.code, d.finding.message))
            .collect();
        assert!(said.is_empty(), "{}: {said:#?}", path.display());
    }
}

#[test]
fn bad_maps_say_what_stands_beside_them() {
    let bless = std::env::var_os("LANEWRIGHT_BLESS").is_some();
    let mut wrong = Vec::new();
    for rule in rule_ids() {
        for path in maps(rule, "bad-") {
            let (data, loaded) = load(&path);
            let (settings, config) = beside(&path);
            let diagnostics = judge_as(&loaded, &settings, &config);
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let promised = diagnostics.iter().any(|diagnostic| {
                let slug = diagnostic.code.strip_prefix(&format!("{rule}/"));
                slug.is_some_and(|slug| name["bad-".len()..].starts_with(slug))
            });
            assert!(promised, "{} does not raise the fault it is named after", path.display());
            let sources = Sources::new(data.sources.iter().map(|source| (source.name.as_str(), source.text.as_str())));
            let mut said = Vec::new();
            text(&mut said, &diagnostics, &sources, TextStyle::default()).unwrap();
            let said = String::from_utf8(said).unwrap();
            let beside = path.with_extension("txt");
            if bless {
                std::fs::write(&beside, &said).unwrap();
            } else if std::fs::read_to_string(&beside).unwrap_or_default() != said {
                wrong.push(format!("{} now says:\n{said}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
