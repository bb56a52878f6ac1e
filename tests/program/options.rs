//! What a run writes and says, and how options change that: canonical maps, several maps, quiet runs, lists for programs.

use std::fs;

use crate::common::program::lanewright;
use crate::common::{is_fresh, root};

/// GDAL, and so QGIS, reads no file with other ids of nodes; JOSM asks before it uploads a file that says so.
#[test]
fn a_built_map_is_canonical_and_other_programs_read_it() {
    let dir = tempfile::tempdir().unwrap();
    for sample in ["roundabout_right.osm", "staggered_left.osm", "turn_lanes_right.osm", "survey_right.xodr"] {
        let input = root().join("sample_maps").join(sample);
        lanewright(dir.path(), &["build", input.to_str().unwrap(), "-o", "map", "--force"]).exits(0);
        lanewright(dir.path(), &["fmt", "map", "--check"]).exits(0);
        let text = fs::read_to_string(dir.path().join("map/lanelet2_map.osm")).unwrap();
        assert!(text.contains("<osm version=\"0.6\" generator=\"lanewright\" upload=\"false\">"));
        let ids: Vec<i64> =
            text.split("<node id=\"").skip(1).map(|one| one.split('"').next().unwrap().parse().unwrap()).collect();
        assert!(ids.iter().all(|id| (0..140_737_488_289_792).contains(id)) && ids.is_sorted(), "{sample}");
        let heights: Vec<&str> =
            text.split("k=\"ele\" v=\"").skip(1).map(|one| one.split('"').next().unwrap()).collect();
        assert!(heights.len() == ids.len() && heights.iter().all(|height| height.contains('.')), "{sample}");
    }
}

#[test]
fn a_map_is_built_into_a_directory() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_left.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "town.osm"])
        .fails_saying(&["that names a file", "give `town`"]);
    fs::create_dir(dir.path().join("old.osm")).unwrap();
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "old.osm"]).exits(0);
}

#[test]
fn several_maps_are_checked_one_after_the_other() {
    let dir = tempfile::tempdir().unwrap();
    let [good, bad] = ["good", "bad-invalid"].map(|name| root().join(format!("tests/rules/vm-03-08/{name}.osm")));
    let [good, bad] = [good.to_str().unwrap(), bad.to_str().unwrap()];
    let told = lanewright(dir.path(), &["check", good, bad, "--isolated"]).exits(1).stdout;
    let both = [good, bad].map(|map| told.lines().position(|line| line == map).unwrap());
    assert!(both.is_sorted() && told.contains("no findings"), "{told}");
    // A map that cannot be read does not hide what the others have.
    let run = lanewright(dir.path(), &["check", "missing.osm", bad, "--format", "concise"]).exits(2);
    assert!(
        run.stdout.contains("vm-03-08/invalid") && run.stderr.contains("missing.osm"),
        "{}{}",
        run.stdout,
        run.stderr
    );
    lanewright(dir.path(), &["check", good, bad, "--format", "json"]).fails_saying(&["several maps", "give one map"]);
    lanewright(dir.path(), &["check", good, bad, "--watch"]).fails_saying(&["--watch is for one map"]);
}

#[test]
fn results_alone_where_that_is_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_left.osm");
    let build = ["build", sample.to_str().unwrap(), "-o", "map"];
    assert!(lanewright(dir.path(), &build).exits(0).stdout.contains("24 lanelets"));
    let run = lanewright(dir.path(), &[&build[..], &["-q"]].concat()).exits(0);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    let run = lanewright(dir.path(), &["draw", "map", "-o", "a.svg", "--quiet"]).exits(0);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    assert_eq!(lanewright(dir.path(), &["check", "map", "-q"]).exits(0).stdout, "no findings\n");
}

#[test]
fn concise_lines_are_of_the_severity_that_is_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let bad = root().join("tests/rules/vm-03-08/bad-invalid.osm");
    let check = ["check", bad.to_str().unwrap(), "--isolated", "--format", "concise"];
    let all = lanewright(dir.path(), &check).exits(1).stdout;
    let errors = lanewright(dir.path(), &[&check[..], &["--show", "error"]].concat()).exits(1).stdout;
    let lines = |text: &str| text.lines().filter(|line| line.contains('[')).map(str::to_owned).collect::<Vec<_>>();
    let meant: Vec<String> = lines(&all).into_iter().filter(|line| line.contains(" error[")).collect();
    assert_eq!(lines(&errors), meant);
    assert!(!meant.is_empty() && errors.lines().last() == all.lines().last(), "all are counted");
}

