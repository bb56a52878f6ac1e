//! What `fix` says of what it did: fixes of one kind in one line, and what changed in the end.

use std::collections::BTreeMap;

use crate::fix::{Mend, Mended};
use crate::osm::{ElementKind, OsmData};
use crate::report::visible;
use crate::text::without_numbers;

/// Fixes of one kind are named up to this number.
const NAMED: usize = 3;

/// All that is said after mending.
pub fn told(mended: &Mended) -> String {
    let mut drawn: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for &(at, kind, id) in &mended.drawn {
        drawn.entry(at).or_default().extend(named(&mended.osm, kind, id));
    }
    let done = mended.done.iter().enumerate().map(|(at, mend)| {
        let more = drawn.get(&at).map(|names| format!(" ({})", names.join(", "))).unwrap_or_default();
        (mend, more)
    });
    let mut text = grouped("fixed", done);
    let refused = mended.refused.iter().map(|(mend, reason)| (mend, format!(" ({})", reason.trim_end_matches('.'))));
    text += &grouped("not kept", refused);
    let [errors, warnings] = mended.after();
    text += &format!("{} fixed", mended.done.len());
    if !mended.refused.is_empty() {
        text += &format!(", {} not kept because they mend nothing or do harm", mended.refused.len());
    }
    text += &format!("; left: {errors} errors, {warnings} warnings");
    if mended.unsafe_left > 0 {
        text += &format!(", {} of them with a fix that needs a look (--unsafe)", mended.unsafe_left);
    }
    text += "\n";
    if mended.revealed > 0 {
        text += &format!(
            "{} of the errors left were not told before: rules now look at the intersections that were marked\n",
            mended.revealed
        );
    }
    text + &change(mended) + "\n"
}

/// What changed, in one line, after one that lists what there are more warnings of, where there are more.
pub fn change(mended: &Mended) -> String {
    let [errors, warnings] = [0, 1].map(|at| {
        let (before, after) = (mended.before.get(at).copied(), mended.after().get(at).copied());
        let (before, after) = (before.unwrap_or_default(), after.unwrap_or_default());
        let word = if after > before { "more" } else { "fewer" };
        (before.abs_diff(after), word)
    });
    let said = |(count, word): (usize, &str), what: &str| {
        let plural = if count == 1 { "" } else { "s" };
        format!("{count} {what}{plural} {word}")
    };
    let look = match mended.to_look_at {
        0 => String::new(),
        1 => ", 1 of the fixes made needs a look".to_owned(),
        many => format!(", {many} of the fixes made need a look"),
    };
    let more = match warnings {
        (1.., "more") => {
            let of_each = mended.more_warnings.iter().map(|(code, count)| format!("{count} × {code}"));
            format!("warnings that there are more of: {}\n", of_each.collect::<Vec<_>>().join(", "))
        }
        _ => String::new(),
    };
    format!("{more}{}, {}{look}", said(errors, "error"), said(warnings, "warning"))
}

/// Lines of fixes, those of one code that differ in numbers alone in one.
fn grouped<'a>(what: &str, fixes: impl Iterator<Item = (&'a Mend, String)>) -> String {
    let mut groups: Vec<Vec<(&Mend, String)>> = Vec::new();
    let mut place: BTreeMap<(String, &str, String), usize> = BTreeMap::new();
    for (mend, more) in fixes {
        let key = (mend.code.clone(), mend.subject.kind(), without_numbers(&mend.title));
        let at = *place.entry(key).or_insert(groups.len());
        match groups.get_mut(at) {
            Some(group) => group.push((mend, more)),
            None => groups.push(vec![(mend, more)]),
        }
    }
    let line = |group: &Vec<(&Mend, String)>| {
        let (first, more) = group.first()?;
        if group.len() == 1 {
            return Some(format!(
                "{what}[{}] {}: {}{}\n",
                first.code,
                first.subject,
                visible(&first.title),
                visible(more)
            ));
        }
        let is_same = group.iter().all(|(mend, _)| mend.title == first.title);
        let title = if is_same { first.title.clone() } else { without_numbers(&first.title) };
        let ids: Vec<String> = group
            .iter()
            .take(NAMED)
            .map(|(mend, more)| format!("{}{}", mend.subject.id().unwrap_or_default(), visible(more)))
            .collect();
        let rest = match group.len() - ids.len() {
            0 => String::new(),
            count => format!(" and {count} more"),
        };
        let kind = first.subject.kind();
        let (code, count) = (&first.code, group.len());
        Some(format!("{what}[{code}] {count} × {}: {kind}s {}{rest}\n", visible(&title), ids.join(", ")))
    };
    groups.iter().filter_map(line).collect()
}

/// An element that was drawn, in words; `None` for nodes, of which there are many.
fn named(osm: &OsmData, kind: ElementKind, id: i64) -> Option<String> {
    let word = match kind {
        ElementKind::Node => return None,
        ElementKind::Way if osm.way(id)?.tags.is("area", "yes") => "area",
        ElementKind::Way => "line",
        ElementKind::Relation if osm.relation(id)?.tags.is("type", "lanelet") => "lanelet",
        ElementKind::Relation => "element",
    };
    Some(format!("{word} {id}"))
}
