//! Mutations that break the file: Autoware's loader stumbles, or reads something else than was meant.

use lanewright::geometry::Vector;
use lanewright::osm::ElementKind::{Node, Relation, Way};

use super::draft::{Dice, Draft, bounds, members, without};
use super::{Kind, kind};

pub const KINDS: &[Kind] = &[
    kind("delete a node of a way", &["load/missing-ref"], |_, map, dice| {
        let way = dice.pick(&map.ways)?;
        let (way, node) = (way.id, dice.pick(way.nodes.clone())?);
        map.remove_alone(Node, node);
        Some(vec![way])
    }),
    kind("delete a bound", &["load/missing-ref"], |_, map, dice| {
        let lanelet = dice.pick(map.lanelets())?;
        let (lanelet, way) = (lanelet.id, dice.pick(bounds(lanelet))?);
        map.remove_alone(Way, way);
        Some(vec![lanelet])
    }),
    kind("delete a lanelet that gives way", &["load/missing-ref"], |_, map, dice| {
        let element = dice.pick(map.elements("right_of_way"))?;
        let (element, lanelet) = (element.id, dice.pick(members(element, "yield"))?);
        map.remove_alone(Relation, lanelet);
        Some(vec![element])
    }),
    kind("delete an element that lanelets refer to", &["load/missing-ref"], |_, map, dice| {
        let lanelets =
            map.lanelets().flat_map(|lanelet| members(lanelet, "regulatory_element").map(|id| (lanelet.id, id)));
        let (lanelet, element) = dice.pick(lanelets)?;
        map.remove_alone(Relation, element);
        Some(vec![lanelet])
    }),
    kind("duplicate a node's id", &["ids/duplicate"], |_, map, dice| {
        let (id, at) = (dice.pick(&map.nodes)?.id, dice.below(map.nodes.len()));
        let copy = map.node(id).clone();
        map.nodes.insert(at, copy);
        Some(vec![id])
    }),
    kind("give a node the id of another", &["ids/duplicate"], |_, map, dice| {
        let (from, to) = (dice.pick(&map.nodes)?.id, dice.pick(&map.nodes)?.id);
        (from != to).then(|| map.renumber(Node, from, to))?;
        Some(vec![to])
    }),
    kind("duplicate a way's id", &["ids/duplicate"], |_, map, dice| {
        let (copy, other) = (dice.pick(&map.ways)?.id, dice.pick(&map.ways)?.id);
        let mut copy = map.way(copy).clone();
        copy.id = other;
        map.ways.push(copy);
        Some(vec![other])
    }),
    kind("duplicate a relation's id", &["ids/duplicate"], |_, map, dice| {
        let (copy, other) = (dice.pick(&map.relations)?.id, dice.pick(&map.relations)?.id);
        let mut copy = map.relation(copy).clone();
        copy.id = other;
        map.relations.push(copy);
        Some(vec![other])
    }),
    kind("give an element a negative id", &["ids/range", "vm-03-01/ia-id-range"], |_, map, dice| {
        let kind = dice.pick([Node, Way, Relation])?;
        let id = any(map, dice, kind)?;
        map.renumber(kind, id, -id);
        Some(vec![-id])
    }),
    kind("give an area an id beyond 31 bits", &["vm-03-01/ia-id-range"], |_, map, dice| {
        let id = dice.pick(map.ways.iter().filter(|way| way.tags.is("area", "yes")))?.id;
        map.renumber(Way, id, id + (1 << 31));
        Some(vec![id + (1 << 31)])
    }),
    kind("drop a bound of a lanelet", &["load/bound-count"], |_, map, dice| {
        let (id, role) = (dice.pick(map.lanelets())?.id, dice.pick(["left", "right"])?);
        map.relation(id).members.retain(|member| member.role != role);
        Some(vec![id])
    }),
    kind("give a lanelet a second bound", &["load/bound-count"], |_, map, dice| {
        let id = dice.pick(map.lanelets())?.id;
        let mut again = dice.pick(map.relation(id).members.iter().filter(|member| member.role == "left"))?.clone();
        again.id = dice.pick(map.lines("virtual").filter(|way| way.id != again.id))?.id;
        map.relation(id).members.push(again);
        Some(vec![id])
    }),
    kind("mark a bound as area", &["load/bound-polygon"], |_, map, dice| {
        let lanelet = dice.pick(map.lanelets())?;
        let (id, way) = (lanelet.id, dice.pick(bounds(lanelet))?);
        map.way(way).tags.set("area", "yes");
        Some(vec![id])
    }),
    kind("empty a way", &["load/empty-way"], |_, map, dice| {
        let id = dice.pick(&map.ways)?.id;
        map.way(id).nodes.clear();
        Some(vec![id])
    }),
    kind("cut a bound down to one node", &["load/bound-short"], |_, map, dice| {
        let lanelet = dice.pick(map.lanelets())?;
        let (id, way) = (lanelet.id, dice.pick(bounds(lanelet))?);
        map.way(way).nodes.truncate(1);
        Some(vec![id])
    }),
    kind("drop a relation's type", &["load/relation-type"], |_, map, dice| {
        let id = dice.pick(&map.relations)?.id;
        map.relation(id).tags = without(&map.relation(id).tags, "type");
        Some(vec![id])
    }),
    kind("misspell an element's subtype", &["load/re-subtype"], |_, map, dice| {
        let id = dice.pick(elements(map))?;
        let subtype = map.relation(id).tags.get("subtype")?.replacen('_', "-", 1) + "s";
        map.relation(id).tags.set("subtype", subtype);
        Some(vec![id])
    }),
    kind("drop an element's subtype", &["load/re-subtype"], |_, map, dice| {
        let id = dice.pick(elements(map))?;
        map.relation(id).tags = without(&map.relation(id).tags, "subtype");
        Some(vec![id])
    }),
    kind("delete all yields of an element", &["load/re-members"], |_, map, dice| {
        let id = dice.pick(map.elements("right_of_way"))?.id;
        map.relation(id).members.retain(|member| member.role != "yield");
        Some(vec![id])
    }),
    kind("drop what a light or marking refers to", &["load/re-members"], |_, map, dice| {
        let id = dice.pick(map.elements("traffic_light").chain(map.elements("road_marking")))?.id;
        map.relation(id).members.retain(|member| member.role != "refers");
        Some(vec![id])
    }),
    kind("refer to a lanelet as element", &["load/element-type"], |_, map, dice| {
        let (id, other) = (dice.pick(map.lanelets())?.id, dice.pick(map.lanelets())?.id);
        map.relation(id).members.push(super::draft::relation_member(other, "regulatory_element"));
        Some(vec![id])
    }),
    kind("drop a height", &["node/no-ele", "node/ele-left-out"], |_, map, dice| {
        let id = dice.pick(&map.nodes)?.id;
        map.node(id).tags = without(&map.node(id).tags, "ele");
        // Where all of a map lies at 0, it is named and not the node.
        Some(Vec::new())
    }),
    kind("drop a latitude", &["node/coordinate"], |_, map, dice| {
        let id = dice.pick(&map.nodes)?.id;
        map.node(id).position = None;
        Some(vec![id])
    }),
    kind("drop a local coordinate", &["node/local-partial"], |_, map, dice| {
        let (id, key) = (dice.pick(&map.nodes)?.id, dice.pick(["local_x", "local_y"])?);
        map.node(id).tags = without(&map.node(id).tags, key);
        Some(vec![id])
    }),
    kind("move a node 0.4 m by latitude and longitude alone", &["node/local-mismatch"], |_, map, dice| {
        let id = dice.pick(&map.nodes)?.id;
        let moved = map.place(id) + direction(dice) * 0.4;
        map.node(id).position = map.projector.inverse(moved);
        Some(vec![id])
    }),
    kind("raise a node of a bound by 3 m", &["node/ele-step"], |_, map, dice| {
        let ways: Vec<i64> = map.lanelets().flat_map(bounds).collect();
        let steps = ways.into_iter().flat_map(|way| {
            let line = map.line(way);
            let ids = &map.ways.iter().find(|one| one.id == way).unwrap().nodes;
            // Farther apart, this would be no more than a steep road.
            let near = (1..line.len()).filter(|&at| (line[at] - line[at - 1]).norm() < 5.0);
            near.map(|at| (way, ids[at])).collect::<Vec<_>>()
        });
        let (way, node) = dice.pick(steps)?;
        let ele: f64 = map.node(node).tags.get("ele")?.parse().ok()?;
        map.node(node).tags.set("ele", (ele + 3.0).to_string());
        Some(vec![way])
    }),
    kind("name a later format", &["load/format-version"], |_, map, dice| {
        let later = ["3", "x", "2-beta", ""];
        map.meta.format_version = dice.pick(later).map(Into::into);
        Some(Vec::new())
    }),
];

fn any(map: &Draft, dice: &mut Dice, kind: lanewright::osm::ElementKind) -> Option<i64> {
    match kind {
        Node => dice.pick(map.nodes.iter().map(|one| one.id)),
        Way => dice.pick(map.ways.iter().map(|one| one.id)),
        Relation => dice.pick(map.relations.iter().map(|one| one.id)),
    }
}

fn elements(map: &Draft) -> Vec<i64> {
    map.relations.iter().filter(|one| one.tags.is("type", "regulatory_element")).map(|one| one.id).collect()
}

/// Any direction, of length 1.
fn direction(dice: &mut Dice) -> Vector {
    let angle = dice.below(360) as f64;
    let (sin, cos) = angle.to_radians().sin_cos();
    Vector::new(cos, sin)
}
