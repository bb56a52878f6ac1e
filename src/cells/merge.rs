//! Puts maps together: what two maps have in common, word for word, stands in the result once.

use std::io::{self, Write};

use rustc_hash::{FxHashMap, FxHashSet};

use super::NAMING;
use super::renumber::{NewIds, renumbered};
use crate::osm::{Content, ElementKind, OsmData, OsmText, Tags};
use crate::text::SourceSpan;

type Key = (ElementKind, i64);

/// Two elements of one id in two maps, which differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collision {
    /// The kind of both.
    pub kind: ElementKind,
    /// The id of both.
    pub id: i64,
    /// The map that has the second, by its position in the list.
    pub map: usize,
}

/// Several maps as one.
#[derive(Debug)]
pub struct Merge<'a> {
    maps: &'a [OsmData],
    /// What is to be written, by kind and id.
    kept: Vec<Kept>,
    /// The ids that elements of each map get.
    new_ids: Vec<NewIds>,
    /// Elements that share their id with another element, in the order of the maps, kinds and ids.
    pub collisions: Vec<Collision>,
}

/// An element of the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Kept {
    kind: ElementKind,
    id: i64,
    map: usize,
    at: usize,
}

impl<'a> Merge<'a> {
    /// Puts maps together. Elements that collide with those of a map before get other ids.
    pub fn of(maps: &'a [OsmData]) -> Self {
        let mut merge = Self { maps, kept: Vec::new(), new_ids: Vec::new(), collisions: Vec::new() };
        let mut said: FxHashMap<Key, u64> = FxHashMap::default();
        let mut used: Option<FxHashSet<i64>> = None;
        let mut next = 0;
        for (map, osm) in maps.iter().enumerate() {
            let own = contents(osm);
            let mut colliding: Vec<Key> = own
                .iter()
                .filter(|(key, own)| said.get(key).is_some_and(|other| other != *own))
                .map(|(key, _)| *key)
                .collect();
            colliding.sort_unstable();
            merge.collisions.extend(colliding.iter().map(|&(kind, id)| Collision { kind, id, map }));
            let used = match colliding.is_empty() {
                true => None,
                false => Some(used.get_or_insert_with(|| maps.iter().flat_map(ids).collect())),
            };
            let others = with_referrers(osm, colliding, &said);
            // The smallest that are free: small enough for polygons, whose ids Autoware reads with 32 bits.
            let mut free = || {
                next += 1;
                while used.as_ref().is_some_and(|used| used.contains(&next)) {
                    next += 1;
                }
                next
            };
            let new: NewIds = others.into_iter().map(|key| (key, free())).collect();
            merge.keep(map, &said, &new);
            said.extend(own.into_iter().map(|((kind, id), own)| {
                let key = (kind, new.get(&(kind, id)).copied().unwrap_or(id));
                (key, own)
            }));
            merge.new_ids.push(new);
        }
        merge.kept.sort_unstable();
        merge
    }

    /// Keeps the elements of a map that no map before has.
    fn keep(&mut self, map: usize, said: &FxHashMap<Key, u64>, new: &NewIds) {
        for (at, kind, id) in elements(&self.maps[map]) {
            let id = match new.get(&(kind, id)) {
                Some(new) => *new,
                None if said.contains_key(&(kind, id)) => continue,
                None => id,
            };
            self.kept.push(Kept { kind, id, map, at });
        }
    }

    /// How many nodes, ways and relations there are.
    pub fn counts(&self) -> [usize; 3] {
        [ElementKind::Node, ElementKind::Way, ElementKind::Relation]
            .map(|kind| self.kept.iter().filter(|kept| kept.kind == kind).count())
    }

    /// How many elements have got another id.
    pub fn renumbered(&self) -> usize {
        self.new_ids.iter().map(FxHashMap::len).sum()
    }

