//! One of the versions, seen with the ids that its elements have in the result.

use std::borrow::Cow;

use rustc_hash::FxHashMap;

use super::content::Content;
use super::id_tags;
use super::versions::Key;
use crate::diagnostic::{SourceSpan, Subject};
use crate::osm::element::{Child, Element};
use crate::osm::{ElementKind, Member, OsmData, OsmText, Tags};
use crate::projection::LonLat;

/// A version of the map.
pub(super) struct View<'a> {
    pub(super) osm: &'a OsmData,
    /// The new ids of elements, by the old ones.
    new: FxHashMap<Key, i64>,
    /// The old ids, by the new ones.
    old: FxHashMap<Key, i64>,
}

impl<'a> View<'a> {
    pub(super) fn new(osm: &'a OsmData) -> Self {
        Self { osm, new: FxHashMap::default(), old: FxHashMap::default() }
    }

    /// With new ids for some elements.
    pub(super) fn renumbered(osm: &'a OsmData, new: &FxHashMap<Key, i64>) -> Self {
        let old = new.iter().map(|(&(kind, id), &new)| ((kind, new), id)).collect();
        Self { osm, new: new.clone(), old }
    }

    /// Its elements in the order of the file: nodes, ways, relations. Where an id repeats, it comes as often.
    pub(super) fn keys(&self) -> impl Iterator<Item = Key> {
        let nodes = self.osm.nodes.iter().map(|one| (ElementKind::Node, one.id));
        let ways = self.osm.ways.iter().map(|one| (ElementKind::Way, one.id));
        let relations = self.osm.relations.iter().map(|one| (ElementKind::Relation, one.id));
        nodes.chain(ways).chain(relations).map(|(kind, id)| (kind, self.to_new((kind, id))))
    }

    fn to_new(&self, key: Key) -> i64 {
        self.new.get(&key).copied().unwrap_or(key.1)
    }

    /// Its own id for an element; `None` where it gives that id to another one.
    fn own(&self, key: Key) -> Option<Key> {
        match self.old.get(&key) {
            Some(old) => Some((key.0, *old)),
            None if self.new.contains_key(&key) => None,
            None => Some(key),
        }
    }

    pub(super) fn has(&self, key: Key) -> bool {
        self.own(key).is_some_and(|(kind, id)| self.osm.contains(kind, id))
    }

