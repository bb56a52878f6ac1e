//! `planner` and `draw --planner` as their users run them.

use std::fs;
use std::path::Path;

use crate::common::program::lanewright;
use crate::common::root;

fn map() -> String {
    root().join("tests/rules/vm-03-10/good.osm").display().to_string()
}

#[test]
fn one_lanelet_a_place_a_route_and_all() {
    let here = Path::new(".");
    let one = lanewright(here, &["planner", &map(), "--lanelet", "213"]).exits(0).stdout;
    assert!(one.starts_with("Lanelet 213 (right)") && one.contains("ignored by element 313"), "{one}");
    let all = lanewright(here, &["planner", &map()]).exits(0).stdout;
    assert_eq!(all.lines().count(), 6, "{all}");
    let route = lanewright(here, &["planner", &map(), "--from", "201", "--to", "206"]).exits(0).stdout;
    assert_eq!(route, one, "the way leads over the turn");
    let json = lanewright(here, &["planner", &map(), "--lanelet", "213", "--format", "json"]).exits(0).stdout;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let told = &json["lanelets"][0];
    assert_eq!(told["lanelet"], 213);
    assert_eq!(told["ignored"][0]["because"], "right_of_way");
    assert_eq!(told["ignored"][0]["element"], 313);
    assert!(told["sentence"].as_str().unwrap().starts_with("Will wait for 2 lanes, ignores 1 lane because"));
    let bumper = &told["lines"]["first_attention"]["ends_lonlat"];
    let middle = |axis: usize| (0..2).map(|end| bumper[end][axis].as_f64().unwrap()).sum::<f64>() / 2.0;
    let (lon, lat) = (middle(0), middle(1));
    let there = lanewright(here, &["planner", &map(), "--at", &format!("{lat},{lon}")]).exits(0).stdout;
    assert!(there.contains("213"), "{there}");
}

#[test]
fn parameters_are_read_from_autowares_files() {
    let dir = tempfile::tempdir().unwrap();
    let write = |text: &str| fs::write(dir.path().join("intersection.param.yaml"), text).unwrap();
    let planner = || {
        let arguments = ["planner", &map(), "--lanelet", "213", "--planner-params", "intersection.param.yaml"];
        lanewright(dir.path(), &arguments)
    };
    write(
        "/**:\n  ros__parameters:\n    intersection:\n      common:\n        attention_area_length: 10.0\n        default_stopline_margin: 1.0\n",
    );
    let told = planner().exits(0).stdout;
    assert!(!told.contains("the map begins"), "ten metres are there: {told}");
    assert!(told.contains("4.3  stop line of the intersection: the default margin"), "{told}");
    write("/**:\n  ros__parameters:\n    intersection:\n      common:\n        attention_area_length: far\n");
    planner()
        .fails_saying(&["`intersection.common.attention_area_length` cannot be `far`", "intersection.param.yaml:5"]);
    write("speed: 1\n");
    planner().fails_saying(&["no parameter in it is read"]);
}

#[test]
fn what_is_not_there_is_told_with_a_way_out() {
    let here = Path::new(".");
    lanewright(here, &["planner", &map(), "--lanelet", "1"])
        .fails_saying(&["the map has no lanelet 1", "draw MAP --ids"]);
    lanewright(here, &["planner", &map(), "--from", "206", "--to", "201"])
        .fails_saying(&["no way leads from lanelet 206 to lanelet 201"]);
    lanewright(here, &["planner", &map(), "--at", "0,0"]).fails_saying(&["0,0"]);
    lanewright(here, &["planner", &map(), "--from", "206"]).fails_saying(&["--to"]);
}

#[test]
fn the_picture_shows_watched_and_ignored_lanes() {
    let dir = tempfile::tempdir().unwrap();
    lanewright(dir.path(), &["draw", &map(), "--planner", "213", "-o", "a.svg"]).exits(0);
    let picture = fs::read_to_string(dir.path().join("a.svg")).unwrap();
    for class in
        ["plan-own", "plan-watched", "plan-before", "plan-ignored", "plan-stuck", "plan-mark", "first attention"]
    {
        assert!(picture.contains(&format!("\"{class}\"")) || picture.contains(&format!(">{class}<")), "{class}");
    }
    lanewright(dir.path(), &["draw", &map(), "--planner", "9", "-o", "b.svg"]).fails_saying(&["no lanelet 9"]);
    assert!(!dir.path().join("b.svg").exists());
}
