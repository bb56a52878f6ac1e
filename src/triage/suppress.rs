//! Suppressions: in `lanewright.toml`, or as a tag of the primitive.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Subject};
use crate::osm::{ElementKind, OsmData, Tags};
use crate::settings::{Settings, covers};

use super::Sorted;
use super::sorted::element;

/// The tag of a primitive that lists what is to be passed over: `vm-03-02/turn-mismatch: reason; vm-03-05: reason`.
pub const TAG: &str = "lanewright:ignore";

/// All suppressions of a map.
#[derive(Debug)]
pub struct Suppressions(Vec<Entry>);

/// One suppression of one primitive.
#[derive(Debug)]
struct Entry {
    code: String,
    subject: Subject,
    reason: bool,
    /// Its position.
    origin: String,
    used: bool,
}

impl Suppressions {
    /// Those of the settings, then those in tags.
    pub fn of(settings: &Settings, osm: &OsmData) -> Self {
        let mut entries = of_settings(settings);
        of_map(osm, &mut entries);
        Self(entries)
    }
}

/// Removes the suppressed findings, and reports suppressions that have no effect or give no reason.
pub(super) fn apply(sorted: &mut Sorted, settings: &Settings, suppressions: Suppressions) -> Vec<Finding> {
    let Suppressions(mut entries) = suppressions;
    let mut of: FxHashMap<Option<(ElementKind, i64)>, Vec<usize>> = FxHashMap::default();
    for (at, entry) in entries.iter().enumerate() {
        of.entry(element(entry.subject)).or_default().push(at);
    }
    let before = sorted.left.len();
    sorted.left.retain(|diagnostic| {
        let mut kept = true;
        for &at in of.get(&element(diagnostic.finding.subject)).into_iter().flatten() {
            if let Some(entry) = entries.get_mut(at)
                && covers(&entry.code, &diagnostic.code)
            {
                entry.used = true;
                kept = false;
            }
        }
        kept
    });
    sorted.suppressed = before - sorted.left.len();
    let selection = settings.selection();
    let mut said = Vec::new();
    for entry in &entries {
        let Entry { code, subject, origin, .. } = entry;
        // A suppression of what this run does not look for has nothing to do, and that is no fault.
        if !entry.used && selection.wants(code) {
            let message = format!("The suppression of `{code}` on {subject} ({origin}) suppresses nothing.");
            said.push(Finding::new("unused-suppression", *subject, message));
        }
        if !entry.reason {
            let message = format!("The suppression of `{code}` on {subject} ({origin}) gives no reason.");
            said.push(Finding::new("no-reason", *subject, message));
        }
    }
    said
}

fn of_settings(settings: &Settings) -> Vec<Entry> {
    let mut entries = Vec::new();
    for suppression in &settings.suppress {
        let origin = suppression.origin.as_ref().map_or(String::new(), |at| format!("{}:{}", at.file, at.line));
        entries.extend(suppression.subjects().into_iter().map(|subject| Entry {
            code: suppression.code.clone(),
            subject,
            reason: !suppression.reason.trim().is_empty(),
            origin: origin.clone(),
            used: false,
        }));
    }
    entries
}

fn of_map(osm: &OsmData, entries: &mut Vec<Entry>) {
    let mut note = |tags: &Tags, subject: Subject| {
        for (code, reason) in tags.get(TAG).map(listed).unwrap_or_default() {
            entries.push(Entry { code, subject, reason, origin: format!("its tag {TAG}"), used: false });
        }
    };
    osm.nodes.iter().for_each(|node| note(&node.tags, Subject::Point(node.id)));
    for way in &osm.ways {
        let polygon = way.tags.is("area", "yes");
        note(&way.tags, if polygon { Subject::Polygon(way.id) } else { Subject::LineString(way.id) });
    }
    for relation in &osm.relations {
        let subject = match relation.tags.get("type") {
            Some("lanelet") => Subject::Lanelet(relation.id),
            Some("regulatory_element") => Subject::RegulatoryElement(relation.id),
            _ => Subject::Relation(relation.id),
        };
        note(&relation.tags, subject);
    }
}

/// Codes of a tag's value, each with whether it gives a reason. A reason may hold a semicolon: what does not begin with a
/// code goes on with the reason before it.
fn listed(value: &str) -> Vec<(String, bool)> {
    let is_code = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "-/_".contains(c));
    let mut entries = Vec::new();
    for part in value.split(';') {
        let (head, reason) = part.split_once(':').unwrap_or((part, ""));
        let codes: Vec<&str> = head.split(',').map(str::trim).collect();
        if codes.iter().all(|code| is_code(code)) {
            entries.extend(codes.iter().map(|&code| (code.to_owned(), !reason.trim().is_empty())));
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_lists_codes_with_reasons() {
        let of = |value: &str| listed(value);
        assert_eq!(of("vm-03-02/turn-mismatch: bends"), [("vm-03-02/turn-mismatch".to_owned(), true)]);
        assert_eq!(of("a/b: x; and y; c: z"), [("a/b".to_owned(), true), ("c".to_owned(), true)]);
        assert_eq!(of("a, b/c: why"), [("a".to_owned(), true), ("b/c".to_owned(), true)]);
        assert_eq!(of("vm-03-02"), [("vm-03-02".to_owned(), false)]);
        assert_eq!(of(""), []);
    }
}
