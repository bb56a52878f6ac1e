//! The surroundings of a change of the map: the findings elsewhere do not depend on the change.

use rustc_hash::{FxHashMap, FxHashSet};

use super::text_edits::{Key, NAMING};
use crate::osm::{ElementKind, Node, OddityKind, OsmData, Relation, Tags, Way};

/// Side of the squares (m) into which the map is divided.
const SQUARE: f64 = 5.0;

/// Up to how many squares from a change elements are near. What is found farther away shows when the map is judged as a whole in the end.
#[derive(Clone, Copy)]
pub struct Near {
    /// From where a line runs otherwise.
    shape: i64,
    /// From an element that lies where it lay, but of which something else is said; and all that it is joined to.
    words: i64,
    /// Whether that may be too close to show what is to be mended.
    pub is_close: bool,
}

/// At least 15 m, and 5 m.
const CLOSE: Near = Near { shape: 3, words: 1, is_close: true };

/// At least 30 m: where the closer ones do not show what is to be mended.
const WIDE: Near = Near { shape: 6, words: 6, is_close: false };

/// At least 60 m: where judging those missed something.
const FAR: Near = Near { shape: 12, words: 12, is_close: false };

/// What is tried one after the other.
pub const REACHES_TRIED: [Near; 3] = [CLOSE, WIDE, FAR];

/// The elements that differ between two maps.
pub fn changed(old: &OsmData, new: &OsmData) -> FxHashSet<Key> {
    // Of elements that share an id it is not told which one has changed.
    let repeated = [old, new].into_iter().flat_map(|osm| &osm.oddities);
    let repeated = repeated.filter(|odd| odd.kind == OddityKind::DuplicateId).filter_map(|odd| odd.element);
    let mut changed: FxHashSet<Key> = repeated.collect();
    for [one, other] in [[old, new], [new, old]] {
        // Most stand where they stood, behind those that stood before them.
        let mut at = 0;
        let mut twin = |id: i64| {
            if other.nodes.get(at).is_none_or(|node| node.id != id) {
                at = other.node_position(id)?;
            }
            at += 1;
            other.nodes.get(at - 1)
        };
        let nodes = one.nodes.iter().filter(|a| !twin(a.id).is_some_and(|b| same_node(a, b)));
        changed.extend(nodes.map(|a| (ElementKind::Node, a.id)));
        let ways = one.ways.iter().filter(|a| !other.way(a.id).is_some_and(|b| same_way(a, b)));
        changed.extend(ways.map(|a| (ElementKind::Way, a.id)));
        let relations = one.relations.iter().filter(|a| !other.relation(a.id).is_some_and(|b| same_relation(a, b)));
        changed.extend(relations.map(|a| (ElementKind::Relation, a.id)));
    }
    changed
}

fn same_node(a: &Node, b: &Node) -> bool {
    a.position == b.position && a.tags == b.tags
}

fn same_way(a: &Way, b: &Way) -> bool {
    a.nodes == b.nodes && a.tags == b.tags
}

fn same_relation(a: &Relation, b: &Relation) -> bool {
    a.members == b.members && a.tags == b.tags
}

/// Whether an element is made of other lines in one of two maps than in the other, or lies elsewhere.
fn is_reshaped([old, new]: [&OsmData; 2], (kind, id): Key) -> bool {
    match kind {
        ElementKind::Node => true,
        ElementKind::Way => old.way(id).map(|way| &way.nodes) != new.way(id).map(|way| &way.nodes),
        ElementKind::Relation => {
            let lines = |osm: &OsmData| -> Vec<i64> {
                let members = osm.relation(id).map(|one| one.members.as_slice()).unwrap_or_default().iter();
                members.filter(|member| member.kind == ElementKind::Way).map(|member| member.id).collect()
            };
            lines(old) != lines(new)
        }
    }
}

/// The elements of two maps that are near the given ones, with all elements that they consist of and refer to. `place` gives the
/// position of a node: east and north, metres. `None` if an element has no place.
pub fn around(
    maps: [&OsmData; 2],
    changed: &FxHashSet<Key>,
    reach: Near,
    place: impl Fn(&Node) -> Option<[f64; 2]>,
) -> Option<FxHashSet<Key>> {
    let square = |node: &Node| place(node).map(|at| at.map(|metres| (metres / SQUARE).floor() as i64));
    let all: Vec<Key> = changed.iter().copied().collect();
    let reshaped: Vec<Key> = changed.iter().copied().filter(|&key| is_reshaped(maps, key)).collect();
    let mut squares: FxHashSet<[i64; 2]> = FxHashSet::default();
    for (keys, depth, reach) in [(all, DEEP, reach.words), (reshaped, OWN_LINES, reach.shape)] {
        let mut with_change: FxHashSet<[i64; 2]> = FxHashSet::default();
        for osm in maps {
            let mut parts = Parts::default();
            keys.iter().for_each(|&key| parts.add(osm, key, depth));
            for id in parts.keys.iter().filter(|(kind, _)| *kind == ElementKind::Node).map(|(_, id)| id) {
                if let Some(node) = osm.node(*id) {
                    with_change.insert(square(node)?);
                }
            }
        }
        for [x, y] in with_change {
            let row = |east| (-reach..=reach).map(move |north| [x.saturating_add(east), y.saturating_add(north)]);
            squares.extend((-reach..=reach).flat_map(row));
        }
    }
    let mut near: FxHashSet<Key> = changed.clone();
    for osm in maps {
        for node in &osm.nodes {
            if square(node).is_some_and(|at| squares.contains(&at)) {
                near.insert((ElementKind::Node, node.id));
            }
        }
    }
    let mut whole = Parts::default();
    for osm in maps {
        whole.add_touching(osm, &near);
    }
    whole.keys.extend(near);
    Some(whole.keys)
}

