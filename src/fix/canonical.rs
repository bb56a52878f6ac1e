//! The canonical form of OpenStreetMap XML: the same elements give the same bytes.
//!
//! Nodes, ways, relations by id; `version` on each, which osmium and JOSM want; latitude and longitude with 11 decimals;
//! `type` and `subtype` before the other tags, `local_x`, `local_y`, `ele` before those of a node, the rest by key. Members
//! and vertices keep their order, which means something. Nothing is left out: attributes, comments and elements that we do
//! not know are kept, behind those that we know.

use std::fmt::Write;

use quick_xml::XmlVersion;
use quick_xml::escape::escape;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

/// Decimals of latitude and longitude: a micrometre.
const DECIMALS: usize = 11;

/// Tags that come first, in this order; the others follow by key.
const FIRST: [&str; 5] = ["type", "subtype", "local_x", "local_y", "ele"];

/// A part of the file.
struct Block {
    /// Rank of its kind, and its id; what is no map element comes first.
    order: (usize, i64),
    text: String,
}

/// The text in canonical form; `None` if it is no OpenStreetMap XML. Formatting twice changes nothing.
pub fn canonical(text: &str) -> Option<String> {
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = Reader::from_str(text);
    let mut root = None;
    let mut blocks: Vec<Block> = Vec::new();
    loop {
        let start = position(&reader)?;
        match reader.read_event().ok()? {
            Event::Start(tag) if root.is_none() => {
                root = Some(head(&tag, &["version", "generator"], &[("version", "0.6")])?)
            }
            Event::Empty(tag) if root.is_none() => {
                let root = head(&tag, &["version", "generator"], &[("version", "0.6")])?;
                return Some(format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<{root}>\n</osm>\n"));
            }
            Event::Start(tag) => {
                let (tag, inner_start) = (tag.to_owned(), position(&reader)?);
                let inner = reader.read_to_end(tag.name()).ok()?;
                let inner = text.get(inner_start..usize::try_from(inner.end).ok()?)?;
                let whole = text.get(start..position(&reader)?)?;
                blocks.push(block(&tag, inner, whole)?);
            }
            Event::Empty(tag) => blocks.push(block(&tag, "", text.get(start..position(&reader)?)?)?),
            Event::Comment(_) | Event::PI(_) | Event::DocType(_) => {
                blocks.push(Block { order: (0, 0), text: text.get(start..position(&reader)?)?.to_owned() });
            }
            Event::Eof => break,
            _ => {}
        }
    }
    let root = root?;
    blocks.sort_by_key(|block| block.order);
    let mut out = format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<{root}>\n");
    for block in blocks {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "  {}", block.text);
    }
    out += "</osm>\n";
    Some(out)
}

fn position(reader: &Reader<&[u8]>) -> Option<usize> {
    usize::try_from(reader.buffer_position()).ok()
}

/// An element of the map, or anything else between them.
fn block(tag: &BytesStart<'_>, inner: &str, whole: &str) -> Option<Block> {
    let kind = match tag.name().as_ref() {
        "node" => 1,
        "way" => 2,
        "relation" => 3,
        _ => return Some(Block { order: (0, 0), text: whole.to_owned() }),
    };
    let Some(id) = attribute(tag, "id").and_then(|id| id.trim().parse().ok()) else {
        return Some(Block { order: (kind, i64::MIN), text: whole.to_owned() });
    };
    let mut text = format!("<{}", head(tag, &["id", "version"], &[("version", "1")])?);
    let children = children(inner)?;
    if children.is_empty() {
        text += "/>";
    } else {
        text.push('>');
        for child in children {
            let _ = write!(text, "\n    {child}");
        }
        let _ = write!(text, "\n  </{}>", tag.name().as_ref());
    }
    Some(Block { order: (kind, id), text })
}

/// Vertices and members in their order, tags in ours, then the rest.
fn children(inner: &str) -> Option<Vec<String>> {
    let mut reader = Reader::from_str(inner);
    let (mut ordered, mut tags, mut rest) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        let start = position(&reader)?;
        let event = reader.read_event().ok()?;
        let tag = match event {
            Event::Start(tag) => {
                let tag = tag.to_owned();
                reader.read_to_end(tag.name()).ok()?;
                tag
            }
            Event::Empty(tag) => tag.to_owned(),
            Event::Eof => break,
            Event::Text(text) if text.trim().is_empty() => continue,
            _ => {
                rest.push(inner.get(start..position(&reader)?)?.trim().to_owned());
                continue;
            }
        };
        match tag.name().as_ref() {
            "nd" => ordered.push(format!("<{}/>", head(&tag, &["ref"], &[])?)),
            "member" => ordered.push(format!("<{}/>", head(&tag, &["type", "ref", "role"], &[])?)),
            "tag" => {
                let key = attribute(&tag, "k").unwrap_or_default();
                let rank = FIRST.iter().position(|first| *first == key).unwrap_or(FIRST.len());
                tags.push((rank, key, format!("<{}/>", head(&tag, &["k", "v"], &[])?)));
            }
            _ => rest.push(inner.get(start..position(&reader)?)?.trim().to_owned()),
        }
    }
    // Stable: where a key repeats, the last one still comes last.
    tags.sort_by(|a, b| (a.0, &a.1).cmp(&(b.0, &b.1)));
    ordered.extend(tags.into_iter().map(|(_, _, text)| text));
    ordered.extend(rest);
    Some(ordered)
}

/// Name and attributes: those named first, those that must be there, the others as they come; latitude and longitude last.
fn head(tag: &BytesStart<'_>, first: &[&str], defaults: &[(&str, &str)]) -> Option<String> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for attribute in tag.attributes().with_checks(false) {
        let attribute = attribute.ok()?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).ok()?;
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
            None => escape(value.as_str()).replace('\n', "&#10;").replace('\r', "&#13;").replace('\t', "&#9;"),
        };
        let _ = write!(text, " {key}=\"{value}\"");
    }
    Some(text)
}

fn attribute(tag: &BytesStart<'_>, key: &str) -> Option<String> {
    let attribute = tag.attributes().with_checks(false).flatten().find(|one| one.key.as_ref() == key)?;
    attribute.normalized_value(XmlVersion::Implicit1_0).ok().map(|value| value.into_owned())
}

#[cfg(test)]
mod tests {
    use super::canonical;

    const WRITTEN: &str = r#"<?xml version='1.0'?>
<osm generator='VMB'>
<!-- of our town -->
<MetaInfo format_version='1' map_version='2'/>
 <relation id='5'><tag k='one_way' v='yes'/><member type='way' role='left' ref='4'/><tag k="subtype" v="road"/><tag k="type" v="lanelet"/></relation>
 <way id='4' version='7' user='a &amp; b'><nd ref='2'/><nd ref='-1'/>
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
  <way id="4" version="7" user="a &amp; b">
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
            assert_eq!(canonical(text), None, "{text}");
        }
    }
}
