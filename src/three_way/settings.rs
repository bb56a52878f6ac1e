//! Merges `lanewright.toml`: by keys, and with the ids that elements of theirs have in the merged map.

use std::collections::BTreeSet;
use std::ops::Range;

use rustc_hash::FxHashMap;
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use super::conflict::{Conflict, Side};
use super::lists;
use super::versions::Key;
use crate::diagnostic::Subject;
use crate::osm::ElementKind;

/// One of the three files that is no TOML.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct SettingsConflict {
    /// Which of them; `None` for what both began with.
    pub side: Option<Side>,
    /// What is wrong with it.
    pub message: String,
}

/// Keys that tell the entries of a list of tables apart.
const NAMES: [&str; 9] = ["ia", "at", "code", "primitive", "id", "nodes", "way", "ways", "highway"];

/// Merges three texts of a file. Where both sides have changed a key to something else, the result has what ours says.
///
/// # Errors
///
/// Where one of the texts is no TOML.
pub fn merge_settings(
    [base, ours, theirs]: [&str; 3],
    new_ids: &FxHashMap<Key, i64>,
) -> Result<(String, Vec<Conflict>), SettingsConflict> {
    let read = |side, text: &str| {
        toml::from_str::<Table>(text).map_err(|error| SettingsConflict { side, message: error.message().to_owned() })
    };
    let theirs =
        &renumbered(theirs, new_ids).map_err(|message| SettingsConflict { side: Some(Side::Theirs), message })?;
    if theirs == base || ours == theirs {
        return Ok((ours.to_owned(), Vec::new()));
    }
    if ours == base {
        return Ok((theirs.clone(), Vec::new()));
    }
    let tables = [read(None, base)?, read(Some(Side::Ours), ours)?, read(Some(Side::Theirs), theirs)?];
    let mut conflicts = Vec::new();
    let merged = merged_tables(tables.each_ref(), "", &mut conflicts);
    if merged == tables[1] {
        return Ok((ours.to_owned(), conflicts));
    }
    // Comments and order are kept where the lines can be merged, too.
    let lines = [base, ours, theirs].map(|text| text.split_inclusive('\n').collect::<Vec<&str>>());
    let by_lines = lists::merged(&lines[0], &lines[1], &lines[2], |_, [a, b], _| Some([a, b].concat()));
    let text =
        by_lines.map(|lines| lines.concat()).filter(|text| toml::from_str::<Table>(text).is_ok_and(|it| it == merged));
    let anew = || {
        let comments: String = ours.split_inclusive('\n').take_while(|line| line.starts_with('#')).collect();
        toml::to_string(&merged).map(|text| comments + &text)
    };
    let text = text.map_or_else(anew, Ok);
    text.map(|text| (text, conflicts)).map_err(|error| SettingsConflict { side: None, message: error.to_string() })
}

/// The keys of three tables, each from the side that changed it.
fn merged_tables([base, ours, theirs]: [&Table; 3], path: &str, conflicts: &mut Vec<Conflict>) -> Table {
    let mut merged = Table::new();
    let mut seen = BTreeSet::new();
    for key in ours.keys().chain(theirs.keys()).filter(|key| seen.insert(*key)) {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let value = merged_values([base.get(key), ours.get(key), theirs.get(key)], &path, conflicts);
        merged.extend(value.map(|value| (key.clone(), value)));
    }
    merged
}

fn merged_values(
    [base, ours, theirs]: [Option<&Value>; 3],
    path: &str,
    conflicts: &mut Vec<Conflict>,
) -> Option<Value> {
    if theirs == base || ours == theirs {
        return ours.cloned();
    }
    if ours == base {
        return theirs.cloned();
    }
    match (ours, theirs) {
        (Some(Value::Table(ours)), Some(Value::Table(theirs))) => {
            let empty = Table::new();
            let base = base.and_then(Value::as_table).unwrap_or(&empty);
            Some(Value::Table(merged_tables([base, ours, theirs], path, conflicts)))
        }
        (Some(Value::Array(ours)), Some(Value::Array(theirs))) if !is_place(ours) && !is_place(theirs) => {
            let base = base.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
            Some(Value::Array(merged_lists([base, ours, theirs], path, conflicts)))
        }
        _ => {
            let said = |value: Option<&Value>| value.map(ToString::to_string);
            conflicts.push(Conflict {
                subject: Subject::Map,
                about: format!("key {path} of lanewright.toml"),
                base: said(base),
                ours: said(ours),
                theirs: said(theirs),
                taken: Side::Ours,
                at: None,
            });
            ours.cloned()
        }
    }
}

