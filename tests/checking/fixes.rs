//! The edits that rules propose.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::fs;
use std::path::PathBuf;

use lanewright::api::FixOptions;
use lanewright::diagnostic::{Diagnostic, Edit, Severity, Subject};
use lanewright::fix::{Scope, canonical, mend};
use lanewright::lanelet::from_osm;
use lanewright::osm::OsmData;
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::report::{Report, Sources, sarif};
use lanewright::rules::Config;
use lanewright::settings::Settings;
use rayon::prelude::*;
use serde_json::Value;

use crate::common::drawing::{Drawing, osm};
use crate::common::judging::{beside, judge, judge_as, load, loaded};
use crate::common::{hand_made_maps, root, rule_maps, shared_maps};

/// The first finding of a rule's bad map that has this code.
fn finding(rule: &str, map: &str, code: &str) -> Diagnostic {
    let path = root().join("tests/rules").join(rule).join(map);
    let (_, loaded) = load(&path);
    judge(&loaded, &Settings::default()).into_iter().find(|diagnostic| diagnostic.code == code).unwrap()
}

fn edits(diagnostic: &Diagnostic) -> &[Edit] {
    &diagnostic.finding.fix.as_ref().unwrap().edits
}

#[test]
fn pieces_are_merged_point_by_point() {
    let found = finding("vm-03-05", "bad-divided.osm", "vm-03-05/divided");
    let merged = edits(&found);
    // Ways 141 and 143 get the far points of 142 and 144 (nodes 4 and 5, the lanes' ends in the east).
    let last_of = |edit: &Edit| match edit {
        Edit::SetVertices { way, points } => Some((*way, *points.last()?)),
        _ => None,
    };
    let grown: Vec<_> = merged.iter().filter_map(last_of).collect();
    assert_eq!(grown, [(Subject::LineString(141), 4), (Subject::LineString(143), 5)]);
    let (role, member) = ("right_of_way".into(), Subject::Lanelet(217));
    assert!(merged.contains(&Edit::RemoveMember { on: Subject::RegulatoryElement(311), role, member }));
    for subject in [Subject::Lanelet(217), Subject::LineString(142), Subject::LineString(144)] {
        assert!(merged.contains(&Edit::Remove { subject }), "{subject} stays");
    }
}

/// Three lanelets one after the other, of which only the first says where it lies, and only the second how fast it is driven on.
#[test]
fn a_lane_without_a_speed_limit_does_not_become_private() {
    let mut map = Drawing::default();
    for (column, lon) in (0_i64..).zip([0.0, 0.0005, 0.001, 0.0015]) {
        map.node(10 + column, [0.00003, lon], "ele=0");
        map.node(20 + column, [0.0, lon], "ele=0");
    }
    for (at, tags) in (0_i64..).zip(["location=private", "speed_limit=20", ""]) {
        map.way(30 + at, [10 + at, 11 + at], "type=road_border");
        map.way(40 + at, [20 + at, 21 + at], "type=road_border");
        map.relation(
            50 + at,
            &[("left", 30 + at), ("right", 40 + at)],
            &format!("type=lanelet subtype=road one_way=yes {tags}"),
        );
    }
    let found = judge(&loaded(&map.data()), &Settings::default());
    let places = found.iter().filter(|one| one.code == "vm-01-01/location");
    let set: Vec<_> = places.map(|one| (one.finding.subject, edits(one))).collect();
    let tag = |id: i64, value: &str| {
        let on = Subject::Lanelet(id);
        (on, vec![Edit::SetTag { on, key: "location".into(), value: value.into() }])
    };
    let wanted = [tag(51, "private"), tag(52, "urban")];
    assert_eq!(set, wanted.each_ref().map(|(on, edits)| (*on, edits.as_slice())));
}

#[test]
fn a_missing_node_goes_between_its_neighbours() {
    let found = finding("vm-03-08", "bad-lane-node-missing.osm", "vm-03-08/lane-node-missing");
    // The outline begins with the kerb, then the south and the north end of the lanes; node 2 lies between the two.
    assert_eq!(edits(&found), [Edit::InsertVertex { way: Subject::Polygon(150), position: 2, point: 2 }]);
}

#[test]
fn a_turn_direction_follows_the_shape() {
    let found = finding("vm-03-02", "bad-turn-mismatch.osm", "vm-03-02/turn-mismatch");
    let on = Subject::Lanelet(213);
    assert_eq!(edits(&found), [Edit::SetTag { on, key: "turn_direction".into(), value: "right".into() }]);
}

#[test]
fn a_turn_signal_starts_behind_the_turn_before() {
    let found = finding("vm-03-02", "bad-turn-signal-overlap.osm", "vm-03-02/turn-signal-overlap");
    let on = Subject::Lanelet(214);
    let [Edit::SetTag { on: set_on, key, value }] = edits(&found) else { panic!("{found:?}") };
    assert_eq!((*set_on, key.as_str()), (on, "turn_signal_distance"));
    assert!((29.9..=30.0).contains(&value.parse::<f64>().unwrap()), "{value}");
}

