//! What is said of tags: who may enter and how fast, held against the real Lanelet2 library; slips of the pen; the page of known tags.

use std::collections::BTreeSet;
use std::io::Write;
use std::process::Stdio;

use lanewright::lanelet::Attributes;
use lanewright::lanelet::participants::{PARTICIPANTS, may_enter, speed_limit};
use lanewright::report::known_words;
use lanewright::settings::Settings;
use serde_json::{Value, json};

use crate::common::judging::{judge, load};
use crate::common::needs::{python, shared};
use crate::common::{is_fresh, root};

#[test]
fn the_page_of_tags_that_rules_know_is_fresh() {
    let page = root().join("docs/tags.md");
    assert!(is_fresh(&page, &known_words()), "run `make rules`: {}", page.display());
}

/// Tags that say who may enter, alone and together, on lanelets of each subtype; and those that say how fast.
fn questions() -> Vec<Vec<(&'static str, &'static str)>> {
    let subtypes = [
        "",
        "road",
        "highway",
        "play_street",
        "emergency_lane",
        "bus_lane",
        "bicycle_lane",
        "exit",
        "walkway",
        "shared_walkway",
        "crosswalk",
        "stairs",
        "tram_lane",
        "road_shoulder",
    ];
    let mut all: Vec<Vec<(&str, &str)>> = subtypes.iter().map(|subtype| vec![("subtype", *subtype)]).collect();
    all.push(Vec::new());
    let keys = [
        "participant",
        "participant:vehicle",
        "participant:vehicle:car",
        "participant:vehicle:truck",
        "participant:pedestrian",
    ];
    for (at, &key) in keys.iter().enumerate() {
        for value in ["yes", "no", "true", "1", "0", "designated", ""] {
            all.push(vec![("subtype", "road"), (key, value)]);
            for &other in &keys[at + 1..] {
                for its in ["yes", "no"] {
                    all.push(vec![("subtype", "road"), (key, value), (other, its)]);
                }
            }
        }
    }
    for subtype in ["road", "highway", "play_street", "exit", "bus_lane"] {
        for limit in ["50", "none", "", "0", "50 km/h", "30 mph", "10 m/s", "10mps", "walk", "50 knots", "5e1"] {
            all.push(vec![("subtype", subtype), ("speed_limit", limit)]);
            all.push(vec![("subtype", subtype), ("speed_limit", "50"), ("speed_limit:vehicle", limit)]);
            all.push(vec![("subtype", subtype), ("speed_limit", limit), ("speed_limit:vehicle:car", "20")]);
        }
        all.push(vec![("subtype", subtype), ("speed_limit_mandatory", "yes")]);
    }
    all
}

