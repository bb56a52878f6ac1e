//! Mutations that break a lane between intersections: its borders, its centre line, what lies beside it, its stop line.

use lanewright::geometry::{Point, Vector, cross};
use lanewright::osm::{ElementKind, Member, Relation, Way};

use super::draft::{Dice, Draft, bounds, members};
use super::{Kind, deleted_lanes, kind};

pub const KINDS: &[Kind] = &[
    kind(deleted_lanes::NAME, deleted_lanes::GONE, |_, map, dice| {
        map.remove(ElementKind::Relation, dice.pick(deleted_lanes::roads(map))?);
        // The lanes that miss it are named, not the lanelet, which is gone.
        Some(Vec::new())
    }),
    kind("draw the line to oncoming traffic a second time", &["vm-01-04/not-shared"], |_, map, dice| {
        let (_, lanelet, way) = dice.pick(oncoming(map))?;
        let copy = map.copy_way(way);
        exchange(map, lanelet, way, copy);
        Some(vec![lanelet])
    }),
    kind("let a lane reach over the line to oncoming traffic", &["vm-01-13/overlap"], |_, map, dice| {
        let (other, lanelet, way) = dice.pick(oncoming(map))?;
        let far = bounds(map.relation(other)).into_iter().find(|&bound| bound != way)?;
        let toward = toward(&map.line(way), &map.line(far));
        let copy = moved_copy(map, way, toward * 1.2);
        exchange(map, lanelet, way, copy);
        Some(vec![lanelet])
    }),
    kind("lay a lane onto the oncoming one over ways of its own", &["vm-01-14/not-shared"], |_, map, dice| {
        let (other, lanelet, _) = dice.pick(oncoming(map))?;
        let [left, right] = bounds(map.relation(other));
        let [a, b] = [map.copy_way(left), map.copy_way(right)];
        let [own_left, own_right] = bounds(map.relation(lanelet));
        exchange(map, lanelet, own_left, b);
        exchange(map, lanelet, own_right, a);
        Some(vec![lanelet, other])
    }),
    kind("let a centre line begin beside the one before it", &["vm-01-11/gap"], |_, map, dice| {
        let (first, second) = dice.pick(in_a_row(map))?;
        let before = center_line(map, first, [0.0, 0.0]);
        center_line(map, second, [0.6, 0.0]);
        Some(vec![before])
    }),
    kind("let a centre line end beside the middle", &["vm-01-12/off-middle"], |_, map, dice| {
        let (first, _) = dice.pick(in_a_row(map))?;
        Some(vec![center_line(map, first, [0.0, 0.6])])
    }),
    kind("put a shoulder beside a lane over a way of its own", &["vm-01-16/not-shared"], |_, map, dice| {
        strip(map, dice, "road_shoulder")
    }),
    kind("put a side strip beside a lane over a way of its own", &["vm-01-18/not-shared"], |_, map, dice| {
        strip(map, dice, "pedestrian_lane")
    }),
    kind("put a walkway onto a crosswalk", &["vm-01-19/doubled"], |_, map, dice| {
        let mut walkway = crosswalk(map, dice)?;
        walkway.tags.set("subtype", "walkway");
        let id = walkway.id;
        map.relations.push(walkway);
        Some(vec![id])
    }),
    kind("make a walkway for bicycles of a crosswalk", &["vm-01-19/not-for-people"], |_, map, dice| {
        let id = dice.pick(map.lanelets().filter(|one| one.tags.is("subtype", "crosswalk")))?.id;
        let tags = &mut map.relation(id).tags;
        tags.set("subtype", "walkway");
        tags.set("participant:pedestrian", "no");
        tags.set("participant:bicycle", "yes");
        Some(vec![id])
    }),
    kind("bend a stop line", &["vm-02-01/bent"], |_, map, dice| {
        let way = dice.pick(map.lines("stop_line"))?.id;
        let line = map.line(way);
        let along = line[1] - line[0];
        let across = Vector::new(-along.y, along.x).normalize() * dice.pick([0.4, -0.4])?;
        let first = map.way(way).nodes[0];
        let node = map.copy_node(first);
        map.shift(node, along / 2.0 + across);
        map.way(way).nodes.insert(1, node);
        Some(vec![way])
    }),
    kind("cut a stop line short", &["vm-02-01/short"], |_, map, dice| {
        let way = dice.pick(map.lines("stop_line"))?.id;
        let (line, nodes) = (map.line(way), map.way(way).nodes.clone());
        // Of a line across several lanes, a piece of the first: it has to be short in its own lane.
        let piece = (line[1] - line[0]).normalize();
        let moved: Vec<i64> = [1.2, 2.0]
            .iter()
            .map(|&by| {
                let node = map.copy_node(nodes[0]);
                map.shift(node, piece * by);
                node
            })
            .collect();
        map.way(way).nodes = moved;
        Some(vec![way])
    }),
    kind("draw a stop line a second time", &["vm-02-03/doubled"], |_, map, dice| {
        let way = dice.pick(map.lines("stop_line"))?.id;
        let copy = map.copy_way(way);
        Some(vec![way, copy])
    }),
    kind("let a light or sign stop vehicles at a second line", &["vm-02-03/second-line"], |_, map, dice| {
        let element = dice.pick(map.elements("traffic_light").chain(map.elements("traffic_sign")))?;
        let (id, line) = (element.id, members(element, "ref_line").next()?);
        let others = |one: &&Relation| one.id != id && one.members.iter().any(|member| member.id == line);
        if map.relations.iter().find(others).is_some() {
            return None;
        }
        let lanelet = *map.referrers(id).first()?;
        let along = heading(map, lanelet);
        // Not as far as the crosswalk behind the line.
        let second = moved_copy(map, line, along * 0.8);
        let member = map.relation(id).members.iter_mut().find(|member| member.role == "ref_line")?;
        member.id = second;
        Some(vec![second])
    }),
    kind("name the stop line of another approach", &["vm-02-04/off-lane"], |_, map, dice| {
        let element = dice.pick(map.elements("traffic_light").chain(map.elements("traffic_sign")))?;
        let (id, own) = (element.id, members(element, "ref_line").next()?);
        // A line that no lane of the element leads across: the one farthest away.
        let at = map.line(own)[0];
        let far = |way: &&Way| (map.line(way.id)[0] - at).norm();
        let other = map.lines("stop_line").max_by(|a, b| far(a).total_cmp(&far(b)))?.id;
        let member = map.relation(id).members.iter_mut().find(|member| member.role == "ref_line")?;
        member.id = other;
        Some(vec![other])
    }),
];

