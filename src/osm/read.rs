//! Reads OpenStreetMap XML, plain or gzip, with the byte position of every element: small files in one pass over a
//! slice, large ones in parts that all threads read at the same time.

use crate::cancel;
use crate::diagnostic::SourceSpan;
use crate::projection::{Extent, LonLat};

use super::load::load;
use super::pbf::MAX_REFERENCES;
use super::{
    ElementKind, Member, MetaInfo, Node, Oddity, OddityKind, OsmData, ReadError, Relation, Source, Tags, Text, Way, pbf,
};
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

mod parts;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

/// Bytes that a packed file may hold: a country of XML. A small file can be packed so that it fills any memory.
const MOST_UNPACKED: u64 = 8 << 30;

/// After so many bytes it is looked whether the reading was called off.
const LOOK: usize = 1 << 20;

/// Reads one file.
pub fn read_file(path: &Path) -> Result<OsmData, ReadError> {
    read_files(&[path.to_path_buf()])
}

/// Reads several files into one map, in the given order.
pub fn read_files(paths: &[PathBuf]) -> Result<OsmData, ReadError> {
    let mut data = OsmData::default();
    for path in paths {
        let bytes = load(path).map_err(|source| ReadError::Io { path: path.clone(), source })?;
        read_bytes(&mut data, &path.display().to_string(), bytes)?;
    }
    Ok(data)
}

/// Adds the content of one file, XML (unpacked where it is gzip) or PBF, to `data`. After an error, `data` holds what was
/// read up to there.
pub fn read_bytes(data: &mut OsmData, name: &str, bytes: Vec<u8>) -> Result<(), ReadError> {
    let (known, bounds, oddities) = (data.counts(), data.bounds.len(), data.oddities.len());
    let read = read_content(data, name, bytes);
    data.index(known);
    data.oddities[oddities..].sort_by_key(|oddity| oddity.span.start);
    read?;
    if data.bounds.len() == bounds {
        data.push_bounds(Extent::EARTH);
    }
    Ok(())
}

fn read_content(data: &mut OsmData, name: &str, bytes: Vec<u8>) -> Result<(), ReadError> {
    if pbf::is_pbf(&bytes) {
        return pbf::read(data, name, &bytes);
    }
    let bytes = if bytes.starts_with(&[0x1f, 0x8b]) { unpack(name, &bytes)? } else { bytes };
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(ReadError::Empty { name: name.to_owned() });
    }
    // Without the byte-order mark, so that offsets are those of the kept text.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").map(<[u8]>::to_vec).unwrap_or(bytes);
    let text = String::from_utf8(bytes)
        .map_err(|error| ReadError::NotText { name: name.to_owned(), offset: error.utf8_error().valid_up_to() })?;
    let file = data.sources.len() as u32;
    if let Err(mut error) = parse(data, file, name, &text) {
        // The error shows the place in the text, so it takes the text along; a copy could be large.
        if let ReadError::Broken { text: shown, .. } = &mut error {
            *shown = text;
        }
        return Err(error);
    }
    data.sources.push(Source { name: name.to_owned(), text });
    Ok(())
}

fn unpack(name: &str, packed: &[u8]) -> Result<Vec<u8>, ReadError> {
    let failed = |message: String| ReadError::Packed { name: name.to_owned(), message };
    let mut bytes = Vec::new();
    let mut unpacked = flate2::read::MultiGzDecoder::new(packed).take(MOST_UNPACKED);
    unpacked.read_to_end(&mut bytes).map_err(|error| failed(error.to_string()))?;
    if unpacked.limit() == 0 {
        return Err(failed(format!("it holds more than {} GB", MOST_UNPACKED >> 30)));
    }
    Ok(bytes)
}

/// The element that is open while its children are read.
enum Open {
    Node(Node),
    Way(Way),
    Relation(Relation),
    /// Passed over with all its children: deleted, or without a usable id.
    Skipped,
}

struct Parser<'a> {
    data: &'a mut OsmData,
    file: u32,
    name: &'a str,
    text: &'a str,
}