/// Latitude and longitude belong together.
fn is_place(list: &[Value]) -> bool {
    list.iter().any(Value::is_float)
}

/// The entries of three lists: tables by what names them, all others by what they are.
fn merged_lists([base, ours, theirs]: [&[Value]; 3], path: &str, conflicts: &mut Vec<Conflict>) -> Vec<Value> {
    let find = |list: &'_ [Value], name: &str| list.iter().find(|entry| name_of(entry) == name).cloned();
    let mut merged = Vec::new();
    let mut seen = BTreeSet::new();
    for name in ours.iter().chain(theirs).map(name_of) {
        if seen.insert(name.clone()) {
            let entries = [base, ours, theirs].map(|list| find(list, &name));
            let path = format!("{path}[{name}]");
            merged.extend(merged_values(entries.each_ref().map(Option::as_ref), &path, conflicts));
        }
    }
    merged
}

/// What names an entry of a list.
fn name_of(entry: &Value) -> String {
    let Some(table) = entry.as_table() else { return entry.to_string() };
    let names = NAMES.iter().filter_map(|name| Some(format!("{name} = {}", table.get(*name)?)));
    let names = names.collect::<Vec<_>>().join(", ");
    if names.is_empty() { entry.to_string() } else { names }
}

/// The text with the ids that elements have now; nothing else in it changes.
fn renumbered(text: &str, new_ids: &FxHashMap<Key, i64>) -> Result<String, String> {
    if new_ids.is_empty() {
        return Ok(text.to_owned());
    }
    let table = DeTable::parse(text).map_err(|error| error.message().to_owned())?;
    let mut found: Vec<(Range<usize>, i64)> = Vec::new();
    for (key, value) in table.get_ref() {
        ids_in(key.get_ref(), value, new_ids, &mut found);
    }
    found.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
    let mut text = text.to_owned();
    for (place, id) in found {
        text.replace_range(place, &id.to_string());
    }
    Ok(text)
}

/// A conflict for settings of theirs that name elements by ids which are others now, where somebody has to write the new ones.
#[must_use]
pub fn renumbered_settings(theirs: &str, new_ids: &FxHashMap<Key, i64>) -> Option<Conflict> {
    let renumbered = renumbered(theirs, new_ids).ok().filter(|text| text != theirs)?;
    let lines = theirs.lines().zip(renumbered.lines()).filter(|(old, new)| old != new);
    let (old, new): (Vec<&str>, Vec<&str>) = lines.unzip();
    Some(Conflict {
        subject: Subject::Map,
        about: "ids in lanewright.toml of theirs; write the new ones".to_owned(),
        base: None,
        ours: Some(new.join(", ")),
        theirs: Some(old.join(", ")),
        taken: Side::Ours,
        at: None,
    })
}

/// Where the ids of elements stand beneath a key of the file.
fn ids_in(
    key: &str,
    value: &Spanned<DeValue<'_>>,
    new_ids: &FxHashMap<Key, i64>,
    found: &mut Vec<(Range<usize>, i64)>,
) {
    let mut all = |value: &Spanned<DeValue<'_>>, kinds: &[ElementKind]| {
        let mut places = Vec::new();
        integers(value, &mut places);
        for (place, id) in places {
            found.extend(kinds.iter().find_map(|kind| new_ids.get(&(*kind, id))).map(|new| (place, *new)));
        }
    };
    match key {
        "bicycle_lanes" | "loose_ends" => all(value, &[ElementKind::Relation]),
        "intersection" => {
            for (key, value) in tables(value).into_iter().flat_map(|table| table.iter()) {
                match key.get_ref().as_ref() {
                    "ia" => all(value, &[ElementKind::Way]),
                    "phases" | "priority_arms" | "prohibited" => all(value, &[ElementKind::Relation]),
                    _ => {}
                }
            }
        }
        "suppress" => {
            for table in tables(value) {
                let get = |name: &str| table.iter().find(|(key, _)| key.get_ref() == name).map(|(_, value)| value);
                let kind = match get("primitive").and_then(|value| value.get_ref().as_str()) {
                    Some("point" | "node") => ElementKind::Node,
                    Some("linestring" | "polygon" | "way") => ElementKind::Way,
                    _ => ElementKind::Relation,
                };
                get("id").into_iter().for_each(|ids| all(ids, &[kind]));
            }
        }
        _ => {}
    }
}

