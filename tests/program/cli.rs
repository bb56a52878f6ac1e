//! The program as its users run it: the README's commands, and input that cannot be good.

use std::fs;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::Stdio;

use crate::common::program::{Run, command, lanewright};
use crate::common::{is_fresh, root};

/// An empty directory with a file in it, if any.
fn place_with(name: &str, content: &[u8]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join(name), content).unwrap();
    dir
}

/// Every command that reads a file refuses this content with these words.
#[track_caller]
fn both_refuse(content: &[u8], words: &[&str]) {
    let dir = place_with("bad.osm", content);
    lanewright(dir.path(), &["build", "bad.osm", "-o", "out"]).fails_saying(words);
    assert!(!dir.path().join("out").exists(), "a failed build leaves nothing");
    lanewright(dir.path(), &["check", "bad.osm"]).fails_saying(words);
    lanewright(dir.path(), &["draw", "bad.osm", "-o", "a.svg"]).fails_saying(words);
    assert!(!dir.path().join("a.svg").exists(), "a failed draw leaves nothing");
}

const WAY: &str = r#"<osm version="0.6">
  <node id="1" lat="49.01" lon="8.53"/>
  <node id="2" lat="49.02" lon="8.53"/>
  <way id="3"><nd ref="1"/><nd ref="2"/><tag k="highway" v="HIGHWAY"/></way>
</osm>
"#;

#[test]
fn not_xml() {
    both_refuse(b"to be or not to be\n", &["this is not XML", "bad.osm:1:1", "expected OpenStreetMap XML"]);
}

#[test]
fn not_text() {
    both_refuse(b"\x89PNG\r\n\x1a\n\xff\xfe", &["neither OpenStreetMap PBF nor UTF-8 text"]);
}

#[test]
fn truncated_xml() {
    let text = &WAY[..WAY.len() - 30];
    both_refuse(text.as_bytes(), &["bad.osm:4:", "cut off"]);
}

#[test]
fn empty_file() {
    both_refuse(b"", &["bad.osm is empty"]);
}

#[test]
fn empty_directory() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("maps")).unwrap();
    lanewright(dir.path(), &["check", "maps"]).fails_saying(&["maps", ".osm"]);
    lanewright(dir.path(), &["build", "maps", "-o", "out"]).fails_saying(&["maps"]);
    assert!(!dir.path().join("out").exists());
}

#[test]
fn no_such_file() {
    let dir = tempfile::tempdir().unwrap();
    for verb in [&["build", "gone.osm", "-o", "out"][..], &["check", "gone.osm"], &["draw", "gone.osm", "-o", "a.png"]]
    {
        lanewright(dir.path(), verb).fails_saying(&["gone.osm"]);
    }
}

#[test]
fn no_drivable_road() {
    let dir = place_with("paths.osm", WAY.replace("HIGHWAY", "footway").as_bytes());
    lanewright(dir.path(), &["build", "paths.osm", "-o", "out"]).fails_saying(&["no drivable road"]);
    assert!(!dir.path().join("out").exists());
}

#[test]
fn nodes_that_are_not_on_earth() {
    both_refuse(WAY.replace("49.02", "200").as_bytes(), &["latitude 200", "not on Earth", "bad.osm:3:"]);
}

#[test]
fn a_way_of_ten_million_members() {
    let dir = tempfile::tempdir().unwrap();
    let mut file = BufWriter::new(fs::File::create(dir.path().join("long.osm")).unwrap());
    file.write_all(b"<osm version=\"0.6\"><node id=\"1\" lat=\"1\" lon=\"1\"/><way id=\"2\">").unwrap();
    for _ in 0..10_000_000 {
        file.write_all(b"<nd ref=\"1\"/>").unwrap();
    }
    file.write_all(b"</way></osm>").unwrap();
    drop(file);
    lanewright(dir.path(), &["build", "long.osm", "-o", "out"]).fails_saying(&["long.osm", "begins within 64 MB"]);
    lanewright(dir.path(), &["check", "long.osm"]).fails_saying(&["long.osm", "begins within 64 MB"]);
}

#[test]
fn a_navigation_map_is_not_a_lanelet2_map() {
    let dir = place_with("roads.osm", WAY.replace("HIGHWAY", "residential").as_bytes());
    lanewright(dir.path(), &["check", "roads.osm"])
        .fails_saying(&["roads.osm is not a Lanelet2 map", "lanewright build roads.osm"]);
}

