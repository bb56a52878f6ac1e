//! Random towns, built and judged by all rules, for layouts that the extracts do not contain. The towns are the same in every run.
//!
//! `make test` takes 40 of them, `make soak` (LANEWRIGHT_SOAK=1) ten times as many.

mod dice;
mod extras;
mod plan;
mod streets;

use std::collections::BTreeSet;

use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::builder::{BuildOptions, build};
use lanewright::diagnostic::{Diagnostic, Severity};
use lanewright::lanelet::Loaded;

use crate::common::drawing::osm;
use crate::common::judging::judge;
use crate::common::soak;
use streets::Grid;

/// Towns of the slice.
const TOWNS: u64 = 40;
/// In one of so many towns, something may be wrong still: mostly lanes that part and lie on each other, and turns in narrow places.
const OF: usize = 5;

/// The errors in the map of a town.
fn errors(xml: &str, left_hand: bool) -> Vec<Diagnostic> {
    let side = if left_hand { DrivingSide::Left } else { DrivingSide::Right };
    let built = build(&osm(xml), &BuildOptions { driving_side: Some(side), ..BuildOptions::default() }).unwrap();
    let mut found = judge(&Loaded { map: built.map, faults: Vec::new() }, &built.settings);
    found.retain(|one| one.severity == Severity::Error);
    found
}

/// The number in a variable of the environment.
fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// To look at towns, `LANEWRIGHT_TOWNS` names a directory for those that are wrong; `LANEWRIGHT_TOWNS_FROM` takes others.
#[test]
fn few_towns_have_errors() {
    let count = if soak() { 10 * TOWNS } else { TOWNS };
    let first = number("LANEWRIGHT_TOWNS_FROM").unwrap_or(0);
    let mut wrong = BTreeSet::new();
    for seed in first..first + count {
        let mut town = Grid::new(seed);
        town.furnish();
        let xml = town.plan.xml(town.dice.between(0.0, 1.5), town.left_hand);
        let errors = errors(&xml, town.left_hand);
        if errors.is_empty() {
            continue;
        }
        if let Some(dir) = std::env::var_os("LANEWRIGHT_TOWNS") {
            std::fs::write(std::path::Path::new(&dir).join(format!("town_{seed}.osm")), xml).unwrap();
        }
        for error in errors {
            let place = error.lonlat.map(|place| format!("{:.6},{:.6}", place.lat, place.lon));
            println!("town {seed}: {} {}: {}", error.code, place.unwrap_or_default(), error.finding.message);
            wrong.insert(seed);
        }
    }
    assert!(wrong.len() * OF <= count as usize, "{} of {count} towns have errors: {wrong:?}", wrong.len());
}
