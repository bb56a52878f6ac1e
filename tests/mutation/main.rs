//! Mutation tests: a clean map, one mistake as a mapper makes it, and the fault that must be reported; more than a hundred kinds of
//! mistakes, at random places.
//!
//! The maps are the sample maps as `build` makes them. A mutation is found if a code that it raises is reported of a primitive
//! that it touched, and was not reported before. `LANEWRIGHT_SOAK` makes more of them; the table by kind is printed.
//! `LANEWRIGHT_SLIPS` names a directory for all broken maps, for another program to read.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]
#![allow(missing_docs)]

mod areas;
#[path = "../common/mod.rs"]
mod common;
mod control;
mod deleted_lanes;
mod draft;
mod exchanged_lights;
mod fix_rate;
mod health;
mod lanelets;
mod lanes;
mod loading;
mod projector;
mod reach;
mod restoring;
mod roads;
mod safe_routes;
mod tags;
mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use common::drawing::osm;
use common::{samples, soak};
use draft::{Dice, Draft};
use lanewright::builder::{BuildOptions, build};
use lanewright::diagnostic::{Diagnostic, Severity, Subject};
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm, to_osm};
use lanewright::osm::read_file;
use lanewright::rules::{self, Config};
use lanewright::settings::Settings;
use rayon::prelude::*;

/// Mutations of each kind: in every run, and in a soak.
const MUTATIONS: [usize; 2] = [3, 15];

/// A way to break a map.
pub struct Kind {
    pub name: &'static str,
    /// One of these must be said.
    pub raises: &'static [&'static str],
    /// Breaks the map; gives the ids of which one must be named (any if there are none), or `None` where the map has
    /// nothing to break in this way.
    pub mutate: fn(&Base, &mut Draft, &mut Dice) -> Option<Vec<i64>>,
}

/// A way to break a map, by its name, the codes of which one must be said, and what it does.
pub const fn kind(
    name: &'static str,
    raises: &'static [&'static str],
    mutate: fn(&Base, &mut Draft, &mut Dice) -> Option<Vec<i64>>,
) -> Kind {
    Kind { name, raises, mutate }
}

/// A clean map and what is known of it.
pub struct Base {
    name: String,
    draft: Draft,
    settings: Settings,
    said: BTreeSet<Said>,
    /// How far each lanelet of an intersection turns, degrees, left positive.
    pub turns: BTreeMap<i64, f64>,
    /// Lanelets that are the only ones from their approach to another.
    pub sole: Vec<i64>,
    /// Pairs of lanelets of one intersection that do not touch and do not start together.
    pub untouched: Vec<(i64, i64)>,
}

/// A finding as far as it can be told from others.
type Said = (String, Severity, Subject, String);

fn said(found: &[Diagnostic]) -> BTreeSet<Said> {
    let one = |one: &Diagnostic| (one.code.clone(), one.severity, one.finding.subject, one.finding.message.clone());
    found.iter().map(one).collect()
}

impl Base {
    fn of(sample: &Path) -> Self {
        let built = build(&read_file(sample).unwrap(), &BuildOptions::default()).unwrap();
        let mut text = Vec::new();
        to_osm(&built.map, &built.projector, &mut text).unwrap();
        let data = osm(text);
        let draft = Draft::of(&data, built.projector);
        let Loaded { map, faults } = from_osm(&data, &built.projector);
        let index = MapIndex::new(&map, &faults, &built.settings);
        let found = rules::run(&index, &Config::default()).unwrap();
        let name = sample.file_stem().unwrap().to_string_lossy().into_owned();
        let bad: Vec<&Diagnostic> = found.iter().filter(|one| one.severity > Severity::Info).collect();
        assert!(bad.is_empty(), "{name} is not clean: {bad:?}");
        let mut base = Self {
            name,
            draft,
            said: said(&found),
            turns: BTreeMap::new(),
            sole: Vec::new(),
            untouched: Vec::new(),
            settings: built.settings.clone(),
        };
        base.learn(&index);
        base
    }

