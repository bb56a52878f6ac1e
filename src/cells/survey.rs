//! What must be known of a map to divide it: ids, places, references. Tags and texts are passed over.

use rustc_hash::FxHashSet;

use crate::geometry::Point;
use crate::lanelet::{is_area, positions};
use crate::osm::{Content, ElementKind, MetaInfo, Node, OsmData, Relation, Tags, Text, Way};
use crate::projection::Projector;

use super::ids::{Ids, Lists};
use super::{DivideError, NAMING};

/// What a map holds, in the order of its files. A position is that among the elements of a kind, without the copies.
#[derive(Debug, Default)]
pub struct Survey {
    /// Nodes and their places in the plane.
    pub nodes: Shelf,
    pub places: Vec<Point>,
    /// Ways, the positions of their nodes or [`GONE`], and whether they are areas.
    pub ways: Shelf,
    pub way_nodes: Lists<u32>,
    /// Nodes that ways have before the nodes come: where in the lists, and the id.
    ahead: Vec<(usize, i64)>,
    pub areas: Vec<bool>,
    /// Relations, their members, what they are.
    pub relations: Shelf,
    pub members: Lists<(ElementKind, i64)>,
    pub relation_is: Vec<Is>,
    /// Ways, and relations, that name a way in a tag: by position, with the id of the way.
    pub way_names: Vec<(u32, i64)>,
    pub relation_names: Vec<(u32, i64)>,
    /// What stands before the elements of the map.
    pub meta: MetaInfo,
    pub generator: Option<Text>,
    /// What the map seems to be.
    pub lanelet2: bool,
    pub roads: usize,
    /// The names of the files, of which there may be several.
    pub files: Vec<String>,
}

/// The position of a node that is not there.
pub const GONE: u32 = u32::MAX;

/// What a relation is to its neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Is {
    /// A lanelet with the ways of its left and right bound, where they are named.
    Lanelet([Option<i64>; 2]),
    RegulatoryElement,
    Other,
}

/// The elements of one kind.
#[derive(Debug, Default)]
pub struct Shelf {
    pub ids: Ids,
    /// Elements that are copies of one in an earlier file, by their number in all files.
    pub copies: FxHashSet<u32>,
    /// Elements that share their id with an earlier one of the same file: positions of that one and of this.
    pub repeats: Vec<(u32, u32)>,
    /// Of each element what it says and its file, where there are several files.
    contents: Vec<(u64, u32)>,
    /// Elements seen, with copies.
    seen: u32,
}

/// Bytes of a map for each of its nodes, and for each reference, at the least.
const BYTES_EACH: u64 = 256;

impl Survey {
    /// Begins the next file, of so many bytes.
    pub fn begin_file(&mut self, name: &str, bytes: u64) {
        self.files.push(name.to_owned());
        let most = (bytes / BYTES_EACH) as usize;
        self.nodes.ids.reserve(most);
        self.places.reserve(most);
        self.way_nodes.reserve(most);
        self.members.reserve(most / 2);
    }

    /// Adds what a block says. With several files, what each element says is remembered.
    pub fn add(&mut self, data: &OsmData, projector: &Projector, several: bool) -> Result<(), DivideError> {
        if let Some(meta) = &data.meta {
            self.meta = meta.clone();
            self.lanelet2 |= meta.format_version.is_some();
        }
        self.generator = data.generator.clone().or(self.generator.take());
        for (node, place) in data.nodes.iter().zip(positions(&data.nodes, projector)) {
            if self.file_away(ElementKind::Node, node.id, several.then_some(node))? {
                self.places.push(place);
            }
        }
        for way in &data.ways {
            self.way(way, several)?;
        }
        for relation in &data.relations {
            self.relation(relation, several)?;
        }
        Ok(())
    }

    /// Ends the last file: now all nodes are known.
    pub fn end(&mut self) {
        for (at, id) in self.ahead.drain(..) {
            if let Some((place, node)) = self.way_nodes.items_mut().get_mut(at).zip(self.nodes.ids.find(id)) {
                *place = node;
            }
        }
    }

