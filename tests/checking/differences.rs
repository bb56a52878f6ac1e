//! In how many things two maps differ. One thing is an element, together with the parts that only it has and the references to it.

use std::collections::{BTreeMap, BTreeSet};

use lanewright::osm::{ElementKind, OsmData};

/// An element: its kind in one letter, and its id.
pub type Key = (char, i64);

/// One element as written, and what it refers to.
#[derive(Clone, Debug, Default, PartialEq)]
struct Element {
    /// Everything but references, in order.
    rest: Vec<String>,
    /// References with their parts, in order.
    references: Vec<(String, Key)>,
}

type Elements = BTreeMap<Key, Vec<Element>>;

fn letter(kind: ElementKind) -> char {
    match kind {
        ElementKind::Node => 'n',
        ElementKind::Way => 'w',
        ElementKind::Relation => 'r',
    }
}

fn elements(data: &OsmData) -> Elements {
    let mut all = Elements::new();
    let mut add = |key: Key, tags: &lanewright::osm::Tags, place: String, mut references: Vec<(String, Key)>| {
        let mut rest = vec![place];
        for (name, value) in tags.iter() {
            // Ids in tags are references, too.
            match value.parse() {
                Ok(id) if matches!(name, "intersection_area" | "traffic_light_id") => {
                    references.push((name.to_owned(), ('w', id)));
                }
                _ => rest.push(format!("{name}={value}")),
            }
        }
        all.entry(key).or_default().push(Element { rest, references });
    };
    for node in &data.nodes {
        add(('n', node.id), &node.tags, format!("{:?}", node.position), Vec::new());
    }
    for way in &data.ways {
        let nodes = way.nodes.iter().map(|&id| (String::new(), ('n', id))).collect();
        add(('w', way.id), &way.tags, String::new(), nodes);
    }
    for relation in &data.relations {
        let members = relation.members.iter().map(|one| (one.role.to_string(), (letter(one.kind), one.id)));
        add(('r', relation.id), &relation.tags, String::new(), members.collect());
    }
    all
}

/// What an element refers to.
fn targets(all: &Elements, key: Key) -> BTreeSet<Key> {
    let found = all.get(&key).into_iter().flatten();
    found.flat_map(|element| element.references.iter().map(|(_, target)| *target)).collect()
}

/// What gives an element its shape: the points of a way, the ways of a relation with their points.
fn shape(all: &Elements, key: Key) -> BTreeSet<Key> {
    let own = targets(all, key);
    let ways = own.iter().filter(|target| target.0 == 'w');
    let inner: Vec<Key> = ways.flat_map(|&way| targets(all, way)).collect();
    own.iter().copied().chain(inner).filter(|target| target.0 != 'r').collect()
}

/// The things in which two maps differ, each with its elements.
pub fn things(good: &OsmData, bad: &OsmData) -> Vec<BTreeSet<Key>> {
    let (good, bad) = (elements(good), elements(bad));
    let added: BTreeSet<Key> = bad.keys().filter(|key| !good.contains_key(key)).copied().collect();
    let removed: BTreeSet<Key> = good.keys().filter(|key| !bad.contains_key(key)).copied().collect();
    let come_or_gone = |key: &Key| added.contains(key) || removed.contains(key);
    let without = |elements: &[Element]| -> Vec<Element> {
        let mut elements = elements.to_vec();
        elements.iter_mut().for_each(|one| one.references.retain(|(_, target)| !come_or_gone(target)));
        elements
    };
    // Who only gains a reference to what is new, or loses one to what is gone, has not changed himself.
    let changed = good.iter().filter(|(key, one)| bad.get(key).is_some_and(|other| without(one) != without(other)));
    let changed: BTreeSet<Key> = changed.map(|(key, _)| *key).collect();
    let all: BTreeSet<Key> = added.iter().chain(&removed).chain(&changed).copied().collect();
    let mut groups: Vec<BTreeSet<Key>> = all.iter().map(|&key| BTreeSet::from([key])).collect();
    // A thing has its parts with it.
    for (elements, set) in [(&bad, &added), (&good, &removed)] {
        for &key in set.iter().chain(&changed) {
            for target in targets(elements, key).into_iter().filter(|target| set.contains(target)) {
                join(&mut groups, key, target);
            }
        }
    }
    // Points of one way, and points and ways of one lanelet, are its shape.
    for kinds in [&['n'][..], &['n', 'w'][..]] {
        let loose = groups.iter().filter(|group| group.iter().all(|key| kinds.contains(&key.0)));
        let loose: BTreeSet<Key> = loose.flatten().copied().collect();
        let of_one = |&key: &Key| {
            let mut own = shape(&good, key);
            own.extend(shape(&bad, key));
            loose.is_subset(&own)
        };
        if let Some(&first) = loose.first()
            && good.keys().any(of_one)
        {
            loose.iter().for_each(|&key| join(&mut groups, first, key));
        }
    }
    // What takes the place of another is one thing with it.
    let of = |set: &BTreeSet<Key>| -> Vec<Key> {
        groups.iter().filter(|group| group.is_subset(set)).filter_map(|group| group.first().copied()).collect()
    };
    if let ([new], [old]) = (&of(&added)[..], &of(&removed)[..]) {
        join(&mut groups, *new, *old);
    }
    groups
}

fn join(groups: &mut Vec<BTreeSet<Key>>, a: Key, b: Key) {
    let Some(at) = groups.iter().position(|group| group.contains(&b)) else { return };
    if groups[at].contains(&a) {
        return;
    }
    let moved = groups.swap_remove(at);
    if let Some(group) = groups.iter_mut().find(|group| group.contains(&a)) {
        group.extend(moved);
    }
}
