//! The profile `tier4` as its users run it, and the table of `docs/tier4.md`.

use std::fmt::Write;
use std::fs;

use lanewright::rules::{find, tier4};
use serde_json::{Value, json};

use crate::common::needs::shared;
use crate::common::program::{Run, lanewright};
use crate::common::{is_fresh, root};

/// A map of the tests of vm-03-01.
fn map(name: &str) -> String {
    root().join("tests/rules/vm-03-01").join(name).display().to_string()
}

fn check(map: &str, more: &[&str]) -> Run {
    let arguments = [&["check", map, "--isolated", "--profile", "tier4", "--format", "tier4"][..], more].concat();
    lanewright(&root(), &arguments)
}

/// The results of the validators by name: passed, issue codes.
fn results(run: &Run) -> Vec<(String, bool, Vec<String>)> {
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let requirements = document["requirements"].as_array().unwrap();
    let validators = requirements.iter().flat_map(|one| one["validators"].as_array().unwrap());
    let codes = |one: &Value| -> Vec<String> {
        let issues = one["issues"].as_array().into_iter().flatten();
        issues.map(|issue| issue["issue_code"].as_str().unwrap().to_owned()).collect()
    };
    validators
        .map(|one| (one["name"].as_str().unwrap().to_owned(), one["passed"].as_bool().unwrap(), codes(one)))
        .collect()
}

fn write(dir: &tempfile::TempDir, name: &str, text: &str) -> String {
    let file = dir.path().join(name);
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

const DANGLING: &str = "mapping.intersection.intersection_area_dangling_reference";
const TAGGING: &str = "mapping.intersection.intersection_area_tagging";
const DIVISION: &str = "mapping.intersection.lanelet_division";

fn set(dir: &tempfile::TempDir, validators: Value) -> String {
    let set = json!({
        "version": "1.2", "note": "kept", "requirements": [{ "id": "vm-x", "owner": "us", "validators": validators }]
    });
    write(dir, "set.json", &set.to_string())
}

#[test]
fn without_a_set_every_validator_runs_under_its_requirement() {
    let run = check(&map("bad-ia-tag-dangling.osm"), &[]).exits(1);
    let results = results(&run);
    assert_eq!(results.len(), 43);
    let of = |name: &str| results.iter().find(|(known, ..)| known == name).unwrap();
    assert_eq!(of(DANGLING).2, ["Intersection.IntersectionAreaDanglingReference-001"]);
    assert!(!of(DANGLING).1 && of(DIVISION).1);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let ids: Vec<&str> =
        document["requirements"].as_array().unwrap().iter().map(|one| one["id"].as_str().unwrap()).collect();
    assert!(ids.contains(&"vm-03-01") && ids.contains(&"mapping.lane.local_coordinates_declaration"));
    assert_eq!(document["validation_info"]["target_map"], "vm-03-01/bad-ia-tag-dangling.osm");
    assert!(
        run.stdout.starts_with("{\n    \"requirements\": [\n        {\n            \"id\": "),
        "{}",
        &run.stdout[..80]
    );
}

#[test]
fn a_set_says_what_runs_and_what_has_to_pass_before() {
    let dir = tempfile::tempdir().unwrap();
    let needs = |name: &str, other: &str| json!({ "name": name, "prerequisites": [{ "name": other }] });
    let set =
        set(&dir, json!([{ "name": DANGLING, "owner": "me" }, needs(DIVISION, DANGLING), needs(TAGGING, TAGGING)]));
    let run = check(&map("bad-ia-tag-dangling.osm"), &["--requirements", &set]).exits(1);
    let codes: Vec<String> = results(&run).into_iter().flat_map(|(_, _, codes)| codes).collect();
    assert_eq!(
        codes,
        [
            "Intersection.IntersectionAreaDanglingReference-001",
            "General.PrerequisitesFailure-001",
            "General.InvalidPrerequisites-001"
        ]
    );
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(document["note"], "kept");
    assert_eq!(document["requirements"][0]["owner"], "us");
    assert_eq!(document["requirements"][0]["validators"][0]["owner"], "me");
    assert_eq!(document["requirements"][0]["passed"], false);
    let requirements = &document["validation_info"]["map_requirements"];
    assert_eq!(*requirements, json!({ "filename": "set.json", "version": "1.2" }));
}

#[test]
fn what_is_excluded_does_not_fail() {
    let dir = tempfile::tempdir().unwrap();
    let set = set(&dir, json!([{ "name": DANGLING }]));
    let run = check(&map("bad-ia-tag-dangling.osm"), &["--requirements", &set]).exits(1);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let id = document["requirements"][0]["validators"][0]["issues"][0]["id"].clone();
    let excluding = |entry: Value| {
        let list = write(&dir, "list.json", &json!({ "exclusion": [entry] }).to_string());
        check(&map("bad-ia-tag-dangling.osm"), &["--requirements", &set, "--exclusions", &list])
    };
    let left = results(&excluding(json!({ "primitive": "lanelet", "id": id })).exits(0));
    assert_eq!(left, [(DANGLING.to_owned(), true, vec![])]);
    excluding(json!({ "primitive": "lanelet", "id": id, "validators": [{ "name": DANGLING }] })).exits(0);
    excluding(json!({ "primitive": "lanelet", "id": id, "validators": [{ "name": TAGGING }] })).exits(1);
    excluding(json!({ "primitive": "polygon", "id": id })).exits(1);
    excluding(json!({ "primitive": "lane", "id": id })).fails_saying(&["`lane` is no primitive", "linestring"]);
}

#[test]
fn parameters_replace_the_tools_own() {
    let dir = tempfile::tempdir().unwrap();
    let set = set(&dir, json!([{ "name": "mapping.lane.speed_limit_validity" }]));
    let map = map("good.osm");
    let with = |text: &str| {
        let file = write(&dir, "params.yaml", text);
        check(&map, &["--requirements", &set, "--parameters", &file])
    };
    check(&map, &["--requirements", &set]).exits(0);
    let strict = with("mapping.lane.speed_limit_validity:\n  min_speed_limit: 1\n  max_speed_limit: 5.5\n").exits(1);
    assert!(strict.stderr.contains("mapping.traffic_light.body_height has no max_height"), "{}", strict.stderr);
    with("mapping.lane.speed_limit_validity:\n  max_speed_limit: 80.0\n").exits(0);
    with("- a\n").fails_saying(&["params.yaml", "expected `validator:`"]);
    with("a: [\n").fails_saying(&["params.yaml"]);
}

#[test]
fn what_does_not_fit_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let good = map("good.osm");
    let format = lanewright(&root(), &["check", &good, "--isolated", "--format", "tier4"]);
    format.fails_saying(&["--profile tier4"]);
    let set =
        write(&dir, "set.json", "{\"requirements\": [{\"id\": \"a\", \"validators\": [{\"name\": \"mapping.x\"}]}]}");
    check(&good, &["--requirements", &set]).fails_saying(&["set.json", "there is no validator `mapping.x`"]);
    let broken = write(&dir, "broken.json", "{\"requirements\": [{\"validators\": []}]}");
    check(&good, &["--requirements", &broken]).fails_saying(&["broken.json", "a requirement has no `id`"]);
    let text = ["check", &good, "--isolated", "--profile", "tier4", "--requirements", &set];
    lanewright(&root(), &text).fails_saying(&["--format tier4"]);
}