#[test]
fn a_lanelet2_map_cannot_be_built_from() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_right.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "out"]).exits(0);
    lanewright(dir.path(), &["build", "out/lanelet2_map.osm", "-o", "again"])
        .fails_saying(&["is a Lanelet2 map already", "lanewright check out/lanelet2_map.osm"]);
    assert!(!dir.path().join("again").exists());
}

#[test]
fn good_files_survive_a_failure() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/tjunction_right.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "out"]).exits(0);
    let listing = |dir: &Path| -> Vec<(std::ffi::OsString, Vec<u8>)> {
        let mut files: Vec<_> = fs::read_dir(dir).unwrap().flatten().map(|e| (e.file_name(), e.path())).collect();
        files.sort();
        files.into_iter().map(|(name, path)| (name, fs::read(path).unwrap())).collect()
    };
    let before = listing(&dir.path().join("out"));
    assert_eq!(before.len(), 3);
    fs::write(dir.path().join("bad.osm"), "<osm>").unwrap();
    lanewright(dir.path(), &["build", "bad.osm", "-o", "out"]).exits(2);
    assert!(before == listing(&dir.path().join("out")));
}

#[test]
fn settings_of_the_user_are_not_written_over() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/tjunction_right.osm");
    let own = "driving_side = \"right\"\n";
    fs::write(dir.path().join("lanewright.toml"), own).unwrap();
    let build = |output: &str| lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", output]);
    build(".").fails_saying(&["lanewright.toml was not written by `build`", "a directory of its own"]);
    assert_eq!(fs::read_to_string(dir.path().join("lanewright.toml")).unwrap(), own);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    // What a build has written, the next one replaces.
    build("out").exits(0);
    build("out").exits(0);
}

/// The input lies beside the map that is built from it: what one build has written does not influence the next.
#[test]
fn what_a_build_has_written_does_not_influence_the_next() {
    let sample = fs::read(root().join("sample_maps/crossing_right.osm")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let map = dir.path().join("map");
    fs::create_dir(&map).unwrap();
    fs::write(map.join("in.osm"), &sample).unwrap();
    let build = |more: &[&str]| {
        lanewright(dir.path(), &[&["build", "map/in.osm", "-o", "map"][..], more].concat()).exits(0);
        fs::read_to_string(map.join("lanewright.toml")).unwrap()
    };
    let plain = build(&[]);
    let text = fs::read_to_string(map.join("lanelet2_map.osm")).unwrap();
    let ia = text.split("k=\"intersection_area\" v=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let phased =
        build(&["--config", &format!("intersection=[{{ia={ia}, phases=[[\"S\"], [\"N\"], [\"E\", \"W\"]]}}]")]);
    assert!(phased.contains("phases = [[\"S\"], [\"N\"], [\"E\", \"W\"]]"), "{phased}");
    assert_eq!(build(&[]), plain);
}

#[test]
fn lines_are_written_for_map_viewers() {
    let sample = root().join("sample_maps/crossing_left.osm");
    let dir = tempfile::tempdir().unwrap();
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "map"]).exits(0);
    let draw = |more: &[&str]| -> serde_json::Value {
        let run = lanewright(dir.path(), &[&["draw", "map", "-o", "lines.geojson"][..], more].concat()).exits(0);
        assert_eq!(run.stdout, "lines.geojson\n");
        serde_json::from_slice(&fs::read(dir.path().join("lines.geojson")).unwrap()).unwrap()
    };
    let features = |value: &serde_json::Value| value["features"].as_array().unwrap().clone();
    let all = features(&draw(&[]));
    for (kind, key) in [("Polygon", "lanelet"), ("LineString", "linestring")] {
        let own: Vec<_> = all.iter().filter(|one| one["geometry"]["type"] == kind).collect();
        assert!(!own.is_empty() && own.iter().all(|one| one["properties"][key].is_i64()), "{kind}");
    }
    let corner = &all[0]["geometry"]["coordinates"][0][0];
    let at = format!("{},{}", corner[1], corner[0]);
    let near = features(&draw(&["--at", &at, "--radius", "1"])).len();
    assert!(0 < near && near < all.len(), "{near} of {}", all.len());
}

