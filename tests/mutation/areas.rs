//! Mutations that break the outline of an intersection.

use std::collections::BTreeSet;

use lanewright::geometry::Vector;

use super::draft::{Dice, Draft, bounds, without};
use super::{Kind, kind};

pub const KINDS: &[Kind] = &[
    kind("remove a vertex at a lane's end", &["vm-03-08/lane-node-missing"], |_, map, dice| {
        let (area, at) = vertex(map, dice)?;
        map.way(area).nodes.remove(at);
        Some(vec![area])
    }),
    kind("shift a vertex inward", &["vm-03-08/edge-not-border"], |_, map, dice| {
        let (area, at) = vertex(map, dice)?;
        let ring = map.line(area);
        let middle = ring.iter().fold(Vector::zeros(), |sum, p| sum + p.coords) / ring.len() as f64;
        replace(map, area, at, (middle - ring[at].coords).normalize() * dice.pick([0.5, 1.0, 2.0])?)
    }),
    kind("copy a vertex", &["vm-03-08/edge-not-border"], |_, map, dice| {
        let (area, at) = vertex(map, dice)?;
        replace(map, area, at, Vector::zeros())
    }),
    kind("exchange two vertices", &["vm-03-08/invalid"], |_, map, dice| {
        let (area, at) = vertex(map, dice)?;
        let count = map.way(area).nodes.len();
        map.way(area).nodes.swap(at, (at + count / 2) % count);
        Some(vec![area])
    }),
    kind("run over a vertex twice", &["vm-03-08/invalid"], |_, map, dice| {
        let (area, at) = vertex(map, dice)?;
        let nodes = &mut map.way(area).nodes;
        // At the very end it would only close the ring.
        let to = at + 1 + dice.below((nodes.len() - at - 1).max(1));
        let node = nodes[at];
        if at == 0 && to == nodes.len() {
            return None;
        }
        nodes.insert(to, node);
        Some(vec![area])
    }),
    kind("close the ring", &["vm-03-08/closed"], |_, map, dice| {
        let area = dice.pick(map.lines("intersection_area"))?.id;
        let first = map.way(area).nodes[0];
        map.way(area).nodes.push(first);
        Some(vec![area])
    }),
    kind("cut the area down to two vertices", &["vm-03-08/invalid"], |_, map, dice| {
        let area = dice.pick(map.lines("intersection_area"))?.id;
        map.way(area).nodes.truncate(2);
        Some(vec![area])
    }),
    kind("drop area=yes of an area", &["vm-03-01/ia-tag-dangling"], |_, map, dice| {
        let area = dice.pick(map.lines("intersection_area"))?.id;
        map.way(area).tags = without(&map.way(area).tags, "area");
        Some(named(map, area))
    }),
    kind("retype an area", &["vm-03-01/ia-tag-dangling"], |_, map, dice| {
        let area = dice.pick(map.lines("intersection_area"))?.id;
        map.way(area).tags.set("type", "detection_area");
        Some(named(map, area))
    }),
    kind("forget a whole intersection", &["vm-03-01/turn-without-ia"], |_, map, dice| {
        let area = dice.pick(map.lines("intersection_area"))?.id;
        let lanelets = named(map, area);
        map.remove(lanewright::osm::ElementKind::Way, area);
        for &lanelet in &lanelets {
            map.relation(lanelet).tags = without(&map.relation(lanelet).tags, "intersection_area");
        }
        Some(lanelets)
    }),
    kind("forget all marks of an intersection", &["vm-03-01/unmarked"], |_, map, dice| {
        let area = dice.pick(map.lines("intersection_area"))?.id;
        let lanelets = named(map, area);
        map.remove(lanewright::osm::ElementKind::Way, area);
        for &lanelet in &lanelets {
            let tags = without(&map.relation(lanelet).tags, "intersection_area");
            map.relation(lanelet).tags = without(&tags, "turn_direction");
        }
        Some(lanelets)
    }),
];

/// A vertex of an area where a lane of the intersection ends.
fn vertex(map: &Draft, dice: &mut Dice) -> Option<(i64, usize)> {
    let lines = map.inner_bounds();
    let ways = map.ways.iter().filter(|way| lines.contains(&way.id));
    let ends: BTreeSet<i64> = ways.flat_map(|way| [way.nodes[0], way.nodes[way.nodes.len() - 1]]).collect();
    let areas = map.lines("intersection_area");
    dice.pick(areas.flat_map(|area| {
        let at = (0..area.nodes.len()).filter(|&at| ends.contains(&area.nodes[at]));
        at.map(|at| (area.id, at)).collect::<Vec<_>>()
    }))
}

/// Puts a node of its own in a vertex's place.
fn replace(map: &mut Draft, area: i64, at: usize, by: Vector) -> Option<Vec<i64>> {
    let old = map.way(area).nodes[at];
    let node = map.copy_node(old);
    map.shift(node, by);
    map.way(area).nodes[at] = node;
    Some(vec![node])
}

/// The lanelets that name an area.
fn named(map: &Draft, area: i64) -> Vec<i64> {
    let value = area.to_string();
    let lanelets = map.lanelets().filter(|lanelet| lanelet.tags.is("intersection_area", &value));
    lanelets.filter(|lanelet| bounds(lanelet).len() == 2).map(|lanelet| lanelet.id).collect()
}
