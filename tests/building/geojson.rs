//! Streets as GeoJSON: files are as `docs/geometry.md` describes them, give the same map as a direct build, may come from other tools,
//! and never cause a panic.

use std::fs;
use std::path::{Path, PathBuf};

use lanewright::builder::network::TurnRestriction;
use lanewright::builder::{BuildOptions, Built, Plan, build_plan, geojson, plan};
use lanewright::lanelet::to_osm;
use lanewright::osm::read_file;
use serde_json::{Value, json};

use crate::common::program::lanewright;
use crate::common::{extracts, root, samples};

/// Largest extract that `make test` takes, bytes.
const SLICE: u64 = 750_000;
/// The same where a map is built from each.
const SLICE_OF_MAPS: u64 = 200_000;

/// The sample maps and the extracts up to this size.
fn inputs(slice: u64) -> Vec<PathBuf> {
    samples().into_iter().chain(extracts(slice)).collect()
}

fn streets(input: &Path) -> Plan {
    plan(read_file(input).unwrap(), &BuildOptions::default()).unwrap()
}

fn text(plan: &Plan) -> String {
    let mut text = Vec::new();
    geojson::write(&plan.streets.network, &plan.streets.outlines, &plan.projector, &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

fn read(text: &str) -> Plan {
    geojson::read(text, &BuildOptions::default()).unwrap()
}

/// What `build` writes.
fn bytes(Built { map, projector, settings, .. }: &Built) -> (Vec<u8>, String) {
    let mut bytes = Vec::new();
    to_osm(map, projector, &mut bytes).unwrap();
    (bytes, toml::to_string(settings).unwrap())
}

#[test]
fn what_is_read_is_what_was_written() {
    for input in inputs(SLICE) {
        let written = streets(&input);
        let file = text(&written);
        let again = read(&file);
        assert_eq!(again.projector, written.projector, "{}", input.display());
        let [a, b] = [&written, &again].map(|plan| &plan.streets);
        assert_eq!(a.network.roads.len(), b.network.roads.len());
        for (a, b) in a.network.roads.iter().zip(&b.network.roads) {
            assert_eq!(format!("{a:?}"), format!("{b:?}"), "{}", input.display());
        }
        for (a, b) in a.network.intersections.iter().zip(&b.network.intersections) {
            assert_eq!(format!("{a:?}"), format!("{b:?}"), "{}", input.display());
        }
        assert_eq!(a.outlines.kept, b.outlines.kept, "{}", input.display());
        for (a, b) in a.outlines.intersections.iter().zip(&b.outlines.intersections) {
            assert_eq!(format!("{a:?}"), format!("{b:?}"), "{}", input.display());
        }
        assert!(file == text(&again), "{} written again is another file", input.display());
    }
}

#[test]
fn a_build_by_way_of_geojson_gives_the_same_map() {
    for input in inputs(SLICE_OF_MAPS) {
        let direct = streets(&input);
        let detour = read(&text(&direct));
        assert!(detour.notes.is_empty(), "nothing is missing in our own file: {:?}", detour.notes.first());
        assert!(bytes(&build_plan(direct)) == bytes(&build_plan(detour)), "{}", input.display());
    }
}

#[test]
fn every_file_is_as_the_schema_says() {
    let schema: Value =
        serde_json::from_str(&fs::read_to_string(root().join("docs/geometry.schema.json")).unwrap()).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    for input in inputs(SLICE) {
        let file: Value = serde_json::from_str(&text(&streets(&input))).unwrap();
        let faults: Vec<String> =
            validator.iter_errors(&file).take(3).map(|e| format!("{e} at {}", e.instance_path())).collect();
        assert!(faults.is_empty(), "{}: {}", input.display(), faults.join("\n"));
    }
}

#[test]
fn the_page_names_every_property() {
    let page = fs::read_to_string(root().join("docs/geometry.md")).unwrap();
    let schema: Value =
        serde_json::from_str(&fs::read_to_string(root().join("docs/geometry.schema.json")).unwrap()).unwrap();
    for kind in ["road", "lane", "intersection"] {
        let properties = &schema["definitions"][kind]["properties"]["properties"]["properties"];
        for name in properties.as_object().unwrap().keys().filter(|name| *name != "type") {
            assert!(page.contains(&format!("`{name}`")), "docs/geometry.md does not tell of {kind}.{name}");
        }
    }
}

#[test]
fn any_order_of_features_gives_the_same_map() {
    let plan = streets(&root().join("sample_maps/staggered_left.osm"));
    let mut file: Value = serde_json::from_str(&text(&plan)).unwrap();
    file["features"].as_array_mut().unwrap().reverse();
    assert!(bytes(&build_plan(plan)) == bytes(&build_plan(read(&file.to_string()))));
}

#[test]
fn any_order_of_restrictions_gives_the_same_file() {
    let mut plan = streets(&root().join("sample_maps/turn_lanes_right.osm"));
    let network = &mut plan.streets.network;
    let arms = network.intersections.iter().map(|intersection| &intersection.arms).find(|arms| arms.len() > 2).unwrap();
    let turn = |from, to| TurnRestriction { relation: 0, from, via: Vec::new(), to, only: false };
    network.restrictions = vec![turn(arms[0], arms[1]), turn(arms[2], arms[1]), turn(arms[1], arms[0])];
    let in_order = text(&plan);
    plan.streets.network.restrictions.reverse();
    assert!(text(&plan) == in_order);
}

/// The file that docs/geometry.md shows.
fn small() -> Value {
    let page = fs::read_to_string(root().join("docs/geometry.md")).unwrap();
    serde_json::from_str(page.split("```json\n").nth(1).unwrap().split("```").next().unwrap()).unwrap()
}

#[test]
fn a_file_from_elsewhere_becomes_a_map() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("small.geojson"), small().to_string()).unwrap();
    let run = lanewright(dir.path(), &["build", "small.geojson", "-o", "map", "--guesses"]).exits(0);
    for slug in ["lanes-guessed", "speed-guessed"] {
        assert!(run.stdout.contains(slug), "{slug} is not noted:\n{}", run.stdout);
    }
    lanewright(dir.path(), &["check", "map", "--fail-on", "warning"]).exits(0);
    let run = lanewright(dir.path(), &["geometry", "small.geojson", "-o", "whole.geojson"]).exits(0);
    assert!(run.stdout.contains("3 roads"), "{}", run.stdout);
    lanewright(dir.path(), &["build", "whole.geojson", "-o", "again"]).exits(0);
    let map = |dir_: &str| fs::read(dir.path().join(dir_).join("lanelet2_map.osm")).unwrap();
    assert!(map("map") == map("again"));
}

