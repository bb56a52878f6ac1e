//! Makes the edits that change one element alone, in the element's own text.

use std::collections::BTreeMap;

use crate::diagnostic::{Edit, Fix, SourceSpan, Subject};
use crate::osm::ElementKind;
use crate::osm::element::{Child, Element};

/// An element of a file: its kind and its id.
pub type Key = (ElementKind, i64);

/// The element of the file that a subject is.
pub fn key_of(subject: Subject) -> Option<Key> {
    match subject {
        Subject::Map => None,
        Subject::Point(id) | Subject::Node(id) => Some((ElementKind::Node, id)),
        Subject::LineString(id) | Subject::Polygon(id) | Subject::Way(id) => Some((ElementKind::Way, id)),
        Subject::Lanelet(id) | Subject::RegulatoryElement(id) | Subject::Relation(id) => {
            Some((ElementKind::Relation, id))
        }
    }
}

/// The only element whose text an edit changes; `None` for an edit that [`edit_element`] does not make.
pub fn edited_element(edit: &Edit) -> Option<Subject> {
    match edit {
        Edit::SetTag { on, .. }
        | Edit::RemoveTag { on, .. }
        | Edit::AddMember { on, .. }
        | Edit::RemoveMember { on, .. }
        | Edit::SetRole { on, .. } => Some(*on),
        Edit::InsertVertex { way, .. } | Edit::RemoveVertex { way, .. } => Some(*way),
        Edit::ReplaceWay { lanelet, .. } => Some(Subject::Lanelet(*lanelet)),
        _ => None,
    }
}

/// Makes an edit of one element; `None` where it cannot be made.
pub fn edit_element(element: &mut Element, edit: &Edit) -> Option<()> {
    let member =
        |member: Subject, role: &str| key_of(member).map(|(kind, id)| Child::Member(kind, id, role.to_owned()));
    let done = match edit {
        Edit::SetTag { key, value, .. } => {
            element.set_tag(key, value);
            true
        }
        Edit::RemoveTag { key, .. } => {
            let tag = Child::Tag(key.to_string());
            element.remove(|child| *child == tag)
        }
        Edit::AddMember { role, member, .. } => {
            let (kind, id) = key_of(*member)?;
            element.add_member(kind, id, role);
            true
        }
        Edit::RemoveMember { role, member: of, .. } => {
            let member = member(*of, role)?;
            element.remove(|child| *child == member)
        }
        Edit::SetRole { member: of, from, to, .. } => {
            let (from, to) = (member(*of, from)?, member(*of, to)?);
            element.replace(|child| (*child == from).then(|| to.clone()))
        }
        Edit::InsertVertex { position, point, .. } => element.insert_vertex(*position, *point),
        Edit::RemoveVertex { position, .. } => element.remove_vertex(*position),
        Edit::ReplaceWay { from, to, .. } => element.replace(|child| match child {
            Child::Member(ElementKind::Way, id, role) if id == from => {
                Some(Child::Member(ElementKind::Way, *to, role.clone()))
            }
            _ => None,
        }),
        _ => false,
    };
    done.then_some(())
}

/// A range of a file (bytes) and its text after the change.
pub type Replacement = (SourceSpan, String);

/// The changes of text that make a fix, in file order; `text` gives the place and the text of an element. `None` where one of its edits
/// changes more than one element, or cannot be made.
pub fn replacements<'t>(
    fix: &Fix,
    text: impl Fn(Subject) -> Option<(SourceSpan, &'t str)>,
) -> Option<Vec<Replacement>> {
    let mut edited: BTreeMap<SourceSpan, (&str, Element)> = BTreeMap::new();
    for edit in &fix.edits {
        let (span, text) = text(edited_element(edit)?)?;
        if !edited.contains_key(&span) {
            edited.insert(span.clone(), (text, Element::parse(text, "")?));
        }
        edit_element(&mut edited.get_mut(&span)?.1, edit)?;
    }
    let mut all = Vec::new();
    for (SourceSpan { file, start, .. }, (text, element)) in edited {
        let changes = element.changes_of(text)?.into_iter();
        all.extend(changes.map(|(at, new)| {
            let [from, to] = [at.start, at.end].map(|offset| start + offset as u64);
            (SourceSpan { file, start: from, end: to }, new)
        }));
    }
    (!all.is_empty()).then_some(all)
}