#[test]
fn the_profile_stands_in_the_settings_too_and_shows_in_every_format() {
    let dir = tempfile::tempdir().unwrap();
    let settings = write(&dir, "lanewright.toml", "profile = \"tier4\"\n");
    let bad = map("bad-ia-tag-dangling.osm");
    let run = lanewright(&root(), &["check", &bad, "--config", &settings, "--format", "concise"]).exits(1);
    assert!(run.stdout.contains("vm-03-01/ia-tag-dangling"), "{}", run.stdout);
    let ours = ["check", &bad, "--config", &settings, "--profile", "ours", "--format", "tier4"];
    lanewright(&root(), &ours).fails_saying(&["--profile tier4"]);
    let listed = lanewright(&root(), &["rules", "--profile", "tier4"]).exits(0);
    assert!(listed.stdout.contains("mapping.intersection.road_markings  vm-03-14\n"), "{}", listed.stdout);
    assert_eq!(listed.stdout.lines().count(), 43);
}

/// `docs/tier4.md` shows the table; `LANEWRIGHT_UPDATE=1 cargo test --test program` writes it anew.
#[test]
fn the_page_shows_the_table() {
    let page = root().join("docs/tier4.md");
    let kept = fs::read_to_string(&page).unwrap();
    let mark = "cargo test --test program -->\n";
    let (prose, _) = kept.split_once(mark).unwrap();
    let mut text =
        format!("{prose}{mark}\n| validator | requirement | code | severity | our code |\n|---|---|---|---|---|\n");
    for validator in tier4::validators() {
        let mut name = format!("`{}`", validator.name);
        for (digits, (severity, fault)) in &validator.issues {
            let (under, severity) = (validator.requirement.as_deref().unwrap_or("-"), format!("{severity:?}"));
            writeln!(text, "| {name} | {under} | {digits} | {severity} | {fault} |").unwrap();
            name.clear();
        }
    }
    assert!(is_fresh(&page, &text), "docs/tier4.md is stale; run: LANEWRIGHT_UPDATE=1 cargo test --test program");
}

/// Compares severities and codes with the validator's own list.
#[test]
fn the_table_holds_every_issue_code_of_the_tool() {
    let Some(file) = shared("corpus/conformance/issue_codes.json") else { return };
    let codes: Value = serde_json::from_slice(&fs::read(file).unwrap()).unwrap();
    let mut ours = Vec::new();
    for validator in tier4::validators() {
        for (digits, (severity, _)) in &validator.issues {
            let code = format!("{}-{digits}", validator.code());
            assert_eq!(
                codes[&code]["severity"].as_str().unwrap().to_lowercase(),
                format!("{severity:?}").to_lowercase()
            );
            ours.push(code);
        }
    }
    // Discontinued, or about the run.
    let left: Vec<&String> =
        codes.as_object().unwrap().keys().filter(|code| !ours.contains(code) && !code.starts_with("General")).collect();
    assert_eq!(
        left,
        [
            "Area.NoStoppingArea-004",
            "Crosswalk.RegulatoryElementDetails-004",
            "Crosswalk.RegulatoryElementDetails-005",
            "Crosswalk.RegulatoryElementDetails-008",
            "Lane.RoadShoulder-002"
        ]
    );
}

#[test]
fn every_fault_of_the_table_stands_in_a_document_that_names_the_code() {
    for validator in tier4::validators() {
        for (digits, (_, code)) in &validator.issues {
            let (rule, fault) = code.split_once('/').unwrap();
            let peer = format!("{}-{digits}", validator.code());
            let requirement = find(rule).unwrap_or_else(|| panic!("no rule {rule}"));
            let fault = requirement.fault(fault).unwrap_or_else(|| panic!("rules/{rule}.md has no fault `{fault}`"));
            assert!(fault.peer.contains(&peer), "rules/{rule}.md: {code} lacks peer {peer}");
        }
    }
}
