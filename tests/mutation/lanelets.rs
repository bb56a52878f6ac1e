//! Mutations that break a lanelet of an intersection: its tags, its bounds, how it hangs together with others.

use lanewright::geometry::{Point, Vector};
use lanewright::osm::{ElementKind, Relation};

use super::draft::{Dice, Draft, bounds, without};
use super::{Kind, kind};

/// A lanelet that leads the wrong way ends where it should start, and the other way round.
const UNCONNECTED: &[&str] =
    &["vm-03-04/dangling-il", "vm-03-04/in-lane-dead-end", "vm-03-04/out-lane-unreached", "vm-03-04/movement-missing"];
/// A bound that is not smooth shows in one of these, by its shape and the place of the damage.
const UNEVEN: &[&str] = &["vm-03-03/kink", "vm-03-03/jagged", "vm-03-03/width", "vm-03-03/curvature"];

pub const KINDS: &[Kind] = &[
    kind("drop turn_direction", &["vm-03-02/turn-missing"], |_, map, dice| untag(map, dice, "turn_direction")),
    kind("misspell turn_direction", &["vm-03-02/turn-invalid"], |_, map, dice| {
        let id = dice.pick(map.movements())?.id;
        let value = dice.pick(["Left", "rigth", "straight ", "", "none", "left;straight"])?;
        map.relation(id).tags.set("turn_direction", value);
        Some(vec![id])
    }),
    kind("label a turn as its opposite", &["vm-03-02/turn-mismatch"], |base, map, dice| {
        let id = dice.pick(base.turns.iter().filter(|(_, turn)| turn.abs() > 45.0 && turn.abs() < 150.0))?.0;
        let tags = &mut map.relation(*id).tags;
        let other = if tags.is("turn_direction", "left") { "right" } else { "left" };
        tags.set("turn_direction", other);
        Some(vec![*id])
    }),
    kind("write a distance that is no number", &["vm-03-02/turn-signal-distance"], |_, map, dice| {
        let id = dice.pick(map.movements())?.id;
        let value = dice.pick(["far", "-1", "", "nan", "15 m"])?;
        map.relation(id).tags.set("turn_signal_distance", value);
        Some(vec![id])
    }),
    kind("drop intersection_area", &["vm-03-01/ia-tag-missing"], |_, map, dice| untag(map, dice, "intersection_area")),
    kind("name an area that is not there", &["vm-03-01/ia-tag-dangling"], |_, map, dice| {
        let (id, fresh) = (dice.pick(map.movements())?.id, map.fresh());
        let value = dice.pick([fresh.to_string(), "0".to_owned(), "east".to_owned(), format!("{}", 1_i64 << 32)])?;
        map.relation(id).tags.set("intersection_area", value);
        Some(vec![id])
    }),
    kind("name another intersection's area", &["vm-03-01/ia-tag-wrong"], |_, map, dice| {
        let lanelet = dice.pick(map.movements())?;
        let (id, own) = (lanelet.id, lanelet.tags.get("intersection_area")?.to_owned());
        let other = dice.pick(map.lines("intersection_area").filter(|way| way.id.to_string() != own))?.id;
        map.relation(id).tags.set("intersection_area", other.to_string());
        Some(vec![id])
    }),
    kind("paint a bound", &["vm-03-02/bound-type"], |_, map, dice| {
        let way = dice.pick(map.inner_bounds())?;
        let (kind, subtype) =
            dice.pick([("line_thin", "solid"), ("line_thick", "solid"), ("stop_line", "solid"), ("curbstone", "low")])?;
        map.way(way).tags.set("type", kind);
        map.way(way).tags.set("subtype", subtype);
        Some(vec![way])
    }),
    kind("drop a bound's type", &["vm-03-02/bound-type"], |_, map, dice| {
        let way = dice.pick(map.inner_bounds())?;
        map.way(way).tags = without(&map.way(way).tags, "type");
        Some(vec![way])
    }),
    kind("allow a lane change over a bound", &["vm-03-02/lane-change-in-ia"], |_, map, dice| {
        let way = dice.pick(map.inner_bounds())?;
        map.way(way).tags.set("lane_change", "yes");
        Some(vec![way])
    }),
    kind("split a lanelet", &["vm-03-05/divided"], split),
    kind("delete a lanelet", UNCONNECTED, |base, map, dice| {
        let &id = dice.pick(&base.sole)?;
        map.remove(ElementKind::Relation, id);
        // The lanes and the area that miss it are named, not the lanelet, which is gone.
        Some(Vec::new())
    }),
    kind("swap the roles left and right", UNCONNECTED, |_, map, dice| {
        let id = dice.pick(map.movements())?.id;
        for member in &mut map.relation(id).members {
            member.role = match member.role.as_str() {
                "left" => "right".into(),
                "right" => "left".into(),
                _ => continue,
            };
        }
        Some(vec![id])
    }),
    kind("copy an end node", &["vm-03-04/near-miss", "vm-03-08/lane-node-missing"], |_, map, dice| {
        apart(map, dice, 0.0)
    }),
    kind("tear an end node 0.4 m off", &["vm-03-04/near-miss", "vm-03-08/lane-node-missing"], |_, map, dice| {
        apart(map, dice, 0.4)
    }),
    kind("move a node of a curve 0.4 m sideways", UNEVEN, |_, map, dice| {
        let mut places = Vec::new();
        for way in map.inner_bounds() {
            let line = map.line(way);
            // Where nodes stand farther apart, 0.4 m are within the limits of the requirement.
            let dense = |at: &usize| (line[*at] - line[at - 1]).norm() < 1.2 && (line[at + 1] - line[*at]).norm() < 1.2;
            // At the ends a curve that a stretch is missing of may still pass as one.
            places.extend((2..line.len().saturating_sub(2)).filter(dense).map(|at| (way, at)));
        }
        let (way, at) = dice.pick(places)?;
        let by = normal(&map.line(way)[at - 1..=at + 1]) * dice.pick([0.4, -0.4])?;
        let node = map.way(way).nodes[at];
        map.shift(node, by);
        Some(vec![way].into_iter().chain(map.bounded(way)).collect())
    }),
    kind("let a bound bulge by half a lane", UNEVEN, |_, map, dice| {
        let lanelet = dice.pick(map.movements())?;
        let (left, right) = (map.line(bounds(lanelet)[0]), map.line(bounds(lanelet)[1]));
        let width = (left[0] - right[0]).norm().min((left[0] - right[right.len() - 1]).norm());
        let way = dice.pick(bounds(lanelet))?;
        let line = map.line(way);
        let at = line.len() / 2;
        let segment = [line[at - 1], line[at]];
        let middle = nalgebra::center(&segment[0], &segment[1]);
        let side = normal(&segment) * dice.pick([width / 2.0, -width / 2.0])?;
        let before = map.way(way).nodes[at - 1];
        let node = map.copy_node(before);
        map.shift(node, middle - segment[0] + side);
        map.way(way).nodes.insert(at, node);
        Some(map.bounded(way))
    }),
    kind("draw a neighbour's bound a second time", &["vm-03-07/not-shared", "vm-03-15/not-shared"], |_, map, dice| {
        let mut pairs = Vec::new();
        for a in map.movements() {
            for b in map.movements().filter(|b| bounds(a)[1] == bounds(b)[0]) {
                pairs.push((a.id, b.id, bounds(a)[1]));
            }
        }
        let (a, b, way) = dice.pick(pairs)?;
        let other = map.copy_way(way);
        let lanelet = dice.pick([a, b])?;
        let member =
            map.relation(lanelet).members.iter_mut().find(|member| member.id == way && member.role != "centerline");
        member?.id = other;
        Some(vec![lanelet])
    }),
];

