//! Writes OpenStreetMap XML, one tag a line, so that a small change of a map is a small change of its text.

use std::io::{self, BufWriter, Write};

use super::{ElementKind, MetaInfo};
use crate::projection::LonLat;

/// Decimals of latitude and longitude: a micrometre.
const DECIMALS: usize = 11;

/// Writes one file. Elements come out in the order of the calls; JOSM and Lanelet2 like nodes, ways, relations.
#[derive(Debug)]
pub struct OsmWriter<W: Write> {
    out: BufWriter<W>,
}

impl<W: Write> OsmWriter<W> {
    /// Opens the document.
    pub fn new(out: W, meta: &MetaInfo) -> io::Result<Self> {
        let mut out = BufWriter::new(out);
        out.write_all(b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<osm version=\"0.6\" generator=\"lanewright\">\n")?;
        let versions = [("format_version", &meta.format_version), ("map_version", &meta.map_version)];
        if versions.iter().any(|(_, v)| v.is_some()) {
            out.write_all(b"  <MetaInfo")?;
            for (name, version) in versions {
                if let Some(version) = version {
                    write!(out, " {name}=\"")?;
                    escaped(&mut out, version)?;
                    out.write_all(b"\"")?;
                }
            }
            out.write_all(b"/>\n")?;
        }
        Ok(Self { out })
    }

    /// A node; without a place, `lat` and `lon` are empty, as in other editors' maps without projection.
    pub fn node<'t>(
        &mut self,
        id: i64,
        place: Option<LonLat>,
        tags: impl IntoIterator<Item = (&'t str, &'t str)>,
    ) -> io::Result<()> {
        match place {
            Some(LonLat { lon, lat }) => write!(
                self.out,
                "  <node id=\"{id}\" version=\"1\" lat=\"{:.DECIMALS$}\" lon=\"{:.DECIMALS$}\"",
                lat + 0.0,
                lon + 0.0
            )?,
            None => write!(self.out, "  <node id=\"{id}\" version=\"1\" lat=\"\" lon=\"\"")?,
        }
        let mut tags = tags.into_iter().peekable();
        if tags.peek().is_none() {
            return self.out.write_all(b"/>\n");
        }
        self.out.write_all(b">\n")?;
        self.tags(tags)?;
        self.out.write_all(b"  </node>\n")
    }

    /// A way.
    pub fn way<'t>(
        &mut self,
        id: i64,
        nodes: impl IntoIterator<Item = i64>,
        tags: impl IntoIterator<Item = (&'t str, &'t str)>,
    ) -> io::Result<()> {
        writeln!(self.out, "  <way id=\"{id}\" version=\"1\">")?;
        for node in nodes {
            writeln!(self.out, "    <nd ref=\"{node}\"/>")?;
        }
        self.tags(tags)?;
        self.out.write_all(b"  </way>\n")
    }

    /// A relation.
    pub fn relation<'t>(
        &mut self,
        id: i64,
        members: impl IntoIterator<Item = (ElementKind, i64, &'t str)>,
        tags: impl IntoIterator<Item = (&'t str, &'t str)>,
    ) -> io::Result<()> {
        writeln!(self.out, "  <relation id=\"{id}\" version=\"1\">")?;
        for (kind, target, role) in members {
            write!(self.out, "    <member type=\"{kind}\" ref=\"{target}\" role=\"")?;
            escaped(&mut self.out, role)?;
            self.out.write_all(b"\"/>\n")?;
        }
        self.tags(tags)?;
        self.out.write_all(b"  </relation>\n")
    }

    /// Closes the document.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.write_all(b"</osm>\n")?;
        self.out.flush()
    }

    fn tags<'t>(&mut self, tags: impl IntoIterator<Item = (&'t str, &'t str)>) -> io::Result<()> {
        for (key, value) in tags {
            self.out.write_all(b"    <tag k=\"")?;
            escaped(&mut self.out, key)?;
            self.out.write_all(b"\" v=\"")?;
            escaped(&mut self.out, value)?;
            self.out.write_all(b"\"/>\n")?;
        }
        Ok(())
    }
}

/// The text of an attribute. Line breaks and tabs would be read back as blanks if they stood bare; what XML cannot hold
/// becomes a replacement character.
fn escaped(out: &mut impl Write, text: &str) -> io::Result<()> {
    let mut plain = 0;
    for (at, letter) in text.char_indices() {
        let instead = match letter {
            '&' => "&amp;",
            '<' => "&lt;",
            '>' => "&gt;",
            '"' => "&quot;",
            '\n' => "&#10;",
            '\r' => "&#13;",
            '\t' => "&#9;",
            '\0'..'\u{20}' | '\u{fffe}' | '\u{ffff}' => "\u{fffd}",
            _ => continue,
        };
        out.write_all(&text.as_bytes()[plain..at])?;
        out.write_all(instead.as_bytes())?;
        plain = at + letter.len_utf8();
    }
    out.write_all(&text.as_bytes()[plain..])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osm::{OsmData, read_bytes};

    #[test]
    fn every_text_is_read_as_it_was_written() {
        let nasty = "a & b < c > \"d\" 'e' \n\t\r &amp; é 道路 \u{1f6a6}";
        let mut bytes = Vec::new();
        let mut writer = OsmWriter::new(&mut bytes, &MetaInfo::default()).unwrap();
        writer.node(-1, Some(LonLat { lon: 139.5, lat: -0.0 }), [(nasty, nasty)]).unwrap();
        writer.node(2, None, []).unwrap();
        writer.way(3, [2, -1], [("k", "")]).unwrap();
        writer.relation(4, [(ElementKind::Way, 3, nasty)], []).unwrap();
        writer.finish().unwrap();
        let text = String::from_utf8(bytes.clone()).unwrap();
        assert!(text.contains(r#"<node id="-1" version="1" lat="0.00000000000" lon="139.50000000000">"#), "{text}");
        assert!(!text.contains("MetaInfo"));
        let mut data = OsmData::default();
        read_bytes(&mut data, "test", bytes).unwrap();
        assert_eq!(data.nodes[0].tags.get(nasty), Some(nasty));
        assert_eq!(data.nodes[1].position, None);
        assert_eq!(data.ways[0].nodes, [2, -1]);
        assert_eq!(data.ways[0].tags.get("k"), Some(""));
        assert_eq!(data.relations[0].members[0].role, nasty);
    }

    #[test]
    fn what_xml_cannot_hold_is_replaced() {
        let mut bytes = Vec::new();
        escaped(&mut bytes, "a\u{0}b\u{1f}").unwrap();
        assert_eq!(String::from_utf8(bytes).unwrap(), "a\u{fffd}b\u{fffd}");
    }
}
