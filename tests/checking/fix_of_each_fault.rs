//! Each fault says whether `fix` mends it; the maps of the rules and `docs/fix.md` are held against that.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use lanewright::rules;
use lanewright::settings::Settings;
use rayon::prelude::*;

use crate::common::judging::{judge, load};
use crate::common::{is_fresh, root, rule_maps};

/// The first words of what a fault may say.
const WORDS: [&str; 5] = ["safe", "safe or needs review", "needs review", "never: ", "not yet: "];

fn faults() -> impl Iterator<Item = (String, &'static str)> {
    let rows = rules::table().unwrap().iter();
    rows.flat_map(|row| {
        let id = &row.requirement.id;
        row.requirement.faults.iter().map(move |(slug, fault)| {
            let fix = fault.fix.as_deref().unwrap_or_else(|| panic!("{id}/{slug} does not say whether `fix` mends it"));
            (format!("{id}/{slug}"), fix)
        })
    })
}

#[test]
fn the_maps_of_the_rules_show_the_fixes_that_the_faults_speak_of() {
    for (code, fix) in faults() {
        let is_said = |word: &str| match fix.strip_prefix(word) {
            Some(rest) => word.ends_with(' ') || rest.is_empty() || rest.starts_with(','),
            None => false,
        };
        assert!(WORDS.into_iter().any(is_said), "{code}: {fix}");
    }
    let said: BTreeMap<String, &str> = faults().collect();
    rule_maps("").par_iter().for_each(|path| {
        let (_, loaded) = load(path);
        for found in judge(&loaded, &Settings::default()) {
            let Some((fix, said)) = found.finding.fix.as_ref().zip(said.get(&found.code)) else { continue };
            let word = if fix.safe { "safe" } else { "needs review" };
            assert!(said.contains(word), "{}: {} has a fix that is {word}, but `{said}`", path.display(), found.code);
        }
    });
}

#[test]
fn what_a_fix_takes_for_granted_is_said_where_a_person_has_to_look() {
    for row in rules::table().unwrap() {
        for (slug, fault) in &row.requirement.faults {
            let looks = fault.fix.as_deref().is_some_and(|fix| fix.contains("needs review"));
            assert_eq!(looks, fault.assumes.is_some(), "{}/{slug}: `fix` and `assumes`", row.requirement.id);
        }
    }
}

/// The table at the end of `docs/fix.md`; written anew with LANEWRIGHT_UPDATE=1.
#[test]
fn the_page_about_fixes_lists_each_fault() {
    let path = root().join("docs/fix.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let head = "| fault | fix |\n|---|---|\n";
    let start = page.find(head).expect("docs/fix.md has the table of faults") + head.len();
    let mut fresh = page[..start].to_owned();
    for (code, fix) in faults() {
        writeln!(fresh, "| `{code}` | {fix} |").unwrap();
    }
    assert!(is_fresh(&path, &fresh), "docs/fix.md is out of date: LANEWRIGHT_UPDATE=1 writes it");
}
