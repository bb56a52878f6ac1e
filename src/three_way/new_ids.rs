//! Other ids for elements of theirs, where both sides have made an element under one id, and not the same.

use rustc_hash::{FxHashMap, FxHashSet};

use super::fields;
use super::versions::{Key, Versions};
use super::view::View;
use crate::osm::{ElementKind, OsmData};

/// The new ids, by kind and the id that both sides have taken.
pub(super) fn of(Versions { base, ours, theirs }: Versions<'_>) -> FxHashMap<Key, i64> {
    let mut new: FxHashMap<Key, i64> = FxHashMap::default();
    let mut used: Option<FxHashSet<i64>> = None;
    let own = View::new(ours);
    // Nodes before ways before relations: parts are compared under the ids that they have by then.
    for kind in [ElementKind::Node, ElementKind::Way, ElementKind::Relation] {
        let both = ids(theirs, kind).filter(|id| !base.contains(kind, *id) && ours.contains(kind, *id));
        let both: Vec<i64> = both.collect();
        let others = View::renumbered(theirs, &new);
        let is_another = |id: &&i64| {
            let [own, other] = [&own, &others].map(|side| side.content((kind, **id)));
            own.zip(other).is_some_and(|(own, other)| own != other && !fields::are_alike(kind, &own, &other))
        };
        let mut taken: Vec<i64> = both.iter().filter(is_another).copied().collect();
        taken.sort_unstable();
        taken.dedup();
        for id in taken {
            let used = used.get_or_insert_with(|| all_ids([base, ours, theirs]));
            let free = free_beyond(id, used);
            used.insert(free);
            new.insert((kind, id), free);
        }
    }
    new
}

fn ids(osm: &OsmData, kind: ElementKind) -> Box<dyn Iterator<Item = i64> + '_> {
    match kind {
        ElementKind::Node => Box::new(osm.nodes.iter().map(|one| one.id)),
        ElementKind::Way => Box::new(osm.ways.iter().map(|one| one.id)),
        ElementKind::Relation => Box::new(osm.relations.iter().map(|one| one.id)),
    }
}

fn all_ids(maps: [&OsmData; 3]) -> FxHashSet<i64> {
    let kinds = [ElementKind::Node, ElementKind::Way, ElementKind::Relation];
    maps.iter().flat_map(|osm| kinds.into_iter().flat_map(|kind| ids(osm, kind))).collect()
}

/// The next id that no element has, farther from 0: an editor that counts up goes on from there, JOSM's ids stay negative, and
/// polygons keep ids that Autoware can read.
fn free_beyond(id: i64, used: &FxHashSet<i64>) -> i64 {
    let step = if id < 0 { -1 } else { 1 };
    let mut free = id;
    while used.contains(&free) {
        free = free.wrapping_add(step);
    }
    free
}
