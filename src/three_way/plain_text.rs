//! A map as text that can be compared line by line: each element by meaning, in an order that does not depend on the file.

use std::fmt::Write;

use super::versions::Key;
use super::view::{View, plain};
use crate::diagnostic::Subject;
use crate::osm::{ElementKind, OsmData};

/// The map as text: lanelets, regulatory elements, areas, polygons, lines, points; each by id, with a line for each thing it says.
#[must_use]
pub fn plain_text(osm: &OsmData) -> String {
    let view = View::new(osm);
    let mut text = String::new();
    let meta = osm.meta.clone().unwrap_or_default();
    for (name, version) in [("format_version", meta.format_version), ("map_version", meta.map_version)] {
        if let Some(version) = version {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "map {name} {version}");
        }
    }
    let subject = |key: Key| view.subject(key).unwrap_or_else(|| plain(key));
    let mut elements: Vec<(Subject, Key)> = view.keys().map(|key| (subject(key), key)).collect();
    elements.sort_by_key(|(subject, key)| (rank(*subject), key.1));
    elements.dedup();
    for (own, key) in elements {
        let Some(content) = view.content(key) else { continue };
        if key.0 == ElementKind::Node {
            let tags: Vec<String> = content.tags.iter().map(|(key, value)| format!("; {key} = {value}")).collect();
            let _ = writeln!(text, "{own} at {}{}", content.position.text(), tags.concat());
            continue;
        }
        let _ = writeln!(text, "{own}");
        for (key, value) in &content.tags {
            let _ = writeln!(text, "  {key} = {value}");
        }
        let mut members: Vec<String> =
            content.members.iter().map(|one| format!("  {}: {}", one.role, subject((one.kind, one.id)))).collect();
        // The order of a ring means something.
        if content.tags.get("type").is_none_or(|kind| kind != "multipolygon") {
            members.sort_unstable();
        }
        for member in members {
            let _ = writeln!(text, "{member}");
        }
        for node in &content.nodes {
            let _ = writeln!(text, "  point {node}");
        }
    }
    text
}

/// What people look for first comes first.
const fn rank(subject: Subject) -> u8 {
    match subject {
        Subject::Map | Subject::Lanelet(_) => 0,
        Subject::RegulatoryElement(_) => 1,
        Subject::Relation(_) => 2,
        Subject::Polygon(_) => 3,
        Subject::LineString(_) | Subject::Way(_) => 4,
        Subject::Point(_) | Subject::Node(_) => 5,
    }
}