    fn learn(&mut self, index: &MapIndex) {
        let id = |lane: usize| index.lanes[lane].id.0;
        for movements in index.traffic.iter().map(|traffic| &traffic.movements) {
            for one in movements {
                self.turns.insert(id(one.lane), index.lanes[one.lane].turn());
                let same = movements.iter().filter(|other| (other.from, other.to) == (one.from, one.to));
                if one.from != one.to && same.count() == 1 {
                    self.sole.push(id(one.lane));
                }
                for other in movements {
                    let touch = index.conflicts[one.lane].iter().any(|conflict| conflict.other == other.lane);
                    let apart = index.lanes[one.lane].start.ids != index.lanes[other.lane].start.ids;
                    if one.lane != other.lane && !touch && apart {
                        self.untouched.push((id(one.lane), id(other.lane)));
                    }
                }
            }
        }
    }

    /// What is said of a map after a mutation.
    fn judge(&self, draft: &Draft) -> Vec<Diagnostic> {
        let data = osm(draft.text());
        let Loaded { map, faults } = from_osm(&data, &draft.projector);
        let index = MapIndex::new(&map, &faults, &self.settings);
        rules::run(&index, &Config::default()).unwrap()
    }

    fn is_new(&self, found: &Diagnostic) -> bool {
        said(std::slice::from_ref(found)).is_disjoint(&self.said)
    }
}

fn bases() -> Vec<Base> {
    samples().iter().map(|sample| Base::of(sample)).collect()
}

fn mutations() -> usize {
    MUTATIONS[usize::from(soak())]
}

/// A kind's broken maps: the map, the seed, the draft and what must be named. Maps that cannot be broken so are passed over.
fn broken<'a>(bases: &'a [Base], at: usize, kind: &'a Kind) -> impl Iterator<Item = (&'a Base, u64, Draft, Vec<i64>)> {
    (0..mutations()).filter_map(move |nth| {
        (0..bases.len()).find_map(|turn| {
            let base = &bases[(at + nth + turn) % bases.len()];
            let seed = (at * 1000 + nth) as u64;
            let mut draft = base.draft.clone();
            let named = (kind.mutate)(base, &mut draft, &mut Dice(seed))?;
            Some((base, seed, draft, named))
        })
    })
}

/// Keeps a map that showed a fault of ours, to be looked at.
fn keep(base: &Base, kind: &Kind, seed: u64, draft: &Draft) -> String {
    keep_in(Path::new(env!("CARGO_TARGET_TMPDIR")), base, kind, seed, draft)
}

fn keep_in(directory: &Path, base: &Base, kind: &Kind, seed: u64, draft: &Draft) -> String {
    let file = format!("{}-{}-{seed}.osm", kind.name.replace(|c: char| !c.is_ascii_alphanumeric(), "_"), base.name);
    let path = directory.join(file);
    std::fs::write(&path, draft.text()).unwrap();
    path.display().to_string()
}

/// Whether the finding speaks of one of them.
fn names(found: &Diagnostic, ids: &[i64]) -> bool {
    let subjects = found.finding.related.iter().map(|related| related.subject).chain([found.finding.subject]);
    ids.is_empty() || subjects.filter_map(Subject::id).any(|id| ids.contains(&id))
}

/// All kinds of mutations.
pub fn all_kinds() -> impl Iterator<Item = &'static Kind> {
    let families = [
        loading::KINDS,
        lanelets::KINDS,
        lanes::KINDS,
        roads::KINDS,
        areas::KINDS,
        control::KINDS,
        health::KINDS,
        tags::KINDS,
        words::KINDS,
    ];
    families.into_iter().flatten()
}

struct Outcome {
    name: &'static str,
    mutations: usize,
    raised: BTreeMap<String, usize>,
    missed: Vec<String>,
}

