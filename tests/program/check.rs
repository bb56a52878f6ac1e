//! `check` as its users run it: settings, suppressions, baseline, formats, watching.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;

use crate::common::program::{Run, command, lanewright};
use crate::common::root;

/// The one finding of the map.
const CODE: &str = "vm-03-02/turn-missing";

/// A directory with `maps/one/map.osm`, whose lanelet 213 has no `turn_direction`, the only fault of the map.
fn place() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir_all(dir.path().join("maps/one")).unwrap();
    fs::copy(root().join("tests/rules/vm-03-02/bad-turn-missing.osm"), dir.path().join("maps/one/map.osm")).unwrap();
    dir
}

fn write(dir: &tempfile::TempDir, name: &str, text: &str) {
    fs::write(dir.path().join(name), text).unwrap();
}

fn check(dir: &tempfile::TempDir, arguments: &[&str]) -> Run {
    lanewright(dir.path(), &[&["check", "maps/one/map.osm", "--format", "concise"], arguments].concat())
}

#[track_caller]
fn says(run: &Run, word: &str) {
    assert!(run.stdout.contains(word), "`{word}` is not said:\n{}", run.stdout);
}

#[test]
fn a_rule_is_selected_and_left_out_by_prefix() {
    let dir = place();
    says(&check(&dir, &[]).exits(1), CODE);
    for left_out in [&["--ignore", "vm-03-02"][..], &["--ignore", CODE], &["--select", "load,vm-03-08"]] {
        says(&check(&dir, left_out).exits(0), "no findings");
    }
    for kept in [&["--select", "vm-03"][..], &["--select", CODE, "--ignore", "vm-03"], &["--ignore", "load,ids"]] {
        check(&dir, kept).exits(1);
    }
    check(&dir, &["--select", "vm-03-2"]).fails_saying(&["no rule or fault `vm-03-2`", "did you mean `vm-03-02`?"]);
    check(&dir, &["--ignore", "vm-03-02/turn-mising"]).fails_saying(&["did you mean `vm-03-02/turn-missing`?"]);
}

#[test]
fn settings_are_found_upward_and_the_nearest_win() {
    let dir = place();
    write(&dir, "lanewright.toml", "ignore = [\"vm-03-02\"]\n");
    check(&dir, &[]).exits(0);
    check(&dir, &["--isolated"]).exits(1);
    // What the command line selects is not left out by the same word of a file.
    check(&dir, &["--select", "vm-03-02"]).exits(1);
    write(&dir, "maps/one/lanewright.toml", "driving_side = \"left\"\n");
    check(&dir, &[]).exits(0);
    write(&dir, "maps/lanewright.toml", "ignore = []\n[severity]\nvm-03-02 = \"warning\"\n");
    says(&check(&dir, &[]).exits(0), "warning[vm-03-02/turn-missing]");
    check(&dir, &["--fail-on", "warning"]).exits(1);
    check(&dir, &["--max-warnings", "0"]).exits(1);
    check(&dir, &["--max-warnings", "1"]).exits(0);
    // A key of the command line is above every file, a file of it replaces what is found.
    check(&dir, &["--config", "severity.vm-03-02='error'"]).exits(1);
    write(&dir, "other.toml", "ignore = [\"vm-03-02\"]\n");
    says(&check(&dir, &["--config", "other.toml"]).exits(0), "no findings");
    check(&dir, &["--isolated", "--config", "ignore=['vm-03-02']"]).exits(0);
}

#[test]
fn the_settings_name_the_projector() {
    let dir = place();
    fs::copy(root().join("tests/rules/node/bad-local-mismatch.osm"), dir.path().join("maps/one/map.osm")).unwrap();
    let mismatch = "node/local-mismatch";
    says(&check(&dir, &[]), mismatch);
    // Then local_x and local_y are the coordinates, and disagree with nothing.
    write(&dir, "lanewright.toml", "projector = \"Local\"\n");
    assert!(!check(&dir, &[]).stdout.contains(mismatch));
    // The settings are above what stands beside the map.
    write(&dir, "maps/one/map_projector_info.yaml", "projector_type: Local\n");
    write(&dir, "lanewright.toml", "driving_side = \"left\"\n");
    assert!(!check(&dir, &[]).stdout.contains(mismatch));
    write(&dir, "lanewright.toml", "projector = \"MGRS\"\n");
    says(&check(&dir, &[]), mismatch);
    write(&dir, "lanewright.toml", "driving_side = \"left\"\nprojector = \"TransverseMercator\"\n");
    check(&dir, &[]).fails_saying(&["this projector needs an origin", "lanewright.toml:2", "add `origin = "]);
}