    /// Where an element stands in the file.
    pub(super) fn span(&self, key: Key) -> Option<&'a SourceSpan> {
        let (kind, id) = self.own(key)?;
        match kind {
            ElementKind::Node => self.osm.node(id).map(|one| &one.span),
            ElementKind::Way => self.osm.way(id).map(|one| &one.span),
            ElementKind::Relation => self.osm.relation(id).map(|one| &one.span),
        }
    }

    fn tags(&self, key: Key) -> Option<&'a Tags> {
        let (kind, id) = self.own(key)?;
        match kind {
            ElementKind::Node => self.osm.node(id).map(|one| &one.tags),
            ElementKind::Way => self.osm.way(id).map(|one| &one.tags),
            ElementKind::Relation => self.osm.relation(id).map(|one| &one.tags),
        }
    }

    /// What an element says.
    pub(super) fn content(&self, key: Key) -> Option<Content> {
        let mut content = Content::of(self.osm, self.own(key)?)?;
        if !self.new.is_empty() {
            content.nodes.iter_mut().for_each(|id| *id = self.to_new((ElementKind::Node, *id)));
            content.members.iter_mut().for_each(|one| one.id = self.to_new((one.kind, one.id)));
            let tags = content.tags.iter().map(|(key, value)| id_tags::renamed(key, value, &self.new));
            content.tags = tags.map(|(key, value)| (key.into_owned(), value.into_owned())).collect();
        }
        Some(content)
    }

    /// What an element refers to: vertices, members, and what tags name.
    pub(super) fn references(&self, key: Key) -> Vec<Key> {
        let mut found = self.own(key).map(|own| self.own_references(own)).unwrap_or_default();
        found.iter_mut().filter(|_| !self.new.is_empty()).for_each(|key| key.1 = self.to_new(*key));
        found
    }

    /// The same by its own ids.
    fn own_references(&self, (kind, id): Key) -> Vec<Key> {
        let (mut found, tags): (Vec<Key>, _) = match kind {
            ElementKind::Node => (Vec::new(), self.osm.node(id).map(|one| &one.tags)),
            ElementKind::Way => match self.osm.way(id) {
                Some(way) => (way.nodes.iter().map(|id| (ElementKind::Node, *id)).collect(), Some(&way.tags)),
                None => return Vec::new(),
            },
            ElementKind::Relation => match self.osm.relation(id) {
                Some(one) => (one.members.iter().map(|one| (one.kind, one.id)).collect(), Some(&one.tags)),
                None => return Vec::new(),
            },
        };
        found.extend(tags.into_iter().flat_map(Tags::iter).flat_map(|(key, value)| id_tags::named(key, value)));
        found
    }

    /// The text of an element, as it stands in the file but for ids that are new; one that is made, where the file is no text.
    pub(super) fn text(&self, key: Key) -> Option<Cow<'a, str>> {
        let own = self.own(key)?;
        let span = self.span(key)?;
        let source = self.osm.sources.get(span.file as usize).map_or("", |source| source.text.as_str());
        let text = match source.get(usize::try_from(span.start).ok()?..usize::try_from(span.end).ok()?) {
            Some(text) if !text.is_empty() => Cow::Borrowed(text),
            _ => Cow::Owned(self.made(own)?),
        };
        if self.new.is_empty() || (own == key && !self.own_references(own).iter().any(|key| self.new.contains_key(key)))
        {
            return Some(text);
        }
        let mut element = Element::parse(&text, MARGIN)?;
        element.set_attribute("id", &key.1.to_string());
        element.replace(|child| match child {
            Child::Vertex(id) => Some(Child::Vertex(*self.new.get(&(ElementKind::Node, *id))?)),
            Child::Member(kind, id, role) => Some(Child::Member(*kind, *self.new.get(&(*kind, *id))?, role.clone())),
            _ => None,
        });
        for (key, value) in self.tags(key)?.iter() {
            let (new_key, new_value) = id_tags::renamed(key, value, &self.new);
            if new_key != key {
                element.remove(|child| *child == Child::Tag(key.to_owned()));
            }
            if (new_key.as_ref(), new_value.as_ref()) != (key, value) {
                element.set_tag(&new_key, &new_value);
            }
        }
        Some(Cow::Owned(element.render()))
    }

    /// The text of an element in canonical form.
    fn made(&self, (kind, id): Key) -> Option<String> {
        let mut text = OsmText::default();
        match kind {
            ElementKind::Node => text.put_node(self.osm.node(id)?),
            ElementKind::Way => text.put_way(self.osm.way(id)?),
            ElementKind::Relation => text.put_relation(self.osm.relation(id)?),
        }
        Some(String::from_utf8_lossy(text.as_bytes()).trim().to_owned())
    }

    /// What an element is, in the words of reports.
    pub(super) fn subject(&self, key: Key) -> Option<Subject> {
        let tags = self.tags(key)?;
        let (kind, id) = key;
        Some(match kind {
            ElementKind::Node => Subject::Point(id),
            ElementKind::Way if matches!(tags.get("area"), Some("yes" | "true")) => Subject::Polygon(id),
            ElementKind::Way => Subject::LineString(id),
            ElementKind::Relation => match tags.get("type") {
                Some("lanelet") => Subject::Lanelet(id),
                Some("regulatory_element") => Subject::RegulatoryElement(id),
                _ => Subject::Relation(id),
            },
        })
    }

    /// Where an element lies: a node, or the middle of what it is made of first.
    pub(super) fn place(&self, key: Key) -> Option<LonLat> {
        /// Regulatory elements refer to lanelets, those to ways, those to nodes.
        const DEEPEST: usize = 4;
        let mut at = key;
        for _ in 0..DEEPEST {
            let (kind, id) = self.own(at)?;
            at = match kind {
                ElementKind::Node => return self.osm.node(id)?.position.filter(|place| *place != LonLat::default()),
                ElementKind::Way => {
                    let nodes = &self.osm.way(id)?.nodes;
                    (ElementKind::Node, self.to_new((ElementKind::Node, *nodes.get(nodes.len() / 2)?)))
                }
                ElementKind::Relation => {
                    let Member { kind, id, .. } = self.osm.relation(id)?.members.first()?;
                    (*kind, self.to_new((*kind, *id)))
                }
            };
        }
        None
    }
}

/// What stands before an element of a map that is written one tag a line.
pub(super) const MARGIN: &str = "\n  ";

/// An element of which no more is known.
pub(super) const fn plain((kind, id): Key) -> Subject {
    match kind {
        ElementKind::Node => Subject::Node(id),
        ElementKind::Way => Subject::Way(id),
        ElementKind::Relation => Subject::Relation(id),
    }
}

/// The like with another id.
pub(super) const fn with_id(subject: Subject, id: i64) -> Subject {
    match subject {
        Subject::Map => Subject::Map,
        Subject::Point(_) => Subject::Point(id),
        Subject::LineString(_) => Subject::LineString(id),
        Subject::Polygon(_) => Subject::Polygon(id),
        Subject::Lanelet(_) => Subject::Lanelet(id),
        Subject::RegulatoryElement(_) => Subject::RegulatoryElement(id),
        Subject::Node(_) => Subject::Node(id),
        Subject::Way(_) => Subject::Way(id),
        Subject::Relation(_) => Subject::Relation(id),
    }
}
