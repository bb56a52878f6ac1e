//! The highest ids of a map, and those that a fix has used.

use crate::osm::OsmData;

/// The highest ids that are in use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ids {
    /// Of all.
    pub(super) last: i64,
    /// Of those that Autoware can read where it reads 32 bits.
    pub(super) small: i64,
}

/// The ids that a fix has used, from those behind the first to the second.
#[derive(Clone, Copy, Debug)]
pub struct IdRange {
    pub(super) from: Ids,
    pub(super) to: Ids,
}

impl Ids {
    /// Those of a map.
    pub(super) fn last_of(osm: &OsmData) -> Self {
        let ids = osm.nodes.iter().map(|node| node.id).chain(osm.ways.iter().map(|way| way.id));
        let ids = ids.chain(osm.relations.iter().map(|relation| relation.id));
        let small = |id: i64| if id <= i64::from(i32::MAX) { id } else { 0 };
        ids.map(|id| Self { last: id, small: small(id) }).fold(Self { last: 0, small: 0 }, Self::max)
    }

    pub(super) fn max(self, other: Self) -> Self {
        Self { last: self.last.max(other.last), small: self.small.max(other.small) }
    }
}