#[test]
fn who_may_enter_and_how_fast_is_as_lanelet2_says() {
    let Some(mut python) = python() else { return };
    // The library has no rules for trains.
    let whom: Vec<&str> = PARTICIPANTS.into_iter().filter(|who| *who != "train").collect();
    let tags = questions();
    let asked: Vec<(&str, &Vec<(&str, &str)>)> =
        whom.iter().flat_map(|who| tags.iter().map(move |tags| (*who, tags))).collect();
    let object = |tags: &[(&str, &str)]| {
        tags.iter().map(|(key, value)| ((*key).to_owned(), json!(value))).collect::<serde_json::Map<_, _>>()
    };
    let input: Vec<Value> = asked.iter().map(|(who, tags)| json!([who, object(tags)])).collect();
    python.arg(root().join("tests/checking/participants.py"));
    let mut running = python.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    running.stdin.take().unwrap().write_all(Value::from(input).to_string().as_bytes()).unwrap();
    let output = running.wait_with_output().unwrap();
    assert!(output.status.success(), "tests/checking/participants.py failed");
    let answers: Vec<(bool, f64)> = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answers.len(), asked.len());
    let mut wrong = Vec::new();
    for ((who, said), (enters, limit)) in asked.iter().zip(&answers) {
        let tags: Attributes = said.iter().copied().collect();
        if may_enter(&tags, who) != *enters {
            wrong.push(format!("{who} {said:?}: may enter {enters}"));
        }
        if let Some(ours) = speed_limit(&tags, who)
            && (ours - limit).abs() > 1e-3
        {
            wrong.push(format!("{who} {said:?}: {limit} km/h, not {ours}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), asked.len(), wrong.join("\n"));
}

/// The codes of the families of this file that are said of a map.
fn said(map: &std::path::Path) -> BTreeSet<String> {
    let found = judge(&load(map).1, &Settings::default());
    let ours = |code: &String| {
        ["tag/", "access/", "parts/", "area/", "roundabout/", "signal/", "landmark/", "planner/"]
            .iter()
            .any(|family| code.starts_with(family))
    };
    found.into_iter().map(|one| one.code).filter(ours).collect()
}

#[test]
fn maps_with_a_slip_each_are_told_and_the_newer_words_of_autoware_are_known() {
    let Some(cases) = shared("cases/check") else { return };
    for (map, codes) in [
        ("raod", &["tag/value"][..]),
        ("one_nosub", &["access/not-road"]),
        ("one_highway", &["access/not-road"]),
        ("one_osmtags", &["access/not-road"]),
        ("hwnone", &["access/not-road", "access/standstill"]),
        ("curbstone", &["parts/curbstone"]),
        ("pocket", &[]),
        ("direction_change", &[]),
        // Each of these has a slip among the newer words.
        ("newtags", &["roundabout/not-true", "roundabout/old-tag", "tag/key", "tag/value"]),
        ("scr", &["signal/blank", "signal/lamp", "signal/target", "tag/key"]),
        ("polys", &["landmark/corners", "landmark/no-id", "tag/renamed", "tag/value"]),
        ("round_re", &["roundabout/apart", "roundabout/unreferenced", "tag/role"]),
    ] {
        let codes: BTreeSet<String> = codes.iter().map(|code| (*code).to_owned()).collect();
        assert_eq!(said(&cases.join(format!("{map}.osm"))), codes, "{map}");
    }
}

/// What is found in hand-made maps, looked at one by one: each is right.
#[test]
fn nothing_wrong_is_said_of_hand_made_maps() {
    let Some(corpus) = shared("corpus") else { return };
    for folder in ["lanelet2", "lanelet2_more"] {
        for entry in std::fs::read_dir(corpus.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|ending| ending != "osm") {
                continue;
            }
            // Maps end; nowhere else than at their border.
            let cut = "planner/attention-cut";
            let right: &[&str] = match path.file_stem().unwrap().to_str().unwrap() {
                "autoware_intersection" => &[cut],
                // Six ways are `curbestone`; two lanes overlap by their borders in bends.
                "autoware_road_shoulder" => &["tag/value", "planner/never-meets", cut],
                // Two turns across each other, neither of which goes first.
                "autoware_sample_planning" => &["planner/both-wait", cut],
                // Made for Lanelet2 alone: it has highways and curbs, and a speed limit of which no lanelet knows.
                "mapping_example" => &["access/not-road", "area/unreached", "parts/curbstone", "parts/unreferenced"],
                "scenario_simulator_borregas" => &["parts/curbstone", cut],
                // Lights on some lanelets of an approach and not on others.
                "scenario_simulator_crossroads" | "scenario_simulator_kashiwanoha" => &["planner/both-wait"],
                // Two nodes at one place, of bounds that meet there; turns that begin behind the lanelet straight on.
                "zalazone_smart_city" => &["parts/same-place", "planner/never-meets", cut],
                "zalazone_uni_track" => &["parts/same-place"],
                _ => &[],
            };
            let right: BTreeSet<String> = right.iter().map(|code| (*code).to_owned()).collect();
            assert_eq!(said(&path), right, "{}", path.display());
        }
    }
}
