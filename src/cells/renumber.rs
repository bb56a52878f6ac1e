//! Other ids in the text of an element; nothing else in it changes.

use std::ops::Range;

use rustc_hash::FxHashMap;

use super::NAMING;
use crate::osm::{ElementKind, attribute};

/// The new ids of elements.
pub type NewIds = FxHashMap<(ElementKind, i64), i64>;

/// The text of an element of this kind with new ids, its own and those that it refers to.
pub fn renumbered(kind: ElementKind, text: &str, new: &NewIds) -> String {
    let mut result = String::with_capacity(text.len());
    let mut copied = 0;
    for (range, id) in changes(kind, text, new) {
        result += &text[copied..range.start];
        result += &id.to_string();
        copied = range.end;
    }
    result + &text[copied..]
}

/// Where ids stand that change, in the order of the text, with the new ones.
fn changes(kind: ElementKind, text: &str, new: &NewIds) -> Vec<(Range<usize>, i64)> {
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some(tag) = text.get(at..).and_then(|rest| rest.find('<')).map(|to| at + to) {
        let rest = &text[tag..];
        if rest.starts_with("<!--") {
            at = tag + rest.find("-->").unwrap_or(rest.len());
            continue;
        }
        at = tag + 1;
        let value = |name| attribute(rest, name).map(|(from, to)| (tag + from..tag + to, &rest[from..to]));
        let name = rest[1..].split(|letter: char| !letter.is_alphanumeric()).next().unwrap_or_default();
        let of_kind = |word: &str| {
            [ElementKind::Node, ElementKind::Way, ElementKind::Relation].into_iter().find(|kind| kind.as_str() == word)
        };
        let reference = match name {
            _ if tag == 0 => value("id").map(|id| (kind, id)),
            "nd" => value("ref").map(|id| (ElementKind::Node, id)),
            "member" => value("type").and_then(|(_, word)| of_kind(word)).zip(value("ref")),
            "tag" if value("k").is_some_and(|(_, key)| NAMING.contains(&key)) => {
                value("v").map(|id| (ElementKind::Way, id))
            }
            _ => None,
        };
        let changed =
            reference.and_then(|(kind, (range, id))| Some((range, *new.get(&(kind, id.trim().parse().ok()?))?)));
        found.extend(changed);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_change_and_nothing_else_does() {
        let new: NewIds =
            [((ElementKind::Node, 1), 901), ((ElementKind::Way, 1), 902), ((ElementKind::Relation, 3), 903)]
                .into_iter()
                .collect();
        let of = |kind, text| renumbered(kind, text, &new);
        assert_eq!(
            of(ElementKind::Way, "<way version='1' id='1'><!-- <nd ref='1'/> --><nd ref=\"1\"/><nd ref='2'/></way>"),
            "<way version='1' id='902'><!-- <nd ref='1'/> --><nd ref=\"901\"/><nd ref='2'/></way>"
        );
        assert_eq!(
            of(
                ElementKind::Relation,
                "<relation id='3'>\n<member type='way' ref='1' role='1'/><member ref='3' type='relation' role=''/>\
                 <tag k='intersection_area' v='1'/><tag k='ele' v='1'/></relation>"
            ),
            "<relation id='903'>\n<member type='way' ref='902' role='1'/><member ref='903' type='relation' role=''/>\
             <tag k='intersection_area' v='902'/><tag k='ele' v='1'/></relation>"
        );
        assert_eq!(of(ElementKind::Node, "<node id='2' lat='1' lon='1'/>"), "<node id='2' lat='1' lon='1'/>");
    }
}