/// The byte at a line and a column in characters, both from 1.
fn offset(text: &str, place: [&Value; 2]) -> usize {
    let [line, column] = place.map(|number| usize::try_from(number.as_u64().unwrap()).unwrap());
    let start: usize = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
    start + text[start..].chars().take(column - 1).map(char::len_utf8).sum::<usize>()
}

/// The text after the changes of a SARIF fix.
fn applied(text: &str, fix: &Value) -> String {
    let mut out = text.to_owned();
    let replacements = fix["artifactChanges"][0]["replacements"].as_array().unwrap();
    // From the last to the first, so that places stay what they are.
    for replacement in replacements.iter().rev() {
        let region = &replacement["deletedRegion"];
        let start = offset(text, [&region["startLine"], &region["startColumn"]]);
        let end = offset(text, [&region["endLine"], &region["endColumn"]]);
        out.replace_range(start..end, replacement["insertedContent"]["text"].as_str().unwrap());
    }
    out
}

#[test]
fn a_fix_in_a_sarif_report_repairs_the_file() {
    let dir = tempfile::tempdir().unwrap();
    let (mut proposed, mut mended) = (0, 0);
    for path in rule_maps("bad-") {
        let (settings, config) = beside(&path);
        let (data, loaded) = load(&path);
        let found = judge_as(&loaded, &settings, &config);
        let source = &data.sources[0];
        let sources = Sources::new([(source.name.as_str(), source.text.as_str())]);
        let mut log = Vec::new();
        sarif::write(&Report::new(&found, &sources, &loaded.map), &mut log).unwrap();
        let log: Value = serde_json::from_slice(&log).unwrap();
        for result in log["runs"][0]["results"].as_array().unwrap() {
            let rule = result["ruleId"].as_str().unwrap();
            let message = result["message"]["text"].as_str().unwrap();
            proposed += usize::from(!result["properties"]["fix"].is_null());
            for fix in result["fixes"].as_array().into_iter().flatten() {
                mended += 1;
                let file = dir.path().join("mended.osm");
                std::fs::write(&file, applied(&source.text, fix)).unwrap();
                let after = |config: &Config| judge_as(&load(&file).1, &settings, config);
                let said = after(&config)
                    .into_iter()
                    .filter(|one| one.code == rule)
                    .any(|one| message.contains(&one.finding.message));
                assert!(!said, "{}: {message} is still said after {fix:#}", path.display());
            }
        }
    }
    println!("{mended} of {proposed} proposed fixes are changes of text alone");
    assert!(mended > 40, "{mended} of {proposed}");
}

/// The maps of the existing validator's tests.
fn validator_maps() -> Vec<PathBuf> {
    shared_maps("corpus/conformance/map", 107)
}

/// The errors of a map by code and subject, with how often each is said.
fn errors(found: &[Diagnostic]) -> BTreeMap<(String, String), usize> {
    let mut counts = BTreeMap::new();
    for one in found.iter().filter(|one| one.severity == Severity::Error) {
        *counts.entry((one.code.clone(), one.finding.subject.to_string())).or_default() += 1;
    }
    counts
}

#[test]
fn formatting_twice_changes_nothing() {
    let maps = [validator_maps(), hand_made_maps()].concat();
    maps.par_iter().for_each(|path| {
        let text = std::fs::read_to_string(path).unwrap();
        let once = canonical(&text).unwrap_or_else(|unkept| panic!("{}: {unkept}", path.display()));
        assert_eq!(canonical(&once).unwrap(), once, "{}", path.display());
        let data = osm(once);
        let (before, _) = load(path);
        let counts = |data: &OsmData| [data.nodes.len(), data.ways.len(), data.relations.len()];
        assert_eq!(counts(&data), counts(&before), "{}", path.display());
    });
}

#[test]
fn fixing_makes_no_error_where_there_was_none() {
    let maps = validator_maps();
    let (settings, config) = (Settings::default(), Config::default());
    let done: usize = maps
        .par_iter()
        .map(|path| {
            let (data, loaded) = load(path);
            let before = errors(&judge_as(&loaded, &settings, &config));
            let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
            let projector = first.map_or(Projector::Local, Projector::mgrs);
            let judge = |osm: &OsmData| Ok::<_, Infallible>(judge_as(&from_osm(osm, &projector), &settings, &config));
            let mended = mend(data, true, judge).unwrap();
            for (error, count) in errors(&mended.left) {
                let known = before.get(&error).copied().unwrap_or_default();
                assert!(count <= known, "{}: {error:?} was said {known} times, now {count}", path.display());
            }
            mended.done.len()
        })
        .sum();
    println!("{done} fixes on {} maps", maps.len());
}

