//! Mutations in the file beside the map that names its projector.

use std::path::Path;

use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{INFO, Loaded, ProjectorInfo, from_osm};
use lanewright::projection::LonLat;
use lanewright::projection::{Projector, VerticalDatum, write_info};
use lanewright::rules::{self, Config};

use super::{Base, Draft, bases};
use crate::common::drawing::osm;

/// What the test raises besides.
pub const ALSO: [&str; 2] = ["projector/other-grid", "projector/far-origin"];

/// What is changed, what is raised, and the file's name and text after it, if it is still there.
type Slip = (&'static str, &'static str, fn(&str) -> Option<(&'static str, String)>);

pub const MUTATIONS: &[Slip] = &[
    ("misname the file", "projector/misnamed", |text| Some(("map_projecter_info.yaml", text.to_owned()))),
    ("name the file in capitals", "projector/misnamed", |text| Some(("MAP_PROJECTOR_INFO.YAML", text.to_owned()))),
    ("lose a colon", "projector/syntax", |text| changed(text, "vertical_datum:", "vertical_datum")),
    ("write the type in small letters", "projector/type", |text| {
        changed(text, "TransverseMercator", "transversemercator")
    }),
    ("name a type that is none", "projector/type", |text| changed(text, "TransverseMercator", "Equirectangular")),
    ("drop the datum", "projector/key", |text| changed(text, "vertical_datum: WGS84\n", "")),
    ("misspell a key", "projector/key", |text| changed(text, "latitude", "lattitude")),
    ("write the origin beside the level above", "projector/syntax", |text| changed(text, "map_origin:\n  ", "  ")),
    ("name a datum that is none", "projector/value", |text| changed(text, "WGS84", "JGD2011")),
    ("write a latitude with a comma", "projector/value", |text| changed(text, "latitude: 3", "latitude: 3,")),
    ("misspell a key that may be missing", "projector/unread", |text| Some((INFO, format!("{text}scale_facto: 1\n")))),
    ("move the origin", "projector/at-odds", |text| changed(text, "longitude: 139.", "longitude: 138.")),
    ("name another type", "projector/at-odds", |text| changed(text, "TransverseMercator", "LocalCartesianUTM")),
    ("lose the file", "projector/missing", |_| None),
];

fn changed(text: &str, from: &str, to: &str) -> Option<(&'static str, String)> {
    assert!(text.contains(from), "{text} has no {from}");
    Some((INFO, text.replacen(from, to, 1)))
}

/// What is said of a map beside such a file.
fn said(draft: &Draft, base: &Base, info: Option<(&str, String)>) -> Vec<String> {
    let data = osm(draft.text());
    let info = info.map_or_else(ProjectorInfo::default, |(name, text)| ProjectorInfo::of(Path::new(name), &text));
    let projector = info.projector().unwrap_or_else(|| lanewright::lanelet::projector_for(&data));
    let Loaded { map, mut faults } = from_osm(&data, &projector);
    info.judge(&data, &projector, &mut faults);
    let index = MapIndex::new(&map, &faults, &base.settings);
    rules::run(&index, &Config::default()).unwrap().into_iter().map(|one| one.code).collect()
}

#[test]
fn the_fault_of_every_mutation_of_the_projectors_file_is_reported() {
    let base = bases().remove(0);
    let mut draft = base.draft.clone();
    // In Tokyo, wherever the sample lies: the mutations below name digits.
    let origin = LonLat { lon: 139.7, lat: 35.7 };
    let there = Projector::transverse_mercator(origin);
    let ids: Vec<i64> = draft.nodes.iter().map(|node| node.id).collect();
    let first = draft.place(ids[0]);
    for id in ids {
        let local = draft.place(id) - first;
        let node = draft.node(id);
        node.position = there.inverse(local.into());
        node.tags.set("local_x", format!("{:.4}", local.x));
        node.tags.set("local_y", format!("{:.4}", local.y));
    }
    let good = write_info(&there, VerticalDatum::default());
    let family = |codes: Vec<String>| -> Vec<String> {
        codes.into_iter().filter(|code| code.starts_with("projector/") || code.starts_with("node/")).collect()
    };
    assert_eq!(family(said(&draft, &base, Some((INFO, good.clone())))), Vec::<String>::new());
    for (name, raises, mutation) in MUTATIONS {
        // Nothing else follows from it.
        let said = family(said(&draft, &base, mutation(&good)));
        assert!(!said.is_empty() && said.iter().all(|code| code == raises), "{name}: {said:?}");
    }
    let mgrs = Projector::mgrs("54SUE".parse().unwrap());
    let squares = write_info(&mgrs, VerticalDatum::default());
    let draft = &base.draft;
    let own = write_info(&draft.projector, VerticalDatum::default());
    assert_eq!(family(said(draft, &base, Some((INFO, own.clone())))), Vec::<String>::new());
    let other = if own == squares { squares.replace("54SUE", "54SUF") } else { squares };
    assert_eq!(family(said(draft, &base, Some((INFO, other)))), ["projector/other-grid"]);
    let mut plain = draft.clone();
    for node in &mut plain.nodes {
        node.tags = super::draft::without(&super::draft::without(&node.tags, "local_x"), "local_y");
    }
    let far = write_info(&Projector::transverse_mercator(LonLat { lon: 20.0, lat: -30.0 }), VerticalDatum::default());
    assert!(family(said(&plain, &base, Some((INFO, far)))).contains(&"projector/far-origin".to_owned()));
}
