//! The files of a map with edits on them. Fixes that reach for the same thing wait for each other.

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};

use super::element::{Child, Element};
use crate::diagnostic::{Edit, Fix, SourceSpan, Subject};
use crate::osm::{ElementKind, OsmData};

type Key = (ElementKind, i64);

/// What an edit takes for itself.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Part {
    Tag(String),
    Vertex(usize),
    Member(ElementKind, i64),
}

/// What the fixes so far have taken.
#[derive(Debug, Default)]
struct Claims {
    whole: FxHashSet<Key>,
    parts: FxHashSet<(Key, Part)>,
    touched: FxHashSet<Key>,
}

/// Edits on the files that `osm` was read from.
pub struct Draft<'a> {
    osm: &'a OsmData,
    /// Edited elements; `None` where one is removed.
    edited: BTreeMap<Key, Option<Element>>,
    created: Vec<Element>,
    claims: Claims,
    referrers: FxHashMap<Key, Vec<Key>>,
    last_id: i64,
}

impl<'a> Draft<'a> {
    /// Without an edit.
    pub fn new(osm: &'a OsmData) -> Self {
        let mut referrers: FxHashMap<Key, Vec<Key>> = FxHashMap::default();
        for way in &osm.ways {
            for node in &way.nodes {
                referrers.entry((ElementKind::Node, *node)).or_default().push((ElementKind::Way, way.id));
            }
        }
        for relation in &osm.relations {
            for member in &relation.members {
                let list = referrers.entry((member.kind, member.id)).or_default();
                list.push((ElementKind::Relation, relation.id));
            }
        }
        let ids = osm.nodes.iter().map(|node| node.id).chain(osm.ways.iter().map(|way| way.id));
        let last_id = ids.chain(osm.relations.iter().map(|relation| relation.id)).max().unwrap_or(0).max(0);
        Self { osm, edited: BTreeMap::new(), created: Vec::new(), claims: Claims::default(), referrers, last_id }
    }

    /// Makes all edits of a fix, or none of them: `false` where another fix has a claim on what it needs, or where the map
    /// is not as the fix takes it to be.
    pub fn apply(&mut self, fix: &Fix) -> bool {
        let mut whole = Vec::new();
        let mut parts = Vec::new();
        for edit in &fix.edits {
            self.claim(edit, &mut whole, &mut parts);
        }
        let claims = &self.claims;
        let taken = whole.iter().any(|key| claims.touched.contains(key))
            || parts.iter().any(|part| claims.whole.contains(&part.0) || claims.parts.contains(part));
        if taken {
            return false;
        }
        let reached = whole.iter().copied().chain(parts.iter().map(|part| part.0));
        let before: Vec<(Key, Option<Option<Element>>)> =
            reached.map(|key| (key, self.edited.get(&key).cloned())).collect();
        let (created, last_id) = (self.created.len(), self.last_id);
        if !fix.edits.iter().all(|edit| self.edit(edit).is_some()) {
            for (key, element) in before {
                match element {
                    Some(element) => self.edited.insert(key, element),
                    None => self.edited.remove(&key),
                };
            }
            self.created.truncate(created);
            self.last_id = last_id;
            return false;
        }
        self.claims.touched.extend(whole.iter().copied().chain(parts.iter().map(|part| part.0)));
        self.claims.whole.extend(whole);
        self.claims.parts.extend(parts);
        true
    }

