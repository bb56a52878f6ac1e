//! The profile `tier4` against what the tests of the existing validator expect, issue by issue.

use std::collections::BTreeMap;
use std::path::Path;

use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::{ElementKind, Member, OsmData, Tags};
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::report::tier4::{Exclusions, Outcome, RequirementSet, Validator};
use lanewright::rules::{Config, tier4};
use lanewright::settings::{Profile, Settings};
use serde_json::Value;

use crate::common::judging::{judge_as, load};
use crate::common::needs::shared;

/// Cases outside vm-03 that come out exactly; the number must not fall.
const OTHERS: usize = 84;

/// Severity, primitive, id and code of an issue.
pub type Issue = (String, String, i64, String);

fn validators() -> Vec<Validator<'static>> {
    tier4::validators()
        .iter()
        .map(|one| Validator { name: &one.name, code: one.code(), requirement: one.shown_under() })
        .collect()
}

/// The issues of every validator on a map, in order.
fn issues(map: &Path) -> BTreeMap<String, Vec<Issue>> {
    issues_of(&load(map).1, map)
}

/// The issues of every validator on a map that is loaded, in order.
pub fn issues_of(loaded: &Loaded, map: &Path) -> BTreeMap<String, Vec<Issue>> {
    let config = Config { profile: Profile::Tier4, ..Config::default() };
    let found = judge_as(loaded, &Settings::default(), &config);
    let known = validators();
    let outcome = Outcome::new(&found, &known, &RequirementSet::of_all(&known), &Exclusions::default(), map);
    let mut all = BTreeMap::new();
    for requirement in outcome.document()["requirements"].as_array().unwrap() {
        for validator in requirement["validators"].as_array().unwrap() {
            let issues = validator["issues"].as_array().map_or(Vec::new(), |list| list.iter().map(issue).collect());
            all.insert(validator["name"].as_str().unwrap().to_owned(), issues);
        }
    }
    all
}

fn issue(value: &Value) -> Issue {
    let word = |key: &str| value[key].as_str().unwrap().to_owned();
    // The tool writes `info`, the list of cases `Info`.
    (word("severity").to_lowercase(), word("primitive"), value["id"].as_i64().unwrap(), word("issue_code"))
}

fn sorted(list: &Value) -> Option<Vec<Issue>> {
    let mut issues: Vec<Issue> = list.as_array()?.iter().map(issue).collect();
    issues.sort();
    Some(issues)
}

#[test]
fn the_existing_validators_cases_come_out_as_it_expects() {
    let Some(folder) = shared("corpus/conformance") else { return };
    let cases: Vec<Value> = serde_json::from_slice(&std::fs::read(folder.join("cases.json")).unwrap()).unwrap();
    let mut maps: BTreeMap<String, BTreeMap<String, Vec<Issue>>> = BTreeMap::new();
    // Exact and all, of vm-03 and of the others.
    let mut counts = [[0, 0], [0, 0]];
    let mut rest = Vec::new();
    for case in &cases {
        let Some(expected) = sorted(&case["expect"]) else { continue };
        let (map, validator) = (case["map"].as_str().unwrap(), case["validator"].as_str().unwrap());
        let all = maps.entry(map.to_owned()).or_insert_with(|| issues(&folder.join("map").join(map)));
        let Some(found) = all.get(validator) else {
            counts[1][1] += 1;
            rest.push(format!("{validator} on {map}: no such validator"));
            continue;
        };
        let mut found = found.clone();
        found.sort();
        let either = [Some(expected.clone()), sorted(&case["equivalent_expect"])];
        let exact = either.iter().flatten().any(|one| *one == found);
        let group = usize::from(!validator.starts_with("mapping.intersection."));
        counts[group][0] += usize::from(exact);
        counts[group][1] += 1;
        if !exact {
            rest.push(format!("{validator} on {map}:\n  expected {expected:?}\n  found    {found:?}"));
        }
    }
    let [[exact, of], [others_exact, others]] = counts;
    println!("vm-03: {exact} of {of} exact; all: {} of {} exact", exact + others_exact, of + others);
    for line in &rest {
        println!("{line}");
    }
    assert_eq!(exact, of, "a case of vm-03 comes out otherwise");
    assert!(others_exact >= OTHERS, "{others_exact} other cases are exact; {OTHERS} were");
}

/// Maps whose answers of the existing validator's own program we have.
const MAPS: usize = 18;
/// Validators that it ran on each.
const VALIDATORS: usize = 43;

