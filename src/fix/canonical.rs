//! The canonical form of OpenStreetMap XML: the same elements give the same bytes.
//!
//! Nodes, ways, relations by id; `version` on each, which osmium and JOSM want; latitude and longitude with 11 decimals;
//! `type` and `subtype` before the other tags, `local_x`, `local_y`, `ele` before those of a node, the rest by key. Members
//! and vertices keep their order, which means something. Nothing is left out: attributes, comments and elements that we do
//! not know are kept, behind those that we know.

use std::fmt::{self, Write};

use quick_xml::XmlVersion;
use quick_xml::escape::partial_escape;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use crate::osm::Tags;

/// Decimals of latitude and longitude: a micrometre.
const DECIMALS: usize = 11;

/// A part of the file.
struct Block {
    /// Rank of its kind, and its id; what is no map element comes first.
    order: (usize, i64),
    text: String,
}

/// What cannot be kept, so that nothing is formatted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unkept {
    /// What it is.
    pub what: &'static str,
    /// A way out.
    pub help: &'static str,
    /// Bytes from the begin of the text.
    pub offset: usize,
}

impl fmt::Display for Unkept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.what)
    }
}

const DOCTYPE: [&str; 2] =
    ["a document type (<!DOCTYPE) has no place in a map", "Lanelet2 reads none: remove it, and write entities out"];
const ENTITY: [&str; 2] = [
    "an attribute cannot be read: XML knows no such entity, or a quote is missing",
    "write it out: XML knows &amp;, &lt;, &gt;, &quot;, &apos; and numbers such as &#228;",
];
const TEXT: [&str; 2] = ["text between elements has no place in a map", "remove it, or put it into a comment <!-- -->"];
const BROKEN: [&str; 2] = ["this is no OpenStreetMap XML", "the file is damaged; export or download it again"];

/// The text in canonical form. Formatting twice changes nothing.
///
/// # Errors
///
/// If it is no OpenStreetMap XML, or holds what the canonical form cannot keep.
pub fn canonical(text: &str) -> Result<String, Unkept> {
    // Where the part begins that is looked at.
    let mut at = 0;
    formatted(text, &mut at).map_err(|[what, help]| Unkept { what, help, offset: at })
}

type Kept<T> = Result<T, [&'static str; 2]>;

fn formatted(text: &str, at: &mut usize) -> Kept<String> {
    let mut reader = Reader::from_str(text);
    let mut root = None;
    let mut blocks: Vec<Block> = Vec::new();
    loop {
        let start = position(&reader);
        *at = start;
        match reader.read_event().map_err(|_| BROKEN)? {
            Event::Start(tag) | Event::Empty(tag) if root.is_none() => {
                root = Some(head(&tag, &["version", "generator"], &[("version", "0.6")])?);
            }
            Event::Start(tag) => {
                let (tag, inner_start) = (tag.to_owned(), position(&reader));
                let inner = reader.read_to_end(tag.name()).map_err(|_| BROKEN)?;
                let inner = text.get(inner_start..inner.end as usize).ok_or(BROKEN)?;
                let whole = text.get(start..position(&reader)).ok_or(BROKEN)?;
                blocks.push(block(&tag, inner, whole, (inner_start, at))?);
            }
            Event::Empty(tag) => {
                let whole = text.get(start..position(&reader)).ok_or(BROKEN)?;
                blocks.push(block(&tag, "", whole, (start, at))?);
            }
            Event::Comment(_) | Event::PI(_) => {
                let whole = text.get(start..position(&reader)).ok_or(BROKEN)?;
                blocks.push(Block { order: (0, 0), text: whole.to_owned() });
            }
            Event::DocType(_) => return Err(DOCTYPE),
            Event::Decl(_) | Event::End(_) => {}
            Event::Eof => break,
            // Blanks, or text, whole or in pieces.
            _ if text.get(start..position(&reader)).ok_or(BROKEN)?.trim().is_empty() => {}
            _ if root.is_none() => return Err(BROKEN),
            _ => return Err(TEXT),
        }
    }
    *at = 0;
    let root = root.ok_or(BROKEN)?;
    blocks.sort_by_key(|block| block.order);
    let mut out = format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<{root}>\n");
    for block in blocks {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "  {}", block.text);
    }
    out += "</osm>\n";
    Ok(out)
}

fn position(reader: &Reader<&[u8]>) -> usize {
    reader.buffer_position() as usize
}

/// An element of the map, or anything else between them.
fn block(tag: &BytesStart<'_>, inner: &str, whole: &str, place: (usize, &mut usize)) -> Kept<Block> {
    let kind = match tag.name().as_ref() {
        "node" => 1,
        "way" => 2,
        "relation" => 3,
        _ => return Ok(Block { order: (0, 0), text: whole.to_owned() }),
    };
    let Some(id) = attribute(tag, "id").and_then(|id| id.trim().parse().ok()) else {
        return Ok(Block { order: (kind, i64::MIN), text: whole.to_owned() });
    };
    let mut text = format!("<{}", head(tag, &["id", "version"], &[("version", "1")])?);
    let children = children(inner, place)?;
    if children.is_empty() {
        text += "/>";
    } else {
        text.push('>');
        for child in children {
            let _ = write!(text, "\n    {child}");
        }
        let _ = write!(text, "\n  </{}>", tag.name().as_ref());
    }
    Ok(Block { order: (kind, id), text })
}

