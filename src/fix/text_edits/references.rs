//! Which elements of a map refer to which.

use rustc_hash::FxHashMap;

use crate::diagnostic::SourceSpan;
use crate::element_edits::Key;
use crate::osm::{ElementKind, OddityKind, OsmData};

/// The type of an intersection's area, and the tag in which a lanelet names it.
pub(super) const AREA: &str = "intersection_area";

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

/// The positions of the elements whose id repeats, in file order.
pub(super) fn repeated(osm: &OsmData) -> FxHashMap<Key, Vec<&SourceSpan>> {
    let twice = osm.oddities.iter().filter(|odd| odd.kind == OddityKind::DuplicateId).filter_map(|odd| odd.element);
    let mut spans: FxHashMap<Key, Vec<&SourceSpan>> = twice.map(|key| (key, Vec::new())).collect();
    let nodes = osm.nodes.iter().map(|one| ((ElementKind::Node, one.id), &one.span));
    let ways = osm.ways.iter().map(|one| ((ElementKind::Way, one.id), &one.span));
    let relations = osm.relations.iter().map(|one| ((ElementKind::Relation, one.id), &one.span));
    for (key, span) in nodes.chain(ways).chain(relations) {
        if let Some(list) = spans.get_mut(&key) {
            list.push(span);
        }
    }
    spans
}
