//! What `fix` says of what it did: fixes of one kind in one line, and what changed in the end.

use std::collections::BTreeMap;

use crate::fix::{Mend, Mended};
use crate::osm::{ElementKind, OsmData};
use crate::report::visible;
use crate::text::without_numbers;

/// Fixes of one kind are named up to this number.
const NAMED: usize = 3;

/// All that is said after mending.
pub fn summary(mended: &Mended) -> String {
    let mut drawn: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for &(at, kind, id) in &mended.drawn {
        drawn.entry(at).or_default().extend(named(&mended.osm, kind, id));
    }
    let done = mended.done.iter().enumerate().map(|(at, mend)| {
        let more = drawn.get(&at).map(|names| format!(" ({})", names.join(", "))).unwrap_or_default();
        (mend, more)
    });
    let mut text = grouped("fixed", done);
    text += &not_kept(&mended.refused);
    let [errors, warnings] = mended.after();
    text += &format!("{} fixed", mended.done.len());
    let harmful = mended.refused.len() - mended.untried;
    if harmful > 0 {
        text += &format!(", {harmful} not kept because they mend nothing or do harm");
    }
    if mended.untried > 0 {
        text += &format!(
            ", {} not tried because too many others do harm (mend some by hand, then run fix again)",
            mended.untried
        );
    }
    text += &format!("; left: {errors} errors, {warnings} warnings");
    if mended.unsafe_left > 0 {
        text += &format!(", {} of them with a fix that needs review (--unsafe)", mended.unsafe_left);
    }
    text += "\n";
    if mended.revealed > 0 {
        text += &format!(
            "{} of the errors left were not told before: rules now look at lanes that became a road or part of an intersection\n",
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
        1 => ", 1 of the fixes made needs review".to_owned(),
        many => format!(", {many} of the fixes made need review"),
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

/// Lines of fixes, those of one code that differ in numbers alone in one; behind each element what is said of it alone.
fn grouped<'a>(what: &str, fixes: impl Iterator<Item = (&'a Mend, String)>) -> String {
    let line = |group: &Vec<(&Mend, String)>| {
        let names = group.iter().take(NAMED).map(|(mend, more)| {
            let id = mend.subject.id().unwrap_or_default();
            format!("{id}{}", visible(more))
        });
        match &group[..] {
            [(only, more)] => Some(format!("{}{}\n", one_line(what, only), visible(more))),
            _ => Some(format!("{}\n", one_line_for_all(what, group, names.collect())?)),
        }
    };
    groups(fixes).iter().filter_map(line).collect()
}

/// The same for fixes that were not kept: behind each group its reasons, each once.
fn not_kept(refused: &[(Mend, String)]) -> String {
    let of_each = refused.iter().map(|(mend, reason)| (mend, reason.trim_end_matches('.').to_owned()));
    let line = |group: &Vec<(&Mend, String)>| match &group[..] {
        [(only, reason)] => Some(format!("{} ({})\n", one_line("not kept", only), visible(reason))),
        _ => {
            let ids = group.iter().take(NAMED).map(|(mend, _)| mend.subject.id().unwrap_or_default().to_string());
            let head = one_line_for_all("not kept", group, ids.collect())?;
            Some(head + "\n" + &reasons(group))
        }
    };
    groups(of_each).iter().filter_map(line).collect()
}

/// The reasons of a group, those that differ in numbers alone as one, the most frequent first.
fn reasons(group: &[(&Mend, String)]) -> String {
    let mut of_each: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for (_, reason) in group {
        of_each.entry(without_numbers(reason)).or_default().push(reason);
    }
    let mut all: Vec<(String, Vec<&str>)> = of_each.into_iter().collect();
    all.sort_by_key(|(_, those)| std::cmp::Reverse(those.len()));
    let rest = all.len().saturating_sub(NAMED);
    let lines = all.iter().take(NAMED).map(|(bare, those)| {
        let is_same = those.windows(2).all(|pair| pair[0] == pair[1]);
        let said = those.first().filter(|_| is_same).map_or(bare.as_str(), |reason| *reason);
        match those.len() {
            count if count == group.len() => format!("  {}\n", visible(said)),
            count => format!("  {count} × {}\n", visible(said)),
        }
    });
    let lines: String = lines.collect();
    match rest {
        0 => lines,
        1 => lines + "  and for one reason more\n",
        count => format!("{lines}  and for {count} reasons more\n"),
    }
}

/// Fixes of one code that differ in numbers alone, in groups in the order of their first ones.
fn groups<'a>(fixes: impl Iterator<Item = (&'a Mend, String)>) -> Vec<Vec<(&'a Mend, String)>> {
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
    groups
}

fn one_line(what: &str, one: &Mend) -> String {
    format!("{what}[{}] {}: {}", one.code, one.subject, visible(&one.title))
}

/// A group in one line with the names of its first elements.
fn one_line_for_all(what: &str, group: &[(&Mend, String)], names: Vec<String>) -> Option<String> {
    let (first, _) = group.first()?;
    let is_same = group.iter().all(|(mend, _)| mend.title == first.title);
    let title = if is_same { first.title.clone() } else { without_numbers(&first.title) };
    let rest = match group.len() - names.len() {
        0 => String::new(),
        count => format!(" and {count} more"),
    };
    let (kind, code, count) = (first.subject.kind(), &first.code, group.len());
    Some(format!("{what}[{code}] {count} × {}: {kind}s {}{rest}", visible(&title), names.join(", ")))
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
