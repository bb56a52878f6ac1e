//! OpenStreetMap's data model and file formats: the only place that knows XML and PBF.
//!
//! [`OsmData`] holds what a file says, in file order, with the byte position of each element; it judges nothing
//! about roads or lanelets.

mod copies;
mod digits;
mod edit;
pub mod element;
mod error;
mod limits;
mod load;
mod pbf;
mod read;
mod replace;
mod tags;
mod write;

pub use crate::text::Text;
pub use copies::{Content, Contradiction};
pub use digits::fixed;
pub use edit::{attribute, kept, moved};
pub use error::ReadError;
pub use limits::{limit_input, most_input};
pub use load::load;
pub use read::{Block, Blocks, DataBlocks, read_bytes, read_file, read_files, refuse_off_earth};
pub use replace::Stretch;
pub use tags::Tags;
pub use write::OsmText;

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::projection::{Extent, LonLat};
use crate::text::SourceSpan;

/// The kind of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ElementKind {
    /// A point.
    Node,
    /// A list of nodes.
    Way,
    /// A list of members.
    Relation,
}

impl ElementKind {
    /// As files write it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::Way => "way",
            Self::Relation => "relation",
        }
    }
}

impl std::fmt::Display for ElementKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A point with tags.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Node {
    /// The id; may be negative (JOSM).
    pub id: i64,
    /// `None` if `lat` or `lon` is absent, not a number or out of range.
    pub position: Option<LonLat>,
    /// Tags in file order.
    pub tags: Tags,
    /// Its position in the file; it is not part of what is serialised.
    #[serde(skip)]
    pub span: SourceSpan,
}

/// A list of nodes with tags.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Way {
    /// The id; may be negative (JOSM).
    pub id: i64,
    /// Node ids in order; they need not exist.
    pub nodes: Vec<i64>,
    /// Tags in file order.
    pub tags: Tags,
    /// Its position in the file; it is not part of what is serialised.
    #[serde(skip)]
    pub span: SourceSpan,
}

/// One member of a relation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Member {
    /// Kind of the target.
    pub kind: ElementKind,
    /// Id of the target; it need not exist.
    pub id: i64,
    /// The role.
    pub role: Text,
}

/// A list of members with tags.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Relation {
    /// The id; may be negative (JOSM).
    pub id: i64,
    /// Members in order.
    pub members: Vec<Member>,
    /// Tags in file order.
    pub tags: Tags,
    /// Its position in the file; it is not part of what is serialised.
    #[serde(skip)]
    pub span: SourceSpan,
}

/// Something odd that reading could pass over.
#[derive(Clone, Debug, PartialEq)]
pub struct Oddity {
    /// Short name of its kind: `duplicate-id`, `bad-number`, `bad-attribute`, `unknown-element`.
    pub kind: OddityKind,
    /// The element it is about, where it has an id.
    pub element: Option<(ElementKind, i64)>,
    /// One line.
    pub message: String,
    /// Where it is.
    pub span: SourceSpan,
    /// Latitude and longitude as written, where they are numbers and no place on Earth.
    pub off_earth: Option<[f64; 2]>,
}

/// The kinds of [`Oddity`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OddityKind {
    /// The same id twice within one kind; both are kept in the lists, lookups find the last.
    DuplicateId,
    /// A coordinate that is absent, not a number or out of range.
    BadCoordinate,
    /// An element without a usable id, a reference or member without target: passed over.
    BadElement,
    /// As [`Self::BadElement`], of which Lanelet2's reader says nothing: it takes 0 for an id that is missing, the digits at the
    /// start of a reference for the whole, and leaves out a member without a type.
    UnsaidElement,
}

/// One file that was read.
#[derive(Clone, Debug)]
pub struct Source {
    /// As given by the user.
    pub name: String,
    /// The whole text, unpacked, without a byte-order mark; empty for PBF.
    pub text: String,
    /// Whether the file begins with a byte-order mark.
    pub marked: bool,
}

/// The byte-order mark of UTF-8, with which some editors begin a file.
const BYTE_ORDER_MARK: char = '\u{feff}';

impl Source {
    /// The text as it stands in the file.
    pub fn as_written(&self) -> String {
        let mark = self.marked.then_some(BYTE_ORDER_MARK);
        mark.into_iter().map(String::from).chain([self.text.clone()]).collect()
    }
}

/// `<MetaInfo>` of an Autoware map.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MetaInfo {
    /// `format_version` as written.
    pub format_version: Option<Text>,
    /// `map_version` as written.
    pub map_version: Option<Text>,
}

/// Places closer to the bounds of a file than this, degrees, lie on their rim: a metre of latitude, to which bounds are
/// written.
const RIM: f64 = 1e-5;

/// What one or several files say.
#[derive(Clone, Debug, Default)]
pub struct OsmData {
    /// The files, in reading order.
    pub sources: Vec<Source>,
    /// The last `<MetaInfo>` seen.
    pub meta: Option<MetaInfo>,
    /// `generator` of the last `<osm>`.
    pub generator: Option<Text>,
    /// What the files hold of the Earth: `<bounds>`, or the box in the header of a PBF; all of it where a file names none.
    pub bounds: Vec<Extent>,
    /// Elements in file order, without those of `action="delete"`.
    pub nodes: Vec<Node>,
    /// See [`OsmData::nodes`].
    pub ways: Vec<Way>,
    /// See [`OsmData::nodes`].
    pub relations: Vec<Relation>,
    /// What reading passed over.
    pub oddities: Vec<Oddity>,
    node_index: FxHashMap<i64, u32>,
    way_index: FxHashMap<i64, u32>,
    relation_index: FxHashMap<i64, u32>,
}

