//! Mutations that break signals, stop lines and rights of way.

use lanewright::geometry::Vector;
use lanewright::osm::{ElementKind, Member, Relation};

use super::draft::{Draft, bounds, members, relation_member};
use super::{Kind, kind};

const YIELD_MISSING: &[&str] = &["vm-03-10/yield-missing", "vm-03-11/yield-missing"];
const MISSING: &[&str] = &["vm-03-10/re-missing", "vm-03-11/re-missing"];

pub const KINDS: &[Kind] = &[
    kind("drop a light's stop line", &["vm-03-04/signal-no-stopline"], |_, map, dice| {
        let (light, _) = dice.pick(lights(map))?;
        map.relation(light).members.retain(|member| member.role != "ref_line");
        Some(vec![light])
    }),
    kind("let a lanelet forget its light", &["vm-03-04/signal-link-missing"], |_, map, dice| {
        // Where it is the only one behind the stop line, the whole approach has none, as some have.
        let (light, lanelet) =
            dice.pick(lights(map).into_iter().filter(|(light, _)| map.referrers(*light).len() > 1))?;
        map.relation(lanelet).members.retain(|member| member.id != light);
        Some(vec![lanelet])
    }),
    kind("hang a light on the lane before it", &["vm-03-04/signal-on-in-lane"], |_, map, dice| {
        let (light, _) = dice.pick(lights(map))?;
        let behind = map.referrers(light);
        let before = dice.pick(before(map, behind[0]))?;
        for lanelet in behind {
            map.relation(lanelet).members.retain(|member| member.id != light);
        }
        map.relation(before).members.push(relation_member(light, "regulatory_element"));
        Some(vec![light])
    }),
    kind("exchange the lights of two approaches that cross", &["vm-04-02/exchanged"], |_, map, dice| {
        let [one, other] = dice.pick(crossing_lights(map))?;
        let bodies = |id: i64| -> Vec<Member> {
            let members = map.relations.iter().filter(|relation| relation.id == id).flat_map(|one| &one.members);
            members.filter(|member| member.role != "ref_line").cloned().collect()
        };
        for (id, fresh) in [(one, bodies(other)), (other, bodies(one))] {
            let element = map.relation(id);
            element.members.retain(|member| member.role == "ref_line");
            element.members.extend(fresh);
        }
        Some(vec![one, other])
    }),
    kind("let two approaches that cross obey each other's light", &["vm-04-02/exchanged"], |_, map, dice| {
        let [one, other] = dice.pick(crossing_lights(map))?;
        let [ours, theirs] = [one, other].map(|id| map.referrers(id));
        for (lanelets, old, new) in [(ours, one, other), (theirs, other, one)] {
            for lanelet in lanelets {
                let members = &mut map.relation(lanelet).members;
                members.iter_mut().filter(|member| member.id == old).for_each(|member| member.id = new);
            }
        }
        Some(vec![one, other])
    }),
    kind("hang a second light on a lanelet", &["vm-03-04/signal-multi"], |_, map, dice| {
        let (light, lanelet) = dice.pick(lights(map))?;
        let (other, _) = dice.pick(lights(map).into_iter().filter(|(other, _)| *other != light))?;
        map.relation(lanelet).members.push(relation_member(other, "regulatory_element"));
        Some(vec![lanelet])
    }),
    kind("delete a stop line and its marking", &["vm-03-09/no-stop-line"], |_, map, dice| {
        let marking = dice.pick(map.elements("road_marking"))?;
        let (id, line) = (marking.id, members(marking, "refers").next()?);
        let lanelets = map.referrers(id);
        map.remove(ElementKind::Relation, id);
        map.remove(ElementKind::Way, line);
        Some(lanelets)
    }),
    kind("delete a signal's stop line", &["vm-03-04/signal-no-stopline"], |_, map, dice| {
        let (light, _) = dice.pick(lights(map))?;
        let line = members(map.relation(light), "ref_line").next()?;
        map.remove(ElementKind::Way, line);
        Some(vec![light])
    }),
    kind("delete a marking", &["vm-03-09/no-stop-line"], |_, map, dice| {
        // A line at which a sign stops vehicles stays one.
        let alone = |marking: &&Relation| {
            let line = members(marking, "refers").next();
            map.relations.iter().all(|other| members(other, "ref_line").next() != line)
        };
        let id = dice.pick(map.elements("road_marking").filter(alone))?.id;
        let lanelets = map.referrers(id);
        map.remove(ElementKind::Relation, id);
        Some(lanelets)
    }),
    kind("retype a marking's stop line", &["vm-03-14/shape"], |_, map, dice| {
        let marking = dice.pick(map.elements("road_marking"))?;
        let (id, line) = (marking.id, members(marking, "refers").next()?);
        map.way(line).tags.set("type", dice.pick(["line_thin", "pedestrian_marking", "virtual"])?);
        Some(vec![id])
    }),
    kind("name a marking's line as ref_line, too", &["vm-03-14/shape"], |_, map, dice| {
        let id = dice.pick(map.elements("road_marking"))?.id;
        let mut again = map.relation(id).members.iter().find(|member| member.role == "refers")?.clone();
        again.role = "ref_line".into();
        map.relation(id).members.push(again);
        Some(vec![id])
    }),
    // From the end of a short lane, 2 m are out of its reach: then it has none.
    kind("move a stop line 2 m back", &["vm-03-09/start-misaligned", "vm-03-09/no-stop-line"], |_, map, dice| {
        let line = dice.pick(stop_lines_of_intersections(map))?;
        move_line(map, line, [2.0, 2.0])
    }),
    kind("turn a stop line", &["vm-03-09/start-misaligned"], |_, map, dice| {
        let line = dice.pick(stop_lines_of_intersections(map))?;
        let shift = dice.pick([[1.2, 0.0], [0.0, 1.2]])?;
        move_line(map, line, shift)
    }),
    kind("delete a yield", YIELD_MISSING, |_, map, dice| {
        let several = |element: &&Relation| members(element, "yield").count() > 1;
        let element = dice.pick(map.elements("right_of_way").filter(several))?;
        let (id, gone) = (element.id, dice.pick(members(element, "yield"))?);
        map.relation(id).members.retain(|member| member.role != "yield" || member.id != gone);
        Some(vec![gone])
    }),
    kind("delete a right_of_way", MISSING, |_, map, dice| {
        let element = dice.pick(map.elements("right_of_way"))?;
        let (id, lanelets) = (element.id, members(element, "right_of_way").collect());
        map.remove(ElementKind::Relation, id);
        Some(lanelets)
    }),
    kind(
        "let a lanelet forget its right_of_way",
        &["vm-03-10/not-referenced", "vm-03-11/not-referenced"],
        |_, map, dice| {
            let id = dice.pick(map.elements("right_of_way"))?.id;
            let lanelet = dice.pick(map.referrers(id))?;
            map.relation(lanelet).members.retain(|member| member.id != id);
            Some(vec![id])
        },
    ),
    kind(
        "give a right_of_way to another lanelet",
        &["vm-03-10/self-missing", "vm-03-11/self-missing"],
        |_, map, dice| {
            let id = dice.pick(map.elements("right_of_way"))?.id;
            let own: Vec<i64> = members(map.relation(id), "right_of_way").collect();
            let other = dice.pick(map.movements().map(|lanelet| lanelet.id).filter(|id| !own.contains(id)))?;
            let member = map.relation(id).members.iter_mut().find(|member| member.role == "right_of_way")?;
            member.id = other;
            Some(vec![id])
        },
    ),
    kind("hang a second right_of_way on a lanelet", &["vm-03-10/multi-re", "vm-03-11/multi-re"], |_, map, dice| {
        let element = dice.pick(map.elements("right_of_way"))?;
        let (own, lanelet) = (element.id, members(element, "right_of_way").next()?);
        let mut other = map.relation(own).clone();
        other.id = map.fresh();
        map.relation(lanelet).members.push(relation_member(other.id, "regulatory_element"));
        map.relations.push(other);
        Some(vec![lanelet])
    }),
    kind(
        "let a lanelet ignore one that goes first",
        &["vm-03-10/yield-unsafe", "vm-03-11/yield-unsafe", "vm-03-11/mutual", "vm-03-11/priority-inverted"],
        |_, map, dice| {
            // Who is told to yield, and has an element of its own that does not name the other.
            let mut pairs = Vec::new();
            for element in map.elements("right_of_way") {
                let Some(first) = members(element, "right_of_way").next() else { continue };
                for second in map.lanelets().filter(|other| members(element, "yield").any(|id| id == other.id)) {
                    let Some(own) = map.element_of(second, "right_of_way") else { continue };
                    let own = map.relations.iter().find(|one| one.id == own)?;
                    if !members(own, "yield").any(|id| id == first) {
                        pairs.push((own.id, first));
                    }
                }
            }
            let (element, first) = dice.pick(pairs)?;
            map.relation(element).members.push(relation_member(first, "yield"));
            Some(vec![first])
        },
    ),
    kind(
        "let a lanelet ignore one that it does not touch",
        &["vm-03-10/yield-needless", "vm-03-11/yield-needless"],
        |base, map, dice| {
            let id = dice.pick(map.elements("right_of_way"))?.id;
            let own = members(map.relation(id), "right_of_way").next()?;
            let other = dice.pick(base.untouched.iter().filter(|(one, _)| *one == own))?.1;
            map.relation(id).members.push(relation_member(other, "yield"));
            Some(vec![id])
        },
    ),
];