/// The elements that a change may connect or part: those that have a point in common with a changed one or with such an element, each
/// with the lines that it is made of.
pub fn connected(maps: [&OsmData; 2], changed: &FxHashSet<Key>) -> FxHashSet<Key> {
    let mut near = changed.clone();
    for _ in 0..2 {
        let mut whole = Parts { lines_only: true, ..Parts::default() };
        for osm in maps {
            let mut parts = Parts { lines_only: true, ..Parts::default() };
            near.iter().for_each(|&key| parts.add(osm, key, DEEP));
            parts.keys.extend(near.iter().copied());
            whole.add_touching(osm, &parts.keys);
            whole.keys.extend(parts.keys);
        }
        near = whole.keys;
    }
    near
}

/// The number of steps from a changed element to the elements that it consists of: its lanelets, their bounds, the nodes of
/// these.
const DEEP: usize = 3;

/// The same from an element to the nodes of its own lines.
const OWN_LINES: usize = 2;

/// More steps than in any chain of elements that refer to each other in an intersection.
const WHOLE: usize = 64;

/// Elements with all that they are made of.
#[derive(Default)]
struct Parts {
    keys: FxHashSet<Key>,
    /// Whether of a relation only its lines count, and not other relations or what its tags name.
    lines_only: bool,
}

impl Parts {
    fn add(&mut self, osm: &OsmData, key: Key, depth: usize) {
        let mut open = vec![(key, depth)];
        while let Some((key, depth)) = open.pop() {
            if !self.keys.insert(key) || depth == 0 {
                continue;
            }
            match key.0 {
                ElementKind::Node => {}
                ElementKind::Way => {
                    let nodes = osm.way(key.1).map(|way| way.nodes.as_slice()).unwrap_or_default();
                    self.keys.extend(nodes.iter().map(|&id| (ElementKind::Node, id)));
                }
                ElementKind::Relation => {
                    let Some(relation) = osm.relation(key.1) else { continue };
                    let members = relation.members.iter().map(|member| (member.kind, member.id));
                    let named = named(&relation.tags).map(|id| (ElementKind::Way, id));
                    let is_line = |(kind, _): &Key| *kind == ElementKind::Way;
                    match self.lines_only {
                        true => open.extend(members.filter(is_line).map(|key| (key, depth - 1))),
                        false => open.extend(members.chain(named).map(|key| (key, depth - 1))),
                    }
                }
            }
        }
    }

    /// Adds the ways and relations that contain a near element, and the lanelets that name a near area, each as a whole.
    fn add_touching(&mut self, osm: &OsmData, near: &FxHashSet<Key>) {
        let mut touching: Vec<Key> = Vec::new();
        let mut ways: FxHashSet<i64> = FxHashSet::default();
        for way in &osm.ways {
            if near.contains(&(ElementKind::Way, way.id))
                || way.nodes.iter().any(|&id| near.contains(&(ElementKind::Node, id)))
            {
                ways.insert(way.id);
                touching.push((ElementKind::Way, way.id));
            }
        }
        let mut relations: FxHashMap<i64, bool> = FxHashMap::default();
        for relation in &osm.relations {
            let is_near = near.contains(&(ElementKind::Relation, relation.id))
                || relation.members.iter().any(|member| match member.kind {
                    ElementKind::Way => ways.contains(&member.id),
                    kind => !self.lines_only && near.contains(&(kind, member.id)),
                })
                || !self.lines_only && named(&relation.tags).any(|id| ways.contains(&id));
            relations.insert(relation.id, is_near);
        }
        // Elements that name a lanelet which is near.
        let is_near = |id: &i64| relations.get(id).copied().unwrap_or(false);
        for relation in &osm.relations {
            let members = relation.members.iter().filter(|member| member.kind == ElementKind::Relation);
            let names = || !self.lines_only && members.map(|member| member.id).any(|id| is_near(&id));
            if is_near(&relation.id) || names() {
                touching.push((ElementKind::Relation, relation.id));
            }
        }
        touching.into_iter().for_each(|key| self.add(osm, key, WHOLE));
    }
}

/// The ways that tags name.
fn named(tags: &Tags) -> impl Iterator<Item = i64> + '_ {
    NAMING.iter().filter_map(|name| tags.get(name)?.parse().ok())
}
