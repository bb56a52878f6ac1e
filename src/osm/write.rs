//! Writes OpenStreetMap XML, one tag a line, so that a small change of a map is a small change of its text.

use super::digits::{put_decimal, put_exact, put_fixed, put_integer};
use super::{ElementKind, MetaInfo, Node, Relation, Way};
use crate::projection::LonLat;

/// Decimals of latitude and longitude: a micrometre.
const DECIMALS: usize = 11;

/// The text of elements, in the order of the calls; JOSM and Lanelet2 expect nodes, ways, relations. Parts of a map may be
/// made separately and written one after the other.
#[derive(Debug, Default)]
pub struct OsmText {
    text: Vec<u8>,
}

impl OsmText {
    /// The text before the first element.
    pub fn head(meta: &MetaInfo) -> Self {
        Self::head_by("lanewright", meta)
    }

    /// The text before the first element of a map that another program has made.
    pub fn head_by(generator: &str, meta: &MetaInfo) -> Self {
        let mut text = Self::default();
        text.put("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<osm version=\"0.6\" generator=\"");
        text.escaped(generator.as_bytes());
        // JOSM then asks before it uploads the file to OpenStreetMap.
        text.put("\" upload=\"false\">\n");
        let versions = [("format_version", &meta.format_version), ("map_version", &meta.map_version)];
        if versions.iter().any(|(_, v)| v.is_some()) {
            text.put("  <MetaInfo");
            for (name, version) in versions {
                if let Some(version) = version {
                    text.put(" ");
                    text.put(name);
                    text.put("=\"");
                    text.escaped(version.as_bytes());
                    text.put("\"");
                }
            }
            text.put("/>\n");
        }
        text
    }

    /// The text after the last element.
    pub fn tail() -> Self {
        Self { text: b"</osm>\n".to_vec() }
    }

    /// The text so far.
    pub fn as_bytes(&self) -> &[u8] {
        &self.text
    }

    /// A node as it was read.
    pub fn put_node(&mut self, Node { id, position, tags, .. }: &Node) {
        self.node(*id, *position, tags.words());
    }

    /// A node as it was read, its place to the last bit.
    pub fn put_node_exactly(&mut self, Node { id, position, tags, .. }: &Node) {
        self.put("  <node id=\"");
        self.integer(*id);
        self.put("\" version=\"1\" lat=\"");
        position.inspect(|place| put_exact(&mut self.text, place.lat));
        self.put("\" lon=\"");
        position.inspect(|place| put_exact(&mut self.text, place.lon));
        self.put("\">\n");
        self.tags(tags.words());
        self.put("  </node>\n");
    }

    /// A way as it was read.
    pub fn put_way(&mut self, Way { id, nodes, tags, .. }: &Way) {
        self.way(*id, nodes.iter().copied(), tags.words());
    }

    /// A relation as it was read.
    pub fn put_relation(&mut self, Relation { id, members, tags, .. }: &Relation) {
        let members = members.iter().map(|member| (member.kind, member.id, member.role.as_str()));
        self.relation(*id, members, tags.words());
    }

    /// A node; without a place, `lat` and `lon` are empty, as in other editors' maps without projection.
    pub fn node<T: AsRef<[u8]>>(&mut self, id: i64, place: Option<LonLat>, tags: impl IntoIterator<Item = (T, T)>) {
        self.node_head(id, place);
        let before = self.text.len();
        self.put("\">\n");
        let tagless = self.text.len();
        self.tags(tags);
        if self.text.len() == tagless {
            self.text.truncate(before);
            self.put("\"/>\n");
        } else {
            self.put("  </node>\n");
        }
    }

    /// Begins a node with tags, which [`OsmText::tag`] and [`OsmText::number`] add, up to [`OsmText::end_node`].
    pub fn begin_node(&mut self, id: i64, place: Option<LonLat>) {
        self.node_head(id, place);
        self.put("\">\n");
    }

    /// Ends a node.
    pub fn end_node(&mut self) {
        self.put("  </node>\n");
    }

    /// A tag.
    pub fn tag(&mut self, key: &str, value: &str) {
        self.tags([(key, value)]);
    }

    /// A tag whose value is a number with this many decimals. The key is plain letters.
    pub fn number(&mut self, key: &str, value: f64, decimals: usize) {
        self.plain_tag(key, |text| put_fixed(text, value, decimals));
    }

    /// A tag whose value is a number with all its decimals, at least one. The key is plain letters.
    pub fn decimal(&mut self, key: &str, value: f64) {
        self.plain_tag(key, |text| put_decimal(text, value));
    }

    fn plain_tag(&mut self, key: &str, value: impl FnOnce(&mut Vec<u8>)) {
        self.put("    <tag k=\"");
        self.put(key);
        self.put("\" v=\"");
        value(&mut self.text);
        self.put("\"/>\n");
    }

    fn node_head(&mut self, id: i64, place: Option<LonLat>) {
        self.put("  <node id=\"");
        self.integer(id);
        self.put("\" version=\"1\" lat=\"");
        if let Some(LonLat { lat, .. }) = place {
            put_fixed(&mut self.text, lat, DECIMALS);
        }
        self.put("\" lon=\"");
        if let Some(LonLat { lon, .. }) = place {
            put_fixed(&mut self.text, lon, DECIMALS);
        }
    }