/// Road lanelets between intersections.
pub fn lanes(map: &Draft) -> Vec<&Relation> {
    let plain = |one: &&Relation| {
        one.tags.is("subtype", "road") && !one.tags.has("intersection_area") && !one.tags.has("turn_direction")
    };
    map.lanelets().filter(plain).collect()
}

/// Pairs of lanes that run against each other, with the way between them.
pub fn oncoming(map: &Draft) -> Vec<(i64, i64, i64)> {
    let lanes = lanes(map);
    let mut pairs = Vec::new();
    for a in &lanes {
        for b in lanes.iter().filter(|b| b.id != a.id) {
            let [mine, theirs] = [bounds(a), bounds(b)];
            pairs.extend(
                [0, 1].into_iter().filter(|&side| mine[side] == theirs[side]).map(|side| (a.id, b.id, mine[side])),
            );
        }
    }
    pairs
}

/// Pairs of road lanelets of which the second is the only one behind the first, and the first the only one before it.
pub fn in_a_row(map: &Draft) -> Vec<(i64, i64)> {
    let all: Vec<(i64, [[i64; 2]; 2])> = map
        .lanelets()
        .filter(|one| one.tags.is("subtype", "road"))
        .map(|one| {
            let [left, right] = course(map, one.id);
            (one.id, [[left[0], right[0]], [left[left.len() - 1], right[right.len() - 1]]])
        })
        .collect();
    let mut pairs = Vec::new();
    for (first, ends) in &all {
        let behind: Vec<_> = all.iter().filter(|(_, other)| other[0] == ends[1]).collect();
        let before = all.iter().filter(|(_, other)| other[1] == ends[1]).count();
        if let ([(second, _)], 1) = (&behind[..], before) {
            pairs.push((*first, *second));
        }
    }
    pairs
}

/// The nodes of both bounds in the direction of travel.
pub fn course(map: &Draft, lanelet: i64) -> [Vec<i64>; 2] {
    let lanelet = map.relations.iter().find(|one| one.id == lanelet).unwrap();
    let mut nodes = bounds(lanelet).map(|way| map.ways.iter().find(|one| one.id == way).unwrap().nodes.clone());
    let place = |nodes: &[i64], at: usize| map.place(nodes[at]);
    let ends = |nodes: &[i64]| [place(nodes, 0), place(nodes, nodes.len() - 1)];
    let ([a, _], [c, d]) = (ends(&nodes[0]), ends(&nodes[1]));
    if (d - a).norm() < (c - a).norm() {
        nodes[1].reverse();
    }
    let ([a, b], [c, _]) = (ends(&nodes[0]), ends(&nodes[1]));
    if cross(b - a, c - a) > 0.0 {
        nodes.iter_mut().for_each(|bound| bound.reverse());
    }
    nodes
}

