//! What an element says, apart from how it is written.

use std::collections::BTreeMap;

use super::id_tags;
use super::versions::Key;
use crate::osm::{ElementKind, Member, Node, OsmData, Tags};
use crate::projection::LonLat;

/// What lies closer than this, degrees, has not moved: a tenth of a millimetre, less than any editor's rounding.
const SAME_DEGREES: f64 = 1e-9;
/// The same in metres, for local coordinates.
const SAME_METRES: f64 = 1e-4;
/// Metres of a degree of latitude.
const DEGREE: f64 = 111_195.0;
/// The tags that say where a point is in a map's own metres.
pub(super) const LOCAL: [&str; 2] = ["local_x", "local_y"];

/// Where a node is, by the Earth and by the map's own metres.
#[derive(Clone, Debug, Default)]
pub(super) struct Position {
    pub(super) lonlat: Option<LonLat>,
    pub(super) local: [Option<String>; 2],
}

impl PartialEq for Position {
    fn eq(&self, other: &Self) -> bool {
        let globe = match (self.lonlat, other.lonlat) {
            (Some(a), Some(b)) => (a.lon - b.lon).abs() < SAME_DEGREES && (a.lat - b.lat).abs() < SAME_DEGREES,
            (a, b) => a.is_none() && b.is_none(),
        };
        let local = self.local.iter().zip(&other.local).all(|(a, b)| {
            a == b || metres(a.as_ref()).zip(metres(b.as_ref())).is_some_and(|(a, b)| (a - b).abs() < SAME_METRES)
        });
        globe && local
    }
}

impl Position {
    /// Metres from another one; `None` where neither says a place that can be compared.
    pub(super) fn metres_to(&self, other: &Self) -> Option<f64> {
        if let Some((a, b)) = self.lonlat.zip(other.lonlat).filter(|(a, _)| *a != LonLat::default()) {
            let along = a.lat.to_radians().cos();
            return Some(f64::hypot((a.lon - b.lon) * along, a.lat - b.lat) * DEGREE);
        }
        let [ax, ay] = self.local.each_ref().map(|one| metres(one.as_ref()));
        let [bx, by] = other.local.each_ref().map(|one| metres(one.as_ref()));
        Some(f64::hypot(ax? - bx?, ay? - by?))
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let globe = self.lonlat.map(|place| format!("{:.7}, {:.7}", place.lat, place.lon));
        let local = self.local.each_ref().map(|one| one.as_deref().unwrap_or("?"));
        let local = self.local.iter().any(Option::is_some).then(|| format!("local {}, {}", local[0], local[1]));
        globe.into_iter().chain(local).collect::<Vec<_>>().join(", ")
    }
}

fn metres(text: Option<&String>) -> Option<f64> {
    text?.trim().parse().ok()
}

/// What an element says.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Content {
    /// Of a node.
    pub(super) position: Position,
    /// Of several values of a key the last, which counts; without those of the position.
    pub(super) tags: BTreeMap<String, String>,
    /// Of a way.
    pub(super) nodes: Vec<i64>,
    /// Of a relation.
    pub(super) members: Vec<Member>,
}

impl Content {
    /// What an element says; `None` where it is not there.
    pub(super) fn of(osm: &OsmData, (kind, id): Key) -> Option<Self> {
        Some(match kind {
            ElementKind::Node => Self::of_node(osm.node(id)?),
            ElementKind::Way => {
                let way = osm.way(id)?;
                Self { tags: tags(&way.tags), nodes: way.nodes.clone(), ..Self::default() }
            }
            ElementKind::Relation => {
                let relation = osm.relation(id)?;
                Self { tags: tags(&relation.tags), members: relation.members.clone(), ..Self::default() }
            }
        })
    }

    fn of_node(node: &Node) -> Self {
        let mut tags = tags(&node.tags);
        let local = LOCAL.map(|key| tags.remove(key));
        Self { position: Position { lonlat: node.position, local }, tags, ..Self::default() }
    }

    /// The elements that it refers to: vertices, members, and those that tags name.
    pub(super) fn references(&self) -> impl Iterator<Item = Key> {
        let nodes = self.nodes.iter().map(|id| (ElementKind::Node, *id));
        let members = self.members.iter().map(|member| (member.kind, member.id));
        let named = self.tags.iter().flat_map(|(key, value)| id_tags::named(key, value));
        nodes.chain(members).chain(named)
    }
}

fn tags(tags: &Tags) -> BTreeMap<String, String> {
    tags.iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect()
}
