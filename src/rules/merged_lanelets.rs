//! The fix that makes one lanelet of two that follow each other, with all that hangs on them.

use std::collections::BTreeMap;

use crate::diagnostic::{Edit, Subject};
use crate::lanelet::index::{MapIndex, STRAIGHT_ON, U_TURN};
use crate::lanelet::{Bound, Lanelet, LineStringId, PointId, Target};

/// More lanes side by side than these are not merged at once.
const MOST: usize = 12;
/// Where one centre line ends this close (m) to where the next begins, one node is enough.
const ONE_PLACE: f64 = 0.05;

/// The edits that extend the first lane over the second. `None` if a person has to decide which lanes become one.
pub fn edits(map: &MapIndex, lane: usize, follower: usize) -> Option<Vec<Edit>> {
    match (map.followers(lane), map.predecessors(follower)) {
        ([_], [_]) => chained(map, lane, follower),
        ([_, _, ..], [_]) => fanned(map, lane, map.followers(lane), true),
        ([_], [_, _, ..]) => fanned(map, follower, map.predecessors(follower), false),
        _ => None,
    }
}

/// For two lanes that are each the only neighbour of the other along the road, as are the lanes beside them that share their
/// bounds.
fn chained(map: &MapIndex, lane: usize, follower: usize) -> Option<Vec<Edit>> {
    let mut pairs = vec![(lane, follower)];
    // For each of two merged ways, the one that stays.
    let mut kept: BTreeMap<LineStringId, LineStringId> = BTreeMap::new();
    let (mut edits, mut gone) = (Vec::new(), Vec::new());
    let mut at = 0;
    while let Some(&(a, b)) = pairs.get(at) {
        if pairs.len() > MOST || map.followers(a) != [b] || map.predecessors(b) != [a] || a == b {
            return None;
        }
        at += 1;
        let [first, second] = [a, b].map(|lane| map.lanes[lane].lanelet);
        for (into, from) in [(first.left, second.left), (first.right, second.right)] {
            let replaced = |to: LineStringId| {
                let lanelet = first.id.0;
                (into.line != to).then_some(Edit::ReplaceWay { lanelet, from: into.line.0, to: to.0 })
            };
            if let Some(&to) = kept.get(&into.line).filter(|to| kept.get(&from.line) == Some(to)) {
                edits.extend(replaced(to));
                continue;
            }
            if kept.contains_key(&into.line) || kept.contains_key(&from.line) || into.line == from.line {
                return None;
            }
            let others = |way: LineStringId, own: usize| -> Vec<usize> {
                map.users_of(way).iter().copied().filter(|&user| user != own).collect()
            };
            let stays = match (&others(into.line, a)[..], &others(from.line, b)[..]) {
                (_, []) if others(into.line, a).is_empty() => {
                    gone.push(from.line);
                    into
                }
                ([], _) => into,
                (_, []) => from,
                (&[x], &[y]) => {
                    pairs.push(if map.follows(x, y) { (x, y) } else { (y, x) });
                    kept.extend([(into.line, into.line), (from.line, into.line)]);
                    gone.push(from.line);
                    into
                }
                _ => return None,
            };
            edits.push(joined(map, stays, [into, from]));
            edits.extend(replaced(stays.line));
        }
        edits.extend(tags(map, [a, b], first, first, second));
        edits.extend(inherited(map, first, second));
        edits.extend(centerline(map, first, [first, second]));
        gone.extend(second.centerline);
        edits.push(Edit::Remove { subject: Subject::Lanelet(second.id.0) });
    }
    edits.extend(gone.into_iter().map(|way| Edit::Remove { subject: Subject::LineString(way.0) }));
    Some(edits)
}

/// The piece before several lanes, or behind them, becomes part of each of them.
fn fanned(map: &MapIndex, piece: usize, lanes: &[usize], before: bool) -> Option<Vec<Edit>> {
    let common = map.lanes[piece].lanelet;
    let mut edits = Vec::new();
    let mut grown: BTreeMap<LineStringId, Bound> = BTreeMap::new();
    for &lane in lanes {
        let only = if before { map.predecessors(lane) } else { map.followers(lane) };
        if only != [piece] || lane == piece {
            return None;
        }
        let lanelet = map.lanes[lane].lanelet;
        for (own, other) in [(lanelet.left, common.left), (lanelet.right, common.right)] {
            match grown.get(&own.line) {
                Some(known) if *known == other => continue,
                Some(_) => return None,
                None => {}
            }
            if own.line == other.line || !map.users_of(own.line).iter().all(|user| lanes.contains(user)) {
                return None;
            }
            grown.insert(own.line, other);
            edits.push(joined(map, own, if before { [other, own] } else { [own, other] }));
        }
        let order = if before { [common, lanelet] } else { [lanelet, common] };
        let places = if before { [piece, lane] } else { [lane, piece] };
        edits.extend(tags(map, places, lanelet, order[0], order[1]));
        edits.extend(inherited(map, lanelet, common));
        edits.extend(centerline(map, lanelet, order));
    }
    let mut edits = without_repeats(edits);
    edits.push(Edit::Remove { subject: Subject::Lanelet(common.id.0) });
    let bounds = [common.left.line, common.right.line].into_iter().filter(|way| map.users_of(*way) == [piece]);
    edits.extend(bounds.chain(common.centerline).map(|way| Edit::Remove { subject: Subject::LineString(way.0) }));
    Some(edits)
}