impl OsmData {
    /// The node of this id; the last one where an id repeats.
    pub fn node(&self, id: i64) -> Option<&Node> {
        self.nodes.get(self.node_position(id)?)
    }

    /// The position in [`OsmData::nodes`] of the node of this id; of the last one where an id repeats.
    pub fn node_position(&self, id: i64) -> Option<usize> {
        self.node_index.get(&id).map(|&at| at as usize)
    }

    /// The way of this id; the last one where an id repeats.
    pub fn way(&self, id: i64) -> Option<&Way> {
        self.way_index.get(&id).and_then(|&i| self.ways.get(i as usize))
    }

    /// The relation of this id; the last one where an id repeats.
    pub fn relation(&self, id: i64) -> Option<&Relation> {
        self.relation_index.get(&id).and_then(|&i| self.relations.get(i as usize))
    }

    /// Whether the files hold what lies around a place: whether it lies within their bounds, and not on their rim.
    pub fn reaches_beyond(&self, place: LonLat) -> bool {
        let around = [-RIM, RIM].into_iter().flat_map(|lat| [-RIM, RIM].map(|lon| (lat, lon)));
        let mut corners = around.map(|(lat, lon)| LonLat { lon: place.lon + lon, lat: place.lat + lat });
        self.bounds.is_empty() || corners.all(|corner| self.bounds.iter().any(|bounds| bounds.contains(corner)))
    }

    /// Notes what a file holds of the Earth; a box that is none says nothing.
    fn push_bounds(&mut self, bounds: Extent) {
        if bounds.min.lat < bounds.max.lat && bounds.min.lon < bounds.max.lon {
            self.bounds.push(bounds);
        }
    }

    /// Whether the element exists.
    pub fn contains(&self, kind: ElementKind, id: i64) -> bool {
        match kind {
            ElementKind::Node => self.node_index.contains_key(&id),
            ElementKind::Way => self.way_index.contains_key(&id),
            ElementKind::Relation => self.relation_index.contains_key(&id),
        }
    }

    /// Adds what another part of the same file says, behind what is here. The index does not know of it yet.
    fn append(&mut self, mut part: Self) {
        self.meta = part.meta.or(self.meta.take());
        self.generator = part.generator.or(self.generator.take());
        self.bounds.append(&mut part.bounds);
        self.nodes.append(&mut part.nodes);
        self.ways.append(&mut part.ways);
        self.relations.append(&mut part.relations);
        self.oddities.append(&mut part.oddities);
    }

    /// Frees the memory of all elements; the texts of the files stay.
    pub fn forget_elements(&mut self) {
        let Self { sources, meta, generator, bounds, oddities, .. } = std::mem::take(self);
        *self = Self { sources, meta, generator, bounds, oddities, ..Self::default() };
    }

    /// How many nodes, ways and relations there are.
    fn counts(&self) -> [usize; 3] {
        [self.nodes.len(), self.ways.len(), self.relations.len()]
    }

    /// Makes the elements behind these many known by their ids; repeated ones are noted as oddities.
    fn index(&mut self, [nodes, ways, relations]: [usize; 3]) {
        let mut of_ways = || index(&self.ways, ways, &mut self.way_index);
        let mut of_relations = || index(&self.relations, relations, &mut self.relation_index);
        let others = || [of_ways(), of_relations()].concat();
        let (of_nodes, others) = rayon::join(|| index(&self.nodes, nodes, &mut self.node_index), others);
        self.oddities.extend(of_nodes.into_iter().chain(others));
    }

    /// Adds a node; a repeated id is noted as an oddity.
    pub fn push_node(&mut self, node: Node) {
        self.nodes.push(node);
        self.oddities.extend(index(&self.nodes, self.nodes.len() - 1, &mut self.node_index));
    }

    /// Adds a way; a repeated id is noted as an oddity.
    pub fn push_way(&mut self, way: Way) {
        self.ways.push(way);
        self.oddities.extend(index(&self.ways, self.ways.len() - 1, &mut self.way_index));
    }

    /// Adds a relation; a repeated id is noted as an oddity.
    pub fn push_relation(&mut self, relation: Relation) {
        self.relations.push(relation);
        self.oddities.extend(index(&self.relations, self.relations.len() - 1, &mut self.relation_index));
    }
}

/// Indexes the elements from one on by their ids, and reports ids that repeat.
fn index<E: Element>(elements: &[E], from: usize, index: &mut FxHashMap<i64, u32>) -> Vec<Oddity> {
    index.reserve(elements.len() - from);
    let repeated = |(at, element): (usize, &E)| {
        let (kind, id, span) = element.identity();
        index.insert(id, at as u32)?;
        let message = format!("{kind} id {id} is used twice");
        Some(Oddity {
            kind: OddityKind::DuplicateId,
            element: Some((kind, id)),
            message,
            span: span.clone(),
            off_earth: None,
        })
    };
    elements.iter().enumerate().skip(from).filter_map(repeated).collect()
}

/// What nodes, ways and relations have in common.
trait Element {
    /// Its id, and its position in the file.
    fn identity(&self) -> (ElementKind, i64, &SourceSpan);
}

impl Element for Node {
    fn identity(&self) -> (ElementKind, i64, &SourceSpan) {
        (ElementKind::Node, self.id, &self.span)
    }
}

impl Element for Way {
    fn identity(&self) -> (ElementKind, i64, &SourceSpan) {
        (ElementKind::Way, self.id, &self.span)
    }
}

impl Element for Relation {
    fn identity(&self) -> (ElementKind, i64, &SourceSpan) {
        (ElementKind::Relation, self.id, &self.span)
    }
}