#[test]
fn wrong_arguments_are_the_users_error() {
    let dir = tempfile::tempdir().unwrap();
    let cases: [&[&str]; 6] = [
        &["fly"],
        &["build", "a.osm"],
        &["draw", "a.osm", "-o", "a.jpg"],
        &["draw", "a.osm", "-o", "a.png", "--at", "here"],
        &["check", "a.osm", "--fail-on", "sometimes"],
        &["explain", "vm-99-99"],
    ];
    for arguments in cases {
        let run = lanewright(dir.path(), arguments).exits(2);
        assert!(!run.stderr.is_empty() && run.stdout.is_empty(), "{arguments:?}");
    }
}

#[test]
fn a_reader_that_stops_early_is_no_failure() {
    for arguments in [&["rules"][..], &["explain", "vm-03-08"], &["--help"]] {
        let mut child =
            command(Path::new("."), arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let run = Run::from(child.wait_with_output().unwrap());
        assert!(run.code == 0 && run.stderr.is_empty(), "{arguments:?}: {} {}", run.code, run.stderr);
    }
}

#[test]
fn pipes_get_no_colours() {
    let dir = tempfile::tempdir().unwrap();
    let run = lanewright(dir.path(), &["check", "gone.osm"]);
    assert!(!run.stderr.contains('\u{1b}'), "{}", run.stderr);
}

#[test]
fn a_foreign_proj_installation_does_no_harm() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_left.osm");
    let mut build = command(dir.path(), &["build", sample.to_str().unwrap(), "-o", "out"]);
    Run::from(build.env("PROJ_DATA", "/nowhere").env("PROJ_LIB", "/nowhere").output().unwrap()).exits(0);
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "plain"]).exits(0);
    let map = |out: &str| fs::read(dir.path().join(out).join("lanelet2_map.osm")).unwrap();
    assert!(map("out") == map("plain"));
}

/// Runs the commands behind `$ ` in the `console` blocks of the README and compares the output with the lines below. A line
/// `...` stands for any lines.
#[test]
fn the_readme_shows_what_happens() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("sample_maps")).unwrap();
    for sample in fs::read_dir(root().join("sample_maps")).unwrap() {
        let sample = sample.unwrap();
        fs::copy(sample.path(), dir.path().join("sample_maps").join(sample.file_name())).unwrap();
    }
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let mut ran = 0;
    for block in readme.split("```console\n").skip(1).filter_map(|rest| rest.split("```").next()) {
        for step in block.split("$ ").skip(1) {
            let (line, expected) = step.split_once('\n').unwrap_or((step, ""));
            let Some(arguments) = line.strip_prefix("lanewright ") else { continue };
            let arguments: Vec<&str> = arguments.split_whitespace().collect();
            let run = lanewright(dir.path(), &arguments);
            assert!(run.code < 2, "`{line}` fails:\n{}", run.stderr);
            assert!(shows(&run.stdout, expected), "`{line}` shows:\n{}\nbut the README has:\n{expected}", run.stdout);
            ran += 1;
        }
    }
    assert!(ran >= 4, "only {ran} commands of the README were found");
}

/// Whether the text is as expected, where a line `...` stands for any lines.
fn shows(text: &str, expected: &str) -> bool {
    let expected = format!("\n{}", expected.trim());
    let parts: Vec<&str> = expected.split("\n...").map(str::trim).collect();
    let mut rest = text.trim();
    for (i, part) in parts.iter().enumerate() {
        match rest.find(part) {
            Some(0) => rest = &rest[part.len()..],
            Some(at) if i > 0 => rest = &rest[at + part.len()..],
            _ => return false,
        }
    }
    rest.trim().is_empty() || parts.last().is_some_and(|p| p.is_empty())
}