fn try_kind(bases: &[Base], at: usize, kind: &Kind) -> Outcome {
    let mut outcome = Outcome { name: kind.name, mutations: 0, raised: BTreeMap::new(), missed: Vec::new() };
    for (base, seed, draft, named) in broken(bases, at, kind) {
        outcome.mutations += 1;
        if let Some(directory) = std::env::var_os("LANEWRIGHT_SLIPS") {
            keep_in(Path::new(&directory), base, kind, seed, &draft);
        }
        let judged = catch_unwind(AssertUnwindSafe(|| base.judge(&draft)));
        let Ok(found) = judged else {
            outcome.missed.push(format!("panicked: {}", keep(base, kind, seed, &draft)));
            continue;
        };
        let new: Vec<&Diagnostic> = found.iter().filter(|one| base.is_new(one)).collect();
        let expected = |one: &&&Diagnostic| kind.raises.contains(&one.code.as_str()) && names(one, &named);
        match new.iter().find(expected) {
            Some(one) => *outcome.raised.entry(one.code.clone()).or_default() += 1,
            None => {
                let codes: BTreeSet<&str> = new.iter().map(|one| one.code.as_str()).collect();
                outcome.missed.push(format!("{named:?} said {codes:?}: {}", keep(base, kind, seed, &draft)));
            }
        }
    }
    outcome
}

/// Mutations of which some cannot be told, [`deleted_lanes`] says how many: a lane is not missed where its ground is that of others, and
/// others lead to where it led.
const SOME_SLIP: &[&str] = &[deleted_lanes::NAME];

#[test]
fn the_fault_of_every_mutation_is_reported() {
    let bases = bases();
    // With LANEWRIGHT_MUTATION only those whose name holds its value.
    let wanted = std::env::var("LANEWRIGHT_MUTATION").unwrap_or_default();
    let kinds: Vec<&Kind> = all_kinds().filter(|kind| kind.name.contains(&wanted)).collect();
    let outcomes: Vec<Outcome> = kinds.par_iter().enumerate().map(|(at, kind)| try_kind(&bases, at, kind)).collect();
    println!("{:>5} {:>5}  mutation", "count", "found");
    for Outcome { name, mutations, raised, .. } in &outcomes {
        let codes: Vec<String> = raised.iter().map(|(code, count)| format!("{code} {count}")).collect();
        println!("{mutations:>5} {:>5}  {name}: {}", raised.values().sum::<usize>(), codes.join(", "));
    }
    let all: usize = outcomes.iter().map(|outcome| outcome.mutations).sum();
    println!("{all} mutations of {} kinds", kinds.len());
    let idle: Vec<&str> = outcomes.iter().filter(|one| one.mutations == 0).map(|one| one.name).collect();
    assert!(idle.is_empty(), "no sample map can be broken so: {idle:?}");
    let slips = |one: &Outcome| (deleted_lanes::SLIPS * one.mutations as f64).ceil() as usize;
    let may_miss = |one: &&Outcome| SOME_SLIP.contains(&one.name) && one.missed.len() <= slips(one);
    let missed: Vec<String> = outcomes
        .iter()
        .filter(|one| !may_miss(one))
        .flat_map(|one| one.missed.iter().map(move |what| format!("{}: {what}", one.name)))
        .collect();
    assert!(missed.is_empty(), "{} of {all} missed:\n{}", missed.len(), missed.join("\n"));
}

#[test]
fn nothing_is_reported_of_a_harmless_change() {
    let bases = bases();
    let loud: Vec<String> = control::HARMLESS
        .par_iter()
        .enumerate()
        .flat_map_iter(|(at, kind)| {
            let all = broken(&bases, at, kind).filter_map(|(base, seed, draft, _)| {
                let found = base.judge(&draft);
                let new: Vec<&Diagnostic> =
                    found.iter().filter(|one| one.severity > Severity::Info && base.is_new(one)).collect();
                (!new.is_empty()).then(|| format!("{}: {new:?}: {}", kind.name, keep(base, kind, seed, &draft)))
            });
            all.collect::<Vec<_>>()
        })
        .collect();
    assert!(loud.is_empty(), "{}", loud.join("\n"));
}