/// Lights with the movements that refer to them.
/// Pairs of elements that are the only ones of their approaches, with lights for vehicles that look across each other.
fn crossing_lights(map: &Draft) -> Vec<[i64; 2]> {
    let is_for_drivers = |id: &i64| {
        let way = map.ways.iter().find(|way| way.id == *id);
        way.is_some_and(|way| way.tags.is("subtype", "red_yellow_green"))
    };
    let along = |element: &Relation| {
        let body = map.line(members(element, "refers").find(is_for_drivers)?);
        Some(*body.last()? - *body.first()?)
    };
    let looks: Vec<(i64, Vector)> = map
        .elements("traffic_light")
        .filter(|element| !map.referrers(element.id).is_empty() && members(element, "ref_line").next().is_some())
        .filter_map(|element| Some((element.id, along(element)?)))
        .collect();
    let cross = |a: Vector, b: Vector| (a.dot(&b) / (a.norm() * b.norm())).abs() < 0.4;
    let pairs = looks.iter().enumerate().flat_map(|(at, one)| looks.iter().skip(at + 1).map(move |other| (one, other)));
    pairs.filter(|(one, other)| cross(one.1, other.1)).map(|(one, other)| [one.0, other.0]).collect()
}

/// The stop lines but those at which vehicles wait before they join a roundabout: there Autoware takes a place of its own.
fn stop_lines_of_intersections(map: &Draft) -> Vec<i64> {
    let joins = |lanelet: &i64| {
        map.elements("roundabout").any(|element| members(element, "entry").any(|entry| entry == *lanelet))
    };
    let of_roundabouts: Vec<i64> = map
        .elements("road_marking")
        .filter(|marking| map.referrers(marking.id).iter().any(joins))
        .flat_map(|marking| members(marking, "refers"))
        .collect();
    map.lines("stop_line").map(|line| line.id).filter(|id| !of_roundabouts.contains(id)).collect()
}