    /// What an edit needs for itself.
    fn claim(&self, edit: &Edit, whole: &mut Vec<Key>, parts: &mut Vec<(Key, Part)>) {
        let mut part = |on: Subject, part: Part| parts.extend(key_of(on).map(|key| (key, part)));
        match edit {
            Edit::SetTag { on, key, .. } | Edit::RemoveTag { on, key } => part(*on, Part::Tag(key.to_string())),
            Edit::AddMember { on, member, .. }
            | Edit::RemoveMember { on, member, .. }
            | Edit::SetRole { on, member, .. } => {
                if let Some((kind, id)) = key_of(*member) {
                    part(*on, Part::Member(kind, id));
                }
            }
            Edit::InsertVertex { way, position, .. } | Edit::RemoveVertex { way, position } => {
                part(*way, Part::Vertex(*position));
            }
            Edit::MergePoints { from, to } => {
                let from = (ElementKind::Node, *from);
                whole.extend([from, (ElementKind::Node, *to)]);
                whole.extend(self.referrers.get(&from).into_iter().flatten());
            }
            Edit::ReplaceWay { lanelet, .. } => whole.push((ElementKind::Relation, *lanelet)),
            Edit::Remove { subject } => {
                if let Some(key) = key_of(*subject) {
                    whole.push(key);
                    whole.extend(self.referrers.get(&key).into_iter().flatten());
                }
            }
            Edit::CreateRegulatoryElement { referrers, .. } => {
                for id in referrers {
                    parts.push(((ElementKind::Relation, *id), Part::Member(ElementKind::Relation, 0)));
                }
            }
        }
    }

    /// Makes one edit; `None` where it cannot be made.
    fn edit(&mut self, edit: &Edit) -> Option<()> {
        let done = |done: bool| done.then_some(());
        match edit {
            Edit::SetTag { on, key, value } => self.element(*on)?.set_tag(key, value),
            Edit::RemoveTag { on, key } => {
                let tag = Child::Tag(key.to_string());
                done(self.element(*on)?.remove(|child| *child == tag))?;
            }
            Edit::AddMember { on, role, member } => {
                let (kind, id) = key_of(*member)?;
                self.element(*on)?.add_member(kind, id, role);
            }
            Edit::RemoveMember { on, role, member } => {
                let (kind, id) = key_of(*member)?;
                let member = Child::Member(kind, id, role.to_string());
                done(self.element(*on)?.remove(|child| *child == member))?;
            }
            Edit::SetRole { on, member, from, to } => {
                let (kind, id) = key_of(*member)?;
                let [from, to] = [from, to].map(|role| Child::Member(kind, id, role.to_string()));
                done(self.element(*on)?.replace(|child| (*child == from).then(|| to.clone())))?;
            }
            Edit::MergePoints { from, to } => self.merge(*from, *to)?,
            Edit::InsertVertex { way, position, point } => {
                done(self.element(*way)?.insert_vertex(*position, *point))?;
            }
            Edit::RemoveVertex { way, position } => done(self.element(*way)?.remove_vertex(*position))?,
            Edit::ReplaceWay { lanelet, from, to } => {
                let other = |child: &Child| match child {
                    Child::Member(ElementKind::Way, id, role) if id == from => {
                        Some(Child::Member(ElementKind::Way, *to, role.clone()))
                    }
                    _ => None,
                };
                done(self.element(Subject::Relation(*lanelet))?.replace(other))?;
            }
            Edit::Remove { subject } => self.remove(key_of(*subject)?)?,
            Edit::CreateRegulatoryElement { subtype, members, referrers } => {
                self.create(subtype, members, referrers)?
            }
        }
        Some(())
    }

    fn merge(&mut self, from: i64, to: i64) -> Option<()> {
        let key = (ElementKind::Node, from);
        for referrer in self.referrers.get(&key).cloned().unwrap_or_default() {
            let element = self.element_of(referrer)?;
            element.replace(|child| match child {
                Child::Vertex(id) if *id == from => Some(Child::Vertex(to)),
                Child::Member(ElementKind::Node, id, role) if *id == from => {
                    Some(Child::Member(ElementKind::Node, to, role.clone()))
                }
                _ => None,
            });
            element.drop_repeats();
        }
        self.element_of(key)?;
        self.edited.insert(key, None);
        Some(())
    }

    fn remove(&mut self, key: Key) -> Option<()> {
        for referrer in self.referrers.get(&key).cloned().unwrap_or_default() {
            // One that was itself removed refers to nothing.
            if let Some(element) = self.element_of(referrer) {
                element.remove(|child| match child {
                    Child::Vertex(id) => (ElementKind::Node, *id) == key,
                    Child::Member(kind, id, _) => (*kind, *id) == key,
                    _ => false,
                });
            }
        }
        self.element_of(key)?;
        self.edited.insert(key, None);
        Some(())
    }

