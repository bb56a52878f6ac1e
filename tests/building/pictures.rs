//! Pictures of a dozen street layouts, compared line by line with `tests/pictures`. What differs is drawn beside the old picture in
//! target/tmp/pictures; `LANEWRIGHT_UPDATE=1 cargo test --test building pictures` writes the pictures anew.

use std::fs;
use std::path::{Path, PathBuf};

use lanewright::geometry::Point;
use lanewright::report::draw::sketch::beside;
use lanewright::report::draw::{View, rendered};

use crate::common::program::lanewright;
use crate::common::{osm_files, root, samples, stem, updating};

/// The stages that are drawn of every layout.
const STAGES: [&str; 2] = ["outline", "lanes"];
/// Further stages, drawn of a few layouts to test the drawing itself.
const STEPS: [&str; 4] = ["thicken", "collide", "trim", "consolidate"];
/// The layouts of which every stage is drawn.
const WHOLE: [&str; 2] = ["divided_crossing", "dogleg"];
/// Pixels per metre: enough to see 10 cm, and not more.
const SCALE: &str = "4";
/// Where the style sheet begins.
const STYLE: &str = "<style>";

/// The sample maps and the layouts in `tests/street_layouts`.
fn places() -> Vec<PathBuf> {
    let own = osm_files(&root().join("tests/street_layouts"));
    samples().into_iter().chain(own).collect()
}

/// The picture as text without the style sheet, which is the same for all; and the style sheet.
fn drawn(place: &Path, stage: &str, dir: &Path) -> (String, String) {
    let picture = dir.join("picture.svg");
    let arguments = ["draw", place.to_str().unwrap(), "--stage", stage, "--scale", SCALE, "-o"];
    let arguments = [&arguments[..], &[picture.to_str().unwrap()]].concat();
    lanewright(dir, &arguments).exits(0);
    let svg = fs::read_to_string(picture).unwrap();
    let (head, rest) = svg.split_once("<title>").unwrap();
    let (_, rest) = rest.split_once("</title>").unwrap();
    let (before, rest) = rest.split_once(STYLE).unwrap();
    let (style, rest) = rest.split_once("</style>").unwrap();
    (format!("{head}<title>{} {stage}</title>{before}{STYLE}</style>{rest}", stem(place)), style.to_owned())
}

/// The size of an SVG document, as its first line says.
fn size(svg: &str) -> (f64, f64) {
    let number = |name: &str| {
        let rest = svg.split_once(&format!("{name}=\"")).unwrap().1;
        rest.split('"').next().unwrap().parse::<f64>().unwrap()
    };
    (number("width"), number("height"))
}

/// Draws old and new side by side, both in today's style.
fn show(name: &str, old: &str, new: &str, style: &str) -> PathBuf {
    let [old, new] = &[old, new].map(|svg| svg.replacen(STYLE, &format!("{STYLE}{style}"), 1));
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    fs::create_dir_all(&out).unwrap();
    let ((w, h), (v, i)) = (size(old), size(new));
    let view = View { min: Point::new(0.0, 0.0), max: Point::new(w.max(v), h.max(i)), scale: 1.0 };
    let path = out.join(format!("{name}.png"));
    fs::write(&path, rendered(&beside(old, new, view)).unwrap()).unwrap();
    path
}

#[test]
fn the_pictures_are_as_before() {
    let kept = root().join("tests/pictures");
    let dir = tempfile::tempdir().unwrap();
    let mut moved = Vec::new();
    let mut count = 0;
    for place in places() {
        let steps = STEPS.iter().filter(|_| WHOLE.contains(&stem(&place).as_str()));
        for stage in STAGES.iter().chain(steps) {
            let name = format!("{}-{stage}", stem(&place));
            let (new, style) = drawn(&place, stage, dir.path());
            let path = kept.join(format!("{name}.svg"));
            let old = fs::read_to_string(&path).unwrap_or_default();
            count += 1;
            if updating() && old != new {
                fs::create_dir_all(&kept).unwrap();
                fs::write(&path, &new).unwrap();
            } else if old.is_empty() {
                moved.push(format!("{name} is new"));
            } else if old != new {
                moved.push(format!("{name}: {}", show(&name, &old, &new, &style).display()));
            }
        }
    }
    assert!(count >= 24, "only {count} pictures");
    let way_out = "look at old (left) and new (right); if the new ones are right: LANEWRIGHT_UPDATE=1 cargo test --test building pictures";
    assert!(moved.is_empty(), "{} of {count} pictures changed:\n{}\n{way_out}", moved.len(), moved.join("\n"));
}

