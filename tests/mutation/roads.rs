//! Mutations that break how lanes lie beside each other, on each other and at the road's edge; centre lines and walkways.

use lanewright::osm::{Member, Relation, Way};

use super::draft::{Dice, Draft, bounds, members};
use super::lanes::{center_line, course, crosswalk, exchange, in_a_row, lanes, moved_copy, oncoming, toward};
use super::{Kind, kind};

pub const KINDS: &[Kind] = &[
    kind("cut a lane and not the oncoming one", &["vm-01-04/cut-apart"], |_, map, dice| {
        let (other, lanelet, _) = dice.pick(oncoming(map))?;
        for (role, nodes) in ["left", "right"].into_iter().zip(course(map, lanelet)) {
            let (first, last) = (*nodes.first()?, *nodes.last()?);
            let middle = map.copy_node(first);
            let half = (map.place(last) - map.place(first)) / 2.0;
            map.shift(middle, half);
            let way = map.relation(lanelet).members.iter().find(|member| member.role == role)?.id;
            let piece = map.copy_way(way);
            map.way(piece).nodes = vec![first, middle];
            let members = &mut map.relation(lanelet).members;
            members.iter_mut().filter(|member| member.role == role).for_each(|member| member.id = piece);
        }
        Some(vec![other, lanelet])
    }),
    kind(
        "leave out the middle line and draw the border beside the middle",
        &["vm-01-13/off-middle"],
        |_, map, dice| unpainted(map, dice, 0.6),
    ),
    kind("leave out the middle line of a road too narrow for two", &["vm-01-13/narrow"], |_, map, dice| {
        unpainted(map, dice, 1.6)
    }),
    kind("lay two lanes of a wide road onto each other", &["vm-01-14/wide"], |_, map, dice| {
        let (other, lanelet, way) = dice.pick(oncoming(map))?;
        let [far, own] = [other, lanelet].map(|id| bounds(map.relation(id)));
        let outer = |bounds: [i64; 2]| bounds.into_iter().find(|&bound| bound != way);
        let (far, own) = (outer(far)?, outer(own)?);
        // Wide is what two vehicles can pass on.
        let outward = toward(&map.line(own), &map.line(far));
        let wider = moved_copy(map, far, outward * 1.5);
        exchange(map, other, far, wider);
        exchange(map, lanelet, way, wider);
        exchange(map, other, way, own);
        Some(vec![lanelet, other])
    }),
    kind("draw a road's edge far inside its border", &["vm-01-08/edge-distance"], |_, map, dice| {
        let (_, way, inner) = dice.pick(outer(map))?;
        let outward = -toward(&map.line(way), &map.line(inner));
        // The way itself becomes the edge, lest the border stay where it was.
        let border = moved_copy(map, way, outward * 1.0);
        map.way(border).tags = [("type", "road_border")].into_iter().collect();
        map.way(way).tags = [("type", "virtual")].into_iter().collect();
        Some(vec![way])
    }),
    kind("let a centre line end before its lane does", &["vm-01-10/end-off"], |_, map, dice| {
        let (first, _) = dice.pick(in_a_row(map))?;
        let line = center_line(map, first, [0.0, 0.0]);
        let places = map.line(line);
        let back = (places[places.len() - 2] - places[places.len() - 1]).normalize();
        let last = *map.way(line).nodes.last()?;
        map.shift(last, back);
        Some(vec![line])
    }),
    kind("let a centre line leave its lane", &["vm-01-10/outside"], |_, map, dice| {
        let (first, _) = dice.pick(in_a_row(map))?;
        let line = center_line(map, first, [0.0, 0.0]);
        let places = map.line(line);
        let way = places[1] - places[0];
        let node = map.way(line).nodes[0];
        let node = map.copy_node(node);
        map.shift(node, way / 2.0 + nalgebra::Vector2::new(-way.y, way.x).normalize() * 6.0);
        map.way(line).nodes.insert(1, node);
        Some(vec![line])
    }),
    kind("let a walkway go on along the road", &["vm-01-19/long"], |_, map, dice| {
        let mut walkway = crosswalk(map, dice)?;
        walkway.tags.set("subtype", "walkway");
        let id = walkway.id;
        map.relations.push(walkway);
        for (role, nodes) in ["left", "right"].into_iter().zip(course(map, id)) {
            let (first, last) = (*nodes.first()?, *nodes.last()?);
            let onward = (map.place(last) - map.place(first)).normalize() * 60.0;
            let far = map.copy_node(last);
            map.shift(far, onward);
            let way = map.relation(id).members.iter().find(|member| member.role == role)?.id;
            let longer = map.copy_way(way);
            map.way(longer).nodes = nodes.iter().copied().chain([far]).collect();
            let members = &mut map.relation(id).members;
            members.iter_mut().filter(|member| member.role == role).for_each(|member| member.id = longer);
        }
        Some(vec![id])
    }),
    kind("draw a walkway that crosses nothing", &["vm-03-13/walkway-idle"], |_, map, dice| {
        let mut walkway = crosswalk(map, dice)?;
        walkway.tags.set("subtype", "walkway");
        let id = walkway.id;
        map.relations.push(walkway);
        for way in bounds(map.relation(id)) {
            let copy = moved_copy(map, way, nalgebra::Vector2::new(3_000.0, 0.0));
            exchange(map, id, way, copy);
        }
        Some(vec![id])
    }),
    kind("let a crosswalk be continued by another", &["vm-01-21/follower"], |_, map, dice| {
        let own = dice.pick(map.lanelets().filter(|one| one.tags.is("subtype", "crosswalk")))?.id;
        let next = Relation { id: map.fresh(), ..map.relation(own).clone() };
        let id = next.id;
        map.relations.push(next);
        for (role, nodes) in ["left", "right"].into_iter().zip(course(map, own)) {
            let (first, last) = (*nodes.first()?, *nodes.last()?);
            let onward = (map.place(last) - map.place(first)).normalize() * 4.0;
            let far = map.copy_node(last);
            map.shift(far, onward);
            let way = map.relation(own).members.iter().find(|member| member.role == role)?.id;
            let longer = map.copy_way(way);
            map.way(longer).nodes = vec![last, far];
            let members = &mut map.relation(id).members;
            members.iter_mut().filter(|member| member.role == role).for_each(|member| member.id = longer);
        }
        Some(vec![own])
    }),
    kind("draw a crosswalk's stop line behind it", &["vm-02-04/behind"], |_, map, dice| {
        let mut choices = Vec::new();
        for element in map.elements("crosswalk") {
            let walk = members(element, "refers").next()?;
            let at = middle(map, walk);
            for lanelet in map.referrers(element.id) {
                let [left, right] = course(map, lanelet);
                let (start, end) = (map.place(left[0]), map.place(*left.last()?));
                // A crosswalk at the near end: all that have it have to pass it before the line.
                let straight =
                    map.relations.iter().any(|one| one.id == lanelet && one.tags.is("turn_direction", "straight"));
                if straight && (start - at).norm() < (end - at).norm() {
                    let behind = |bound: &[i64]| {
                        let far = |&&node: &&i64| (map.place(node) - start).norm() > 5.5;
                        bound.iter().find(far).copied()
                    };
                    choices.extend(behind(&left).zip(behind(&right)).map(|(a, b)| (element.id, a, b)));
                }
            }
        }
        let (element, a, b) = dice.pick(choices)?;
        let tags = [("type", "stop_line"), ("subtype", "solid")].into_iter().collect();
        let way = Way { id: map.fresh(), nodes: vec![a, b], tags, ..map.ways[0].clone() };
        let id = way.id;
        map.ways.push(way);
        let line = Member { kind: lanewright::osm::ElementKind::Way, id, role: "ref_line".into() };
        map.relation(element).members.push(line);
        Some(vec![id])
    }),
    kind("let a lane's two sides change places", &["health/self-crossing", "load/align"], |_, map, dice| {
        let lane = dice.pick(lanes(map).iter().map(|one| one.id).collect::<Vec<_>>())?;
        let [mut left, mut right] = course(map, lane);
        let (a, b) = (left.len() - 1, right.len() - 1);
        std::mem::swap(&mut left[a], &mut right[b]);
        for (role, nodes) in [("left", left), ("right", right)] {
            let way = map.relation(lane).members.iter().find(|member| member.role == role)?.id;
            let crossed = map.copy_way(way);
            map.way(crossed).nodes = nodes;
            let members = &mut map.relation(lane).members;
            members.iter_mut().filter(|member| member.role == role).for_each(|member| member.id = crossed);
        }
        Some(vec![lane])
    }),
];

