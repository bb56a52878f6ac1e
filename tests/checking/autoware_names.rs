//! The page of what Autoware reads, held against the names that stand in its sources: each is on the page, no other is, and the words
//! that lanewright knows hold it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use lanewright::lanelet::vocabulary::{On, words};
use serde::Deserialize;

use crate::common::root;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Names {
    /// The day on which the sources were read.
    read: toml::value::Datetime,
    source: Vec<Source>,
}

#[derive(Deserialize)]
struct Source {
    what: String,
    #[serde(flatten)]
    kinds: BTreeMap<String, Vec<String>>,
}

/// Kind in the list, and the heading on the page.
const HEADINGS: [(&str, &str); 7] = [
    ("lanelets", "## Lanelets, by subtype"),
    ("areas", "## Areas"),
    ("elements", "## Regulatory elements, by subtype"),
    ("roles", "## Roles of members"),
    ("polygons", "## Polygons, by type"),
    ("lines", "## Lines, by type"),
    ("tags", "## Tags"),
];

fn names() -> BTreeMap<String, BTreeSet<String>> {
    let text = fs::read_to_string(root().join("tests/data/autoware_names.toml")).unwrap();
    let names: Names = toml::from_str(&text).unwrap();
    assert!(names.read.date.is_some() && names.source.iter().all(|source| !source.what.is_empty()));
    let mut all: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (kind, words) in names.source.into_iter().flat_map(|source| source.kinds) {
        assert!(HEADINGS.iter().any(|(known, _)| *known == kind), "{kind} has no chapter");
        all.entry(kind).or_default().extend(words);
    }
    all
}

/// The names in the first column of the table under a heading.
fn on_page(page: &str, heading: &str) -> BTreeSet<String> {
    let (_, rest) = page.split_once(&format!("{heading}\n")).unwrap_or_else(|| panic!("no chapter {heading}"));
    let chapter = rest.split("\n## ").next().unwrap_or_default();
    let rows = chapter.lines().filter(|line| line.starts_with("| `"));
    let named = rows.map(|row| {
        let columns: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        assert!(columns.len() == 3 && columns.iter().all(|column| !column.is_empty()), "{heading}: {row}");
        let says = columns[2];
        assert!(says.starts_with("judged") || says.starts_with("known"), "{row} does not say what is done");
        columns[0].trim_matches('`').to_owned()
    });
    named.collect()
}

#[test]
fn the_page_of_what_autoware_reads_has_every_name_of_its_sources() {
    let page = fs::read_to_string(root().join("docs/autoware.md")).unwrap();
    let names = names();
    for (kind, heading) in HEADINGS {
        assert_eq!(on_page(&page, heading), names[kind], "{heading}");
    }
}

#[test]
fn every_name_of_autowares_sources_is_a_known_word() {
    let (words, mut unknown) = (words().unwrap(), Vec::new());
    let types = |on: On, name: &str| words.lists(on).any(|list| list.names.iter().any(|one| one == name));
    let subtypes =
        |on: On, name: &str| words.lists(on).any(|list| list.subtypes.iter().flatten().any(|one| one == name));
    let keys: BTreeSet<String> = words.key.iter().flat_map(|key| words.written_out(key)).collect();
    for (kind, names) in names() {
        for name in names {
            let is_known = match kind.as_str() {
                "lanelets" => subtypes(On::Lanelet, &name),
                "areas" => types(On::Area, &name),
                "elements" => words.roles.iter().any(|roles| roles.of == name),
                "roles" => words.roles.iter().any(|roles| roles.words.contains(&name)),
                "polygons" => types(On::Polygon, &name),
                "lines" => types(On::LineString, &name) || subtypes(On::LineString, &name),
                // These two stand on the file.
                "tags" => keys.contains(&name) || ["format_version", "map_version"].contains(&name.as_str()),
                _ => false,
            };
            if !is_known {
                unknown.push(format!("{kind}: {name}"));
            }
        }
    }
    assert!(unknown.is_empty(), "{unknown:?}");
}