    /// Takes the text away and keeps its memory for the next.
    pub fn clear(&mut self) {
        self.text.clear();
    }

    /// A way.
    pub fn way<T: AsRef<[u8]>>(
        &mut self,
        id: i64,
        nodes: impl IntoIterator<Item = i64>,
        tags: impl IntoIterator<Item = (T, T)>,
    ) {
        self.put("  <way id=\"");
        self.integer(id);
        self.put("\" version=\"1\">\n");
        for node in nodes {
            self.put("    <nd ref=\"");
            self.integer(node);
            self.put("\"/>\n");
        }
        self.tags(tags);
        self.put("  </way>\n");
    }

    /// A relation.
    pub fn relation<'t, T: AsRef<[u8]>>(
        &mut self,
        id: i64,
        members: impl IntoIterator<Item = (ElementKind, i64, &'t str)>,
        tags: impl IntoIterator<Item = (T, T)>,
    ) {
        self.put("  <relation id=\"");
        self.integer(id);
        self.put("\" version=\"1\">\n");
        for (kind, target, role) in members {
            self.put("    <member type=\"");
            self.put(kind.as_str());
            self.put("\" ref=\"");
            self.integer(target);
            self.put("\" role=\"");
            self.escaped(role.as_bytes());
            self.put("\"/>\n");
        }
        self.tags(tags);
        self.put("  </relation>\n");
    }

    /// Keys and values are text, the bytes of which need not be known to be.
    /// Tags in the order given.
    pub fn tags<T: AsRef<[u8]>>(&mut self, tags: impl IntoIterator<Item = (T, T)>) {
        for (key, value) in tags {
            self.put("    <tag k=\"");
            self.escaped(key.as_ref());
            self.put("\" v=\"");
            self.escaped(value.as_ref());
            self.put("\"/>\n");
        }
    }

    /// Written in place: most of these texts are known, and short.
    #[inline(always)]
    fn put(&mut self, text: &str) {
        self.text.extend_from_slice(text.as_bytes());
    }

    #[inline]
    fn integer(&mut self, number: i64) {
        put_integer(&mut self.text, number);
    }

    /// The text of an attribute. Line breaks and tabs would be read back as blanks if they were bare; what XML cannot
    /// hold becomes a replacement character.
    fn escaped(&mut self, text: &[u8]) {
        // U+FFFE and U+FFFF are the only letters beyond ASCII that XML cannot hold; they begin with this byte.
        let plain = |b: u8| b >= b' ' && !matches!(b, b'&' | b'<' | b'>' | b'"' | 0xef);
        if text.iter().copied().all(plain) {
            return self.text.extend_from_slice(text);
        }
        let mut letter_bytes = [0; 4];
        for letter in String::from_utf8_lossy(text).chars() {
            self.put(match letter {
                '&' => "&amp;",
                '<' => "&lt;",
                '>' => "&gt;",
                '"' => "&quot;",
                '\n' => "&#10;",
                '\r' => "&#13;",
                '\t' => "&#9;",
                '\0'..'\u{20}' | '\u{fffe}' | '\u{ffff}' => "\u{fffd}",
                _ => letter.encode_utf8(&mut letter_bytes),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osm::{OsmData, read_bytes};

    #[test]
    fn every_text_is_read_as_it_was_written() {
        let nasty = "a & b < c > \"d\" 'e' \n\t\r &amp; é 道路 \u{1f6a6}";
        let mut elements = OsmText::default();
        elements.node(-1, Some(LonLat { lon: 139.5, lat: -0.0 }), [(nasty, nasty)]);
        elements.node::<&str>(2, None, []);
        elements.way(3, [2, -1], [("k", "")]);
        elements.relation::<&str>(4, [(ElementKind::Way, 3, nasty)], []);
        let text = [OsmText::head(&MetaInfo::default()), elements, OsmText::tail()].map(|text| text.text).concat();
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains(r#"<node id="-1" version="1" lat="0.00000000000" lon="139.50000000000">"#), "{text}");
        assert!(!text.contains("MetaInfo"));
        let mut data = OsmData::default();
        read_bytes(&mut data, "test", text.into_bytes()).unwrap();
        assert_eq!(data.nodes[0].tags.get(nasty), Some(nasty));
        assert_eq!(data.nodes[1].position, None);
        assert_eq!(data.ways[0].nodes, [2, -1]);
        assert_eq!(data.ways[0].tags.get("k"), Some(""));
        assert_eq!(data.relations[0].members[0].role, nasty);
    }

    #[test]
    fn what_xml_cannot_hold_is_replaced() {
        let mut text = OsmText::default();
        text.escaped("a\u{0}b\u{1f}\u{feff}\u{ffff}".as_bytes());
        assert_eq!(text.text, "a\u{fffd}b\u{fffd}\u{feff}\u{fffd}".as_bytes());
    }
}