/// The heading at a lanelet's start.
fn heading(map: &Draft, lanelet: i64) -> Vector {
    let [left, _] = course(map, lanelet);
    (map.place(left[1]) - map.place(left[0])).normalize()
}

/// Uses another way as a bound.
pub fn exchange(map: &mut Draft, lanelet: i64, from: i64, to: i64) {
    let members = &mut map.relation(lanelet).members;
    members
        .iter_mut()
        .filter(|member| member.kind == ElementKind::Way && member.id == from)
        .for_each(|member| member.id = to);
}

/// A copy of a way over nodes of its own, moved; its id.
pub fn moved_copy(map: &mut Draft, way: i64, by: Vector) -> i64 {
    let copy = map.copy_way(way);
    let nodes = map.way(copy).nodes.clone();
    let moved = nodes.into_iter().map(|node| {
        let own = map.copy_node(node);
        map.shift(own, by);
        own
    });
    let moved: Vec<i64> = moved.collect();
    map.way(copy).nodes = moved;
    copy
}

/// The direction from one line to another abreast of it, of length 1.
pub fn toward(from: &[Point], to: &[Point]) -> Vector {
    let middle = |line: &[Point]| nalgebra::center(&line[0], &line[line.len() - 1]);
    (middle(to) - middle(from)).normalize()
}

/// Gives a lanelet a centre line midway between its bounds' ends, which starts and ends this far (m) to one side; its id.
pub fn center_line(map: &mut Draft, lanelet: i64, off: [f64; 2]) -> i64 {
    let [left, right] = course(map, lanelet);
    let count = left.len().min(right.len());
    let at = |nodes: &[i64], step: usize| nodes[(nodes.len() - 1) * step / (count - 1)];
    let mut nodes = Vec::new();
    for step in 0..count {
        let (a, b) = (at(&left, step), at(&right, step));
        let across = map.place(b) - map.place(a);
        let by = if step == 0 {
            off[0]
        } else if step + 1 == count {
            off[1]
        } else {
            0.0
        };
        let node = map.copy_node(a);
        map.shift(node, across / 2.0 + across.normalize() * by);
        nodes.push(node);
    }
    let [bound, _] = bounds(map.relation(lanelet));
    let id = map.copy_way(bound);
    map.way(id).nodes = nodes;
    map.way(id).tags = [("type", "centerline")].into_iter().collect();
    map.relation(lanelet).members.push(Member { kind: ElementKind::Way, id, role: "centerline".into() });
    id
}

/// Puts a strip of a kind beside a lane, over a copy of the lane's outer bound.
fn strip(map: &mut Draft, dice: &mut Dice, subtype: &str) -> Option<Vec<i64>> {
    let free = |way: i64| map.bounded(way).len() == 1;
    let outer: Vec<(i64, usize)> = lanes(map)
        .into_iter()
        .flat_map(|lane| [0, 1].map(|side| (lane.id, side)))
        .filter(|&(lane, side)| free(bounds(map.relations.iter().find(|one| one.id == lane).unwrap())[side]))
        .collect();
    let (lane, side) = dice.pick(outer)?;
    let own = bounds(map.relation(lane));
    let outward = -toward(&map.line(own[side]), &map.line(own[1 - side]));
    let inner = map.copy_way(own[side]);
    let border = moved_copy(map, own[side], outward * 1.5);
    map.way(border).tags = [("type", "road_border")].into_iter().collect();
    let mut strip = map.relation(lane).clone();
    strip.id = map.fresh();
    strip.tags.set("subtype", subtype);
    strip.members.retain(|member| member.role == "left" || member.role == "right");
    let id = strip.id;
    map.relations.push(strip);
    // The strip lies beyond the lane's bound: what is the lane's left is its right.
    let sides = if side == 0 { [border, inner] } else { [inner, border] };
    for (role, way) in ["left", "right"].into_iter().zip(sides) {
        map.relation(id).members.iter_mut().filter(|member| member.role == role).for_each(|member| member.id = way);
    }
    Some(vec![id])
}

/// A copy of a crosswalk's lanelet that nothing refers to.
pub fn crosswalk(map: &Draft, dice: &mut Dice) -> Option<Relation> {
    let mut copy = dice.pick(map.lanelets().filter(|one| one.tags.is("subtype", "crosswalk")))?.clone();
    copy.id = map.fresh();
    Some(copy)
}
