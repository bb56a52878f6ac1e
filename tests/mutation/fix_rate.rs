//! How often `fix` makes a clean map of one that a mutation has broken, by kind of mutation.

use std::panic::{AssertUnwindSafe, catch_unwind};

use lanewright::diagnostic::{Diagnostic, Severity};
use lanewright::fix::mend;
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::OsmData;
use lanewright::rules::{self, Config, ConfigError};
use rayon::prelude::*;

use super::draft::Draft;
use super::{Base, Kind, all_kinds, bases, broken, keep};
use crate::common::drawing::osm;
use crate::common::{is_fresh, root, soak};

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
    "exchange the lights of two approaches that cross",
    "let two approaches that cross obey each other's light",
    "drop a light's height",
    "drop lane_change between lanes",
    "drop lane_change of a middle line",
];

/// Why slips stay, by the reason. The first reasons are those of slips that take with them what the map knew.
const LOST: &[(&str, &[&str])] = &[
    (
        "what was there is gone",
        &[
            "delete a node of a way",
            "delete a bound",
            "delete a lanelet that gives way",
            "delete a lanelet",
            "empty a way",
            "cut a bound down to one node",
            "take a node for a bound",
            "delete a stop line and its marking",
            "drop a bound of a lanelet",
            "delete an element that lanelets refer to",
            "let all forget a light",
        ],
    ),
    (
        "the value is gone",
        &[
            "name a later format",
            "write a distance that is no number",
            "write a speed that is no number",
            "write a speed beyond all limits",
            "slow down by a word",
            "slow down from a word on",
            "write a light's height in centimetres",
        ],
    ),
    (
        "a person has to draw the right shape",
        &[
            "move a node of a curve 0.4 m sideways",
            "let a bound bulge by half a lane",
            "let a lane reach over the line to oncoming traffic",
            "lay a lane onto the oncoming one over ways of its own",
            "leave out the middle line and draw the border beside the middle",
            "leave out the middle line of a road too narrow for two",
            "lay two lanes of a wide road onto each other",
            "let a centre line leave its lane",
            "let a lane's two sides change places",
            "let a lane end in a point",
            "move a stop line 2 m back",
            "turn a stop line",
        ],
    ),
    (
        "two readings are possible, and the map does not tell which is meant",
        &[
            "give a node the id of another",
            "duplicate a way's id",
            "give a lanelet a second bound",
            "make a shoulder of a lane",
            "raise one side of a lane by 2 m",
            "move a node 0.4 m by latitude and longitude alone",
            "move a node into another square",
            "let a light or sign stop vehicles at a second line",
            "paint a bound",
            "close one side beside lane_change",
            "close one side alone",
            "turn a light by a quarter",
        ],
    ),
    (
        "only the street tells whether it is there",
        &[
            "put a walkway onto a crosswalk",
            "make a walkway for bicycles of a crosswalk",
            "let a walkway go on along the road",
            "draw a walkway that crosses nothing",
            "let a crosswalk be continued by another",
            "draw a fence across a crosswalk",
            "draw a guard rail across a lane",
            "misspell a guard rail",
            "hatch a lane",
            "draw a lanelet of no length",
            "draw a crosswalk's stop line behind it",
            "draw a stop line that nothing refers to",
        ],
    ),
];

/// Reasons of slips that a machine could mend.
const OPEN: &[(&str, &[&str])] = &[
    (
        "a lanelet has to be divided or merged with all that hangs on it",
        &["split a lanelet", "cut a lane and not the oncoming one"],
    ),
    ("the loader asks for a stop line, and none is near", &["watch an area without an element"]),
    ("some of these areas lie where no bus can stop", &["stop buses without an element"]),
    ("no outline is found, or a lane reaches far beyond the others", &["shift a vertex inward"]),
];

/// At least this share of the slips that leave enough in the map is mended.
const LEAST: f64 = 0.8;

/// What came of a kind: mutations, clean maps after safe fixes, after all fixes, and where a map was left that should not be.
struct FixRate {
    name: &'static str,
    mutations: usize,
    safely: usize,
    with_all: usize,
    left: Vec<String>,
}

impl FixRate {
    fn is_mended(&self) -> bool {
        self.with_all == self.mutations
    }
}

/// What is worse than before the mutation, after fixing.
fn worse(base: &Base, draft: &Draft, unsafe_too: bool) -> Vec<Diagnostic> {
    let data = osm(draft.text());
    let judge = |osm: &OsmData| -> Result<Vec<Diagnostic>, ConfigError> {
        let Loaded { map, faults } = from_osm(osm, &draft.projector);
        let index = MapIndex::new(&map, &faults, &base.settings);
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
    if wanted.is_empty() {
        let kept: Vec<&FixRate> =
            all.iter().filter(|rate| rate.is_mended() || reason(LOST, rate.name).is_none()).collect();
        let [mended, of] = [|one: &FixRate| one.with_all, |one: &FixRate| one.mutations]
            .map(|count| kept.iter().map(|one| count(one)).sum::<usize>());
        println!("{mended} of {of} that leave enough in the map");
        assert!(mended as f64 >= LEAST * of as f64, "{mended} of {of}");
        // So few mutations as `make test` tries tell little of a kind.
        if soak() {
            hold_table(&all);
        }
    }
}

/// The table in `docs/fix.md`; written anew by a soak with LANEWRIGHT_UPDATE=1.
fn hold_table(all: &[FixRate]) {
    let mut rows = Vec::new();
    for rate in all {
        let why = match (rate.is_mended(), reason(LOST, rate.name).or_else(|| reason(OPEN, rate.name))) {
            (true, _) => "",
            (false, Some(why)) => why,
            (false, None) => panic!("no reason why `{}` is not mended: {:#?}", rate.name, rate.left),
        };
        let star = if ALL.contains(&rate.name) { " *" } else { "" };
        let FixRate { name, mutations, safely, with_all, .. } = rate;
        rows.push(format!("| {mutations} | {safely} | {with_all} | {name}{star} | {why} |\n"));
    }
    let path = root().join("docs/fix.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let head = "|---|---|---|---|---|\n";
    let start = page.find(head).expect("docs/fix.md has the table of slips") + head.len();
    let end = start + page[start..].find("\n\n").map_or(page.len() - start, |end| end + 1);
    let fresh = page[..start].to_owned() + &rows.concat() + &page[end..];
    assert!(is_fresh(&path, &fresh), "docs/fix.md is out of date: LANEWRIGHT_UPDATE=1 writes it");
}

fn reason(table: &[(&'static str, &[&str])], name: &str) -> Option<&'static str> {
    table.iter().find(|(_, names)| names.contains(&name)).map(|(why, _)| *why)
}
