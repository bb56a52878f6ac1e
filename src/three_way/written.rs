//! The text of the result: that of ours, with the elements exchanged, left out and put in that are not as ours has them.

use std::ops::Range;

use rustc_hash::FxHashMap;

use super::content::{Content, LOCAL};
use super::decide::{Decision, Decisions};
use super::versions::Key;
use super::view::{MARGIN, View};
use crate::osm::element::{Child, Element};
use crate::osm::{ElementKind, OsmText};

/// A piece of the text in place of another; of several at one place the order counts.
struct Piece {
    old: Range<usize>,
    order: usize,
    new: String,
}

/// The text with all decisions.
pub(super) fn text(decisions: &Decisions, ours: &View<'_>, theirs: &View<'_>) -> String {
    let source = ours.osm.sources.first().map_or("", |source| source.text.as_str());
    if source.is_empty() {
        return anew(decisions, ours, theirs);
    }
    let mut pieces: Vec<Piece> = Vec::new();
    for (key, decision) in &decisions.made {
        let Some(place) = place(ours, *key) else { continue };
        let (old, new) = match decision {
            Decision::Removed => (with_blanks_before(source, place), String::new()),
            Decision::Theirs => (place, theirs.text(*key).unwrap_or_default().into_owned()),
            Decision::Combined(content) => {
                let before = source.get(..place.start).unwrap_or_default();
                let margin = before.get(before.trim_end_matches([' ', '\t']).trim_end_matches(['\r', '\n']).len()..);
                let text = ours.text(*key).unwrap_or_default();
                (place, combined(&text, margin.unwrap_or(MARGIN), ours, *key, content))
            }
        };
        pieces.push(Piece { old, order: 0, new });
    }
    pieces.extend(added(source, decisions, ours, theirs));
    pieces.sort_unstable_by_key(|piece| (piece.old.start, piece.old.end, piece.order));
    let mut text = String::with_capacity(source.len());
    let mut at = 0;
    for Piece { old, new, .. } in pieces {
        text += source.get(at..old.start).unwrap_or_default();
        text += &new;
        at = old.end.max(at);
    }
    text + source.get(at..).unwrap_or_default()
}

/// Where an element stands in the text.
fn place(view: &View<'_>, key: Key) -> Option<Range<usize>> {
    let span = view.span(key)?;
    Some(usize::try_from(span.start).ok()?..usize::try_from(span.end).ok()?)
}

fn with_blanks_before(source: &str, place: Range<usize>) -> Range<usize> {
    let before = source.get(..place.start).unwrap_or_default();
    before.trim_end_matches([' ', '\t']).trim_end_matches(['\r', '\n']).len()..place.end
}

/// The elements that only theirs has, each behind the one that it follows: by its id where ours is in the order of ids, else by
/// its place in theirs.
fn added(source: &str, decisions: &Decisions, ours: &View<'_>, theirs: &View<'_>) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for kind in [ElementKind::Node, ElementKind::Way, ElementKind::Relation] {
        let of_kind = |view: &View<'_>| view.keys().filter(|key| key.0 == kind).collect::<Vec<Key>>();
        let own = of_kind(ours);
        let is_sorted = own.is_sorted();
        let mut new: Vec<Key> = Vec::new();
        let mut behind: FxHashMap<Key, Option<Key>> = FxHashMap::default();
        let mut last = None;
        for key in of_kind(theirs) {
            if ours.has(key) {
                last = Some(key);
            } else if decisions.has(key, ours) && !behind.contains_key(&key) {
                behind.insert(key, last);
                new.push(key);
            }
        }
        if is_sorted {
            new.sort_unstable();
        }
        for (order, key) in new.into_iter().enumerate() {
            let anchor = match is_sorted {
                true => own.partition_point(|one| *one < key).checked_sub(1).and_then(|at| own.get(at).copied()),
                false => behind.get(&key).copied().flatten().or(own.last().copied()),
            };
            let at = match anchor.and_then(|anchor| place(ours, anchor)) {
                Some(place) => place.end,
                None => first_place(source, ours, kind),
            };
            let text = theirs.text(key).unwrap_or_default();
            let text = match decisions.made.get(&key) {
                Some(Decision::Combined(content)) => combined(&text, MARGIN, theirs, key, content).into(),
                _ => text,
            };
            pieces.push(Piece { old: at..at, order: order + 1, new: format!("{MARGIN}{text}") });
        }
    }
    pieces
}

/// Where the elements of a kind begin: before the first of them, or of the kinds behind it, else at the end.
fn first_place(source: &str, ours: &View<'_>, kind: ElementKind) -> usize {
    let first = ours.keys().find(|key| key.0 >= kind).and_then(|key| place(ours, key));
    match first {
        Some(place) => with_blanks_before(source, place).start,
        None => source.get(..source.rfind("</osm").unwrap_or(source.len())).unwrap_or(source).trim_end().len(),
    }
}

/// The text of an element of one side that says what both have made of it: what is not changed in it keeps its letters.
fn combined(text: &str, margin: &str, of: &View<'_>, key: Key, content: &Content) -> String {
    let Some((mut element, own)) = Element::parse(text, margin).zip(of.content(key)) else { return text.to_owned() };
    if let Some(place) = content.position.lonlat.filter(|_| content.position != own.position) {
        element.set_place(place.lat, place.lon);
    }
    if content.position != own.position {
        for (key, value) in LOCAL.into_iter().zip(&content.position.local) {
            set(&mut element, key, value.as_deref());
        }
    }
    for key in own.tags.keys().chain(content.tags.keys()) {
        let value = content.tags.get(key);
        if value != own.tags.get(key) {
            set(&mut element, key, value.map(String::as_str));
        }
    }
    if content.nodes != own.nodes {
        element.set_vertices(&content.nodes);
    }
    if content.members != own.members {
        element.set_members(content.members.iter().map(|one| (one.kind, one.id, one.role.as_str())));
    }
    element.render()
}

fn set(element: &mut Element, key: &str, value: Option<&str>) {
    match value {
        Some(value) => element.set_tag(key, value),
        None => {
            element.remove(|child| *child == Child::Tag(key.to_owned()));
        }
    }
}

/// The result where ours is no text: in canonical form.
fn anew(decisions: &Decisions, ours: &View<'_>, theirs: &View<'_>) -> String {
    let mut keys: Vec<Key> =
        ours.keys().chain(decisions.made.keys().copied()).filter(|key| decisions.has(*key, ours)).collect();
    keys.sort_unstable();
    keys.dedup();
    let head = OsmText::head(&ours.osm.meta.clone().unwrap_or_default());
    let mut text = String::from_utf8_lossy(head.as_bytes()).into_owned();
    for key in keys {
        let own = || ours.text(key).or_else(|| theirs.text(key)).unwrap_or_default();
        let element = match decisions.made.get(&key) {
            Some(Decision::Theirs) => theirs.text(key).unwrap_or_default(),
            Some(Decision::Combined(content)) => {
                combined(&own(), MARGIN, if ours.has(key) { ours } else { theirs }, key, content).into()
            }
            _ => own(),
        };
        text += &format!("  {element}\n");
    }
    text + &String::from_utf8_lossy(OsmText::tail().as_bytes())
}