fn tables<'t, 'i>(value: &'t Spanned<DeValue<'i>>) -> Vec<&'t DeTable<'i>> {
    let entries = value.get_ref().as_array().into_iter().flat_map(|list| list.iter());
    entries.filter_map(|entry| entry.get_ref().as_table()).collect()
}

/// All integers in a value, with their places.
fn integers(value: &Spanned<DeValue<'_>>, found: &mut Vec<(Range<usize>, i64)>) {
    match value.get_ref() {
        DeValue::Integer(number) => {
            found.extend(number.as_str().parse().ok().map(|number| (value.span(), number)));
        }
        DeValue::Array(list) => list.iter().for_each(|entry| integers(entry, found)),
        DeValue::Table(table) => table.iter().for_each(|(_, value)| integers(value, found)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merged(texts: [&str; 3]) -> (String, Vec<Conflict>) {
        merge_settings(texts, &FxHashMap::default()).unwrap()
    }

    const BASE: &str = "# Mine.\ndriving_side = \"left\"\nbicycle_lanes = [1, 2]\n\n[[intersection]]\nia = 5 # the old one\nphases = [[1]]\n";

    #[test]
    fn what_either_side_says_is_there_and_comments_stay() {
        let ours = BASE.replace("[1, 2]", "[1, 2, 3]");
        let theirs = format!("{BASE}\n[[intersection]]\nia = 6\narrows = true\n").replace("[[1]]", "[[1], [2]]");
        let (text, conflicts) = merged([BASE, &ours, &theirs]);
        assert_eq!(text, theirs.replace("[1, 2]", "[1, 2, 3]"));
        assert_eq!(conflicts, []);
        // The same lines changed, to things that go together.
        let theirs = BASE.replace("[1, 2]", "[2, 4]");
        let (text, conflicts) = merged([BASE, &ours, &theirs]);
        assert_eq!(conflicts, []);
        assert!(text.starts_with("# Mine.\n") && text.contains("bicycle_lanes = [2, 3, 4]"), "{text}");
    }

    #[test]
    fn what_both_change_is_a_conflict() {
        let (ours, theirs) = (BASE.replace("left", "right"), BASE.replace("left", "auto"));
        let (text, conflicts) = merged([BASE, &ours, &theirs]);
        assert_eq!(text, ours);
        let [conflict] = &conflicts[..] else { panic!("{conflicts:?}") };
        assert_eq!(conflict.about, "key driving_side of lanewright.toml");
        assert_eq!(conflict.theirs.as_deref(), Some("\"auto\""));
        let (_, conflicts) =
            merged([BASE, &BASE.replace("[[1]]", "[[3]]\narrows = true"), &BASE.replace("[[1]]", "[[3]]")]);
        assert_eq!(conflicts, []);
        assert_eq!(merge_settings([BASE, BASE, "= 1"], &FxHashMap::default()).unwrap().0, "= 1");
        assert!(merge_settings([BASE, "a = 1", "= 1"], &FxHashMap::default()).is_err());
    }

    #[test]
    fn ids_of_theirs_are_those_that_its_elements_have_now() {
        let new = [((ElementKind::Way, 6), 60), ((ElementKind::Relation, 6), 66)].into_iter().collect();
        let theirs = format!(
            "{BASE}[[intersection]]\nia = 6 # the new one\nphases = [[6, 7], [\"N\"]]\n[[suppress]]\ncode = \"a\"\n\
             primitive = \"lanelet\"\nid = [6, 1]\n"
        );
        let (text, _) = merge_settings([BASE, BASE, &theirs], &new).unwrap();
        let expected = theirs.replace("ia = 6 ", "ia = 60 ").replace("[6, 7]", "[66, 7]").replace("[6, 1]", "[66, 1]");
        assert_eq!(text, expected);
        let conflict = renumbered_settings(&theirs, &new).unwrap();
        assert_eq!(conflict.theirs.as_deref(), Some("ia = 6 # the new one, phases = [[6, 7], [\"N\"]], id = [6, 1]"));
        assert_eq!(renumbered_settings(BASE, &new), None);
    }
}
