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
const OF: usize = 6;

/// The errors in the map of a town.
fn errors(xml: &str, left_hand: bool) -> Vec<Diagnostic> {
    let side = if left_hand { DrivingSide::Left } else { DrivingSide::Right };
    let built = build(&osm(xml), &BuildOptions { driving_side: Some(side), ..BuildOptions::default() }).unwrap();
    let mut found = judge(&Loaded { map: built.map, faults: Vec::new() }, &built.settings);
    found.retain(|one| one.severity == Severity::Error);
    found
}

/// Towns side by side in a strip of some kilometres, with roads from each to the next, at a place that differs.
pub fn region(seed: u64) -> String {
    /// How far the towns lie apart, metres.
    const APART: f64 = 550.0;
    const TOWNS: u64 = 7;
    let mut strip = Grid::new(1_000 * seed);
    strip.furnish();
    let shift = [strip.dice.between(0.0, 2_000.0), strip.dice.between(0.0, 2_000.0)];
    let turned = strip.dice.between(0.0, 6.0);
    let end = |arm: usize| move |crossing: &streets::Crossing| crossing.arms[arm].first().copied();
    let mut east = strip.crossings.iter().rev().find_map(end(0));
    for at in 1..TOWNS {
        let mut town = Grid::new(1_000 * seed + at);
        town.furnish();
        let (west, next) = (town.crossings.iter().find_map(end(2)), town.crossings.iter().rev().find_map(end(0)));
        let first = strip.plan.put_beside(&town.plan, [APART * at as f64, 0.0]);
        if let (Some(from), Some(to)) = (east, west) {
            strip.plan.way(vec![from, first + to], "highway=secondary");
        }
        east = next.map(|node| first + node);
    }
    strip.plan.shift(shift);
    strip.plan.xml(turned, strip.left_hand)
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