#[test]
fn rules_are_listed_for_programs() {
    let dir = tempfile::tempdir().unwrap();
    let told = lanewright(dir.path(), &["rules", "--format", "json"]).exits(0).stdout;
    let rules: Vec<serde_json::Value> = serde_json::from_str(&told).unwrap();
    let rule = rules.iter().find(|rule| rule["id"] == "vm-03-08").unwrap();
    assert!(rule["source"].as_str().unwrap().starts_with("https://"), "{rule}");
    let codes: Vec<&str> =
        rule["faults"].as_array().unwrap().iter().map(|fault| fault["code"].as_str().unwrap()).collect();
    assert!(codes.contains(&"vm-03-08/invalid"), "{codes:?}");
    let told = lanewright(dir.path(), &["rules", "--format", "json", "--profile", "tier4"]).exits(0).stdout;
    let validators: Vec<serde_json::Value> = serde_json::from_str(&told).unwrap();
    assert!(validators.iter().all(|one| one["name"].is_string() && one["code"].is_string()), "{told}");
}

#[test]
fn settings_that_are_left_out_are_told() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_left.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "map"]).exits(0);
    assert_eq!(lanewright(dir.path(), &["check", "map"]).exits(0).stderr, "");
    let told = lanewright(dir.path(), &["check", "map", "--isolated"]).stderr;
    assert_eq!(
        told,
        "map/lanewright.toml was left out (--isolated): what it says of this map explains some findings\n"
    );
}

#[test]
fn the_picture_of_the_readme_is_fresh() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_right.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "crossing"]).exits(0);
    let part = ["--at", "49.0123,8.5321", "--radius", "35"];
    lanewright(dir.path(), &[&["draw", "crossing", "-o", "crossing.svg"][..], &part].concat()).exits(0);
    let drawn = fs::read_to_string(dir.path().join("crossing.svg")).unwrap();
    assert!(is_fresh(&root().join("docs/crossing.svg"), &drawn), "LANEWRIGHT_UPDATE=1 draws it again");
}

/// A lane along the equator, across the meridian of Greenwich: MGRS would fold its ends, which lie in four squares, into one.
#[test]
fn a_map_across_squares_is_judged_under_another_projection() {
    let dir = tempfile::tempdir().unwrap();
    let node = |id, lat, lon| format!("<node id=\"{id}\" lat=\"{lat}\" lon=\"{lon}\"><tag k=\"ele\" v=\"10\"/></node>");
    let nodes = [node(1, 2e-5, -2e-4), node(2, 2e-5, 2e-4), node(3, -1e-5, -2e-4), node(4, -1e-5, 2e-4)].concat();
    let ways = [(11, 1, 2), (12, 3, 4)]
        .map(|(id, a, b)| {
            let tags = "<tag k=\"type\" v=\"line_thin\"/><tag k=\"subtype\" v=\"solid\"/>";
            format!("<way id=\"{id}\"><nd ref=\"{a}\"/><nd ref=\"{b}\"/>{tags}</way>")
        })
        .concat();
    let members = "<member type=\"way\" role=\"left\" ref=\"11\"/><member type=\"way\" role=\"right\" ref=\"12\"/>";
    let tags =
        [("type", "lanelet"), ("subtype", "road"), ("location", "urban"), ("one_way", "yes"), ("speed_limit", "40")];
    let tags = tags.map(|(key, value)| format!("<tag k=\"{key}\" v=\"{value}\"/>")).concat();
    let text = format!(
        "<osm><MetaInfo format_version=\"2\"/>{nodes}{ways}<relation id=\"21\">{members}{tags}</relation></osm>"
    );
    fs::write(dir.path().join("m.osm"), text).unwrap();
    let told = lanewright(dir.path(), &["check", "m.osm", "--format", "concise"]).stdout;
    assert!(
        told.contains("projector/missing") && told.contains("30NZF") && told.contains("TransverseMercator"),
        "{told}"
    );
    assert!(!told.contains("health/") && !told.contains("node/"), "nothing is torn: {told}");
    let told = lanewright(dir.path(), &["project", "infer", "m.osm"]).stdout;
    assert!(told.contains("projector_type: TransverseMercator") && !told.contains("-0.0\n"), "{told}");
}

/// A street of 317 m over the border between two squares of 100 km.
#[test]
fn mgrs_names_the_border_that_the_data_crosses() {
    let dir = tempfile::tempdir().unwrap();
    let nodes = [(1, 48.0900, 11.6824), (2, 48.0900, 11.6867)];
    let nodes = nodes.map(|(id, lat, lon)| format!("<node id=\"{id}\" lat=\"{lat}\" lon=\"{lon}\"/>")).concat();
    let way = "<way id=\"9\"><nd ref=\"1\"/><nd ref=\"2\"/><tag k=\"highway\" v=\"residential\"/></way>";
    fs::write(dir.path().join("street.osm"), format!("<osm version=\"0.6\">{nodes}{way}</osm>")).unwrap();
    lanewright(dir.path(), &["build", "street.osm", "-o", "map", "--projector", "MGRS"]).fails_saying(&[
        "32UPU",
        "32UQU",
        "--projector TransverseMercator",
    ]);
    lanewright(dir.path(), &["build", "street.osm", "-o", "map"]).exits(0);
}