fn parse(data: &mut OsmData, file: u32, name: &str, text: &str) -> Result<(), ReadError> {
    if let Some(parts) = parts::parse(file, name, text) {
        data.nodes.reserve(parts.iter().map(|part| part.nodes.len()).sum());
        parts.into_iter().for_each(|part| data.append(part));
        return Ok(());
    }
    let mut parser = Parser { data, file, name, text };
    match parser.run(0..text.len(), Place::default())? {
        Place { depth: 1.., .. } => Err(parser.broken(
            text.len(),
            "the file ends in the middle of an element".to_owned(),
            "the file is cut off; export or download it again",
        )),
        Place { seen_root: false, .. } => Err(parser.broken(
            0,
            "there is no <osm> element".to_owned(),
            "expected OpenStreetMap XML, which begins with <?xml or <osm",
        )),
        _ => Ok(()),
    }
}

/// Where in the tree of elements reading stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Place {
    /// How many elements are open: 1 between the children of the root.
    depth: usize,
    /// Whether the root was opened.
    seen_root: bool,
}

impl Place {
    /// Between the children of the root.
    const IN_ROOT: Self = Self { depth: 1, seen_root: true };
}

impl Parser<'_> {
    /// Reads a range of the text that begins at this place, and says at which place it ends.
    fn run(&mut self, range: Range<usize>, Place { mut depth, mut seen_root }: Place) -> Result<Place, ReadError> {
        let mut reader = Reader::from_str(&self.text[range.clone()]);
        // The end of an element that was open before is seen to below.
        reader.config_mut().allow_unmatched_ends = depth > 0;
        let mut open: Option<Open> = None;
        let mut looked = 0;
        loop {
            let start = range.start + reader.buffer_position() as usize;
            if start > looked + LOOK {
                cancel::look();
                looked = start;
            }
            let event = match reader.read_event() {
                Ok(event) => event,
                Err(error) => {
                    return Err(self.broken(
                        range.start + reader.error_position() as usize,
                        format!("not well-formed XML: {error}"),
                        "the file is damaged or cut off here; export or download it again",
                    ));
                }
            };
            let end = range.start + reader.buffer_position() as usize;
            match event {
                Event::Start(tag) => {
                    match depth {
                        0 => {
                            self.root(&tag, start)?;
                            seen_root = true;
                        }
                        1 => open = self.element(&tag, start, end)?,
                        2 => self.child(&tag, start, open.as_mut())?,
                        _ => {}
                    }
                    depth += 1;
                }
                Event::Empty(tag) => match depth {
                    0 => {
                        self.root(&tag, start)?;
                        seen_root = true;
                    }
                    1 => {
                        let whole = self.element(&tag, start, end)?;
                        self.close(whole, end);
                    }
                    2 => self.child(&tag, start, open.as_mut())?,
                    _ => {}
                },
                Event::End(tag) if depth == 0 || (depth == 1 && tag.name().as_ref() != "osm") => {
                    let message = format!("</{}> closes nothing", tag.name().as_ref());
                    return Err(self.broken(start, message, "the file is damaged here; export or download it again"));
                }
                Event::End(_) => {
                    depth = depth.saturating_sub(1);
                    if depth == 1 {
                        self.close(open.take(), end);
                    }
                }
                Event::Text(content) if depth == 0 && !content.trim().is_empty() => {
                    return Err(self.broken(
                        start,
                        "this is not XML".to_owned(),
                        "expected OpenStreetMap XML, which begins with <?xml or <osm",
                    ));
                }
                Event::Eof => break,
                _ => {}
            }
        }
        Ok(Place { depth, seen_root })
    }

    fn root(&mut self, tag: &BytesStart<'_>, start: usize) -> Result<(), ReadError> {
        let name = tag.name();
        // osmChange and overpass' <osm-derived> are other formats; JOSM, VMB and the API all write <osm>.
        if name.as_ref() != "osm" {
            return Err(self.broken(
                start,
                format!("the document is <{}>, not <osm>", name.as_ref()),
                "expected OpenStreetMap XML, whose root element is <osm>",
            ));
        }
        for attribute in tag.attributes().with_checks(false).flatten() {
            if attribute.key.as_ref() == "generator" {
                self.data.generator = Some(value(&attribute));
            }
        }
        Ok(())
    }

    fn element(&mut self, tag: &BytesStart<'_>, start: usize, end: usize) -> Result<Option<Open>, ReadError> {
        let name = tag.name();
        let kind = match name.as_ref() {
            "node" => ElementKind::Node,
            "way" => ElementKind::Way,
            "relation" => ElementKind::Relation,
            "MetaInfo" => {
                self.meta(tag);
                return Ok(None);
            }
            "bounds" => {
                self.bounds(tag);
                return Ok(None);
            }
            _ => return Ok(None),
        };
        let (mut id, mut lat, mut lon, mut deleted) = (None, None, None, false);
        for attribute in tag.attributes().with_checks(false).flatten() {
            match attribute.key.as_ref() {
                "id" => id = attribute.value.trim().parse::<i64>().ok(),
                "lat" => lat = attribute.value.trim().parse::<f64>().ok(),
                "lon" => lon = attribute.value.trim().parse::<f64>().ok(),
                "action" => deleted = attribute.value == "delete",
                _ => {}
            }
        }
        if deleted {
            return Ok(Some(Open::Skipped));
        }
        let span = self.span(start, end);
        let Some(id) = id else {
            self.odd(OddityKind::BadElement, None, format!("{kind} without an integer id is passed over"), span);
            return Ok(Some(Open::Skipped));
        };
        let tags = Tags::new();
        Ok(Some(match kind {
            ElementKind::Node => {
                let position = match (lat, lon) {
                    (Some(lat), Some(lon)) => {
                        if !(-90.0..=90.0).contains(&lat) || !(-180.0..=180.0).contains(&lon) {
                            return Err(self.broken(
                                start,
                                format!("node {id} lies at latitude {lat}, longitude {lon}, which is not on Earth"),
                                "latitudes run from -90 to 90, longitudes from -180 to 180; are the two swapped?",
                            ));
                        }
                        Some(LonLat { lon, lat })
                    }
                    _ => {
                        let message = format!("node {id} has no usable lat and lon");
                        self.odd(OddityKind::BadCoordinate, Some((kind, id)), message, span.clone());
                        None
                    }
                };
                Open::Node(Node { id, position, tags, span })
            }
            ElementKind::Way => Open::Way(Way { id, nodes: Vec::new(), tags, span }),
            ElementKind::Relation => Open::Relation(Relation { id, members: Vec::new(), tags, span }),
        }))
    }

    fn child(&mut self, tag: &BytesStart<'_>, start: usize, open: Option<&mut Open>) -> Result<(), ReadError> {
        let Some(open) = open else { return Ok(()) };
        let name = tag.name();
        let (mut key, mut val, mut reference, mut kind, mut role) = (None, None, None, None, None);
        for attribute in tag.attributes().with_checks(false).flatten() {
            match attribute.key.as_ref() {
                "k" => key = Some(value(&attribute)),
                "v" => val = Some(value(&attribute)),
                "ref" => reference = attribute.value.trim().parse::<i64>().ok(),
                "type" => kind = element_kind(&attribute.value),
                "role" => role = Some(value(&attribute)),
                _ => {}
            }
        }
        let too_many = |count: usize| count >= MAX_REFERENCES;
        match (name.as_ref(), open) {
            (_, Open::Skipped) => {}
            ("tag", open) => {
                let tags = match open {
                    Open::Node(node) => &mut node.tags,
                    Open::Way(way) => &mut way.tags,
                    Open::Relation(relation) => &mut relation.tags,
                    Open::Skipped => return Ok(()),
                };
                if let Some(key) = key {
                    tags.push(key, val.unwrap_or_default());
                }
            }
            ("nd", Open::Way(way)) => match reference {
                Some(_) if too_many(way.nodes.len()) => {
                    let message = format!("way {} has more than {MAX_REFERENCES} nodes", way.id);
                    return Err(self.broken(start, message, "split the way; OpenStreetMap allows 2,000 nodes in one"));
                }
                Some(id) => way.nodes.push(id),
                None => {
                    let message = format!("way {} has a node reference that is not a number", way.id);
                    let element = Some((ElementKind::Way, way.id));
                    self.odd(OddityKind::BadElement, element, message, self.span(start, start + 1));
                }
            },
            ("member", Open::Relation(relation)) => match (kind, reference) {
                (Some(_), Some(_)) if too_many(relation.members.len()) => {
                    let message = format!("relation {} has more than {MAX_REFERENCES} members", relation.id);
                    return Err(self.broken(start, message, "split the relation"));
                }
                (Some(kind), Some(id)) => {
                    relation.members.push(Member { kind, id, role: role.unwrap_or_default() });
                }
                _ => {
                    let message = format!("relation {} has a member without type or ref", relation.id);
                    let element = Some((ElementKind::Relation, relation.id));
                    self.odd(OddityKind::BadElement, element, message, self.span(start, start + 1));
                }
            },
            _ => {}
        }
        Ok(())
    }

    fn close(&mut self, open: Option<Open>, end: usize) {
        let end = end as u64;
        match open {
            Some(Open::Node(mut node)) => {
                node.span.end = end;
                self.data.nodes.push(node);
            }
            Some(Open::Way(mut way)) => {
                way.span.end = end;
                self.data.ways.push(way);
            }
            Some(Open::Relation(mut relation)) => {
                relation.span.end = end;
                self.data.relations.push(relation);
            }
            Some(Open::Skipped) | None => {}
        }
    }

    fn meta(&mut self, tag: &BytesStart<'_>) {
        let mut meta = MetaInfo::default();
        for attribute in tag.attributes().with_checks(false).flatten() {
            match attribute.key.as_ref() {
                "format_version" => meta.format_version = Some(value(&attribute)),
                "map_version" => meta.map_version = Some(value(&attribute)),
                _ => {}
            }
        }
        self.data.meta = Some(meta);
    }

    fn bounds(&mut self, tag: &BytesStart<'_>) {
        let [mut min_lat, mut min_lon, mut max_lat, mut max_lon] = [None; 4];
        for attribute in tag.attributes().with_checks(false).flatten() {
            let side = match attribute.key.as_ref() {
                "minlat" => &mut min_lat,
                "minlon" => &mut min_lon,
                "maxlat" => &mut max_lat,
                "maxlon" => &mut max_lon,
                _ => continue,
            };
            *side = attribute.value.trim().parse::<f64>().ok();
        }
        let corner = |lon: Option<f64>, lat: Option<f64>| Some(LonLat { lon: lon?, lat: lat? });
        if let (Some(min), Some(max)) = (corner(min_lon, min_lat), corner(max_lon, max_lat)) {
            self.data.push_bounds(Extent { min, max });
        }
    }

    fn span(&self, start: usize, end: usize) -> SourceSpan {
        SourceSpan { file: self.file, start: start as u64, end: end as u64 }
    }

    fn odd(&mut self, kind: OddityKind, element: Option<(ElementKind, i64)>, message: String, span: SourceSpan) {
        self.data.oddities.push(Oddity { kind, element, message, span });
    }

    fn broken(&self, offset: usize, message: String, help: &'static str) -> ReadError {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &self.text[..offset];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        ReadError::Broken {
            name: self.name.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            offset,
            text: String::new(),
            message,
            help,
        }
    }
}

fn element_kind(word: &str) -> Option<ElementKind> {
    match word {
        "node" => Some(ElementKind::Node),
        "way" => Some(ElementKind::Way),
        "relation" => Some(ElementKind::Relation),
        _ => None,
    }
}

/// The value of an attribute; one with an unknown entity stays as written.
fn value(attribute: &quick_xml::events::attributes::Attribute<'_>) -> Text {
    if !attribute.value.contains(['&', '\n', '\t', '\r']) {
        return Text::from(attribute.value.as_ref());
    }
    match attribute.normalized_value(XmlVersion::Implicit1_0) {
        Ok(value) => Text::from(value.as_ref()),
        Err(_) => Text::from(attribute.value.as_ref()),
    }
}

#[cfg(test)]
mod tests;
