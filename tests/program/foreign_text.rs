//! Text of strangers, in maps, settings and names of files, steers neither a terminal nor a machine that runs CI.

use std::fs;
use std::path::Path;

use crate::common::program::{Run, lanewright};
use crate::common::root;

/// What no output may hold, in any line: escape bytes, and commands of GitHub and Azure.
#[track_caller]
fn steers_nothing(run: &Run, what: &str) {
    // A patch that goes to a file fits what is there.
    let is_patch = what.ends_with("--diff");
    for text in [&run.stdout, &run.stderr] {
        let steering = |c: char| c.is_control() && !matches!(c, '\n' | '\t') || c == '\u{202e}' && !is_patch;
        for line in text.lines() {
            assert!(!line.chars().any(steering), "{what}: {line:?}");
            assert!(!line.trim_start().starts_with("::"), "{what}: {line:?}");
            assert!(!line.contains("##[") && !line.contains("##vso["), "{what}: {line:?}");
        }
    }
}

const EVIL: &str = "\u{1b}]0;x\u{7}\u{9b}2J##[error]e&#10;::error::e\u{202e}##vso[task]";

/// A map with lanes that turn nowhere known, and whose words are the stranger's.
fn evil_map(dir: &Path) -> String {
    let sample = root().join("sample_maps/crossing_right.osm");
    lanewright(dir, &["build", sample.to_str().unwrap(), "-o", "good"]).exits(0);
    let good = fs::read_to_string(dir.join("good/lanelet2_map.osm")).unwrap();
    let bad = good.replacen("k=\"turn_direction\" v=\"left\"", &format!("k=\"turn_direction\" v=\"{EVIL}\""), 1);
    let bad = bad.replacen("k=\"subtype\" v=\"road\"", &format!("k=\"subtype\" v=\"{EVIL}\""), 1);
    let bad = bad.replacen("k=\"subtype\" v=\"solid\"", &format!("k=\"subtype\" v=\"{EVIL}\""), 1);
    assert_ne!(good, bad);
    bad
}

#[test]
fn a_map_steers_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let map = evil_map(dir.path());
    fs::write(dir.path().join("a.osm"), &map).unwrap();
    for arguments in [
        &["check", "a.osm"][..],
        &["check", "a.osm", "--format", "full", "--show", "info"],
        &["check", "a.osm", "--format", "concise"],
        &["check", "a.osm", "--statistics"],
        &["check", "a.osm", "--profile", "tier4", "--format", "tier4"],
        &["check", "a.osm", "--profile", "tier4"],
        &["fix", "a.osm", "--unsafe", "--diff"],
        &["stats", "a.osm"],
        &["diff", "good", "a.osm"],
        &["draw", "a.osm", "-o", "a.svg"],
        &["fmt", "a.osm", "--check"],
        &["project", "infer", "a.osm"],
    ] {
        steers_nothing(&lanewright(dir.path(), arguments), &arguments.join(" "));
    }
    steers_nothing(&lanewright(dir.path(), &["fix", "a.osm", "--unsafe"]), "fix");
}

#[test]
fn the_name_of_a_file_steers_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let evil = "\u{1b}[2J##[error]\n::error::e\u{9b}";
    let [map, broken, streets] = ["map", "broken", "streets"].map(|what| format!("::{what}{evil}.osm"));
    fs::write(dir.path().join(&map), evil_map(dir.path())).unwrap();
    fs::write(dir.path().join(&broken), "<osm><node id=\"1\"").unwrap();
    fs::copy(root().join("sample_maps/crossing_right.osm"), dir.path().join(&streets)).unwrap();
    let out = |ending: &str| format!("::out{evil}{ending}");
    for arguments in [
        &["check", &map][..],
        &["check", &broken],
        &["check", "::none\u{1b}[1m\n::error::"],
        &["check", &map, "--format", "concise"],
        &["check", &map, "--report", &out(".html")],
        &["check", &map, "--write-baseline", &out(".json")],
        &["check", &map, "--profile", "tier4", "--format", "tier4"],
        &["fmt", &map, "--check"],
        &["fix", &map, "--pictures", &out("pictures")],
        &["draw", &map, "-o", &out(".svg")],
        &["draw", &map, "-o", &out(".nothing")],
        &["draw", &streets, "--stage", "outline", "-o", &out("stage.svg")],
        &["draw", &streets, "--stage", "outline", "--each", "-o", &out("each")],
        &["geometry", &streets, "-o", &out(".geojson")],
        &["build", &streets, "-o", &out("")],
        &["build", &streets, "-o", &out("cells"), "--cells", "100"],
        &["split", &map, "-o", &out("split")],
        &["merge", &map, "-o", &out("merged")],
        &["cut", &streets, "--tiles", "800", "-o", &out("tiles")],
        &["project", "convert", &map, "--to", "MGRS", "-o", &out("converted")],
        &["diff", &map, &streets],
        &["man", &out("man")],
    ] {
        steers_nothing(&lanewright(dir.path(), arguments), &format!("{arguments:?}"));
    }
}