/// A traffic light's element and a lanelet that obeys it.
fn lights(map: &Draft) -> Vec<(i64, i64)> {
    let light = |lanelet: &Relation| Some((map.element_of(lanelet, "traffic_light")?, lanelet.id));
    map.movements().filter(|lanelet| lanelet.tags.is("subtype", "road")).filter_map(light).collect()
}

/// The lanes that lead to a movement: they end on the nodes on which it starts.
fn before(map: &mut Draft, lanelet: i64) -> Vec<i64> {
    let ways = bounds(map.relation(lanelet));
    let ends = |map: &mut Draft, way: i64| {
        let nodes = &map.way(way).nodes;
        [nodes[0], nodes[nodes.len() - 1]]
    };
    let own = ways.map(|way| ends(map, way));
    let roads = map.lanelets().filter(|one| one.tags.is("subtype", "road") && !one.tags.has("intersection_area"));
    let roads: Vec<(i64, [i64; 2])> = roads.map(|one| (one.id, bounds(one))).collect();
    let line = members(map.relation(light_of(map, lanelet)), "ref_line").next().unwrap();
    let stop: Vec<_> = map.line(line);
    let mut found = Vec::new();
    for (id, ways) in roads {
        let theirs = ways.map(|way| ends(map, way));
        let shared: Vec<i64> =
            theirs.iter().zip(own).flat_map(|(a, b)| a.iter().copied().filter(move |id| b.contains(id))).collect();
        let at_line = shared.iter().all(|&node| stop.iter().any(|p| (p - map.place(node)).norm() < 2.0));
        if shared.len() == 2 && at_line {
            found.push(id);
        }
    }
    found
}