    fn way(&mut self, way: &Way, several: bool) -> Result<(), DivideError> {
        self.roads += usize::from(way.tags.has("highway"));
        let position = self.ways.ids.len() as u32;
        if self.file_away(ElementKind::Way, way.id, several.then_some(way))? {
            let before = self.way_nodes.items();
            let at = |id: &i64| self.nodes.ids.find(*id).unwrap_or(GONE);
            self.way_nodes.push(way.nodes.iter().map(at));
            let gone = way.nodes.iter().enumerate().filter(|(_, id)| self.nodes.ids.find(**id).is_none());
            self.ahead.extend(gone.map(|(i, id)| (before + i, *id)));
            self.areas.push(is_area(&way.tags));
            self.way_names.extend(named(&way.tags).map(|id| (position, id)));
        }
        Ok(())
    }

    fn relation(&mut self, relation: &Relation, several: bool) -> Result<(), DivideError> {
        let position = self.relations.ids.len() as u32;
        if !self.file_away(ElementKind::Relation, relation.id, several.then_some(relation))? {
            return Ok(());
        }
        self.members.push(relation.members.iter().map(|member| (member.kind, member.id)));
        self.relation_names.extend(named(&relation.tags).map(|id| (position, id)));
        let bound = |role: &str| {
            let mut ways = relation.members.iter().filter(|member| member.kind == ElementKind::Way);
            ways.find(|member| member.role == role).map(|member| member.id)
        };
        self.relation_is.push(match relation.tags.get("type") {
            Some("lanelet") => Is::Lanelet(["left", "right"].map(bound)),
            Some("regulatory_element") => Is::RegulatoryElement,
            _ => Is::Other,
        });
        self.lanelet2 |= self.relation_is.last() != Some(&Is::Other);
        Ok(())
    }

    /// Adds an id to its shelf; whether the element is new, and no copy.
    fn file_away(&mut self, kind: ElementKind, id: i64, content: Option<&impl Content>) -> Result<bool, DivideError> {
        let file = self.files.len().saturating_sub(1) as u32;
        let shelf = match kind {
            ElementKind::Node => &mut self.nodes,
            ElementKind::Way => &mut self.ways,
            ElementKind::Relation => &mut self.relations,
        };
        let said = content.map(|content| (content.fingerprint(), file));
        let differs = |first: u32| DivideError::Contradiction {
            first: self.files.get(first as usize).cloned().unwrap_or_default(),
            second: self.files.last().cloned().unwrap_or_default(),
            kind,
            id,
        };
        shelf.file_away(id, said, differs)
    }
}

impl Shelf {
    fn file_away(
        &mut self,
        id: i64,
        said: Option<(u64, u32)>,
        differs: impl Fn(u32) -> DivideError,
    ) -> Result<bool, DivideError> {
        let number = self.seen;
        self.seen = number.checked_add(1).filter(|next| *next < u32::MAX).ok_or(DivideError::TooMany)?;
        if let (Some((content, file)), Some(first)) = (said, self.ids.find(id))
            && let Some((_, first_file)) = self.contents.get(first as usize).filter(|(_, of)| *of != file)
        {
            let others = self.repeats.iter().filter(|(of, _)| *of == first).map(|(_, other)| *other);
            let mut all = std::iter::once(first).chain(others);
            if all.any(|at| self.contents.get(at as usize).is_some_and(|(known, _)| *known == content)) {
                self.copies.insert(number);
                return Ok(false);
            }
            return Err(differs(*first_file));
        }
        let position = self.ids.len() as u32;
        self.contents.extend(said);
        if let Some(first) = self.ids.push(id) {
            self.repeats.push((first, position));
        }
        Ok(true)
    }
}

/// The ways that the tags of an element name.
fn named(tags: &Tags) -> impl Iterator<Item = i64> {
    NAMING.iter().filter_map(|key| tags.get(key)?.trim().parse().ok())
}

/// The first node that has a place on the Earth, and whether any has a place of its own in the plane: what tells the projector
/// of a map without a file for it.
#[derive(Debug, Default)]
pub struct Hints {
    pub first: Option<Node>,
    pub local: Option<Node>,
}

impl Hints {
    /// Looks at a block; whether all is known.
    pub fn look(&mut self, data: &OsmData) -> bool {
        let placed = |node: &&Node| node.position.is_some_and(|place| place != Default::default());
        let local = |node: &&Node| node.tags.has("local_x") || node.tags.has("local_y");
        self.first = self.first.take().or_else(|| data.nodes.iter().find(placed).cloned());
        self.local = self.local.take().or_else(|| data.nodes.iter().find(local).cloned());
        self.first.is_some()
    }

    /// As much of the map as tells the projector.
    pub fn data(self) -> OsmData {
        let mut data = OsmData::default();
        self.first.into_iter().chain(self.local).for_each(|node| data.nodes.push(node));
        data
    }
}
