//! The streets of real extracts, measured by `../shared/tools/quality.py` and compared with those of osm2streets; and no road is
//! narrower than its tags or its class say.
//!
//! `make test` measures the small extracts one by one, `make soak` (LANEWRIGHT_SOAK=1) all of them and their total.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use lanewright::builder::network::{NetworkOptions, Road, road_network};
use lanewright::builder::tags::cross_section::{StripKind, minimum_lane_width};
use lanewright::builder::{BuildOptions, plan};
use lanewright::osm::read_file;
use serde_json::Value;

use crate::common::needs::{python, shared};
use crate::common::program::lanewright;
use crate::common::{all_extracts, extracts, soak};

/// Largest extract that `make test` takes, bytes.
const SLICE: u64 = 1_000_000;

/// Measures that are to be zero.
const NONE: [&str; 8] = [
    "int_bowtie",
    "int_invalid",
    "int_empty",
    "int_fallback",
    "gap_ends",
    "lane_invalid",
    "road_oblivion",
    "road_invalid",
];
/// Shares of which no input may have more than osm2streets has, percent.
const NO_WORSE: [&str; 3] = ["int_bad_pct", "road_bad_pct", "overlap_pct"];

fn number(measures: &Value, name: &str) -> f64 {
    measures[name].as_f64().unwrap_or(0.0)
}

/// The measures of the streets of these extracts, by name, with levels as the extracts in the folder `osm` have them. `None` without the
/// shared tools.
fn measured(inputs: &[PathBuf], osm: Option<&Path>) -> Option<BTreeMap<String, Value>> {
    let (script, mut python) = (shared("tools/quality.py")?, python()?);
    let dir = tempfile::tempdir().unwrap();
    let mut arguments = vec!["geometry".to_owned(), "-o".to_owned(), "out".to_owned()];
    arguments.extend(inputs.iter().map(|path| path.to_str().unwrap().to_owned()));
    lanewright(dir.path(), &arguments.iter().map(String::as_str).collect::<Vec<_>>()).exits(0);
    python.current_dir(dir.path()).arg(script).args(["--complete", "--drive-only", "--json", "measures.json"]);
    if let Some(osm) = osm {
        python.arg("--osm").arg(osm);
    }
    let files = fs::read_dir(dir.path().join("out")).unwrap().map(|entry| entry.unwrap().path());
    let run = python.args(files).output().unwrap();
    assert!(run.status.success(), "{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    Some(read(&dir.path().join("measures.json")))
}

fn read(path: &Path) -> BTreeMap<String, Value> {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn polygons_are_simple_where_the_builder_did_not_grow_up() {
    let Some(measures) = measured(&all_extracts(SLICE), None) else { return };
    let names = ["int_bowtie", "int_invalid", "int_empty", "lane_invalid", "road_invalid", "road_oblivion"];
    let faults = |(place, of): (&String, &Value)| {
        let faults = names.iter().filter(|name| number(of, name) > 0.0);
        faults.map(|name| format!("{place}: {name} is {}", number(of, name))).collect::<Vec<_>>()
    };
    assert_eq!(measures.iter().flat_map(faults).collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
fn the_streets_are_no_worse_than_those_of_osm2streets() {
    let Some(osm) = shared("corpus/osm") else { return };
    let Some(ours) = measured(&extracts(SLICE), Some(&osm)) else { return };
    let theirs = read(&osm.join("osm2streets_quality.json"));
    let mut faults = Vec::new();
    for (place, measures) in &ours {
        faults.extend(NONE.iter().filter(|name| number(measures, name) > 0.0).map(|name| format!("{place}: {name}")));
        if place == "TOTAL" {
            continue;
        }
        let other = &theirs[place];
        let worse = NO_WORSE.iter().filter(|name| number(measures, name) > number(other, name));
        faults.extend(worse.map(|name| format!("{place}: {name} is {}", number(measures, name))));
    }
    if soak() {
        faults.extend(in_total(&ours, &theirs));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What is too much, or too little, over all extracts.
fn in_total(ours: &BTreeMap<String, Value>, theirs: &BTreeMap<String, Value>) -> Vec<String> {
    let total = &ours["TOTAL"];
    let sum = |name: &str| -> f64 { ours.keys().filter_map(|place| theirs.get(place)).map(|m| number(m, name)).sum() };
    let most = [
        ("int_bad_pct", 0.2),
        ("road_bad_pct", 0.2),
        ("overlap_pct", 0.005),
        ("int_long", sum("int_long") - 1.0),
        ("longtrim", sum("longtrim") - 1.0),
    ];
    let over = most.iter().filter(|(name, most)| number(total, name) > *most);
    let mut faults: Vec<String> = over.map(|(name, most)| format!("{name} is {} > {most}", total[name])).collect();
    let length = number(total, "road_len") / sum("road_len");
    if length < 0.9 {
        faults.push(format!("roads are {length:.3} times as long as those of osm2streets"));
    }
    faults
}

/// Widths come from tags in decimetres or finer, and streets lie on a grid of micrometres.
const SAME_WIDTH: f64 = 1e-5;

#[test]
fn no_road_is_narrower_than_its_tags_or_its_class_say() {
    let mut narrow = Vec::new();
    for input in extracts(SLICE) {
        let osm = read_file(&input).unwrap();
        let plan = plan(&osm, &BuildOptions::default()).unwrap();
        let to_metres = |places: &[_]| plan.projector.forward_all(places);
        let read = road_network(&osm, &to_metres, &NetworkOptions::default()).unwrap().network;
        let mut tagged: BTreeMap<i64, Vec<(StripKind, f64)>> = BTreeMap::new();
        let mut least: BTreeMap<i64, f64> = BTreeMap::new();
        for road in &read.roads {
            let said = road.section.strips.iter().filter(|strip| !strip.width_guessed);
            tagged.entry(road.key.way).or_default().extend(said.map(|strip| (strip.kind, strip.width)));
            let narrowest = narrowest(road).min(minimum_lane_width(road.class));
            least.entry(road.key.way).and_modify(|least| *least = least.min(narrowest)).or_insert(narrowest);
        }
        for road in &plan.streets.network.roads {
            let said: Vec<_> = road.ways.iter().filter_map(|way| tagged.get(way)).flatten().collect();
            let as_said = |kind, width: f64| said.iter().any(|(k, w)| *k == kind && (w - width).abs() < SAME_WIDTH);
            // The island between two carriageways that became one road is drawn, not tagged.
            let strips = road.section.strips.iter().filter(|s| !s.width_guessed && s.kind != StripKind::Buffer);
            let lost = strips.filter(|strip| !as_said(strip.kind, strip.width)).map(|strip| strip.width);
            narrow.extend(
                lost.map(|width| format!("{}: {} has {width} m, which no tag says", input.display(), road.key)),
            );
            let floor = road.ways.iter().filter_map(|way| least.get(way)).copied().fold(f64::INFINITY, f64::min);
            if narrowest(road) < floor - SAME_WIDTH {
                narrow.push(format!("{}: {} has a lane of {:.2} m", input.display(), road.key, narrowest(road)));
            }
        }
    }
    assert!(narrow.is_empty(), "{}", narrow.join("\n"));
}

/// The width of a road's narrowest lane for cars, metres.
fn narrowest(road: &Road) -> f64 {
    road.section
        .strips
        .iter()
        .filter(|strip| strip.kind == StripKind::Drive)
        .map(|s| s.width)
        .fold(f64::INFINITY, f64::min)
}