/// Another tool drew the outline of the intersection; its roads run on to the middle.
#[test]
fn a_foreign_outline_cuts_the_roads() {
    let mut file = small();
    let square =
        json!([[[8.5319, 49.0122], [8.5321, 49.0122], [8.5321, 49.0124], [8.5319, 49.0124], [8.5319, 49.0122]]]);
    file["features"][3]["geometry"] = json!({"type": "Polygon", "coordinates": square});
    let plan = read(&file.to_string());
    let outlines = &plan.streets.outlines;
    for (road, [from, to]) in plan.streets.network.roads.iter().zip(&outlines.kept) {
        let cut = from + road.line.length() - to;
        assert!((7.0..12.0).contains(&cut), "cut back by {cut} m");
    }
    let outline = outlines.intersections.iter().find(|o| o.cuts.len() == 3).unwrap();
    assert_eq!(outline.ring.len(), 4);
}

#[track_caller]
fn refused(file: &str, words: &[&str]) {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("bad.geojson"), file).unwrap();
    lanewright(dir.path(), &["build", "bad.geojson", "-o", "out"]).fails_saying(words);
    lanewright(dir.path(), &["geometry", "bad.geojson", "-o", "out.geojson"]).fails_saying(words);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "a failed run leaves nothing");
}

/// The small file with one road changed, one feature a line.
fn with_road(change: impl FnOnce(&mut Value)) -> String {
    let mut file = small();
    change(&mut file["features"][1]);
    let features: Vec<String> = file["features"].as_array().unwrap().iter().map(Value::to_string).collect();
    format!("{{\"type\":\"FeatureCollection\",\"features\":[\n{}\n]}}\n", features.join(",\n"))
}