#[test]
fn what_the_settings_get_wrong_is_shown() {
    let dir = place();
    for (text, words) in [
        ("\nselct = [\"vm-03\"]\n", ["unknown key `selct`", "did you mean `select`?", "lanewright.toml:2:1"]),
        ("ignore = [\"vm-3-02\"]\n", ["no rule or fault `vm-3-02`", "did you mean `vm-03-02`?", "lanewright.toml:1:"]),
        ("[parameters.vm-03-08]\nspik = 1\n", ["no parameter `spik`", "did you mean `spike`?", "lanewright.toml:2:1"]),
        ("[severity]\nload = \"eror\"\n", ["unknown word `eror`", "did you mean `error`?", "lanewright.toml:2:"]),
        ("[[suppress]]\ncode = \"load\"\nprimitive = \"lanelet\"\n", ["needs the id", "add `id = 123`", "toml:1:"]),
        ("select = [\"vm-03\"\n", ["lanewright.toml", "docs/configuration.md", "toml:"]),
    ] {
        write(&dir, "lanewright.toml", text);
        check(&dir, &[]).fails_saying(&words);
    }
    fs::remove_file(dir.path().join("lanewright.toml")).unwrap();
    check(&dir, &["--config", "selct=1"]).fails_saying(&["--config selct=1: unknown key", "did you mean `select`?"]);
    check(&dir, &["--config", "select=vm-03"]).fails_saying(&["KEY=VALUE is TOML"]);
    check(&dir, &["--config", "gone.toml"]).fails_saying(&["cannot read gone.toml"]);
    write(&dir, "other.toml", "");
    check(&dir, &["--config", "othr.toml"]).fails_saying(&["cannot read othr.toml", "did you mean other.toml?"]);
    check(&dir, &["--config", "parameters.vm-03-08.spike='x'"]).fails_saying(&["vm-03-08", "expected"]);
}

#[test]
fn a_finding_is_suppressed_with_a_reason() {
    let dir = place();
    let suppression = |reason: &str| {
        format!(
            "[[suppress]]\ncode = \"{CODE}\"\nprimitive = \"lanelet\"\nid = 213\n{reason}\n[[suppress]]\n\
                 code = \"vm-03\"\nprimitive = \"lanelet\"\nid = [5]\nreason = \"x\"\n"
        )
    };
    write(&dir, "lanewright.toml", &suppression("reason = \"a private yard\""));
    let run = check(&dir, &[]).exits(0);
    says(&run, "left out: 1 suppressed");
    says(
        &run,
        "warning[triage/unused-suppression] The suppression of `vm-03` on lanelet 5 (lanewright.toml:6) suppresses",
    );
    assert!(!run.stdout.contains("no-reason"), "{}", run.stdout);
    // Who looks for something else is not told.
    says(&check(&dir, &["--select", "load"]).exits(0), "no findings");
    write(&dir, "lanewright.toml", &suppression(""));
    says(&check(&dir, &[]).exits(0), "triage/no-reason");
    check(&dir, &["--ignore", "triage"]).exits(0);
}

#[test]
fn a_finding_is_suppressed_by_a_tag() {
    let dir = place();
    let file = dir.path().join("maps/one/map.osm");
    let text = fs::read_to_string(&file).unwrap();
    let start = text.find("<relation id=\"213\"").unwrap();
    let at = start + text[start..].find('>').unwrap() + 1;
    let tagged = |value: &str| {
        let tag = format!("<tag k=\"lanewright:ignore\" v=\"{value}\"/>");
        fs::write(&file, [&text[..at], &tag, &text[at..]].concat()).unwrap();
    };
    tagged(&format!("{CODE}: a yard; of a farm"));
    let run = check(&dir, &[]).exits(0);
    says(&run, "left out: 1 suppressed");
    assert!(!run.stdout.contains("triage"), "{}", run.stdout);
    tagged("vm-03-05, vm-03-02");
    let run = check(&dir, &[]).exits(0);
    says(&run, "`vm-03-05` on lanelet 213 (its tag lanewright:ignore) suppresses nothing");
    says(&run, "gives no reason");
}