#[test]
fn the_file_of_the_projector_is_written_beside_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.osm");
    // Local coordinates alone: only the file can say so.
    let text = fs::read_to_string(root().join("tests/rules/vm-03-08/good.osm")).unwrap();
    fs::write(&map, text.lines().map(with_local_place).collect::<Vec<_>>().join("\n")).unwrap();
    let fixed = |unsafe_too: bool| {
        lanewright::fix(map.clone(), &FixOptions { scope: unsafe_too.into(), ..FixOptions::default() }).unwrap()
    };
    assert!(!fixed(false).diff().contains("projector_type"), "heights are taken from the ellipsoid: it needs review");
    let all = fixed(true);
    assert!(all.diff().contains("+projector_type: Local"), "{}", all.diff());
    all.write().unwrap();
    let written = fs::read_to_string(folder.path().join("map_projector_info.yaml")).unwrap();
    assert_eq!(written, "projector_type: Local\nvertical_datum: WGS84\n");
    assert!(fixed(true).diff().is_empty(), "a second run finds nothing to do");
}

#[test]
fn the_file_of_a_map_in_one_square_is_written_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(root().join("tests/rules/vm-03-08/good.osm"), folder.path().join("lanelet2_map.osm")).unwrap();
    let scope = Scope { unsafe_too: true, ..Scope::default() };
    let fixed = lanewright::fix(folder.path().to_path_buf(), &FixOptions { scope, ..FixOptions::default() }).unwrap();
    assert!(fixed.diff().contains("+projector_type: MGRS"), "{}", fixed.diff());
    let [before, after] = [fixed.mended.before, fixed.mended.after()];
    assert_eq!(before[1] - after[1], 1, "the missing file was one warning");
    assert_eq!(fixed.mended.to_look_at, 1);
}

/// The line of a node with its place in metres only.
fn with_local_place(line: &str) -> String {
    let number = |name: &str| -> Option<f64> {
        let (_, rest) = line.split_once(&format!(" {name}=\""))?;
        rest.split_once('"')?.0.parse().ok()
    };
    let Some((lat, lon)) = number("lat").zip(number("lon")) else { return line.to_owned() };
    let (x, y) = ((lon - 139.72) * 90_000.0, (lat - 35.25) * 111_000.0);
    let head = &line[..line.find(" lat=").unwrap()];
    format!("{head}><tag k=\"local_x\" v=\"{x:.3}\"/><tag k=\"local_y\" v=\"{y:.3}\"/><tag k=\"ele\" v=\"10\"/></node>")
}

/// A lanelet of 20 m with a racing line of its own, of which the last point lies 0.2 m off the end: moved onto the edge, the line keeps
/// its course.
#[test]
fn a_racing_line_keeps_its_course() {
    let mut map = Drawing::default();
    for (column, lon) in (0_i64..).zip([0.0, 0.0002]) {
        map.node(10 + column, [0.00003, lon], "ele=0");
        map.node(20 + column, [0.0, lon], "ele=0");
    }
    for (at, [lat, lon]) in (0_i64..).zip([[0.000004, 0.0], [0.000006, 0.0001], [0.000024, 0.000198]]) {
        map.node(30 + at, [lat, lon], "ele=0");
    }
    map.way(40, [10, 11], "type=road_border");
    map.way(41, [20, 21], "type=road_border");
    map.way(42, [30, 31, 32], "");
    let tags = "type=lanelet subtype=road one_way=yes location=urban speed_limit=30";
    map.relation(50, &[("left", 40), ("right", 41), ("centerline", 42)], tags);
    let found = judge(&loaded(&map.data()), &Settings::default());
    let off = found.iter().find(|one| one.code == "vm-01-10/end-off").unwrap();
    let [Edit::PlaceBetween { point: 32, from: 11, to: 21, share }] = edits(off) else { panic!("{off:?}") };
    assert!((share - 0.2).abs() < 0.01, "it stays where it lies across the lane: {share}");
}

/// Of each kind that `fix` takes away or leaves alone: an element without members goes, ids that are not positive stay unless asked for.
#[test]
fn safe_fixes_leave_ids_alone() {
    let path = root().join("tests/rules/ids/bad-range.osm");
    let fixed = |scope: lanewright::fix::Scope| {
        lanewright::fix(path.clone(), &FixOptions { scope, ..FixOptions::default() }).unwrap().mended
    };
    let is_ids = |one: &lanewright::fix::Mend| one.code == "ids/range";
    let scope = lanewright::fix::Scope::default();
    assert!(!fixed(scope).done.iter().any(is_ids), "only where somebody asks for it");
    assert!(fixed(scope.naming(&["ids".to_owned()])).done.iter().any(is_ids));
}
