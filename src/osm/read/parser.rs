//! Reads the elements of OpenStreetMap XML from a text or a part of one.

use std::ops::Range;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use crate::cancel;
use crate::osm::pbf::MAX_REFERENCES;
use crate::osm::{
    ElementKind, Member, MetaInfo, Node, Oddity, OddityKind, OsmData, ReadError, Relation, Tags, Text, Way,
};
use crate::projection::{Extent, LonLat};
use crate::text::SourceSpan;

/// Bytes between two looks whether the reading was cancelled.
const LOOK: usize = 1 << 20;

/// The element that is open while its children are read.
enum Open {
    Node(Node),
    Way(Way),
    Relation(Relation),
    /// Passed over with all its children: deleted, or without a usable id.
    Skipped,
}

/// Reads one text into `data`.
pub struct Parser<'a> {
    pub data: &'a mut OsmData,
    pub file: u32,
    pub name: &'a str,
    pub text: &'a str,
}

/// The reader's position in the tree of elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// How many elements are open: 1 between the children of the root.
    pub depth: usize,
    /// Whether the root was opened.
    pub seen_root: bool,
}

impl Place {
    /// Between the children of the root.
    pub const IN_ROOT: Self = Self { depth: 1, seen_root: true };
}

impl Parser<'_> {
    /// Reads a range of the text that begins at this place; returns the place where it ends.
    pub fn run(&mut self, range: Range<usize>, mut place: Place) -> Result<Place, ReadError> {
        let mut reader = Reader::from_str(&self.text[range.clone()]);
        // `event` checks the end of an element that was open before the range.
        reader.config_mut().allow_unmatched_ends = place.depth > 0;
        let mut open: Option<Open> = None;
        let mut looked = 0;
        loop {
            let start = range.start + reader.buffer_position() as usize;
            if start > looked + LOOK {
                cancel::look();
                looked = start;
            }
            let event = reader.read_event().map_err(|error| {
                self.broken(
                    range.start + reader.error_position() as usize,
                    format!("not well-formed XML: {error}"),
                    "the file is damaged or cut off here; export or download it again",
                )
            })?;
            if matches!(event, Event::Eof) {
                return Ok(place);
            }
            let end = range.start + reader.buffer_position() as usize;
            self.event(&event, start..end, &mut place, &mut open)?;
        }
    }

    fn event(
        &mut self,
        event: &Event<'_>,
        at: Range<usize>,
        place: &mut Place,
        open: &mut Option<Open>,
    ) -> Result<(), ReadError> {
        match event {
            Event::Start(tag) => {
                self.start(tag, at, place, open)?;
                place.depth += 1;
            }
            Event::Empty(tag) => {
                let end = at.end;
                self.start(tag, at, place, open)?;
                if place.depth == 1 {
                    self.close(open.take(), end);
                }
            }
            Event::End(tag) if place.depth == 0 || (place.depth == 1 && tag.name().as_ref() != "osm") => {
                let message = format!("</{}> closes nothing", tag.name().as_ref());
                return Err(self.broken(at.start, message, "the file is damaged here; export or download it again"));
            }
            Event::End(_) => {
                place.depth = place.depth.saturating_sub(1);
                if place.depth == 1 {
                    self.close(open.take(), at.end);
                }
            }
            Event::Text(content) if place.depth == 0 && !content.trim().is_empty() => {
                return Err(self.broken(
                    at.start,
                    "this is not XML".to_owned(),
                    "expected OpenStreetMap XML, which begins with <?xml or <osm",
                ));
            }
            _ => {}
        }
        Ok(())
    }

    /// The begin of an element, whose meaning depends on how deep it lies.
    fn start(
        &mut self,
        tag: &BytesStart<'_>,
        at: Range<usize>,
        place: &mut Place,
        open: &mut Option<Open>,
    ) -> Result<(), ReadError> {
        match place.depth {
            0 => {
                self.root(tag, at.start)?;
                place.seen_root = true;
            }
            1 => *open = self.element(tag, at)?,
            2 => self.child(tag, at.start, open.as_mut())?,
            _ => {}
        }
        Ok(())
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

    /// A child of the root.
    fn element(&mut self, tag: &BytesStart<'_>, at: Range<usize>) -> Result<Option<Open>, ReadError> {
        let name = tag.name();
        let Some(kind) = element_kind(name.as_ref()) else {
            match name.as_ref() {
                "MetaInfo" => self.meta(tag),
                "bounds" => self.bounds(tag),
                _ => {}
            }
            return Ok(None);
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
        let span = self.span(at.start, at.end);
        let Some(id) = id else {
            self.odd(OddityKind::UnsaidElement, None, format!("{kind} without an integer id is passed over"), span);
            return Ok(Some(Open::Skipped));
        };
        let tags = Tags::new();
        Ok(Some(match kind {
            ElementKind::Node => {
                let position = self.position(id, lat.zip(lon), &span);
                Open::Node(Node { id, position, tags, span })
            }
            ElementKind::Way => Open::Way(Way { id, nodes: Vec::new(), tags, span }),
            ElementKind::Relation => Open::Relation(Relation { id, members: Vec::new(), tags, span }),
        }))
    }

    /// The position of a node by its latitude and longitude (deg).
    fn position(&mut self, id: i64, said: Option<(f64, f64)>, span: &SourceSpan) -> Option<LonLat> {
        let Some((lat, lon)) = said else {
            let message = format!("node {id} has no usable lat and lon");
            self.odd(OddityKind::BadCoordinate, Some((ElementKind::Node, id)), message, span.clone());
            return None;
        };
        if !(-90.0..=90.0).contains(&lat) || !(-180.0..=180.0).contains(&lon) {
            let message = format!("node {id} lies at latitude {lat}, longitude {lon}, which is not on Earth");
            self.odd(OddityKind::BadCoordinate, Some((ElementKind::Node, id)), message, span.clone());
            if let Some(odd) = self.data.oddities.last_mut() {
                odd.off_earth = Some([lat, lon]);
            }
            return None;
        }
        Some(LonLat { lon, lat })
    }

    /// A child of a node, way or relation.
    fn child(&mut self, tag: &BytesStart<'_>, start: usize, open: Option<&mut Open>) -> Result<(), ReadError> {
        let name = tag.name();
        match (name.as_ref(), open) {
            ("tag", Some(Open::Node(Node { tags, .. }) | Open::Way(Way { tags, .. }))) => push_tag(tag, tags),
            ("tag", Some(Open::Relation(relation))) => push_tag(tag, &mut relation.tags),
            ("nd", Some(Open::Way(way))) => self.node_reference(tag, start, way)?,
            ("member", Some(Open::Relation(relation))) => self.member(tag, start, relation)?,
            _ => {}
        }
        Ok(())
    }

    /// `<nd ref="…"/>`.
    fn node_reference(&mut self, tag: &BytesStart<'_>, start: usize, way: &mut Way) -> Result<(), ReadError> {
        let (mut reference, mut digits) = (None, false);
        for attribute in tag.attributes().with_checks(false).flatten().filter(|one| one.key.as_ref() == "ref") {
            reference = attribute.value.trim().parse::<i64>().ok();
            digits = begins_with_digits(&attribute.value);
        }
        match reference {
            Some(_) if way.nodes.len() >= MAX_REFERENCES => {
                let message = format!("way {} has more than {MAX_REFERENCES} nodes", way.id);
                return Err(self.broken(start, message, "split the way; OpenStreetMap allows 2,000 nodes in one"));
            }
            Some(id) => way.nodes.push(id),
            None => {
                let message = format!("way {} has a node reference that is not a number", way.id);
                let element = Some((ElementKind::Way, way.id));
                self.odd(passed_over(digits), element, message, self.span(start, start + 1));
            }
        }
        Ok(())
    }

    /// `<member type="…" ref="…" role="…"/>`.
    fn member(&mut self, tag: &BytesStart<'_>, start: usize, relation: &mut Relation) -> Result<(), ReadError> {
        let (mut kind, mut reference, mut digits, mut role) = (None, None, false, Text::default());
        for attribute in tag.attributes().with_checks(false).flatten() {
            match attribute.key.as_ref() {
                "ref" => {
                    reference = attribute.value.trim().parse::<i64>().ok();
                    digits = begins_with_digits(&attribute.value);
                }
                "type" => kind = element_kind(&attribute.value),
                "role" => role = value(&attribute),
                _ => {}
            }
        }
        match kind.zip(reference) {
            Some(_) if relation.members.len() >= MAX_REFERENCES => {
                let message = format!("relation {} has more than {MAX_REFERENCES} members", relation.id);
                return Err(self.broken(start, message, "split the relation"));
            }
            Some((kind, id)) => relation.members.push(Member { kind, id, role }),
            None => {
                let message = format!("relation {} has a member without type or ref", relation.id);
                let element = Some((ElementKind::Relation, relation.id));
                self.odd(passed_over(kind.is_none() || digits), element, message, self.span(start, start + 1));
            }
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
        self.data.oddities.push(Oddity { kind, element, message, span, off_earth: None });
    }

    pub fn broken(&self, offset: usize, message: String, help: &'static str) -> ReadError {
        broken(self.name, self.text, offset, message, help)
    }
}

/// What is wrong at a place of a text, in bytes from its start.
pub fn broken(name: &str, text: &str, offset: usize, message: String, help: &'static str) -> ReadError {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    let before = &text[..offset];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    ReadError::Broken {
        name: name.to_owned(),
        line: before.matches('\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
        offset,
        text: String::new(),
        message,
        help,
    }
}

/// `<tag k="…" v="…"/>`.
fn push_tag(tag: &BytesStart<'_>, tags: &mut Tags) {
    let (mut key, mut val) = (None, Text::default());
    for attribute in tag.attributes().with_checks(false).flatten() {
        match attribute.key.as_ref() {
            "k" => key = Some(value(&attribute)),
            "v" => val = value(&attribute),
            _ => {}
        }
    }
    if let Some(key) = key {
        tags.push(key, val);
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

/// The kind of what is passed over, by whether Lanelet2's reader says nothing of it.
const fn passed_over(unsaid: bool) -> OddityKind {
    if unsaid { OddityKind::UnsaidElement } else { OddityKind::BadElement }
}

fn begins_with_digits(text: &str) -> bool {
    let text = text.trim_start();
    text.strip_prefix(['+', '-']).unwrap_or(text).starts_with(|first: char| first.is_ascii_digit())
}