#[test]
fn every_stage_can_be_drawn() {
    let dir = tempfile::tempdir().unwrap();
    let place = root().join("tests/street_layouts/divided_crossing.osm");
    for stage in STAGES.iter().chain(&STEPS).chain(&["movements"]) {
        let arguments = ["draw", place.to_str().unwrap(), "--stage", stage, "--around", "1", "-o", "a.png"];
        lanewright(dir.path(), &arguments).exits(0);
        assert!(fs::read(dir.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
    }
    let nowhere = ["draw", place.to_str().unwrap(), "--stage", "trim", "--around", "4711", "-o", "b.png"];
    lanewright(dir.path(), &nowhere).fails_saying(&["nothing with the id 4711"]);
}

#[test]
fn each_intersection_has_a_row_on_the_page() {
    let dir = tempfile::tempdir().unwrap();
    let place = root().join("tests/street_layouts/slip_lane.osm");
    let arguments = ["draw", place.to_str().unwrap(), "--stage", "outline,trim", "--each", "-o", "out"];
    let run = lanewright(dir.path(), &arguments).exits(0);
    let page = fs::read_to_string(dir.path().join("out/index.html")).unwrap();
    let rows = page.matches("<section").count();
    assert!(rows >= 1 && run.stdout.contains(&format!("{rows} intersections")), "{}", run.stdout);
    assert_eq!(fs::read_dir(dir.path().join("out")).unwrap().count(), 2 * rows + 1);
}

#[test]
fn two_versions_are_compared() {
    let dir = tempfile::tempdir().unwrap();
    let place = root().join("tests/street_layouts/divided_crossing.osm");
    let geometry = |out: &str, more: &[&str]| {
        let arguments = [&["geometry", place.to_str().unwrap(), "-o", out][..], more].concat();
        lanewright(dir.path(), &arguments).exits(0)
    };
    let run = geometry("new.geojson", &["--explain-merges"]);
    assert!(run.stdout.contains("merged     way 102, nodes 4 to 1"), "{}", run.stdout);
    let wish = "keep_apart=[{nodes=[1,2,3,4]}]";
    let run = geometry("old.geojson", &["--explain-merges", "--config", wish]);
    assert!(run.stdout.contains("kept apart way 102, nodes 4 to 1: lanewright.toml says so"), "{}", run.stdout);
    let compare =
        |old: &str, new: &str| lanewright(dir.path(), &["draw", "--compare", old, new, "-o", "c.png"]).exits(0);
    let run = compare("old.geojson", "new.geojson");
    assert!(run.stdout.contains("1 2 3 4: merged: were 4"), "{}", run.stdout);
    assert!(compare("new.geojson", "new.geojson").stdout.contains("0 of"));
    for out in ["new", "old"] {
        let file = format!("{out}.geojson");
        lanewright(dir.path(), &["build", &file, "-o", out]).exits(0);
    }
    compare("old", "new");
    lanewright(dir.path(), &["draw", "--compare", "old", "new.geojson", "-o", "d.png"])
        .fails_saying(&["one is a Lanelet2 map and the other is not"]);
}

#[test]
fn a_setting_without_effect_is_a_warning() {
    let dir = tempfile::tempdir().unwrap();
    let place = root().join("tests/street_layouts/dogleg.osm");
    fs::copy(&place, dir.path().join("dogleg.osm")).unwrap();
    fs::write(
        dir.path().join("lanewright.toml"),
        "\n[[merge]]\nnodes = [7, 8]\n\n[[keep_apart]]\nway = 101\n\n[[road]]\nways = [9]\ntags = { lanes = \"2\" }\n",
    )
    .unwrap();
    let run = lanewright(dir.path(), &["build", "dogleg.osm", "-o", "out"]).exits(0);
    assert!(run.stdout.contains("lanewright.toml:2: [[merge]] does nothing"), "{}", run.stdout);
    assert!(run.stdout.contains("lanewright.toml:8: [[road]] does nothing for way 9"), "{}", run.stdout);
    assert!(run.stdout.contains("nodes 7, 8") && !run.stdout.contains("keep_apart"), "{}", run.stdout);
    fs::write(dir.path().join("lanewright.toml"), "[[merge]]\nreason = \"so\"\n").unwrap();
    lanewright(dir.path(), &["build", "dogleg.osm", "-o", "again"])
        .fails_saying(&["[[merge]]: it names no road", "lanewright.toml:1:"]);
}