    fn create(&mut self, subtype: &str, members: &[(crate::osm::Text, Subject)], referrers: &[i64]) -> Option<()> {
        self.last_id = self.last_id.checked_add(1)?;
        let id = self.last_id;
        let mut element = Element::relation(id, "\n  ");
        for (role, member) in members {
            let (kind, id) = key_of(*member)?;
            element.add_member(kind, id, role);
        }
        element.set_tag("type", "regulatory_element");
        element.set_tag("subtype", subtype);
        self.created.push(element);
        for referrer in referrers {
            let lanelet = self.element(Subject::Relation(*referrer))?;
            lanelet.add_member(ElementKind::Relation, id, "regulatory_element");
        }
        Some(())
    }

    fn element(&mut self, subject: Subject) -> Option<&mut Element> {
        self.element_of(key_of(subject)?)
    }

    /// The element to edit; `None` if it is removed, or not in the files.
    fn element_of(&mut self, key: Key) -> Option<&mut Element> {
        if !self.edited.contains_key(&key) {
            let span = self.span(key)?;
            let source = &self.osm.sources.get(span.file as usize)?.text;
            let (start, end) = (usize::try_from(span.start).ok()?, usize::try_from(span.end).ok()?);
            let before = source.get(..start)?;
            // The line end, too; a file in one line has none.
            let blanks = before.trim_end_matches([' ', '\t']).trim_end_matches(['\r', '\n']).len();
            let element = Element::parse(source.get(start..end)?, before.get(blanks..)?)?;
            self.edited.insert(key, Some(element));
        }
        self.edited.get_mut(&key)?.as_mut()
    }

    fn span(&self, (kind, id): Key) -> Option<&SourceSpan> {
        match kind {
            ElementKind::Node => self.osm.node(id).map(|node| &node.span),
            ElementKind::Way => self.osm.way(id).map(|way| &way.span),
            ElementKind::Relation => self.osm.relation(id).map(|relation| &relation.span),
        }
    }

    /// The files' texts with all edits, in the order of the sources.
    pub fn texts(&self) -> Vec<String> {
        let mut spans: Vec<(&SourceSpan, Option<&Element>)> =
            (self.edited.iter()).filter_map(|(key, element)| Some((self.span(*key)?, element.as_ref()))).collect();
        spans.sort_by_key(|(span, _)| (span.file, span.start));
        let mut texts = Vec::new();
        for (file, source) in self.osm.sources.iter().enumerate() {
            let mut text = String::with_capacity(source.text.len());
            let mut at = 0;
            for (span, element) in spans.iter().filter(|(span, _)| span.file as usize == file) {
                let (start, end) = (span.start as usize, span.end as usize);
                let kept = source.text.get(at..start).unwrap_or_default();
                match element {
                    Some(element) => {
                        text += kept;
                        text += &element.render();
                    }
                    // With the blanks and the line end before it.
                    None => text += kept.trim_end_matches([' ', '\t']).trim_end_matches(['\r', '\n']),
                }
                at = end;
            }
            text += source.text.get(at..).unwrap_or_default();
            texts.push(text);
        }
        if let Some(text) = texts.last_mut().filter(|_| !self.created.is_empty()) {
            let end = text.rfind("</osm>").unwrap_or(text.len());
            let at = text[..end].trim_end().len();
            let added: String = self.created.iter().map(|element| format!("\n  {}", element.render())).collect();
            text.insert_str(at, &added);
        }
        texts
    }
}

/// The element of the file that a subject is.
fn key_of(subject: Subject) -> Option<Key> {
    match subject {
        Subject::Map => None,
        Subject::Point(id) | Subject::Node(id) => Some((ElementKind::Node, id)),
        Subject::LineString(id) | Subject::Polygon(id) | Subject::Way(id) => Some((ElementKind::Way, id)),
        Subject::Lanelet(id) | Subject::RegulatoryElement(id) | Subject::Relation(id) => {
            Some((ElementKind::Relation, id))
        }
    }
}