/// Compares what the validator's own program reports of hand-made maps with what we report, issue by issue, for every pair of map
/// and validator. None of its answers depends on an order in memory, so no pair is left out.
#[test]
fn hand_made_maps_come_out_as_the_existing_validator_itself_judges_them() {
    let Some(corpus) = shared("corpus") else { return };
    let mut results: Vec<_> = std::fs::read_dir(corpus.join("peer_results")).unwrap().map(|one| one.unwrap()).collect();
    results.sort_by_key(std::fs::DirEntry::path);
    let (mut pairs, mut exact, mut compared) = (0, 0, 0);
    let mut wrong = Vec::new();
    for result in &results {
        let name = result.path().with_extension("osm").file_name().unwrap().to_owned();
        let map = ["lanelet2", "lanelet2_more"].map(|folder| corpus.join(folder).join(&name));
        let map = map.iter().find(|map| map.exists()).unwrap();
        let said: BTreeMap<String, Vec<(String, String, String, i64)>> =
            serde_json::from_slice(&std::fs::read(result.path()).unwrap()).unwrap();
        let all = issues(map);
        for (validator, said) in said {
            let mut expected: Vec<Issue> = said
                .into_iter()
                .map(|(code, severity, primitive, id)| (severity.to_lowercase(), primitive, id, code))
                .collect();
            let mut found = all.get(&validator).cloned().unwrap_or_default();
            expected.sort();
            found.sort();
            pairs += 1;
            compared += expected.len();
            if found == expected {
                exact += 1;
            } else {
                wrong.push(format!(
                    "{validator} on {}:\n  expected {expected:?}\n  found    {found:?}",
                    name.to_string_lossy()
                ));
            }
        }
    }
    println!("{exact} of {pairs} pairs of {} maps exact, with {compared} issues", results.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!((results.len(), pairs), (MAPS, MAPS * VALIDATORS));
    assert!(compared > 0);
}

/// Makes an edit of `tier4_further.json`: a tag set or dropped, a member added in front or dropped.
fn edit(data: &mut OsmData, edit: &Value) {
    if let Some([kind, id, key, value]) = edit["tag"].as_array().and_then(|list| list.first_chunk()) {
        let id = id.as_i64().unwrap();
        let tags: &mut Tags = match kind.as_str().unwrap() {
            "node" => &mut data.nodes.iter_mut().find(|one| one.id == id).unwrap().tags,
            "way" => &mut data.ways.iter_mut().find(|one| one.id == id).unwrap().tags,
            _ => &mut data.relations.iter_mut().find(|one| one.id == id).unwrap().tags,
        };
        let key = key.as_str().unwrap();
        match value.as_str() {
            Some(value) => tags.set(key, value),
            None => *tags = tags.iter().filter(|(own, _)| *own != key).collect(),
        }
        return;
    }
    let list = edit["add"].as_array().or(edit["drop"].as_array()).unwrap();
    let relation = data.relations.iter_mut().find(|one| one.id == list[0].as_i64().unwrap()).unwrap();
    let (role, id) = (list[1].as_str(), list[2].as_i64().unwrap());
    if edit["add"].is_array() {
        let member = Member { kind: ElementKind::Relation, id, role: role.unwrap().into() };
        relation.members.insert(0, member);
    } else {
        relation.members.retain(|member| member.id != id || role.is_some_and(|role| member.role != role));
    }
}

/// One or several edits of the good map each, with what `docs/tier4.md` says of them: derived by hand from how the
/// validators are described, and not from what we say.
#[test]
fn further_cases_come_out_as_the_validators_are_described() {
    let Some(folder) = shared("corpus/conformance/map") else { return };
    let map = folder.join("sample_map.osm");
    let cases: Vec<Value> = serde_json::from_str(include_str!("tier4_further.json")).unwrap();
    let (data, _) = load(&map);
    let grid = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of).unwrap();
    let all = |data: &OsmData| -> Vec<Issue> {
        let mut all: Vec<Issue> =
            issues_of(&from_osm(data, &Projector::mgrs(grid)), &map).into_values().flatten().collect();
        all.sort();
        all
    };
    let ground = all(&data);
    let mut wrong = Vec::new();
    for case in &cases {
        let mut changed = data.clone();
        case["edits"].as_array().unwrap().iter().for_each(|one| edit(&mut changed, one));
        let mut found = all(&changed);
        for known in &ground {
            if let Some(at) = found.iter().position(|one| one == known) {
                found.remove(at);
            }
        }
        let expected = case["expect"].as_array().unwrap().iter().map(|one| {
            let word = |at: usize| one[at].as_str().unwrap().to_owned();
            (word(1).to_lowercase(), word(2), one[3].as_i64().unwrap(), word(0))
        });
        let mut expected: Vec<Issue> = expected.collect();
        expected.sort();
        if found != expected {
            wrong.push(format!("{}: expected {expected:?}, found {found:?}", case["case"]));
        }
    }
    println!("{} of {} further cases as described", cases.len() - wrong.len(), cases.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
