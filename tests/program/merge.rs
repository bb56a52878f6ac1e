//! `merge --base` as its users and git run it.

use std::fs;
use std::path::Path;

use crate::common::program::lanewright;
use crate::common::root;

/// A directory with a built map in `base`, `ours` and `theirs`.
fn place() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_right.osm");
    for name in ["base", "ours", "theirs"] {
        lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", name, "-q"]).exits(0);
    }
    dir
}

/// Replaces the first of some text in a file, which has it.
#[track_caller]
fn edit(file: &Path, old: &str, new: &str) {
    let text = fs::read_to_string(file).unwrap();
    assert!(text.contains(old), "{old}");
    fs::write(file, text.replacen(old, new, 1)).unwrap();
}

/// The speed of the nth lanelet is another.
fn speed(dir: &Path, name: &str, nth: usize, speed: &str) {
    let file = dir.join(name).join("lanelet2_map.osm");
    let text = fs::read_to_string(&file).unwrap();
    let (at, old) = text.match_indices("<tag k=\"speed_limit\" v=\"50\"/>").nth(nth).unwrap();
    let new = format!("<tag k=\"speed_limit\" v=\"{speed}\"/>");
    fs::write(&file, [&text[..at], &new, &text[at + old.len()..]].concat()).unwrap();
}

#[test]
fn directories_are_merged_with_what_stands_beside_the_maps() {
    let dir = place();
    speed(dir.path(), "ours", 0, "30");
    speed(dir.path(), "theirs", 3, "20");
    edit(
        &dir.path().join("ours/lanewright.toml"),
        "driving_side = \"right\"\n",
        "driving_side = \"right\"\nignore = [\"vm-01\"]\n",
    );
    let run = |arguments: &[&str]| {
        lanewright(dir.path(), &[&["merge", "--base", "base", "ours", "theirs", "-o"], arguments].concat())
    };
    let told = run(&["out"]).exits(0).stdout;
    assert_eq!(told, "out\n        1 element changed\n");
    let text = |name: &str, file: &str| fs::read_to_string(dir.path().join(name).join(file)).unwrap();
    speed(dir.path(), "ours", 2, "20");
    assert_eq!(text("out", "lanelet2_map.osm"), text("ours", "lanelet2_map.osm"), "both edits and nothing else");
    assert!(text("out", "lanewright.toml").contains("ignore = [\"vm-01\"]"));
    assert_eq!(text("out", "map_projector_info.yaml"), text("base", "map_projector_info.yaml"));
    // Another map is in the way; ours is not.
    run(&["out"]).fails_saying(&["out/lanelet2_map.osm is there already"]);
    run(&["ours"]).exits(0);
}

#[test]
fn conflicts_are_told_with_place_and_values_and_the_exit_code_says_so() {
    let dir = place();
    speed(dir.path(), "ours", 0, "30");
    speed(dir.path(), "theirs", 0, "20");
    let [base, ours, theirs] = ["base", "ours", "theirs"].map(|name| format!("{name}/lanelet2_map.osm"));
    let verb = ["merge", "--base", &base, &ours, &theirs, "-o", "out.osm"];
    let told = lanewright(dir.path(), &verb).exits(1).stdout;
    for words in
        ["tag speed_limit (at ", "base    50\n", "ours    30  <- in the result\n", "theirs  20\n", "1 conflict;"]
    {
        assert!(told.contains(words), "{words}:\n{told}");
    }
    assert_eq!(fs::read(dir.path().join("out.osm")).unwrap(), fs::read(dir.path().join(&ours)).unwrap());
    let json = lanewright(dir.path(), &[&verb[..], &["--format", "json"]].concat()).exits(1).stdout;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let conflict = &json["conflicts"][0];
    assert_eq!((&conflict["ours"], &conflict["theirs"]), (&"30".into(), &"20".into()), "{json}");
    assert_eq!((&conflict["subject"]["kind"], &conflict["about"]), (&"lanelet".into(), &"tag speed_limit".into()));
    assert!(conflict["at"]["lat"].is_number());
    lanewright(dir.path(), &[&verb[..], &["--report", "page.html"]].concat()).exits(1);
    let page = fs::read_to_string(dir.path().join("page.html")).unwrap();
    assert!(page.contains("rule-merge"));
}

#[test]
fn a_map_that_cannot_be_read_leaves_the_output_as_it_was() {
    let dir = place();
    fs::write(dir.path().join("broken.osm"), "<osm><node id='1'></osm>").unwrap();
    let verb =
        ["merge", "--base", "base/lanelet2_map.osm", "broken.osm", "theirs/lanelet2_map.osm", "-o", "broken.osm"];
    lanewright(dir.path(), &verb).fails_saying(&["broken.osm"]);
    assert_eq!(fs::read_to_string(dir.path().join("broken.osm")).unwrap(), "<osm><node id='1'></osm>");
    lanewright(dir.path(), &["merge", "--base", "base", "ours", "-o", "out"]).fails_saying(&["two versions, and 1"]);
    lanewright(dir.path(), &["merge", "base", "ours", "--no-check", "-o", "out"]).exits(2);
    lanewright(dir.path(), &["split", "base", "-o", "cells"]).exits(0);
    lanewright(dir.path(), &["merge", "--base", "cells", "ours", "theirs", "-o", "out"])
        .fails_saying(&["divided into cells", "lanewright merge MAP -o WHOLE"]);
}

#[test]
fn what_is_wrong_only_in_both_together_is_told() {
    let dir = place();
    let file = |name: &str| dir.path().join(name).join("lanelet2_map.osm");
    let text = fs::read_to_string(file("base")).unwrap();
    let id = |relation: &str| relation.split('"').nth(1).unwrap().to_owned();
    let is_free = |relation: &&str| {
        relation.contains("v=\"lanelet\"") && !text.contains(&format!("type=\"relation\" ref=\"{}\"", id(relation)))
    };
    let begins = text.match_indices("  <relation ").map(|(at, _)| &text[at..]);
    let lanelet = begins.map(|rest| rest.split_inclusive("</relation>\n").next().unwrap()).find(is_free).unwrap();
    // A lanelet is missing, and both draw it.
    fs::write(file("base"), text.replace(lanelet, "")).unwrap();
    for (name, new) in [("ours", "7000000001"), ("theirs", "7000000002")] {
        fs::write(file(name), text.replace(lanelet, &lanelet.replace(&id(lanelet), new))).unwrap();
    }
    let told = lanewright(dir.path(), &["merge", "--base", "base", "ours", "theirs", "-o", "out"]).exits(0).stdout;
    assert!(told.contains("new warning[health/twice]: "), "{told}");
    let told = lanewright(dir.path(), &["merge", "--base", "base", "ours", "theirs", "-o", "other", "--no-check"]);
    assert!(!told.exits(0).stdout.contains("new "));
}