/// Between two lanes that have nobody else beside them: no paint, and the border this far (m) toward one of the two.
fn unpainted(map: &mut Draft, dice: &mut Dice, by: f64) -> Option<Vec<i64>> {
    let alone = |map: &Draft, lanelet: i64, way: i64| {
        let own = map.relations.iter().find(|one| one.id == lanelet).map(bounds)?;
        let outer = own.into_iter().find(|&bound| bound != way)?;
        (map.bounded(outer).len() == 1).then_some(outer)
    };
    let pairs = oncoming(map).into_iter().filter_map(|(a, b, way)| {
        alone(map, b, way)?;
        Some((a, b, way, alone(map, a, way)?))
    });
    let (a, b, way, outer) = dice.pick(pairs.collect::<Vec<_>>())?;
    let toward = toward(&map.line(way), &map.line(outer));
    let moved = moved_copy(map, way, toward * by);
    map.way(moved).tags = [("type", "virtual")].into_iter().collect();
    exchange(map, a, way, moved);
    exchange(map, b, way, moved);
    Some(vec![moved])
}

/// Lanes with their bound at the road's edge, and the other one.
fn outer(map: &Draft) -> Vec<(i64, i64, i64)> {
    let sides = lanes(map).into_iter().flat_map(|lane| {
        let own = bounds(lane);
        [(lane.id, own[0], own[1]), (lane.id, own[1], own[0])]
    });
    // Of a straight one, a copy that is moved is as far away everywhere.
    sides.filter(|(_, way, _)| map.bounded(*way).len() == 1 && map.line(*way).len() == 2).collect()
}

/// Where a lanelet is, more or less.
fn middle(map: &Draft, lanelet: i64) -> lanewright::geometry::Point {
    let [left, right] = course(map, lanelet);
    nalgebra::center(&map.place(left[0]), &map.place(right[right.len() - 1]))
}