/// Vertices and members in their order, tags in ours, then the rest.
fn children(inner: &str, (begin, at): (usize, &mut usize)) -> Kept<Vec<String>> {
    let mut reader = Reader::from_str(inner);
    let (mut ordered, mut tags, mut rest) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        let start = position(&reader);
        *at = begin + start;
        let event = reader.read_event().map_err(|_| BROKEN)?;
        let (tag, has_children) = match event {
            Event::Start(tag) => {
                let (tag, inside) = (tag.to_owned(), position(&reader));
                let inside = inside..reader.read_to_end(tag.name()).map_err(|_| BROKEN)?.end as usize;
                (tag, !inner.get(inside).unwrap_or_default().trim().is_empty())
            }
            Event::Empty(tag) => (tag.to_owned(), false),
            Event::Eof => break,
            Event::Text(text) if text.trim().is_empty() => continue,
            _ => {
                rest.push(inner.get(start..position(&reader)).ok_or(BROKEN)?.trim().to_owned());
                continue;
            }
        };
        match tag.name().as_ref() {
            "nd" | "member" | "tag" if has_children => return Err(TEXT),
            "nd" => ordered.push(format!("<{}/>", head(&tag, &["ref"], &[])?)),
            "member" => ordered.push(format!("<{}/>", head(&tag, &["type", "ref", "role"], &[])?)),
            "tag" => {
                let key = attribute(&tag, "k").unwrap_or_default();
                tags.push((Tags::rank(key.as_bytes()), key, format!("<{}/>", head(&tag, &["k", "v"], &[])?)));
            }
            _ => rest.push(inner.get(start..position(&reader)).ok_or(BROKEN)?.trim().to_owned()),
        }
    }
    // Stable: where a key repeats, the last one still comes last.
    tags.sort_by(|a, b| (a.0, &a.1).cmp(&(b.0, &b.1)));
    ordered.extend(tags.into_iter().map(|(_, _, text)| text));
    ordered.extend(rest);
    Ok(ordered)
}

/// Name and attributes: those named first, those that must be there, the others as they come; latitude and longitude last.
fn head(tag: &BytesStart<'_>, first: &[&str], defaults: &[(&str, &str)]) -> Kept<String> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for attribute in tag.attributes().with_checks(false) {
        let attribute = attribute.map_err(|_| ENTITY)?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|_| ENTITY)?;
        pairs.push((attribute.key.as_ref().to_owned(), value.into_owned()));
    }
    for (key, value) in defaults {
        if !pairs.iter().any(|(known, _)| known == key) {
            pairs.push(((*key).to_owned(), (*value).to_owned()));
        }
    }
    let rank = |key: &str| match key {
        "lat" => first.len() + 1,
        "lon" => first.len() + 2,
        _ => first.iter().position(|one| *one == key).unwrap_or(first.len()),
    };
    pairs.sort_by_key(|(key, _)| rank(key));
    let mut text = tag.name().as_ref().to_owned();
    for (key, value) in pairs {
        let degrees = matches!(key.as_str(), "lat" | "lon").then(|| value.trim().parse::<f64>().ok()).flatten();
        let value = match degrees.filter(|degrees| degrees.is_finite()) {
            Some(degrees) => format!("{:.DECIMALS$}", degrees + 0.0),
            // An apostrophe stands as it is, as in what `build` writes.
            None => partial_escape(value.as_str())
                .replace('"', "&quot;")
                .replace('\n', "&#10;")
                .replace('\r', "&#13;")
                .replace('\t', "&#9;"),
        };
        let _ = write!(text, " {key}=\"{value}\"");
    }
    Ok(text)
}

fn attribute(tag: &BytesStart<'_>, key: &str) -> Option<String> {
    let attribute = tag.attributes().with_checks(false).flatten().find(|one| one.key.as_ref() == key)?;
    attribute.normalized_value(XmlVersion::Implicit1_0).ok().map(|value| value.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const WRITTEN: &str = r#"<?xml version='1.0'?>
<osm generator='VMB'>
<!-- of our town -->
<MetaInfo format_version='1' map_version='2'/>
 <relation id='5'><tag k='one_way' v='yes'/><member type='way' role='left' ref='4'/><tag k="subtype" v="road"/><tag k="type" v="lanelet"/></relation>
 <way id='4' version='7' user='a &amp; &quot;b&quot;&apos;s'><nd ref='2'/><nd ref='-1'/>
   <note>by hand</note></way>
 <node id='2' lat='1.5' lon='-0'/>
 <node lon='2' lat='' id='-1'><tag k='ele' v='0.10'/><tag k='local_x' v='a&#10;b'/></node>
</osm>
"#;

    const MEANT: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6" generator="VMB">
  <!-- of our town -->
  <MetaInfo format_version='1' map_version='2'/>
  <node id="-1" version="1" lat="" lon="2.00000000000">
    <tag k="local_x" v="a&#10;b"/>
    <tag k="ele" v="0.10"/>
  </node>
  <node id="2" version="1" lat="1.50000000000" lon="0.00000000000"/>
  <way id="4" version="7" user="a &amp; &quot;b&quot;'s">
    <nd ref="2"/>
    <nd ref="-1"/>
    <note>by hand</note>
  </way>
  <relation id="5" version="1">
    <member type="way" ref="4" role="left"/>
    <tag k="type" v="lanelet"/>
    <tag k="subtype" v="road"/>
    <tag k="one_way" v="yes"/>
  </relation>
</osm>
"#;

    #[test]
    fn whoever_wrote_it_it_is_written_so() {
        assert_eq!(canonical(WRITTEN).unwrap(), MEANT);
    }

    #[test]
    fn twice_is_once() {
        assert_eq!(canonical(MEANT).unwrap(), MEANT);
    }

    #[test]
    fn what_is_not_xml_is_left_alone() {
        for text in ["", "lanelets", "<osm><node id='1'></osm>", "<osm", "<osm><way id='1'>"] {
            assert_eq!(canonical(text).unwrap_err().what, BROKEN[0], "{text}");
        }
    }
}