/// Members that each of the lanes takes over are let go once.
fn without_repeats(edits: Vec<Edit>) -> Vec<Edit> {
    let mut kept: Vec<Edit> = Vec::new();
    for edit in edits {
        if !matches!(edit, Edit::RemoveMember { .. }) || !kept.contains(&edit) {
            kept.push(edit);
        }
    }
    kept
}

/// A way runs over the points of two bounds, in its own direction; the common one once.
fn joined(map: &MapIndex, way: Bound, [first, second]: [Bound; 2]) -> Edit {
    let behind = map.map.bound_points(second).skip(1);
    let mut points: Vec<i64> = map.map.bound_points(first).chain(behind).map(|point| point.id.0).collect();
    if way.inverted {
        points.reverse();
    }
    Edit::SetVertices { way: Subject::LineString(way.line.0), points }
}

/// The centre line of a lanelet runs over those of two that follow each other; the point that they have in common once.
fn centerline(map: &MapIndex, onto: &Lanelet, [first, second]: [&Lanelet; 2]) -> Option<Edit> {
    let points = |lanelet: &Lanelet| Some(&map.map.linestrings.get(lanelet.centerline?)?.points);
    let (before, behind) = (points(first)?, points(second)?);
    let is_common = before.last().zip(behind.first()).is_some_and(|(a, b)| a == b || is_one_place(map, *a, *b));
    let points = before.iter().chain(behind.iter().skip(usize::from(is_common))).map(|id| id.0).collect();
    Some(Edit::SetVertices { way: Subject::LineString(onto.centerline?.0), points })
}

fn is_one_place(map: &MapIndex, a: PointId, b: PointId) -> bool {
    let place = |id| map.map.points.get(id).map(|point| point.position);
    place(a).zip(place(b)).is_some_and(|(a, b)| (a - b).norm() < ONE_PLACE)
}

/// The tags that a lanelet has differently as one with another: where it turns, the area that either names, the lower speed.
fn tags(map: &MapIndex, lanes: [usize; 2], onto: &Lanelet, first: &Lanelet, second: &Lanelet) -> Vec<Edit> {
    let on = Subject::Lanelet(onto.id.0);
    let set = |key: &'static str, value: String| {
        let is_new = onto.attributes.get(key) != Some(value.as_str());
        is_new.then(|| Edit::SetTag { on, key: key.into(), value: value.into() })
    };
    let values = |key: &str| [first, second].map(|lanelet| lanelet.attributes.get(key));
    let turn = match values("turn_direction") {
        [Some(a), Some(b)] if a == b => None,
        [None, None] => None,
        _ => {
            let turn = lanes.iter().map(|&lane| map.lanes[lane].turn()).sum();
            set("turn_direction", map.label_for(turn, STRAIGHT_ON, U_TURN).as_str().to_owned())
        }
    };
    let [a, b] = values("intersection_area");
    let area = a.or(b).and_then(|area| set("intersection_area", area.to_owned()));
    let [a, b] = values("speed_limit").map(|value| value.and_then(|value| value.trim().parse::<f64>().ok()));
    let lower = a.zip(b).filter(|(a, b)| a != b).and_then(|(a, b)| {
        let value = values("speed_limit")[usize::from(b < a)]?;
        set("speed_limit", value.to_owned())
    });
    turn.into_iter().chain(area).chain(lower).collect()
}

/// The first lanelet takes over the elements of the second, and its parts in the elements of others.
fn inherited(map: &MapIndex, first: &Lanelet, second: &Lanelet) -> Vec<Edit> {
    let (one, other) = (Subject::Lanelet(first.id.0), Subject::Lanelet(second.id.0));
    let own = second.regulatory_elements.iter().filter(|element| !first.regulatory_elements.contains(element));
    let mut edits: Vec<Edit> = own
        .map(|element| Edit::AddMember {
            on: one,
            role: "regulatory_element".into(),
            member: Subject::RegulatoryElement(element.0),
        })
        .collect();
    for element in map.elements_naming(second.id) {
        let on = Subject::RegulatoryElement(element.id.0);
        for member in element.members.iter().filter(|member| member.target == Target::Lanelet(second.id)) {
            edits.push(Edit::RemoveMember { on, role: member.role.clone(), member: other });
            if !element.lanelets(&member.role).any(|lanelet| lanelet == first.id) {
                edits.push(Edit::AddMember { on, role: member.role.clone(), member: one });
            }
        }
    }
    edits
}