#[test]
fn a_tolerance_is_a_length() {
    let dir = tempfile::tempdir().unwrap();
    let map = root().join("tests/rules/vm-03-02/good.osm");
    let map = map.to_str().unwrap();
    for tolerance in ["nan", "-1", "inf", "-0.5", "much"] {
        let argument = format!("--tolerance={tolerance}");
        lanewright(dir.path(), &["diff", map, map, &argument]).fails_saying(&[tolerance, "is no length in metres"]);
    }
    lanewright(dir.path(), &["diff", map, map, "--tolerance", "0"]).exits(0);
}

#[test]
#[cfg(unix)]
fn a_link_shows_nothing_of_what_it_leads_to() {
    let secret = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        fs::write(secret.path().join(name), text).unwrap();
        secret.path().join(name)
    };
    let tree = tempfile::tempdir().unwrap();
    let at = |name: &str| tree.path().join(name);
    std::os::unix::fs::symlink(file("passwd", "root:hunter2:0:0\n"), at("a.osm")).unwrap();
    std::os::unix::fs::symlink(file("page", "<html><p>hunter2</html>"), at("b.osm")).unwrap();
    for map in ["a.osm", "b.osm"] {
        let run = lanewright(tree.path(), &["check", map]).fails_saying(&[map]);
        assert!(!run_text(&run).contains("hunter2"), "{}", run.stderr);
    }
    fs::copy(root().join("tests/rules/vm-03-02/good.osm"), at("good.osm")).unwrap();
    let settings =
        ["select = [\"hunter2\"]\n", "[severity]\nhunter2 = \"error\"\n", "[parameters.vm-03-08]\nhunter2 = 1\n"];
    for text in ["root:hunter2:0:0\n", "[registry]\ntoken = \"hunter2\"\n"].into_iter().chain(settings) {
        let _ = fs::remove_file(at("lanewright.toml"));
        std::os::unix::fs::symlink(file("credentials", text), at("lanewright.toml")).unwrap();
        let run =
            lanewright(tree.path(), &["check", "good.osm"]).fails_saying(&["lanewright.toml", "instead of a link"]);
        assert!(!run_text(&run).contains("hunter2"), "{}", run.stderr);
    }
    fs::remove_file(at("lanewright.toml")).unwrap();
    for text in ["root:hunter2:0:0\n", "projector_type: hunter2\n", "hunter2: [\n", "[registry]\ntoken = \"hunter2\"\n"]
    {
        let _ = fs::remove_file(at("map_projector_info.yaml"));
        std::os::unix::fs::symlink(file("hosts", text), at("map_projector_info.yaml")).unwrap();
        let run = lanewright(tree.path(), &["check", "good.osm"]);
        assert!(run_text(&run).contains("the link leads to a file that names no projector"), "{text}");
        assert!(!run_text(&run).contains("hunter2"), "{}", run_text(&run));
    }
    fs::remove_file(at("map_projector_info.yaml")).unwrap();
    // What is no link is shown with its place.
    fs::write(at("lanewright.toml"), "profile = mine\n").unwrap();
    lanewright(tree.path(), &["check", "good.osm"]).fails_saying(&["lanewright.toml:1:", "profile = mine"]);
}

#[cfg(unix)]
fn run_text(run: &Run) -> String {
    format!("{}{}", run.stdout, run.stderr)
}

#[test]
fn a_long_word_of_the_settings_is_not_repeated_whole() {
    let dir = tempfile::tempdir().unwrap();
    let word = "y".repeat(100_000);
    for settings in [format!("profile = \"{word}\""), format!("select = [\"{word}\"]")] {
        fs::write(dir.path().join("long.toml"), settings).unwrap();
        let run = lanewright(dir.path(), &["check", "--config", "long.toml", "map.osm"]).exits(2);
        assert!(run.stderr.len() < 5000 && run.stderr.contains("letters left out"), "{}", run.stderr.len());
    }
}
