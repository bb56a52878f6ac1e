//! Random towns, built and judged by all rules, for layouts that the extracts do not contain. The towns are the same in every run.
//!
//! `make test` takes 40 of each kind, `make soak` (LANEWRIGHT_SOAK=1) ten times as many.

mod arterial;
mod dice;
mod extras;
mod house_rows;
mod obeyed_tags;
mod plan;
mod streets;

use std::collections::BTreeSet;

use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::builder::{BuildOptions, Built, build};
use lanewright::diagnostic::{Diagnostic, Place, Severity};
use lanewright::geometry::Point;
use lanewright::lanelet::Loaded;

use crate::common::drawing::osm;
use crate::common::judging::judge;
use crate::common::soak;
use arterial::arterial;
use dice::Dice;
use house_rows::house_rows;
use streets::Grid;

/// Towns of the slice.
const TOWNS: u64 = 40;
/// At most one town in this number may have errors. Most of these are at wide roads that lead onto a small roundabout, and at turns
/// without room.
const OF: usize = 20;

/// Streets between car parks of the slice, and the number of which one may have errors.
const ARTERIALS: u64 = 40;
const OF_ARTERIALS: usize = 50;

/// Streets with rows of houses of the slice. Nothing may be wrong in any of those of the soak.
const HOUSE_ROWS: u64 = 40;
const OF_HOUSE_ROWS: usize = 1000;

/// What lanes that nothing leads to, or that lead to nothing, are found for ...
const CLOSED_LANES: [&str; 2] = ["vm-03-04/in-lane-dead-end", "vm-03-04/out-lane-unreached"];

/// ... within this distance, metres, of the place that the build's note names.
const AT_CLOSED_LANE: f64 = 40.0;

fn built(xml: &str, left_hand: bool) -> Built {
    let side = if left_hand { DrivingSide::Left } else { DrivingSide::Right };
    build(&osm(xml), &BuildOptions { driving_side: Some(side), ..BuildOptions::default() }).unwrap()
}

/// The errors in a map.
fn errors_of(built: &Built) -> Vec<Diagnostic> {
    let mut found = judge(&Loaded { map: built.map.clone(), faults: Vec::new() }, &built.settings);
    found.retain(|one| one.severity == Severity::Error);
    found
}

/// The errors in the map of a town.
fn errors(xml: &str, left_hand: bool) -> Vec<Diagnostic> {
    errors_of(&built(xml, left_hand))
}

/// The same without lanes that tags and restrictions close: the input is at fault there, and a note names the place.
fn errors_but_closed_lanes(xml: &str, left_hand: bool) -> Vec<Diagnostic> {
    let built = built(xml, left_hand);
    let closed = built.notes.iter().filter(|note| note.fault == "lane-closed");
    let closed: Vec<Point> =
        closed.filter_map(|note| if let Place::Point(at) = note.place { Some(at) } else { None }).collect();
    let is_closed = |one: &Diagnostic| {
        let at = one.lonlat.and_then(|at| built.projector.forward(at, 0.0));
        let is_noted = at.is_some_and(|at| closed.iter().any(|place| (place - at).norm() < AT_CLOSED_LANE));
        CLOSED_LANES.contains(&one.code.as_str()) && is_noted
    };
    errors_of(&built).into_iter().filter(|one| !is_closed(one)).collect()
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

/// Builds worlds of a kind, each from its XML and the side on which people drive; in no more than one `of` so many there are errors.
/// To look at them, `LANEWRIGHT_TOWNS` names a directory for those that are wrong; `LANEWRIGHT_TOWNS_FROM` takes others.
fn few_have_errors(
    kind: &str,
    (count, of): (u64, usize),
    errors: fn(&str, bool) -> Vec<Diagnostic>,
    draw: impl Fn(u64) -> (String, bool),
) {
    let count = if soak() { 10 * count } else { count };
    let first = number("LANEWRIGHT_TOWNS_FROM").unwrap_or(0);
    let mut wrong = BTreeSet::new();
    for seed in first..first + count {
        let (xml, left_hand) = draw(seed);
        let errors = errors(&xml, left_hand);
        if errors.is_empty() {
            continue;
        }
        if let Some(dir) = std::env::var_os("LANEWRIGHT_TOWNS") {
            std::fs::write(std::path::Path::new(&dir).join(format!("{kind}_{seed}.osm")), xml).unwrap();
        }
        for error in errors {
            let place = error.lonlat.map(|place| format!("{:.6},{:.6}", place.lat, place.lon));
            println!("{kind} {seed}: {} {}: {}", error.code, place.unwrap_or_default(), error.finding.message);
            wrong.insert(seed);
        }
    }
    assert!(wrong.len() * of <= count as usize, "{} of {count} have errors: {wrong:?}", wrong.len());
}

/// The town of a seed, and whether people drive on the left there.
fn town(seed: u64) -> (String, bool) {
    let mut town = Grid::new(seed);
    town.furnish();
    (town.plan.xml(town.dice.between(0.0, 1.5), town.left_hand), town.left_hand)
}

#[test]
fn few_towns_have_errors() {
    few_have_errors("town", (TOWNS, OF), errors, town);
}

#[test]
fn few_towns_whose_tags_bind_drivers_have_errors() {
    few_have_errors("tagged_town", (TOWNS, OF), errors_but_closed_lanes, |seed| {
        let mut town = Grid::new(seed);
        town.furnish();
        town.plan.obey(&mut Dice::new(seed));
        (town.plan.xml(town.dice.between(0.0, 1.5), town.left_hand), town.left_hand)
    });
}

/// Bicycle lanelets between bounds that would squeeze them; shoulders along a lanelet of an intersection; lanes at the median of a divided
/// road that only a U-turn reaches; lanes beside one that leads around the island of a roundabout; lanes side by side that would
/// change sides; turns that begin in a corner or bend too tightly; lanes in for whose turn there is no room; lanes of buses side by side
/// with lanes of cars.
#[test]
fn corners_of_towns_have_no_errors() {
    let seeds = [53, 149, 178, 243, 89, 383, 298, 370];
    let mended = [64, 159, 679, 714, 419, 492, 589, 592, 103, 173, 216, 569, 242, 51, 163, 162, 198, 236, 318, 176];
    for seed in seeds.into_iter().chain(mended) {
        let (xml, left_hand) = town(seed);
        let found = errors(&xml, left_hand);
        assert!(found.is_empty(), "town {seed}: {found:?}");
    }
}

#[test]
fn few_streets_between_car_parks_have_errors() {
    few_have_errors("arterial", (ARTERIALS, OF_ARTERIALS), errors, |seed| {
        let mut dice = Dice::new(seed);
        let left_hand = dice.chance(0.5);
        (arterial(&mut dice).xml(dice.between(0.0, 6.0), left_hand), left_hand)
    });
}

#[test]
fn no_street_with_rows_of_houses_has_errors() {
    few_have_errors("house_row", (HOUSE_ROWS, OF_HOUSE_ROWS), errors, |seed| {
        let mut dice = Dice::new(seed);
        let left_hand = dice.chance(0.5);
        (house_rows(&mut dice).xml(dice.between(0.0, 6.0), left_hand), left_hand)
    });
}