#[test]
fn a_baseline_lets_old_findings_pass_and_new_ones_not() {
    let dir = place();
    check(&dir, &["--write-baseline", "debts/base.json"]).exits(0);
    let text = fs::read_to_string(dir.path().join("debts/base.json")).unwrap();
    assert!(text.contains(r#"{"code":"vm-03-02/turn-missing","primitive":"lanelet","id":213,"count":1}"#), "{text}");
    says(&check(&dir, &["--baseline", "debts/base.json"]).exits(0), "left out: 1 known from the baseline");

    write(&dir, "other.json", &text.replace("213", "214"));
    let run = check(&dir, &["--baseline", "other.json"]).exits(1);
    says(&run, "error[vm-03-02/turn-missing]");
    says(
        &run,
        "info[triage/stale-baseline] The baseline lists 1 of `vm-03-02/turn-missing` on lanelet 214 that was not",
    );
    write(&dir, "bad.json", "{}");
    check(&dir, &["--baseline", "bad.json"]).fails_saying(&["bad.json: not a baseline", "--write-baseline"]);
    check(&dir, &["--baseline", "gone.json"]).fails_saying(&["cannot read the baseline gone.json"]);
}

#[test]
fn statistics_count() {
    let dir = place();
    let run = check(&dir, &["--statistics"]).exits(1);
    assert_eq!(run.stdout, format!("1  error    {CODE}\n1 error, 0 warnings, 0 infos\n"));
    lanewright(dir.path(), &["check", "maps/one/map.osm", "--format", "json", "--statistics"])
        .fails_saying(&["--statistics is for text, full and concise"]);
}

#[test]
fn every_format_says_the_same_and_exits_the_same() {
    let dir = place();
    for (format, words) in [
        ("text", &[CODE, "213", "help"][..]),
        ("concise", &["maps/one/map.osm:", CODE]),
        ("json", &["\"schema_version\": 1", CODE, "\"lat\": 35.2"]),
        ("sarif", &["\"version\": \"2.1.0\"", CODE, "\"uri\": \"maps/one/map.osm\"", "## How to mend"]),
        ("github", &["::error file=maps/one/map.osm,line=", CODE]),
        ("gitlab", &["\"fingerprint\"", CODE, "\"path\": \"maps/one/map.osm\""]),
        ("junit", &["<testcase", CODE, "failures=\"1\""]),
        ("geojson", &["\"FeatureCollection\"", CODE, "\"LineString\""]),
    ] {
        let run = lanewright(dir.path(), &["check", "maps/one/map.osm", "--format", format]).exits(1);
        words.iter().for_each(|word| says(&run, word));
        let again = lanewright(dir.path(), &["check", "maps/one/map.osm", "--format", format]);
        assert_eq!(run.stdout, again.stdout, "{format}");
    }
}

#[test]
fn json_of_a_real_run_is_as_its_schema_says() {
    let dir = place();
    let run = lanewright(dir.path(), &["check", "maps/one/map.osm", "--format", "json"]).exits(1);
    let schema = serde_json::from_str(include_str!("../../docs/report.schema.json")).unwrap();
    let value = serde_json::from_str(&run.stdout).unwrap();
    assert!(jsonschema::validator_for(&schema).unwrap().is_valid(&value), "{}", run.stdout);
}

#[test]
fn watching_checks_again_when_the_map_changes() {
    let dir = place();
    let arguments = ["check", "maps/one/map.osm", "--format", "concise", "--watch"];
    let mut child = command(dir.path(), &arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut until = |word: &str| lines.by_ref().map(Result::unwrap).any(|line| line.contains(word));
    let first = until("1 error");
    let good = root().join("tests/rules/vm-03-02/good.osm");
    fs::copy(good, dir.path().join("maps/one/map.osm")).unwrap();
    let second = until("no findings");
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(first && second);
}

#[test]
fn findings_about_settings_are_explained() {
    let run = lanewright(Path::new("."), &["explain", "triage/unused-suppression"]).exits(0);
    says(&run, "lanewright:ignore");
    says(&lanewright(Path::new("."), &["rules"]).exits(0), "triage");
}

#[test]
fn infos_are_counted_until_they_are_asked_for() {
    let dir = place();
    let text = |arguments: &[&str]| lanewright(dir.path(), &[&["check", "maps/one/map.osm"], arguments].concat());
    write(&dir, "lanewright.toml", "[severity]\nvm-03-02 = \"info\"\n");
    let counted = text(&[]).exits(0);
    says(&counted, "counted only; --show info shows them:\n  1  info");
    assert!(!counted.stdout.contains("info[vm-03-02/turn-missing]"), "{}", counted.stdout);
    for shown in [&["--show", "info"][..], &["--format", "full", "--show", "info"]] {
        says(&text(shown).exits(0), "vm-03-02/turn-missing");
        assert!(!text(shown).stdout.contains("counted only"));
    }
    assert!(!text(&["--format", "full"]).stdout.contains("turn-missing"));
    // What makes the run fail is shown.
    says(&text(&["--fail-on", "info"]).exits(1), "info[vm-03-02/turn-missing]");
    write(&dir, "lanewright.toml", "");
    let run = text(&["--show", "error"]).exits(1);
    says(&run, "lanewright explain vm-03-02/turn-missing");
    says(&run, "lanewright fix maps/one/map.osm");
    says(&run, "lanewright check maps/one/map.osm --report report.html");
    text(&["--show", "info", "--format", "json"]).fails_saying(&["--show is for text, full, concise and --report"]);
    says(&text(&["--show", "info", "--format", "json", "--report", "page.html"]).exits(1), "\"schema_version\"");
    says(&text(&["--report", "page.html"]).exits(1), "  look        page.html\n");
    // A packed map is not mended where it is.
    let packed = fs::File::create(dir.path().join("map.osm.gz")).unwrap();
    let mut packed = flate2::write::GzEncoder::new(packed, flate2::Compression::fast());
    std::io::copy(&mut fs::File::open(dir.path().join("maps/one/map.osm")).unwrap(), &mut packed).unwrap();
    packed.finish().unwrap();
    let run = lanewright(dir.path(), &["check", "map.osm.gz"]).exits(1);
    assert!(!run.stdout.contains("lanewright fix"), "{}", run.stdout);
}
