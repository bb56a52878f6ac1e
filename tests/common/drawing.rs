//! OpenStreetMap data drawn by hand, and data from text.

use std::fmt::{Display, Write};

use lanewright::osm::{OsmData, read_bytes};

/// Elements as XML, in the order in which they are added.
#[derive(Default)]
pub struct Drawing(String);

impl Drawing {
    /// Tags are written `key=value`, with blanks between them.
    pub fn node(&mut self, id: impl Display, [lat, lon]: [impl Display; 2], tags: &str) {
        write!(self.0, "<node id='{id}' lat='{lat}' lon='{lon}'>{}</node>", tags_of(tags)).unwrap();
    }

    pub fn way(&mut self, id: impl Display, nodes: impl IntoIterator<Item = impl Display>, tags: &str) {
        let nodes: String = nodes.into_iter().map(|id| format!("<nd ref='{id}'/>")).collect();
        write!(self.0, "<way id='{id}'>{nodes}{}</way>", tags_of(tags)).unwrap();
    }

    /// Members are ways, each with its role.
    pub fn relation(&mut self, id: impl Display, members: &[(&str, i64)], tags: &str) {
        let members: Vec<_> = members.iter().map(|(role, id)| (*role, 'w', *id)).collect();
        self.members(id, &members, tags);
    }

    /// A relation of nodes (`n`), ways (`w`) and relations (`r`), each with its role.
    pub fn members(&mut self, id: impl Display, members: &[(&str, char, i64)], tags: &str) {
        let kind = |kind: char| match kind {
            'n' => "node",
            'r' => "relation",
            _ => "way",
        };
        let member =
            |(role, k, id): &(&str, char, i64)| format!("<member type='{}' role='{role}' ref='{id}'/>", kind(*k));
        let members: String = members.iter().map(member).collect();
        write!(self.0, "<relation id='{id}'>{members}{}</relation>", tags_of(tags)).unwrap();
    }

    pub fn xml(&self) -> String {
        format!("<osm version='0.6'>{}</osm>", self.0)
    }

    pub fn data(&self) -> OsmData {
        osm(self.xml())
    }
}

fn tags_of(text: &str) -> String {
    let pairs = text.split_whitespace().filter_map(|tag| tag.split_once('='));
    pairs.map(|(key, value)| format!("<tag k='{key}' v='{value}'/>")).collect()
}

/// The data of a file with this content.
pub fn osm(content: impl Into<Vec<u8>>) -> OsmData {
    let mut data = OsmData::default();
    read_bytes(&mut data, "test.osm", content.into()).unwrap();
    data
}
