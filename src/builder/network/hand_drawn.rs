//! Small networks for tests, drawn by hand in metres.

use crate::builder::tags::cross_section::CrossSection;
use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::diagnostic::SourceSpan;
use crate::geometry::{Point, Polyline};
use crate::osm::{ElementKind, Member, Node, OsmData, Relation, Tags, Way};
use crate::projection::LonLat;

use super::{IntersectionIx, NetworkOptions, Road, RoadKey, RoadNetwork, road_network};

const SPAN: SourceSpan = SourceSpan { file: 0, start: 0, end: 0 };
/// Metres of the test plane in a degree.
pub const SCALE: f64 = 100_000.0;

/// A way as (id, nodes, tags).
pub type DrawnWay<'a> = (i64, &'a [i64], &'a str);

fn tags(text: &str) -> Tags {
    text.split_whitespace().filter_map(|word| word.split_once('=')).collect()
}

/// Nodes as (id, east, north, tags) and ways, `highway=residential` unless tagged.
pub fn osm(nodes: &[(i64, f64, f64, &str)], ways: &[DrawnWay<'_>]) -> OsmData {
    let mut osm = OsmData::default();
    for (id, x, y, text) in nodes {
        let position = Some(LonLat { lon: x / SCALE, lat: y / SCALE });
        osm.push_node(Node { id: *id, position, tags: tags(text), span: SPAN });
    }
    for (id, nodes, text) in ways {
        let mut tags = tags(text);
        if !tags.has("highway") {
            tags.set("highway", "residential");
        }
        osm.push_way(Way { id: *id, nodes: nodes.to_vec(), tags, span: SPAN });
    }
    osm
}

/// Adds a restriction with members as (role, `n` or `w`, id).
pub fn restrict(osm: &mut OsmData, id: i64, text: &str, members: &[(&str, char, i64)]) {
    let kind = |c| if c == 'n' { ElementKind::Node } else { ElementKind::Way };
    let members =
        members.iter().map(|(role, k, id)| Member { kind: kind(*k), id: *id, role: (*role).into() }).collect();
    let mut tags = tags(text);
    tags.set("type", "restriction");
    osm.push_relation(Relation { id, members, tags, span: SPAN });
}

/// The test plane.
pub fn plane(places: &[LonLat]) -> Vec<Point> {
    places.iter().map(|p| Point::new(p.lon, p.lat) * SCALE).collect()
}

/// The network, driven on the right.
pub fn network(osm: &OsmData) -> RoadNetwork {
    let options = NetworkOptions { driving_side: Some(DrivingSide::Right), ..NetworkOptions::default() };
    road_network(osm, &plane, &options).unwrap().network
}

/// The network of nodes without tags.
pub fn network_of(nodes: &[(i64, f64, f64)], ways: &[DrawnWay<'_>]) -> RoadNetwork {
    network(&osm(&nodes.iter().map(|(id, x, y)| (*id, *x, *y, "")).collect::<Vec<_>>(), ways))
}

/// A residential road between two intersections.
pub fn road(key: RoadKey, [from, to]: [u32; 2], line: Polyline, section: CrossSection) -> Road {
    Road {
        key,
        ways: vec![key.way],
        from: IntersectionIx(from),
        to: IntersectionIx(to),
        line,
        heights: Vec::new(),
        section,
        class: RoadClass::Residential,
        link: false,
        level: 0.0,
        roundabout: false,
        public: true,
        name: None,
        speed: [50.0, 50.0],
        features: Vec::new(),
        tags: Tags::default(),
    }
}
