//! What the rule `load` calls an error under the profile `tier4`, against what the existing validator's loader says of the same
//! files: its program was run on the map `loader.osm` with one change each, and `loader.json` holds which elements it named.

use std::collections::BTreeSet;

use lanewright::lanelet::from_osm;
use lanewright::osm::read_bytes;
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::rules::Config;
use lanewright::settings::{Profile, Settings};
use serde_json::Value;

use crate::common::judging::judge_as;

/// Cases of which the loader tells and we do not: areas that are relations, which Autoware uses nowhere, and signs without
/// `subtype` though the element has a `sign_type`.
const UNTOLD: [&str; 9] = [
    "traffic_sign sign_type with bare",
    "speed_limit sign_type with bare",
    "member is broken multipolygon",
    "multipolygon open",
    "multipolygon no outer",
    "multipolygon empty",
    "multipolygon outer is polygon",
    "multipolygon outer is node",
    "multipolygon crossing",
];

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

/// What the profile says of a map: subjects of errors, and of all findings of the rule.
fn told(text: String) -> [BTreeSet<i64>; 2] {
    let mut data = lanewright::osm::OsmData::default();
    read_bytes(&mut data, "loader.osm", text.into_bytes()).unwrap();
    let grid = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of).unwrap();
    let loaded = from_osm(&data, &Projector::mgrs(grid));
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
    assert_eq!(untold, BTreeSet::from(UNTOLD));
}
