//! A map in pieces: what a mutation can change, and the map's text after it.

use std::collections::BTreeSet;

use lanewright::geometry::{Point, Vector};
use lanewright::osm::{ElementKind, Member, MetaInfo, Node, OsmData, OsmText, Relation, Tags, Way};
use lanewright::projection::Projector;

/// Numbers from a seed, the same on every machine (SplitMix64).
pub struct Dice(pub u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `count`, which must not be 0.
    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    /// One of them; `None` if there is none.
    pub fn pick<T>(&mut self, from: impl IntoIterator<Item = T>) -> Option<T> {
        let mut all: Vec<T> = from.into_iter().collect();
        if all.is_empty() { None } else { Some(all.swap_remove(self.below(all.len()))) }
    }

    /// Another order.
    pub fn shuffle<T>(&mut self, all: &mut [T]) {
        for at in (1..all.len()).rev() {
            all.swap(at, self.below(at + 1));
        }
    }
}

/// The elements of a map, free to be changed.
#[derive(Clone)]
pub struct Draft {
    pub meta: MetaInfo,
    pub nodes: Vec<Node>,
    pub ways: Vec<Way>,
    pub relations: Vec<Relation>,
    pub projector: Projector,
}

impl Draft {
    /// The map, every node with `local_x` and `local_y`, as editors write them.
    pub fn of(data: &OsmData, projector: Projector) -> Self {
        let mut draft = Self {
            meta: data.meta.clone().unwrap_or_default(),
            nodes: data.nodes.clone(),
            ways: data.ways.clone(),
            relations: data.relations.clone(),
            projector,
        };
        for node in &mut draft.nodes {
            set_local(node, projector.forward(node.position.unwrap(), 0.0).unwrap());
        }
        draft
    }

    /// The file that says so.
    pub fn text(&self) -> Vec<u8> {
        let mut out = OsmText::default();
        self.nodes.iter().for_each(|node| out.node(node.id, node.position, node.tags.iter()));
        self.ways.iter().for_each(|way| out.way(way.id, way.nodes.iter().copied(), way.tags.iter()));
        for relation in &self.relations {
            let members = relation.members.iter().map(|member| (member.kind, member.id, member.role.as_str()));
            out.relation(relation.id, members, relation.tags.iter());
        }
        [OsmText::head(&self.meta), out, OsmText::tail()].map(|text| text.as_bytes().to_vec()).concat()
    }

    pub fn node(&mut self, id: i64) -> &mut Node {
        self.nodes.iter_mut().find(|node| node.id == id).unwrap()
    }

    pub fn way(&mut self, id: i64) -> &mut Way {
        self.ways.iter_mut().find(|way| way.id == id).unwrap()
    }

    pub fn relation(&mut self, id: i64) -> &mut Relation {
        self.relations.iter_mut().find(|relation| relation.id == id).unwrap()
    }

    /// An id that nothing has.
    pub fn fresh(&self) -> i64 {
        let ways = self.ways.iter().map(|way| way.id);
        let relations = self.relations.iter().map(|relation| relation.id);
        1 + self.nodes.iter().map(|node| node.id).chain(ways).chain(relations).max().unwrap()
    }

    /// A second node like this one; its id.
    pub fn copy_node(&mut self, id: i64) -> i64 {
        let node = Node { id: self.fresh(), ..self.node(id).clone() };
        self.nodes.push(node);
        self.nodes.last().unwrap().id
    }

    /// A second way over the same nodes; its id.
    pub fn copy_way(&mut self, id: i64) -> i64 {
        let way = Way { id: self.fresh(), ..self.way(id).clone() };
        self.ways.push(way);
        self.ways.last().unwrap().id
    }

    /// Where a node lies, local metres.
    pub fn place(&self, id: i64) -> Point {
        let node = self.nodes.iter().find(|node| node.id == id).unwrap();
        let local = |key| node.tags.get(key).unwrap().parse().unwrap();
        Point::new(local("local_x"), local("local_y"))
    }

    /// The places of a way's nodes.
    pub fn line(&self, way: i64) -> Vec<Point> {
        let way = self.ways.iter().find(|one| one.id == way).unwrap();
        way.nodes.iter().map(|&node| self.place(node)).collect()
    }

    /// Moves a node, by all that says where it lies.
    pub fn shift(&mut self, id: i64, by: Vector) {
        let to = self.place(id) + by;
        let lonlat = self.projector.inverse(to);
        let node = self.node(id);
        node.position = lonlat;
        set_local(node, to);
    }