/// `docs/cli.md` is the help of every verb; `LANEWRIGHT_UPDATE=1 cargo test --test program` writes it anew.
#[test]
fn the_page_of_the_command_line_is_fresh() {
    let mut page = String::from(
        "# The command line\n\nWhat `lanewright --help` says, and each verb after it. This page is generated; \
         `LANEWRIGHT_UPDATE=1 cargo test --test program` writes it anew.\n\n\
         Results go to standard output, progress and errors to standard error. A pipe or a file gets no colours, nor does \
         a terminal with `NO_COLOR` set.\n",
    );
    let help_of = |verb: &str| {
        let arguments: Vec<&str> = [verb, "--help"].into_iter().filter(|word| !word.is_empty()).collect();
        lanewright(Path::new("."), &arguments).exits(0).stdout
    };
    let overview = help_of("");
    let (_, verbs) = overview.split_once("Commands:\n").unwrap();
    // A verb begins in the third column; the lines that go on further in are what it does.
    let verbs = verbs.lines().take_while(|line| !line.is_empty()).filter_map(|line| line.strip_prefix("  "));
    let verbs = verbs.filter(|line| !line.starts_with(' ')).filter_map(|line| line.split_whitespace().next());
    for verb in std::iter::once("").chain(verbs.filter(|verb| *verb != "help")) {
        let help = help_of(verb);
        let title = if verb.is_empty() { "lanewright" } else { verb };
        page += &format!("\n## {title}\n\n```text\n{}\n```\n", help.trim_end());
    }
    let path = root().join("docs/cli.md");
    assert!(is_fresh(&path, &page), "docs/cli.md is stale; run: LANEWRIGHT_UPDATE=1 cargo test --test program");
}

#[test]
fn completions_and_manual_pages_name_every_verb() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = lanewright(Path::new("."), &["completions", shell]).exits(0).stdout;
        for word in ["build", "check", "draw", "--fail-on"] {
            assert!(script.contains(word.trim_start_matches('-')), "{shell} does not complete {word}");
        }
    }
    let dir = tempfile::tempdir().unwrap();
    lanewright(dir.path(), &["man", "pages"]).exits(0);
    for (page, word) in
        [("lanewright.1", "check"), ("lanewright-check.1", "baseline"), ("lanewright-build.1", "projector")]
    {
        let text = fs::read_to_string(dir.path().join("pages").join(page)).unwrap();
        assert!(text.starts_with(".ie") && text.contains(word), "{page} does not speak of {word}");
    }
}

#[test]
fn diff_tells_what_changed_and_shows_it() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_right.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "old"]).exits(0);
    assert_eq!(lanewright(dir.path(), &["diff", "old", "old"]).exits(0).stdout, "no difference\n");
    fs::create_dir(dir.path().join("new")).unwrap();
    let text = fs::read_to_string(dir.path().join("old/lanelet2_map.osm")).unwrap();
    let new = text.replacen("v=\"left\"", "v=\"right\"", 1);
    assert_ne!(text, new);
    fs::write(dir.path().join("new/lanelet2_map.osm"), new).unwrap();
    fs::copy(dir.path().join("old/map_projector_info.yaml"), dir.path().join("new/map_projector_info.yaml")).unwrap();
    let run = lanewright(dir.path(), &["diff", "old", "new", "--report", "changes.html"]).exits(1);
    assert!(run.stdout.contains("turn_direction from `left` to `right`"), "{}", run.stdout);
    let page = fs::read_to_string(dir.path().join("changes.html")).unwrap();
    assert!(page.contains("<title>old → new") && page.contains("id=\"old-map-data\""));
    let json = lanewright(dir.path(), &["diff", "old", "new", "--format", "json"]).exits(1).stdout;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["totals"]["lanelets"]["changed"], 1);
    assert_eq!(json["changes"][0]["facts"][0]["fact"], "tag");
}

#[test]
fn fix_mends_what_it_can_and_touches_nothing_else() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_right.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "map"]).exits(0);
    let path = dir.path().join("map/lanelet2_map.osm");
    let good = fs::read_to_string(&path).unwrap();
    let nothing = "0 fixed; left: 0 errors, 0 warnings\n0 errors fewer, 0 warnings fewer\n";
    assert_eq!(lanewright(dir.path(), &["fix", "map"]).exits(0).stdout, nothing);
    assert_eq!(fs::read_to_string(&path).unwrap(), good);
    let bad = good.replacen("v=\"left\"", "v=\"right\"", 1);
    fs::write(&path, &bad).unwrap();
    let diff = lanewright(dir.path(), &["fix", "map", "--diff"]).exits(1).stdout;
    assert!(
        diff.contains("-    <tag k=\"turn_direction\" v=\"right\"/>\n+    <tag k=\"turn_direction\" v=\"left\"/>"),
        "{diff}"
    );
    lanewright(dir.path(), &["fix", "map", "--diff", "--pictures", "seen"]).exits(1);
    let seen = |name: &str| fs::read_to_string(dir.path().join("seen").join(name)).unwrap();
    assert!(seen("index.html").contains("set turn_direction=left") && seen("index.html").contains("src=\"1.svg\""));
    // One picture, and in it both versions.
    assert_eq!(seen("1.svg").matches("<svg").count(), 3);
    assert_eq!(fs::read_dir(dir.path().join("seen")).unwrap().count(), 2);
    assert_eq!(fs::read_to_string(&path).unwrap(), bad, "--diff changes nothing");
    lanewright(dir.path(), &["check", "map"]).exits(1);
    lanewright(dir.path(), &["check", "map", "--fix"]).exits(0);
    assert_eq!(fs::read_to_string(&path).unwrap(), good);
}