fn untag(map: &mut Draft, dice: &mut Dice, key: &str) -> Option<Vec<i64>> {
    let id = dice.pick(map.movements())?.id;
    map.relation(id).tags = without(&map.relation(id).tags, key);
    Some(vec![id])
}

/// Across a line, of length 1, from its first to its last point.
fn normal(line: &[Point]) -> Vector {
    let along = (line[line.len() - 1] - line[0]).normalize();
    Vector::new(-along.y, along.x)
}

/// Gives a bound of a lanelet an end node of its own, this far from the one it had.
fn apart(map: &mut Draft, dice: &mut Dice, metres: f64) -> Option<Vec<i64>> {
    let way = dice.pick(map.inner_bounds())?;
    let line = map.line(way);
    let count = line.len();
    let (end, next) = dice.pick([(0, 1), (count - 1, count - 2)])?;
    let old = map.way(way).nodes[end];
    let node = map.copy_node(old);
    map.shift(node, (line[next] - line[end]).normalize() * metres);
    map.way(way).nodes[end] = node;
    Some(vec![node])
}

/// Makes two lanelets of one, at a node of each bound, with all their tags and elements.
fn split(_: &super::Base, map: &mut Draft, dice: &mut Dice) -> Option<Vec<i64>> {
    let long = |lanelet: &&Relation| bounds(lanelet).iter().all(|&way| map.line(way).len() > 3);
    let id = dice.pick(map.movements().filter(long))?.id;
    let share = dice.pick([0.3, 0.4, 0.5, 0.6, 0.7])?;
    let mut second = map.relation(id).clone();
    second.id = map.fresh();
    let second_id = second.id;
    map.relations.push(second);
    let left = bounds(map.relation(id))[0];
    let start = map.line(left)[0];
    for role in ["left", "right"] {
        let of = |lanelet: &Relation| lanelet.members.iter().position(|member| member.role == role).unwrap();
        let at = of(map.relation(id));
        let whole = map.relation(id).members[at].id;
        let line = map.line(whole);
        // Bounds that others share may run the other way.
        let reversed = (line[line.len() - 1] - start).norm() < (line[0] - start).norm();
        let mut nodes = map.way(whole).nodes.clone();
        if reversed {
            nodes.reverse();
        }
        let cut = ((nodes.len() - 1) as f64 * share).round().clamp(1.0, (nodes.len() - 2) as f64) as usize;
        for (lanelet, piece) in [(id, nodes[..=cut].to_vec()), (second_id, nodes[cut..].to_vec())] {
            let way = map.copy_way(whole);
            map.way(way).nodes = piece;
            map.relation(lanelet).members[at].id = way;
        }
    }
    Some(vec![id, second_id])
}
