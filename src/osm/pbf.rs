//! Reads OpenStreetMap PBF: blobs are decoded in parallel and kept in file order.
//!
//! PBF keeps coordinates in whole nanodegrees; divided by 1e9 they are the same numbers that the XML of the same
//! extract gives, to the last bit.

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};

use osmpbf::{Blob, BlobDecode, BlobReader, Element, HeaderBBox, PrimitiveBlock, RelMemberType};
use rayon::prelude::*;

use crate::cancel;
use crate::parallel::InSmallParts;
use crate::projection::{Extent, LonLat};
use crate::text::SourceSpan;

use super::limits::most_input;
use super::{ElementKind, Member, Node, OsmData, ReadError, Relation, Source, Tags, Text, Way};

/// More node references or members than this in one element is damage or an attack, not a map: OpenStreetMap allows
/// 2,000 nodes in a way and 32,000 members in a relation.
pub const MAX_REFERENCES: usize = 1_000_000;

/// What a header may demand of its reader: <https://wiki.openstreetmap.org/wiki/PBF_Format>. A file with another feature, such as
/// `HistoricalInformation` (what was deleted stands in it), would be misread.
const FEATURES: [&str; 2] = ["OsmSchema-V0.6", "DenseNodes"];

/// Whether these bytes begin like a PBF file: a length, then a blob header that names its type `OSMHeader`.
pub fn is_pbf(bytes: &[u8]) -> bool {
    matches!(bytes, [0, _, _, _, rest @ ..] if rest.len() > 16 && rest.windows(9).take(12).any(|w| w == b"OSMHeader"))
}

/// Bytes that the elements of one block may take in memory. Packed, a block has at most 32 MB, but its elements may all have
/// the same long tag.
const MOST_IN_BLOCK: usize = 64 << 20;

/// Adds the content of a PBF file to `data`, whose elements may take `most` bytes in memory.
pub fn read(data: &mut OsmData, name: &str, bytes: &[u8], most: u64) -> Result<(), ReadError> {
    let file = data.sources.len() as u32;
    let blobs = BlobReader::new(Cursor::new(bytes)).collect::<Result<Vec<_>, _>>();
    let blobs = blobs.map_err(|error| damaged(name, error.to_string()))?;
    decode(data, name, file, &blobs, most)?;
    data.sources.push(Source { name: name.to_owned(), text: String::new(), marked: false });
    Ok(())
}

/// Blobs that are decoded at the same time: enough for many threads, and 8,000 elements each at most.
const BLOBS: usize = 32;

/// What a PBF file says, some blobs at a time.
pub struct PbfBlocks {
    name: String,
    blobs: BlobReader<BufReader<File>>,
}

impl PbfBlocks {
    /// Begins to read a file from its first byte on.
    pub fn new(name: String, file: File) -> Self {
        Self { name, blobs: BlobReader::new(BufReader::new(file)) }
    }

    /// What the next blobs say; `None` at the end of the file.
    ///
    /// # Errors
    ///
    /// If the file cannot be read further, or is damaged.
    pub fn next_block(&mut self) -> Result<Option<OsmData>, ReadError> {
        let blobs = self.blobs.by_ref().take(BLOBS).collect::<Result<Vec<_>, _>>();
        let blobs = blobs.map_err(|error| damaged(&self.name, error.to_string()))?;
        let mut data = OsmData::default();
        decode(&mut data, &self.name, 0, &blobs, most_input())?;
        Ok((!blobs.is_empty()).then_some(data))
    }
}

fn damaged(name: &str, message: String) -> ReadError {
    ReadError::Pbf { name: name.to_owned(), message }
}

/// Adds what blobs say to `data`, in their order. It may take `most` bytes in memory.
fn decode(data: &mut OsmData, name: &str, file: u32, blobs: &[Blob], most: u64) -> Result<(), ReadError> {
    let decode = |blob: &Blob| match blob.decode()? {
        BlobDecode::OsmData(block) => Part::of(&block, file),
        BlobDecode::OsmHeader(header) => {
            let foreign = header.required_features().iter().find(|one| !FEATURES.contains(&one.as_str()));
            Ok(Part { bounds: header.bbox().map(extent), feature: foreign.cloned(), ..Part::default() })
        }
        BlobDecode::Unknown(_) => Ok(Part::default()),
    };
    // The decoder panics on what no program writes: a member of an unknown kind, ids that overflow. It has nothing to lose
    // but the blob, so the panic can stop here.
    let guarded = |blob: &Blob| catch_unwind(AssertUnwindSafe(|| decode(blob)));
    // Behind a block that is too long, or once there is too much of all, nothing is decoded: it could fill the memory.
    let (held, too_long) = (AtomicU64::new(0), AtomicUsize::new(usize::MAX));
    let read_blob = |(at, blob)| {
        if held.load(Relaxed) > most || too_long.load(Relaxed) < at {
            return Ok(Ok(Part::default()));
        }
        let part = guarded(blob);
        if let Ok(Ok(part)) = &part {
            held.fetch_add(part.held as u64, Relaxed);
            part.too_long.iter().for_each(|_| _ = too_long.fetch_min(at, Relaxed));
        }
        part
    };
    let parts: Vec<_> = blobs.par_iter().enumerate().in_small_parts().map(read_blob).collect();
    if held.into_inner() > most {
        return Err(ReadError::TooLarge { name: name.to_owned(), most });
    }
    for part in parts {
        let part = part.map_err(|payload| {
            cancel::pass_on(payload);
            damaged(name, "a block holds values that no program writes".to_owned())
        })?;
        let part = part.map_err(|error| damaged(name, error.to_string()))?;
        if let Some(feature) = part.feature {
            return Err(ReadError::PbfFeature { name: name.to_owned(), feature });
        }
        if let Some(message) = part.too_long {
            return Err(damaged(name, message));
        }
        part.bounds.into_iter().for_each(|bounds| data.push_bounds(bounds));
        data.nodes.extend(part.nodes);
        data.ways.extend(part.ways);
        data.relations.extend(part.relations);
    }
    Ok(())
}