#[test]
fn what_is_wrong_is_shown_where_it_stands() {
    refused("{\"type\": \"FeatureCollection\",\n\"features\": [", &["bad.geojson:2:", "cut off"]);
    refused("{\"a\": 1}", &["no GeoJSON FeatureCollection"]);
    refused("[1, 2]", &["no GeoJSON FeatureCollection"]);
    refused("{\"type\": \"FeatureCollection\", \"features\": []}", &["none of the 0 features is a road"]);
    refused(
        &with_road(|f| f["properties"]["src"] = json!("x")),
        &["bad.geojson:3:1", "road east ends at intersection x"],
    );
    refused(&with_road(|f| f["properties"]["id"] = json!("west")), &["two roads have the id west"]);
    refused(&with_road(|f| f["properties"]["class"] = json!("path")), &["bad.geojson:3:", "unknown variant `path`"]);
    refused(
        &with_road(|f| f["geometry"]["coordinates"] = json!([[445_000.0, 5_429_000.0], [8.0, 49.0]])),
        &["bad.geojson:3:", "not on Earth"],
    );
    refused(&with_road(|f| f["geometry"]["coordinates"] = json!([[8.0, 49.0]])), &["road east has no centre line"]);
    refused(&with_road(|f| f["geometry"] = json!(null)), &["road east has no centre line", "centerline"]);
    refused(&with_road(|f| f["geometry"]["type"] = json!("Point")), &["bad.geojson:3:", "Point"]);
    refused(&with_road(|f| f["properties"]["speed"] = json!([50, -1])), &["bad.geojson:3:1", "speed"]);
    let wide =
        json!({"type": "Feature", "geometry": null, "properties": {"type": "lane", "road": "west", "width": -3}});
    refused(&with_road(|f| *f = wide), &["bad.geojson:3:1", "a lane of road west is -3 m wide"]);
    let metres = "{\"type\":\"FeatureCollection\",\"units\":\"m\",\"features\":[]}";
    refused(metres, &["metres of no known place"]);
    let new = "{\"type\":\"FeatureCollection\",\"lanewright\":{\"format\":2},\"features\":[]}";
    refused(new, &["format 2", "reads 1"]);
}

/// Roads that do not say their keys are numbered: one that says the number of another of these is no road of its own.
#[test]
fn a_key_that_a_numbered_road_has_is_refused() {
    let mut file = small();
    let features = file["features"].as_array_mut().unwrap();
    // All lead along one way from one intersection to another.
    features[1]["properties"]["osm_ids"] = json!([7]);
    features[1]["properties"]["dst"] = json!("e");
    features.push(json!({"type": "Feature", "geometry": null, "properties": {"type": "intersection", "id": "e"}}));
    let another = |id: &str, features: &[Value]| {
        let mut road = features[1].clone();
        road["properties"]["id"] = json!(id);
        road
    };
    features.extend(["e2", "e3"].map(|id| another(id, features)));
    let roads = read(&file.to_string()).streets.network.roads;
    let key = roads.iter().map(|road| road.key).find(|key| key.turn == 1).unwrap();
    let features = file["features"].as_array_mut().unwrap();
    let mut said = another("e4", features);
    said["properties"]["key"] = json!({"way": key.way, "first": key.first, "last": key.last, "turn": 1});
    features.push(said);
    refused(&file.to_string(), &["road e4 has the key of another", "leave `key` out"]);
}

#[test]
fn several_inputs_go_to_a_directory() {
    let dir = tempfile::tempdir().unwrap();
    let inputs = samples();
    let mut arguments = vec!["geometry", "-o", "out"];
    arguments.extend(inputs.iter().map(|path| path.to_str().unwrap()));
    lanewright(dir.path(), &arguments).exits(0);
    assert_eq!(fs::read_dir(dir.path().join("out")).unwrap().count(), inputs.len());
    let twice = [arguments.last().unwrap(), "geometry", "-o", "twice"].map(|a| a.to_owned());
    lanewright(dir.path(), &["geometry", "-o", &twice[3], &twice[0], &twice[0]])
        .fails_saying(&["two inputs would be written to"]);
}

/// Cut, doubled and shuffled text of a good file is refused or read, and never a panic.
#[test]
fn damaged_files_are_refused() {
    let file = text(&streets(&root().join("sample_maps/crossing_left.osm")));
    let mut seed = 1_u64;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % below
    };
    let boundary = |mut at: usize| {
        while !file.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    for round in 0..400 {
        let (a, b) = (boundary(random(file.len())), boundary(random(file.len())));
        let (a, b) = (a.min(b), a.max(b));
        let damaged = match round % 4 {
            0 => file[..a].to_owned(),
            1 => format!("{}{}", &file[..a], &file[b..]),
            2 => format!("{}{}", &file[..b], &file[a..]),
            _ => {
                let digit = file[a..].find(|c: char| c.is_ascii_digit()).map_or(a, |i| a + i);
                format!("{}{}{}", &file[..digit], random(1_000_000), &file[(digit + 1).min(file.len())..])
            }
        };
        if let Ok(plan) = geojson::read(&damaged, &BuildOptions::default()) {
            build_plan(plan);
        }
    }
}
