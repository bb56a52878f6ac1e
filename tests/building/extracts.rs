//! Maps can be built from real extracts of OpenStreetMap, and the real Lanelet2 library accepts them.
//!
//! `make test` takes the small ones, `make soak` (LANEWRIGHT_SOAK=1) all of them.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use geo::{Area, BooleanOps, MultiPolygon};
use lanewright::builder::network::{End, Intersection};
use lanewright::builder::streets::Streets;
use lanewright::builder::streets::outline::ribbon;
use lanewright::builder::{BuildOptions, plan};
use lanewright::geometry::polygon;
use lanewright::osm::read_file;
use lanewright::projection::LonLat;

use crate::common::needs::accept;
use crate::common::program::lanewright;
use crate::common::{all_extracts, extracts};

/// Largest extract that `make test` takes, bytes: the Lanelet2 library's check of a larger one takes minutes.
pub const SLICE: u64 = 1_000_000;

#[test]
fn every_extract_builds_and_is_accepted() {
    let dir = tempfile::tempdir().unwrap();
    let mut faults = Vec::new();
    for input in extracts(SLICE) {
        let name = input.file_name().unwrap().to_string_lossy().into_owned();
        let map = dir.path().join(&name).with_extension("");
        let start = Instant::now();
        let run = lanewright(dir.path(), &["build", input.to_str().unwrap(), "-o", map.to_str().unwrap()]);
        eprintln!("{name}: built in {:.2} s", start.elapsed().as_secs_f64());
        if run.code != 0 {
            faults.push(format!("{name} does not build:\n{}", run.stderr));
            continue;
        }
        let judged = lanewright(dir.path(), &["check", map.to_str().unwrap(), "--format", "concise"]);
        if judged.code == 2 || judged.code < 0 {
            faults.push(format!("{name} cannot be checked:\n{}", judged.stderr));
        }
        if let Some(verdict) = accept(&map.join("lanelet2_map.osm"), false)
            && verdict.code != 0
        {
            faults.push(format!("{name} is not accepted:\n{}{}", verdict.stdout, verdict.stderr));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The errors that are left in built maps: extract, code, how many.
const LEFT: [(&str, &str, usize); 1] = [("seattle_slip_lane", "vm-03-07/overlap", 1)];

#[test]
fn built_maps_have_no_errors_but_for_those_that_are_left() {
    let dir = tempfile::tempdir().unwrap();
    let mut found: BTreeMap<(String, String), usize> = BTreeMap::new();
    for input in all_extracts(SLICE) {
        let name = input.file_stem().unwrap().to_string_lossy().into_owned();
        let map = dir.path().join(&name);
        let built = lanewright(dir.path(), &["build", input.to_str().unwrap(), "-o", map.to_str().unwrap()]);
        assert_eq!(built.code, 0, "{name} does not build:\n{}", built.stderr);
        let judged = lanewright(dir.path(), &["check", map.to_str().unwrap(), "--format", "concise"]);
        for line in judged.stdout.lines() {
            let code = line.split_once("error[").and_then(|(_, rest)| rest.split_once(']'));
            if let Some((code, _)) = code {
                *found.entry((name.clone(), code.to_owned())).or_default() += 1;
            }
        }
    }
    let left =
        |name: &str, code: &str| LEFT.iter().find(|left| (left.0, left.1) == (name, code)).map_or(0, |left| left.2);
    let more: Vec<_> = found.iter().filter(|((name, code), count)| **count > left(name, code)).collect();
    assert!(more.is_empty(), "{more:?}");
}

/// `highway` values of ways that cars drive on; each has its `_link`s.
pub const DRIVABLE: [&str; 12] = [
    "motorway",
    "trunk",
    "primary",
    "secondary",
    "tertiary",
    "unclassified",
    "road",
    "residential",
    "living_street",
    "service",
    "busway",
    "track",
];
/// A way shorter than this, metres, may be missing without a note.
const SHORT: f64 = 10.0;

/// Metres between two places that are close.
fn between(a: LonLat, b: LonLat) -> f64 {
    const DEGREE: f64 = 111_200.0;
    let east = (b.lon - a.lon) * DEGREE * a.lat.to_radians().cos();
    ((b.lat - a.lat) * DEGREE).hypot(east)
}

#[test]
fn every_missing_way_has_a_note() {
    let mut lost = Vec::new();
    for input in extracts(SLICE) {
        let osm = read_file(&input).unwrap();
        let plan = plan(&osm, &BuildOptions::default()).unwrap();
        let mut told: BTreeSet<i64> = plan.streets.network.roads.iter().flat_map(|road| road.ways.clone()).collect();
        let notes = plan.notes.iter().chain(&plan.streets.findings);
        let says_why = ["way-skipped", "way-merged", "way-duplicate", "node-missing"];
        told.extend(notes.filter(|note| says_why.contains(&note.fault)).filter_map(|note| note.subject.id()));
        for way in &osm.ways {
            let highway = way.tags.get("highway").unwrap_or_default();
            let places: Vec<LonLat> =
                way.nodes.iter().filter_map(|node| osm.node(*node).and_then(|node| node.position)).collect();
            let length: f64 = places.windows(2).map(|pair| between(pair[0], pair[1])).sum();
            if DRIVABLE.contains(&highway.trim_end_matches("_link")) && length > SHORT && !told.contains(&way.id) {
                lost.push(format!("{}: way {}, {length:.0} m", input.display(), way.id));
            }
        }
    }
    assert!(lost.is_empty(), "{}", lost.join("\n"));
}

/// A merged intersection's outline covers at most so many times the ground of the roads inside it.
const COVER_MOST: f64 = 1.3;

/// What the roads inside a merged intersection cover, square metres: those between its nodes, and its arms up to the cuts.
fn ground(streets: &Streets, at: &Intersection) -> f64 {
    let inner = at.inner.iter().filter_map(|inner| ribbon(&inner.line, inner.section.width() / 2.0));
    let arms = at.arms.iter().filter_map(|arm| {
        let (road, [from, to]) = (streets.network.road(arm.road), streets.outlines.kept[arm.road.0 as usize]);
        let stub = match arm.end {
            End::Start => road.line.cut(0.0, from),
            End::End => road.line.cut(to, road.line.length()),
        };
        ribbon(&stub?, road.half_width())
    });
    let whole = inner.chain(arms).fold(MultiPolygon::new(Vec::new()), |all, ring| all.union(&polygon::to_geo(&ring)));
    whole.unsigned_area()
}

#[test]
fn no_merged_intersection_covers_much_more_than_its_roads() {
    let mut wide = Vec::new();
    for input in extracts(SLICE) {
        let osm = read_file(&input).unwrap();
        let streets = plan(&osm, &BuildOptions::default()).unwrap().streets;
        let outlines = streets.network.intersections.iter().zip(&streets.outlines.intersections);
        for (at, outline) in outlines.filter(|(at, _)| at.nodes.len() > 1) {
            let (covered, ground) = (polygon::signed_area(&outline.ring).abs(), ground(&streets, at));
            if covered > COVER_MOST * ground {
                wide.push(format!("{}: {:?} covers {:.2} of its roads", input.display(), at.nodes, covered / ground));
            }
        }
    }
    assert!(wide.is_empty(), "{}", wide.join("\n"));
}
