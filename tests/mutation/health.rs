//! Mutations that no requirement of intersections forbids: points and lanelets said twice, barriers where people walk or drive.

use lanewright::osm::{Relation, Tags, Way};

use super::draft::{Dice, Draft, bounds};
use super::{Kind, kind};

pub const KINDS: &[Kind] = &[
    kind("name a point of a bound twice", &["health/repeated-point"], |_, map, dice| {
        let way = dice.pick(map.lanelets().flat_map(bounds))?;
        let nodes = &mut map.way(way).nodes;
        let at = dice.below(nodes.len());
        nodes.insert(at, nodes[at]);
        Some(vec![way])
    }),
    kind("draw a lanelet twice", &["health/twice"], |_, map, dice| {
        let id = dice.pick(map.lanelets())?.id;
        let again = Relation { id: map.fresh(), ..map.relation(id).clone() };
        map.relations.push(again);
        Some(vec![id])
    }),
    kind("draw a fence across a crosswalk", &["vm-05-04/across"], |_, map, dice| {
        barrier(map, dice, "crosswalk", "fence")
    }),
    kind("draw a guard rail across a lane", &["vm-07-03/on-lane"], |_, map, dice| {
        barrier(map, dice, "road", "guard_rail")
    }),
    kind("misspell a guard rail", &["vm-07-02/word"], |_, map, dice| {
        barrier(map, dice, "road", "guardrail").map(|ids| ids[..1].to_vec())
    }),
];

/// A line from one corner of a lanelet to the one opposite; the ids of both.
fn barrier(map: &mut Draft, dice: &mut Dice, subtype: &str, kind: &str) -> Option<Vec<i64>> {
    let lanelet = dice.pick(map.lanelets().filter(|lanelet| lanelet.tags.is("subtype", subtype)))?;
    let (id, [left, right]) = (lanelet.id, bounds(lanelet));
    let (from, to) = (*map.way(left).nodes.first()?, *map.way(right).nodes.last()?);
    // Bounds may run either way: the corner that is farther off is the one opposite.
    let other = *map.way(right).nodes.first()?;
    let far = |node: i64| (map.place(node) - map.place(from)).norm();
    let to = if far(to) >= far(other) { to } else { other };
    let mut tags = Tags::new();
    tags.set("type", kind);
    let way = Way { id: map.fresh(), nodes: vec![from, to], tags, ..map.way(left).clone() };
    let barrier = way.id;
    map.ways.push(way);
    Some(vec![barrier, id])
}
