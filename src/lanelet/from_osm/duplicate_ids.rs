//! Elements that share an id: what the last of them is, and which elements refer to it.

use nalgebra::Vector2;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{SourceSpan, Subject};
use crate::lanelet::fault::Repeat;
use crate::osm::{ElementKind, Member, Node, OsmData, Relation, Tags, Way};
use crate::projection::LonLat;

use super::relation_type::RelationType;

type Key = (ElementKind, i64);

/// A way belongs to one of two nodes with the same id if the detour over the other node is this many times as long.
const PLAIN: f64 = 3.0;

/// The elements around those with repeated ids; empty if no id repeats.
pub struct DuplicateIds<'a> {
    osm: &'a OsmData,
    nodes: FxHashMap<i64, Vec<&'a Node>>,
    ways: FxHashMap<i64, Vec<&'a Way>>,
    relations: FxHashMap<i64, Vec<&'a Relation>>,
    /// The ways that have a node.
    users: FxHashMap<i64, Vec<&'a Way>>,
    /// The relations that refer to an element, each with the role.
    referrers: FxHashMap<Key, Vec<(i64, &'a str)>>,
    /// Ways that tags name.
    named: FxHashSet<i64>,
    /// The first way over each list of nodes.
    way_of: FxHashMap<&'a [i64], &'a Way>,
    relation_of: FxHashMap<Vec<(ElementKind, i64, &'a str)>, &'a Relation>,
}

impl<'a> DuplicateIds<'a> {
    /// Collects what is needed for these ids, which come with the positions of their elements.
    pub fn of(osm: &'a OsmData, repeated: &FxHashMap<Key, Vec<SourceSpan>>) -> Self {
        let mut all = Self {
            osm,
            nodes: FxHashMap::default(),
            ways: FxHashMap::default(),
            relations: FxHashMap::default(),
            users: FxHashMap::default(),
            referrers: FxHashMap::default(),
            named: FxHashSet::default(),
            way_of: FxHashMap::default(),
            relation_of: FxHashMap::default(),
        };
        if !repeated.is_empty() {
            all.fill(repeated);
        }
        all
    }

    fn fill(&mut self, repeated: &FxHashMap<Key, Vec<SourceSpan>>) {
        let osm = self.osm;
        let is = |kind, id| repeated.contains_key(&(kind, id));
        for node in osm.nodes.iter().filter(|node| is(ElementKind::Node, node.id)) {
            self.nodes.entry(node.id).or_default().push(node);
        }
        for way in &osm.ways {
            let own: FxHashSet<i64> = way.nodes.iter().copied().filter(|&id| is(ElementKind::Node, id)).collect();
            own.into_iter().for_each(|id| self.users.entry(id).or_default().push(way));
            match is(ElementKind::Way, way.id) {
                true => self.ways.entry(way.id).or_default().push(way),
                false => _ = self.way_of.entry(&way.nodes).or_insert(way),
            }
        }
        for relation in &osm.relations {
            for member in relation.members.iter().filter(|member| is(member.kind, member.id)) {
                let list = self.referrers.entry((member.kind, member.id)).or_default();
                list.push((relation.id, &member.role));
            }
            match is(ElementKind::Relation, relation.id) {
                true => self.relations.entry(relation.id).or_default().push(relation),
                false => _ = self.relation_of.entry(made_of(&relation.members)).or_insert(relation),
            }
        }
        let tags = osm.relations.iter().map(|one| &one.tags).chain(osm.ways.iter().map(|one| &one.tags));
        let names = tags.flat_map(|tags| ["intersection_area", "traffic_light_id"].map(|key| tags.get(key)));
        self.named.extend(names.flatten().filter_map(|value| value.parse::<i64>().ok()));
    }

    /// The last of the elements that have this id.
    pub fn last(&self, kind: ElementKind, id: i64) -> Repeat {
        match kind {
            ElementKind::Node => self.node(id),
            ElementKind::Way => self.way(id),
            ElementKind::Relation => self.relation(id),
        }
    }

    fn node(&self, id: i64) -> Repeat {
        let Some([first, last]) = two(&self.nodes, id) else { return SEVERAL };
        if first.position == last.position {
            return if same(&first.tags, &last.tags) { Repeat::Copy } else { TAGS };
        }
        let unclear = |why| Repeat::Unclear { why };
        if self.referrers.contains_key(&(ElementKind::Node, id)) {
            return unclear("a relation refers to it");
        }
        let mut referrers = Vec::new();
        for way in self.users.get(&id).into_iter().flatten() {
            let [a, b] = [first, last].map(|node| self.detour(way, node));
            let (Some(a), Some(b)) = (a, b) else { return unclear("a way that has it has no other node") };
            if b * PLAIN < a {
                referrers.push(Subject::Way(way.id));
            } else if a * PLAIN >= b {
                return unclear("a way that has it may run to either");
            }
        }
        Repeat::Other { referrers }
    }

    /// The length of a way from the vertex before a node over the node to the vertex behind it, in degrees of latitude; `None` if
    /// the way has no other node.
    fn detour(&self, way: &Way, node: &Node) -> Option<f64> {
        let here = node.position?;
        let apart = |other: LonLat| {
            let lon = (other.lon - here.lon) * here.lat.to_radians().cos();
            Vector2::new(lon, other.lat - here.lat).norm()
        };
        let beside = way.nodes.windows(2).filter(|pair| (pair[0] == node.id) != (pair[1] == node.id));
        let others = beside.map(|pair| if pair[0] == node.id { pair[1] } else { pair[0] });
        let lengths: Vec<f64> = others.filter_map(|other| Some(apart(self.osm.node(other)?.position?))).collect();
        (!lengths.is_empty()).then(|| lengths.iter().sum())
    }

    fn way(&self, id: i64) -> Repeat {
        let Some([first, last]) = two(&self.ways, id) else { return SEVERAL };
        if first.nodes == last.nodes {
            return if same(&first.tags, &last.tags) { Repeat::Copy } else { TAGS };
        }
        match self.way_of.get(last.nodes.as_slice()).filter(|twin| same(&twin.tags, &last.tags)) {
            Some(twin) => Repeat::Twin { id: twin.id },
            None => self.unless_referred(ElementKind::Way, id),
        }
    }

    fn relation(&self, id: i64) -> Repeat {
        let Some([first, last]) = two(&self.relations, id) else { return SEVERAL };
        if first.members == last.members {
            return if same(&first.tags, &last.tags) { Repeat::Copy } else { TAGS };
        }
        if let Some(twin) = self.relation_of.get(&made_of(&last.members)).filter(|twin| same(&twin.tags, &last.tags)) {
            return Repeat::Twin { id: twin.id };
        }
        let kinds = [first, last].map(|one| RelationType::of(&one.tags));
        if kinds[0] == kinds[1] {
            return self.unless_referred(ElementKind::Relation, id);
        }
        // The role tells whether a lanelet or a regulatory element refers to it.
        let mut referrers = Vec::new();
        for &(referrer, role) in self.referrers.get(&(ElementKind::Relation, id)).into_iter().flatten() {
            let element = role == "regulatory_element";
            let wanted = if element { RelationType::RegulatoryElement } else { RelationType::Lanelet };
            if kinds[1] == wanted {
                referrers.push(Subject::Relation(referrer));
            } else if kinds[0] != wanted {
                return Repeat::Unclear { why: "a relation refers to neither kind of element" };
            }
        }
        Repeat::Other { referrers }
    }

    /// An element without references can have any id.
    fn unless_referred(&self, kind: ElementKind, id: i64) -> Repeat {
        let named = kind == ElementKind::Way && self.named.contains(&id);
        match named || self.referrers.contains_key(&(kind, id)) {
            true => Repeat::Unclear { why: "what refers to it may mean either" },
            false => Repeat::Other { referrers: Vec::new() },
        }
    }
}

const SEVERAL: Repeat = Repeat::Unclear { why: "more than two elements have it" };
const TAGS: Repeat = Repeat::Unclear { why: "they differ in their tags alone, and either may be right" };

fn two<'a, T>(of: &FxHashMap<i64, Vec<&'a T>>, id: i64) -> Option<[&'a T; 2]> {
    of.get(&id)?.as_slice().try_into().ok()
}

fn made_of(members: &[Member]) -> Vec<(ElementKind, i64, &str)> {
    members.iter().map(|member| (member.kind, member.id, member.role.as_str())).collect()
}

/// Whether these are the same tags, in whatever order.
fn same(a: &Tags, b: &Tags) -> bool {
    let sorted = |tags: &Tags| {
        let mut all: Vec<(String, String)> = tags.iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
        all.sort_unstable();
        all
    };
    sorted(a) == sorted(b)
}
