//! Which elements of a map refer to which.

use rustc_hash::FxHashMap;

use super::{AREA, Key, TextEdits};
use crate::osm::{ElementKind, OsmData};

/// Tags whose value is the id of a way.
pub const NAMING: [&str; 2] = [AREA, "traffic_light_id"];

/// Who refers to an element.
pub(super) struct References {
    /// By a member or a vertex.
    referrers: FxHashMap<Key, Vec<Key>>,
    /// By the value of a tag that names a way.
    named: FxHashMap<i64, Vec<Key>>,
}

impl References {
    /// Those of a map.
    pub(super) fn of(osm: &OsmData) -> Self {
        let mut referrers: FxHashMap<Key, Vec<Key>> = FxHashMap::default();
        for way in &osm.ways {
            for node in &way.nodes {
                referrers.entry((ElementKind::Node, *node)).or_default().push((ElementKind::Way, way.id));
            }
        }
        for relation in &osm.relations {
            for member in &relation.members {
                let list = referrers.entry((member.kind, member.id)).or_default();
                list.push((ElementKind::Relation, relation.id));
            }
        }
        let ways = osm.ways.iter().map(|way| ((ElementKind::Way, way.id), &way.tags));
        let tagged = ways.chain(osm.relations.iter().map(|one| ((ElementKind::Relation, one.id), &one.tags)));
        let mut named: FxHashMap<i64, Vec<Key>> = FxHashMap::default();
        for (key, tags) in tagged {
            for id in NAMING.iter().filter_map(|name| tags.get(name)?.parse().ok()) {
                named.entry(id).or_default().push(key);
            }
        }
        Self { referrers, named }
    }

    /// The elements that have this one as a member or a vertex.
    pub(super) fn referrers(&self, key: Key) -> &[Key] {
        self.referrers.get(&key).map_or(&[], Vec::as_slice)
    }

    /// The elements that name a way in the value of a tag.
    pub(super) fn named(&self, (kind, id): Key) -> &[Key] {
        let tagged = self.named.get(&id).filter(|_| kind == ElementKind::Way);
        tagged.map_or(&[], Vec::as_slice)
    }
}

impl TextEdits<'_> {
    /// Whether a way is part of the outline of a multipolygon, which has to stay closed: no rule knows of it.
    pub(super) fn borders_area(&self, way: Key) -> bool {
        let is_area = |(kind, id): Key| {
            let relation = (kind == ElementKind::Relation).then(|| self.osm.relation(id)).flatten();
            relation.is_some_and(|relation| relation.tags.is("type", "multipolygon"))
        };
        way.0 == ElementKind::Way && self.referrers_of(way).any(is_area)
    }

    /// The elements that are made of one: of a node the ways over it and the lanelets between these.
    pub fn made_of(&self, key: Key) -> Vec<Key> {
        let mut users: Vec<Key> = self.referrers_of(key).collect();
        if key.0 == ElementKind::Node {
            users.extend(self.referrers_of(key).flat_map(|way| self.referrers_of(way)));
        }
        users
    }

    pub(super) fn referrers_of(&self, key: Key) -> impl Iterator<Item = Key> + '_ {
        self.references.referrers(key).iter().copied()
    }
}