fn light_of(map: &Draft, lanelet: i64) -> i64 {
    let lanelet = map.relations.iter().find(|one| one.id == lanelet).unwrap();
    map.element_of(lanelet, "traffic_light").unwrap()
}

/// Gives a stop line nodes of its own, each moved this far against or along the traffic.
fn move_line(map: &mut Draft, line: i64, by: [f64; 2]) -> Option<Vec<i64>> {
    let nodes = map.way(line).nodes.clone();
    let [a, b] = nodes[..] else { return None };
    let along = map.place(b) - map.place(a);
    let across = Vector::new(-along.y, along.x).normalize();
    let moved = [(a, by[0]), (b, by[1])].map(|(node, metres)| {
        let copy = map.copy_node(node);
        map.shift(copy, across * metres);
        copy
    });
    map.way(line).nodes = moved.to_vec();
    // What is said of it may be said of the lanelets that wait at it.
    let waits = |one: &&Relation| one.members.iter().any(|member| member.kind == ElementKind::Way && member.id == line);
    let elements: Vec<i64> = map.relations.iter().filter(waits).map(|one| one.id).collect();
    let refer = |one: &&Relation| one.members.iter().any(|member| elements.contains(&member.id));
    let waiting: Vec<i64> = map.relations.iter().filter(refer).map(|one| one.id).collect();
    Some([line].into_iter().chain(waiting).collect())
}

/// What changes nothing that Autoware would see; nothing must be said of it.
pub const HARMLESS: &[Kind] = &[
    kind("reverse a bound", &[], |_, map, dice| {
        let way = dice.pick(map.lanelets().flat_map(bounds))?;
        map.way(way).nodes.reverse();
        Some(Vec::new())
    }),
    kind("reverse a stop line or an area", &[], |_, map, dice| {
        let way = dice.pick(map.lines("stop_line").chain(map.lines("intersection_area")))?.id;
        map.way(way).nodes.reverse();
        Some(Vec::new())
    }),
    kind("shuffle the elements", &[], |_, map, dice| {
        dice.shuffle(&mut map.nodes);
        dice.shuffle(&mut map.ways);
        dice.shuffle(&mut map.relations);
        Some(Vec::new())
    }),
    kind("shuffle a relation's members", &[], |_, map, dice| {
        let id = dice.pick(&map.relations)?.id;
        let members: &mut Vec<Member> = &mut map.relation(id).members;
        dice.shuffle(members);
        Some(Vec::new())
    }),
    kind("write a note", &[], |_, map, dice| {
        let id = dice.pick(&map.relations)?.id;
        map.relation(id).tags.set("note", "seen on 3 May; \"<&>\"");
        let id = dice.pick(&map.ways)?.id;
        map.way(id).tags.set("surveyor", "é");
        Some(Vec::new())
    }),
    kind("add a node that nothing uses", &[], |_, map, dice| {
        let id = dice.pick(&map.nodes)?.id;
        map.copy_node(id);
        Some(Vec::new())
    }),
];