#[test]
fn a_formatted_map_says_the_same_and_stays_so() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/tjunction_left.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "map"]).exits(0);
    let path = dir.path().join("map/lanelet2_map.osm");
    let good = fs::read_to_string(&path).unwrap();
    let unkempt =
        good.replace(" version=\"1\" ", " ").replace("\n    ", "\n\t").replacen("<osm version=\"0.6\"", "<osm", 1);
    fs::write(&path, &unkempt).unwrap();
    lanewright(dir.path(), &["fmt", "map", "--check"]).exits(1);
    let shown = lanewright(dir.path(), &["fmt", "map", "--diff"]).exits(1).stdout;
    assert!(shown.starts_with("--- map/lanelet2_map.osm\n+++ map/lanelet2_map.osm\n@@"), "{shown}");
    assert!(shown.contains("\n-<osm generator") && shown.contains("\n+<osm version=\"0.6\" generator"), "{shown}");
    assert_eq!(fs::read_to_string(&path).unwrap(), unkempt, "--check and --diff change nothing");
    lanewright(dir.path(), &["fmt", "map"]).exits(0);
    assert_eq!(lanewright(dir.path(), &["fmt", "map", "--diff"]).exits(0).stdout, "");
    let formatted = fs::read_to_string(&path).unwrap();
    lanewright(dir.path(), &["fmt", "map", "--check"]).exits(0);
    assert_eq!(fs::read_to_string(&path).unwrap(), formatted);
    fs::create_dir(dir.path().join("old")).unwrap();
    fs::write(dir.path().join("old/lanelet2_map.osm"), good).unwrap();
    assert_eq!(lanewright(dir.path(), &["diff", "old", "map"]).exits(0).stdout, "no difference\n");
}

#[test]
fn a_projection_is_found_and_changed() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_left.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "built"]).exits(0);
    // Autoware needs no metres beside degrees, so they are not written.
    let told = lanewright(dir.path(), &["project", "infer", "built"]).exits(0).stdout;
    assert!(told.contains("none has local_x") && told.contains("mgrs_grid: 54SVE"), "{told}");
    lanewright(dir.path(), &["project", "convert", "built", "--to", "MGRS", "-o", "map"]).exits(0);
    let told = lanewright(dir.path(), &["project", "infer", "map"]).exits(0).stdout;
    assert!(told.contains("projector_type: MGRS"), "{told}");
    for to in ["TransverseMercator", "LocalCartesianUTM", "LocalCartesian"] {
        lanewright(dir.path(), &["project", "convert", "map", "--to", to, "-o", to]).exits(0);
        let told = lanewright(dir.path(), &["project", "infer", to]).exits(0).stdout;
        assert!(told.contains(&format!("map_projector_info.yaml says {to}")), "{told}");
        lanewright(dir.path(), &["check", to]).exits(0);
    }
    let [heights, back] = ["LocalCartesian", "back"].map(|map| dir.path().join(map).join("map_projector_info.yaml"));
    let geoid = fs::read_to_string(&heights).unwrap().replace("WGS84", "EGM2008");
    fs::write(&heights, geoid).unwrap();
    lanewright(dir.path(), &["project", "convert", "LocalCartesian", "--to", "MGRS", "-o", "back"]).exits(0);
    assert!(fs::read_to_string(back).unwrap().contains("vertical_datum: EGM2008"), "heights stay what they are");
    assert_eq!(lanewright(dir.path(), &["diff", "map", "back"]).exits(0).stdout, "no difference\n");
    let info = dir.path().join("TransverseMercator/map_projector_info.yaml");
    let wrong = fs::read_to_string(&info).unwrap().replace("TransverseMercator", "LocalCartesian");
    fs::write(&info, wrong).unwrap();
    lanewright(dir.path(), &["project", "infer", "TransverseMercator"]).exits(1);
}
