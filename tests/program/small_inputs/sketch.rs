//! OpenStreetMap's XML, written from a plane in metres.

use std::fmt::Write;

/// Where the plane's origin lies; people drive on the right there.
const LATITUDE: f64 = 49.0;
const LONGITUDE: f64 = 8.5;
/// Metres in a degree of latitude, and of longitude at `LATITUDE`.
const DEGREE: [f64; 2] = [73_170.0, 111_200.0];

/// A place: metres east and north.
pub type Place = (f64, f64);

/// A file in the making.
#[derive(Default)]
pub struct Sketch {
    nodes: String,
    ways: String,
    relations: String,
    last_id: i64,
}

impl Sketch {
    fn id(&mut self) -> i64 {
        self.last_id += 1;
        self.last_id
    }

    pub fn node(&mut self, at: Place) -> i64 {
        self.tagged_node(at, &[("ele", "10")])
    }

    pub fn tagged_node(&mut self, (east, north): Place, tags: &[(&str, &str)]) -> i64 {
        let id = self.id();
        let (lat, lon) = (LATITUDE + north / DEGREE[1], LONGITUDE + east / DEGREE[0]);
        let _ = write!(self.nodes, "<node id=\"{id}\" lat=\"{lat:.10}\" lon=\"{lon:.10}\">");
        write_tags(&mut self.nodes, tags);
        self.nodes.push_str("</node>\n");
        id
    }

    pub fn way(&mut self, nodes: &[i64], tags: &[(&str, &str)]) -> i64 {
        let id = self.id();
        let _ = write!(self.ways, "<way id=\"{id}\">");
        for node in nodes {
            let _ = write!(self.ways, "<nd ref=\"{node}\"/>");
        }
        write_tags(&mut self.ways, tags);
        self.ways.push_str("</way>\n");
        id
    }

    /// A way with nodes of its own.
    pub fn line(&mut self, places: &[Place], tags: &[(&str, &str)]) -> i64 {
        let nodes: Vec<i64> = places.iter().map(|&place| self.node(place)).collect();
        self.way(&nodes, tags)
    }

    /// Members: kind, role, id.
    pub fn relation(&mut self, members: &[(&str, &str, i64)], tags: &[(&str, &str)]) -> i64 {
        let id = self.id();
        let _ = write!(self.relations, "<relation id=\"{id}\">");
        for (kind, role, member) in members {
            let _ = write!(self.relations, "<member type=\"{kind}\" role=\"{role}\" ref=\"{member}\"/>");
        }
        write_tags(&mut self.relations, tags);
        self.relations.push_str("</relation>\n");
        id
    }

    /// Puts the elements of another file beside these, with the ids that they have.
    pub fn append(&mut self, other: &Self) {
        self.nodes.push_str(&other.nodes);
        self.ways.push_str(&other.ways);
        self.relations.push_str(&other.relations);
    }

    /// The id that the next element gets.
    pub fn next_id(&self) -> i64 {
        self.last_id + 1
    }

    pub fn text(&self) -> String {
        let Self { nodes, ways, relations, .. } = self;
        let head = "<osm version=\"0.6\">\n<MetaInfo format_version=\"2\" map_version=\"1\"/>";
        format!("<?xml version=\"1.0\"?>\n{head}\n{nodes}{ways}{relations}</osm>\n")
    }
}

fn write_tags(out: &mut String, tags: &[(&str, &str)]) {
    for (key, value) in tags {
        let _ = write!(out, "<tag k=\"{key}\" v=\"{value}\"/>");
    }
}
