//! How often `fix` makes a clean map of one that a mutation has broken, by kind of mutation.

use std::panic::{AssertUnwindSafe, catch_unwind};

use lanewright::diagnostic::{Diagnostic, Severity};
use lanewright::fix::mend;
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::index::Thresholds;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::OsmData;
use lanewright::rules::{self, Config, ConfigError};
use rayon::prelude::*;

use super::draft::Draft;
use super::{Base, Kind, all_kinds, bases, broken, keep};
use crate::common::drawing::osm;

/// Mutations that a program can take back for certain: what is gone follows from what is left.
const ALL: &[&str] = &[
    "drop turn_direction",
    "drop intersection_area",
    "drop area=yes of an area",
    "drop a latitude",
    "duplicate a node's id",
    "give an element a negative id",
    "give an area an id beyond 31 bits",
    "drop a height",
    "drop a local coordinate",
    "drop a relation's type",
    "drop an element's subtype",
    "let a lanelet forget its light",
    "let a lanelet forget its right_of_way",
    "delete a yield",
    "copy an end node",
    "tear an end node 0.4 m off",
    "forget a whole intersection",
    "write a speed with its unit",
    "turn a light around",
    "drop a light's height",
    "drop lane_change between lanes",
    "drop lane_change of a middle line",
];

/// What came of a kind: mutations, clean maps after safe fixes, after all fixes, and where a map was left that should not be.
struct FixRate {
    name: &'static str,
    mutations: usize,
    safely: usize,
    with_all: usize,
    left: Vec<String>,
}

/// What is worse than before the mutation, after fixing.
fn worse(base: &Base, draft: &Draft, unsafe_too: bool) -> Vec<Diagnostic> {
    let data = osm(draft.text());
    let judge = |osm: &OsmData| -> Result<Vec<Diagnostic>, ConfigError> {
        let Loaded { map, faults } = from_osm(osm, &draft.projector);
        let index = MapIndex::new(&map, &faults, &base.settings, Thresholds::default());
        rules::run(&index, &Config::default())
    };
    let mut left = mend(data, unsafe_too, judge).unwrap().left;
    left.retain(|found| found.severity > Severity::Info && base.is_new(found));
    left
}

fn fix_rate(bases: &[Base], at: usize, kind: &Kind) -> FixRate {
    let mut rate = FixRate { name: kind.name, mutations: 0, safely: 0, with_all: 0, left: Vec::new() };
    for (base, seed, draft, _) in broken(bases, at, kind) {
        // Where the mutation took the id by which lanewright.toml names an area, nobody can know which one was meant.
        let mut named = base.settings.intersection.iter().filter_map(|one| one.ia);
        if named.any(|id| !draft.ways.iter().any(|way| way.id == id)) {
            continue;
        }
        let [safely, with_all] =
            [false, true].map(|unsafe_too| catch_unwind(AssertUnwindSafe(|| worse(base, &draft, unsafe_too))).ok());
        rate.mutations += 1;
        rate.safely += usize::from(safely.as_ref().is_some_and(Vec::is_empty));
        rate.with_all += usize::from(with_all.as_ref().is_some_and(Vec::is_empty));
        if with_all.as_ref().is_none_or(|left| !left.is_empty()) {
            let said: Vec<String> = with_all
                .iter()
                .flatten()
                .map(|one| format!("{}: {} ({:?})", one.code, one.finding.message, one.finding.fix.is_some()))
                .collect();
            rate.left.push(format!("{said:?}: {}", keep(base, kind, seed, &draft)));
        }
    }
    rate
}

#[test]
fn fix_makes_a_clean_map_of_a_broken_one() {
    let bases = bases();
    // With LANEWRIGHT_MUTATION only those whose name holds its value: for the one who mends a fix.
    let wanted = std::env::var("LANEWRIGHT_MUTATION").unwrap_or_default();
    let kinds: Vec<&Kind> = all_kinds().filter(|kind| kind.name.contains(&wanted)).collect();
    let all: Vec<FixRate> = kinds.par_iter().enumerate().map(|(at, kind)| fix_rate(&bases, at, kind)).collect();
    println!("{:>5} {:>6} {:>5}  mutation", "count", "safely", "fixed");
    for FixRate { name, mutations, safely, with_all, left } in &all {
        println!("{mutations:>5} {safely:>6} {with_all:>5}  {name}");
        if !wanted.is_empty() {
            left.iter().for_each(|left| println!("{left}"));
        }
    }
    let sum = |of: fn(&FixRate) -> usize| all.iter().map(of).sum::<usize>();
    println!("{:>5} {:>6} {:>5}  all", sum(|one| one.mutations), sum(|one| one.safely), sum(|one| one.with_all));
    for name in ALL.iter().filter(|name| name.contains(&wanted)) {
        let rate = all.iter().find(|one| one.name == *name).unwrap_or_else(|| panic!("no mutation `{name}`"));
        assert_eq!(rate.with_all, rate.mutations, "{name}: {:#?}", rate.left);
    }
}