    /// Writes the map: nodes, ways, relations, each by ascending id, with their own text.
    ///
    /// # Errors
    ///
    /// Where `out` fails.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let generator = self.maps.iter().find_map(|osm| osm.generator.as_deref()).unwrap_or("lanewright");
        let meta = self.maps.iter().find_map(|osm| osm.meta.clone()).unwrap_or_default();
        out.write_all(OsmText::head_by(generator, &meta).as_bytes())?;
        for kept in &self.kept {
            let (osm, new) = (&self.maps[kept.map], &self.new_ids[kept.map]);
            let mut made = OsmText::default();
            let text = text(osm, kept, &mut made);
            out.write_all(b"  ")?;
            match new.is_empty() {
                true => out.write_all(text.as_bytes())?,
                false => out.write_all(renumbered(kept.kind, text, new).as_bytes())?,
            }
            out.write_all(b"\n")?;
        }
        out.write_all(OsmText::tail().as_bytes())
    }
}

/// The text of an element: its own, or one that is made where its file has none.
fn text<'t>(osm: &'t OsmData, kept: &Kept, made: &'t mut OsmText) -> &'t str {
    let span = span_of(osm, kept);
    let source = osm.sources.get(span.file as usize).map_or("", |source| source.text.as_str());
    match source.get(span.start as usize..span.end as usize) {
        Some(own) if !own.is_empty() => own,
        _ => {
            match kept.kind {
                ElementKind::Node => made.put_node(&osm.nodes[kept.at]),
                ElementKind::Way => made.put_way(&osm.ways[kept.at]),
                ElementKind::Relation => made.put_relation(&osm.relations[kept.at]),
            }
            std::str::from_utf8(made.as_bytes()).unwrap_or_default().trim()
        }
    }
}

fn span_of<'o>(osm: &'o OsmData, kept: &Kept) -> &'o SourceSpan {
    match kept.kind {
        ElementKind::Node => &osm.nodes[kept.at].span,
        ElementKind::Way => &osm.ways[kept.at].span,
        ElementKind::Relation => &osm.relations[kept.at].span,
    }
}

/// All elements of a map with their positions in its lists.
fn elements(osm: &OsmData) -> impl Iterator<Item = (usize, ElementKind, i64)> {
    let nodes = osm.nodes.iter().enumerate().map(|(at, one)| (at, ElementKind::Node, one.id));
    let ways = osm.ways.iter().enumerate().map(|(at, one)| (at, ElementKind::Way, one.id));
    let relations = osm.relations.iter().enumerate().map(|(at, one)| (at, ElementKind::Relation, one.id));
    nodes.chain(ways).chain(relations)
}

fn ids(osm: &OsmData) -> impl Iterator<Item = i64> {
    elements(osm).map(|(_, _, id)| id)
}

/// What a map says of each id; what it says twice counts twice.
fn contents(osm: &OsmData) -> FxHashMap<Key, u64> {
    let mut said: FxHashMap<Key, u64> = FxHashMap::default();
    let mut note = |kind, id, content: u64| {
        let all = said.entry((kind, id)).or_default();
        *all = all.wrapping_add(content);
    };
    osm.nodes.iter().for_each(|one| note(ElementKind::Node, one.id, one.fingerprint()));
    osm.ways.iter().for_each(|one| note(ElementKind::Way, one.id, one.fingerprint()));
    osm.relations.iter().for_each(|one| note(ElementKind::Relation, one.id, one.fingerprint()));
    said
}