/// What one blob holds.
#[derive(Default)]
struct Part {
    bounds: Option<Extent>,
    nodes: Vec<Node>,
    ways: Vec<Way>,
    relations: Vec<Relation>,
    /// Bytes that its elements take in memory.
    held: usize,
    too_long: Option<String>,
    /// A feature of the file that this reader has not.
    feature: Option<String>,
}

impl Part {
    fn of(block: &PrimitiveBlock, file: u32) -> Result<Self, osmpbf::Error> {
        let mut part = Self::default();
        let span = SourceSpan { file, start: 0, end: 0 };
        let mut failed = None;
        block.for_each_element(|element| {
            let outcome = part.push(element, &span);
            failed = failed.take().or(outcome.err());
        });
        failed.map_or(Ok(part), Err)
    }

    fn push(&mut self, element: Element<'_>, span: &SourceSpan) -> Result<(), osmpbf::Error> {
        if self.too_long.is_some() {
            return Ok(());
        }
        let span = span.clone();
        match element {
            Element::Node(n) => self.push_node(n.id(), place(n.nano_lon(), n.nano_lat()), n.tags(), span),
            Element::DenseNode(n) => self.push_node(n.id(), place(n.nano_lon(), n.nano_lat()), n.tags(), span),
            Element::Way(w) => {
                if w.raw_refs().len() > MAX_REFERENCES {
                    self.too_long = Some(format!("way {} has more than {MAX_REFERENCES} nodes", w.id()));
                    return Ok(());
                }
                if !self.holds(size_of::<Way>() + size_of_val(w.raw_refs())) {
                    return Ok(());
                }
                let tags = self.tags(w.tags());
                self.ways.push(Way { id: w.id(), nodes: w.refs().collect(), tags, span });
            }
            Element::Relation(r) => {
                let mut members = Vec::new();
                for m in r.members() {
                    let kind = match m.member_type {
                        RelMemberType::Node => ElementKind::Node,
                        RelMemberType::Way => ElementKind::Way,
                        RelMemberType::Relation => ElementKind::Relation,
                    };
                    let role = m.role()?;
                    if !self.holds(size_of::<Member>() + role.len()) {
                        return Ok(());
                    }
                    members.push(Member { kind, id: m.member_id, role: Text::from(role) });
                }
                if !self.holds(size_of::<Relation>()) {
                    return Ok(());
                }
                let tags = self.tags(r.tags());
                self.relations.push(Relation { id: r.id(), members, tags, span });
            }
        }
        Ok(())
    }

    fn push_node<'a>(
        &mut self,
        id: i64,
        position: Option<LonLat>,
        tags: impl Iterator<Item = (&'a str, &'a str)>,
        span: SourceSpan,
    ) {
        if self.holds(size_of::<Node>()) {
            let tags = self.tags(tags);
            self.nodes.push(Node { id, position, tags, span });
        }
    }

    fn tags<'a>(&mut self, tags: impl Iterator<Item = (&'a str, &'a str)>) -> Tags {
        tags.take_while(|(key, value)| self.holds(key.len() + value.len())).collect()
    }

    /// Whether the block may take so many bytes more; once it may not, it is no map.
    fn holds(&mut self, bytes: usize) -> bool {
        self.held += bytes;
        if self.held > MOST_IN_BLOCK {
            self.too_long = Some(format!("the elements of one block take more than {} MB", MOST_IN_BLOCK >> 20));
        }
        self.too_long.is_none()
    }
}

/// The box of a header, to the last bit as XML would give it.
fn extent(bbox: HeaderBBox) -> Extent {
    let degrees = |value: f64| (value * 1e9).round() / 1e9;
    let [west, south, east, north] = [bbox.left, bbox.bottom, bbox.right, bbox.top].map(degrees);
    Extent { min: LonLat { lon: west, lat: south }, max: LonLat { lon: east, lat: north } }
}

/// From nanodegrees; `None` off the Earth.
fn place(lon: i64, lat: i64) -> Option<LonLat> {
    let position = LonLat { lon: lon as f64 / 1e9, lat: lat as f64 / 1e9 };
    ((-180.0..=180.0).contains(&position.lon) && (-90.0..=90.0).contains(&position.lat)).then_some(position)
}
