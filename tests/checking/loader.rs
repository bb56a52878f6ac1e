//! Small maps with one odd element each, against what the existing validator's program says of the same files: it was run on the
//! map `loader.osm` with one change each. `loader.json` holds which elements its loader named, what its validators reported besides
//! what they report of `loader.osm` or no longer, and which validators ended without a result.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::read_bytes;
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::rules::Config;
use lanewright::settings::{Profile, Settings};
use serde_json::Value;

use super::tier4_conformance::{Issue, issues_of};
use crate::common::judging::judge_as;

/// The map of a case: lines of the ground left out, lines added.
fn text(ground: &str, case: &Value) -> String {
    let words = |key: &str| case[key].as_array().unwrap().iter().map(|one| one.as_str().unwrap()).collect::<Vec<_>>();
    let starts: Vec<String> =
        words("without").into_iter().map(|one| format!("<{} id=\"{}\"", half(one).0, half(one).1)).collect();
    let kept = ground.lines().filter(|line| !starts.iter().any(|start| line.starts_with(start.as_str())));
    kept.map(|line| if line == "</osm>" { words("with").join("\n") + "\n</osm>\n" } else { format!("{line}\n") })
        .collect()
}

/// Kind and id of `way 3`.
fn half(name: &str) -> (&str, &str) {
    name.split_once(' ').unwrap()
}

fn loaded(text: String) -> Loaded {
    let mut data = lanewright::osm::OsmData::default();
    read_bytes(&mut data, "loader.osm", text.into_bytes()).unwrap();
    let grid = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of).unwrap();
    from_osm(&data, &Projector::mgrs(grid))
}

/// What the profile says of a map: subjects of errors, and of all findings of the rule.
fn told(text: String) -> [BTreeSet<i64>; 2] {
    let loaded = loaded(text);
    let found = judge_as(&loaded, &Settings::default(), &Config { profile: Profile::Tier4, ..Config::default() });
    let found: Vec<_> = found.iter().filter(|one| one.code.starts_with("load/")).collect();
    let errors = found.iter().filter(|one| one.severity == lanewright::diagnostic::Severity::Error);
    let ids = |one: &&&lanewright::diagnostic::Diagnostic| one.finding.subject.id().unwrap_or_default();
    [errors.map(|one| ids(&one)).collect(), found.iter().map(|one| ids(&one)).collect()]
}

#[test]
fn what_is_an_error_on_loading_is_one_to_the_existing_validators_loader() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("loader.json")).unwrap();
    let (mut wrong, mut untold) = (Vec::new(), BTreeSet::new());
    for case in &cases {
        let name = case["case"].as_str().unwrap();
        let theirs: BTreeSet<i64> = case["errors"].as_array().unwrap().iter().map(|id| id.as_i64().unwrap()).collect();
        let [errors, all] = told(text(include_str!("loader.osm"), case));
        if !errors.is_subset(&theirs) {
            wrong.push(format!("{name}: errors {errors:?}, there {theirs:?}"));
        }
        if !theirs.is_subset(&all) {
            untold.insert(name);
        }
    }
    println!("{} of {} files: no error that the loader does not know", cases.len() - wrong.len(), cases.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(untold, BTreeSet::new());
}

/// The issues of a case in one of its lists.
fn expected(case: &Value, key: &str) -> BTreeMap<Issue, usize> {
    let mut issues = BTreeMap::new();
    for one in case[key].as_array().into_iter().flatten() {
        let word = |at: usize| one[at].as_str().unwrap().to_owned();
        *issues.entry((word(1), word(2), one[3].as_i64().unwrap(), word(0))).or_default() += 1;
    }
    issues
}

/// How often each issue stands in the lists of the validators, but for those that ended without a result.
fn counted(all: &BTreeMap<String, Vec<Issue>>, ended: &[&str]) -> BTreeMap<Issue, usize> {
    let mut counts = BTreeMap::new();
    for (_, issues) in all.iter().filter(|(validator, _)| !ended.contains(&validator.as_str())) {
        issues.iter().for_each(|issue| *counts.entry(issue.clone()).or_default() += 1);
    }
    counts
}

#[test]
fn what_is_odd_is_reported_as_the_existing_validators_program_reports_it() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("loader.json")).unwrap();
    let ground = include_str!("loader.osm");
    let all = |text: String| issues_of(&loaded(text), Path::new("loader.osm"));
    let before = all(ground.to_owned());
    let mut wrong = Vec::new();
    for case in &cases {
        let ended: Vec<&str> =
            case["ended"].as_array().into_iter().flatten().map(|one| one.as_str().unwrap()).collect();
        let found = counted(&all(text(ground, case)), &ended);
        let mut wanted = counted(&before, &ended);
        for (issue, count) in expected(case, "issues") {
            *wanted.entry(issue).or_default() += count;
        }
        for (issue, count) in expected(case, "no_longer") {
            *wanted.get_mut(&issue).unwrap() -= count;
        }
        wanted.retain(|_, count| *count > 0);
        if found != wanted {
            wrong.push(format!("{}:\n  expected {wanted:?}\n  found    {found:?}", case["case"]));
        }
    }
    println!("{} of {} files judged alike", cases.len() - wrong.len(), cases.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