    /// Relations of `type=lanelet`.
    pub fn lanelets(&self) -> impl Iterator<Item = &Relation> {
        self.relations.iter().filter(|relation| relation.tags.is("type", "lanelet"))
    }

    /// Lanelets through an intersection.
    pub fn movements(&self) -> impl Iterator<Item = &Relation> {
        self.lanelets().filter(|lanelet| lanelet.tags.has("intersection_area"))
    }

    /// The regulatory elements of a subtype.
    pub fn elements<'a>(&'a self, subtype: &'a str) -> impl Iterator<Item = &'a Relation> {
        let elements = self.relations.iter().filter(|relation| relation.tags.is("type", "regulatory_element"));
        elements.filter(move |relation| relation.tags.is("subtype", subtype))
    }

    /// The ways of a type.
    pub fn lines<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a Way> {
        self.ways.iter().filter(move |way| way.tags.is("type", kind))
    }

    /// The lanelets that refer to an element.
    pub fn referrers(&self, element: i64) -> Vec<i64> {
        let refers = |lanelet: &&Relation| members(lanelet, "regulatory_element").any(|id| id == element);
        self.lanelets().filter(refers).map(|lanelet| lanelet.id).collect()
    }

    /// The lanelets that a way bounds.
    pub fn bounded(&self, way: i64) -> Vec<i64> {
        let bounds = |lanelet: &&Relation| bounds(lanelet).contains(&way);
        self.lanelets().filter(bounds).map(|lanelet| lanelet.id).collect()
    }

    /// The ways that bound movements.
    pub fn inner_bounds(&self) -> BTreeSet<i64> {
        self.movements().flat_map(bounds).collect()
    }

    /// The element of a subtype to which a lanelet refers.
    pub fn element_of(&self, lanelet: &Relation, subtype: &str) -> Option<i64> {
        let own: Vec<i64> = members(lanelet, "regulatory_element").collect();
        self.elements(subtype).map(|element| element.id).find(|id| own.contains(id))
    }

    /// Takes an element out with every reference to it.
    pub fn remove(&mut self, kind: ElementKind, id: i64) {
        self.remove_alone(kind, id);
        for relation in &mut self.relations {
            relation.members.retain(|member| (member.kind, member.id) != (kind, id));
        }
    }

    /// Takes an element out and leaves the references to it.
    pub fn remove_alone(&mut self, kind: ElementKind, id: i64) {
        match kind {
            ElementKind::Node => self.nodes.retain(|node| node.id != id),
            ElementKind::Way => self.ways.retain(|way| way.id != id),
            ElementKind::Relation => self.relations.retain(|relation| relation.id != id),
        }
    }

    /// Gives an element another id, wherever it is spoken of.
    pub fn renumber(&mut self, kind: ElementKind, from: i64, to: i64) {
        match kind {
            ElementKind::Node => {
                self.node(from).id = to;
                let refs = self.ways.iter_mut().flat_map(|way| &mut way.nodes);
                refs.filter(|node| **node == from).for_each(|node| *node = to);
            }
            ElementKind::Way => self.way(from).id = to,
            ElementKind::Relation => self.relation(from).id = to,
        }
        for member in self.relations.iter_mut().flat_map(|relation| &mut relation.members) {
            if (member.kind, member.id) == (kind, from) {
                member.id = to;
            }
        }
        if kind == ElementKind::Way {
            let named = |relation: &&mut Relation| relation.tags.is("intersection_area", &from.to_string());
            self.relations.iter_mut().filter(named).for_each(|lanelet| {
                lanelet.tags.set("intersection_area", to.to_string());
            });
        }
    }
}

/// The targets of a role.
pub fn members<'a>(relation: &'a Relation, role: &'a str) -> impl Iterator<Item = i64> + 'a {
    relation.members.iter().filter(move |member| member.role == role).map(|member| member.id)
}

/// Left and right.
pub fn bounds(lanelet: &Relation) -> [i64; 2] {
    ["left", "right"].map(|role| members(lanelet, role).next().unwrap())
}

pub fn without(tags: &Tags, key: &str) -> Tags {
    tags.iter().filter(|(own, _)| *own != key).collect()
}

/// A reference from a relation to another.
pub fn relation_member(id: i64, role: &str) -> Member {
    Member { kind: ElementKind::Relation, id, role: role.into() }
}

/// Says in metres where a node lies.
fn set_local(node: &mut Node, place: Point) {
    node.tags.set("local_x", format!("{:.4}", place.x));
    node.tags.set("local_y", format!("{:.4}", place.y));
}