/// These elements, and whatever refers to them and has its like in another map: the same words there mean other elements.
fn with_referrers(osm: &OsmData, colliding: Vec<Key>, said: &FxHashMap<Key, u64>) -> Vec<Key> {
    if colliding.is_empty() {
        return colliding;
    }
    let mut referrers: FxHashMap<Key, Vec<Key>> = FxHashMap::default();
    let mut note = |from: Key, to: Key| {
        if said.contains_key(&from) && said.contains_key(&to) {
            referrers.entry(to).or_default().push(from);
        }
    };
    for way in &osm.ways {
        let key = (ElementKind::Way, way.id);
        way.nodes.iter().for_each(|node| note(key, (ElementKind::Node, *node)));
        named(&way.tags).for_each(|id| note(key, (ElementKind::Way, id)));
    }
    for relation in &osm.relations {
        let key = (ElementKind::Relation, relation.id);
        relation.members.iter().for_each(|member| note(key, (member.kind, member.id)));
        named(&relation.tags).for_each(|id| note(key, (ElementKind::Way, id)));
    }
    let mut found: FxHashSet<Key> = colliding.iter().copied().collect();
    let mut queue = colliding;
    while let Some(key) = queue.pop() {
        for referrer in referrers.get(&key).into_iter().flatten() {
            if found.insert(*referrer) {
                queue.push(*referrer);
            }
        }
    }
    let mut found: Vec<Key> = found.into_iter().collect();
    found.sort_unstable();
    found
}

/// The ways that the tags of an element name.
fn named(tags: &Tags) -> impl Iterator<Item = i64> {
    NAMING.iter().filter_map(|key| tags.get(key)?.trim().parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osm::read_bytes;

    fn map(text: &str) -> OsmData {
        let mut data = OsmData::default();
        read_bytes(&mut data, "test", format!("<osm generator='g'>{text}</osm>").into_bytes()).unwrap();
        data
    }

    fn written(maps: &[OsmData]) -> (String, usize) {
        let merge = Merge::of(maps);
        let mut out = Vec::new();
        merge.write(&mut out).unwrap();
        (String::from_utf8(out).unwrap(), merge.collisions.len())
    }

    fn node(id: i64, lat: i64) -> String {
        format!("<node id='{id}' lat='{lat}' lon='2'/>")
    }

    #[test]
    fn what_two_maps_share_stands_there_once() {
        let maps = [map(&[node(2, 0), node(1, 0)].concat()), map(&[node(2, 0), node(3, 0)].concat())];
        let (text, collisions) = written(&maps);
        let body = [1, 2, 3].map(|id| format!("  {}\n", node(id, 0))).concat();
        assert_eq!(collisions, 0);
        assert!(text.contains("generator=\"g\"") && text.contains(&format!("\">\n{body}</osm>\n")), "{text}");
    }

    #[test]
    fn what_collides_gets_another_id_with_all_that_means_it() {
        let way = "<way id='5'><nd ref='1'/><nd ref='2'/></way>";
        let other = "<way id='6'><nd ref='1'/></way>";
        let first = map(&[&node(1, 0), &node(2, 0), way].concat());
        let second = map(&[&node(1, 9), &node(2, 0), way, other].concat());
        let maps = [first, second];
        assert_eq!(Merge::of(&maps).collisions, [Collision { kind: ElementKind::Node, id: 1, map: 1 }]);
        let data = map(written(&maps).0.split_once("\">\n").unwrap().1.trim_end_matches("</osm>\n"));
        // The node, and the way that has the same words in both maps.
        let ids = |of: Vec<i64>| of;
        assert_eq!(ids(data.nodes.iter().map(|one| one.id).collect()), [1, 2, 3]);
        assert_eq!(ids(data.ways.iter().map(|one| one.id).collect()), [4, 5, 6]);
        assert_eq!((data.way(4).unwrap().nodes.clone(), data.way(5).unwrap().nodes.clone()), (vec![3, 2], vec![1, 2]));
        assert_eq!(data.way(6).unwrap().nodes, [3]);
        assert_eq!(data.node(3).unwrap().position.unwrap().lat, 9.0);
    }

    #[test]
    fn three_maps_with_the_same_ids_become_one() {
        let maps = [0, 1, 2].map(|lat| {
            map(&[&node(1, lat), "<relation id='1'><member type='node' ref='1' role=''/></relation>"].concat())
        });
        let merge = Merge::of(&maps);
        assert_eq!((merge.counts(), merge.renumbered(), merge.collisions.len()), ([3, 0, 3], 4, 2));
    }
}
