//! The fix that makes one border of two ways that were drawn along each other.

use crate::diagnostic::Edit;
use crate::geometry::Point;
use crate::lanelet::index::{Lane, MapIndex};
use crate::lanelet::{LineStringId, PointId};

/// Ends no farther apart (m) become one: as far as end nodes that lie beside each other are joined.
const ENDS: f64 = 0.5;
/// Ends whose heights differ by more (m) are parted by a wall.
const WALL_HEIGHT: f64 = 0.5;

/// An end of a way: the node and its place.
type End = (PointId, Point);

/// The edits by which two lanes share one way as the border between them: one way is used by both, and the ends of the other one
/// become its ends. `None` where the ways do not end beside each other, or the one that would go has other users.
pub fn edits(map: &MapIndex, lanes: [usize; 2], ways: [LineStringId; 2]) -> Option<Vec<Edit>> {
    let is_single = |way: LineStringId| map.users_of(way).len() == 1;
    // The painted way stays rather than the virtual one, and else the first.
    let order = if is_virtual(map, ways[0]) && !is_virtual(map, ways[1]) { [1, 0] } else { [0, 1] };
    let [keep, drop] = [order, [order[1], order[0]]].into_iter().find(|[_, drop]| is_single(ways[*drop]))?;
    let (kept, dropped) = (ends(map, ways[keep])?, ends(map, ways[drop])?);
    let [forth, back] = [kept, [kept[1], kept[0]]];
    let apart = |kept: &[End; 2]| (0..2).map(|i| (kept[i].1 - dropped[i].1).norm()).fold(0.0, f64::max);
    let kept = if apart(&forth) <= apart(&back) { forth } else { back };
    if apart(&kept) > ENDS {
        return None;
    }
    let mut edits = Vec::new();
    for ((to, _), (from, _)) in kept.into_iter().zip(dropped) {
        if from == to {
            continue;
        }
        if !may_become_one(map, lanes, from, to) {
            return None;
        }
        edits.push(Edit::MergePoints { from: from.0, to: to.0 });
    }
    let lanelet = map.lanes[lanes[drop]].id.0;
    edits.push(Edit::ReplaceWay { lanelet, from: ways[drop].0, to: ways[keep].0 });
    Some(edits)
}

/// The same, for the two bounds of the lanes that end nearest to each other; with the way that stays.
pub fn between(map: &MapIndex, lanes: [usize; 2]) -> Option<(LineStringId, Vec<Edit>)> {
    let [a, b] = lanes.map(|lane| &map.lanes[lane]);
    let pairs = a.bounds.iter().flat_map(|&one| b.bounds.iter().map(move |&other| [one, other]));
    let apart = |ways: [LineStringId; 2]| -> Option<f64> {
        let [one, other] = [ends(map, ways[0])?, ends(map, ways[1])?];
        let sum = |i: usize| (one[0].1 - other[i].1).norm() + (one[1].1 - other[1 - i].1).norm();
        Some(sum(0).min(sum(1)))
    };
    let near = pairs.filter_map(|ways| Some((apart(ways)?, ways)));
    let (_, ways) = near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
    let edits = edits(map, lanes, ways)?;
    let kept = edits.iter().find_map(|edit| match edit {
        Edit::ReplaceWay { to, .. } => Some(LineStringId(*to)),
        _ => None,
    })?;
    Some((kept, edits))
}

fn is_virtual(map: &MapIndex, way: LineStringId) -> bool {
    map.map.linestrings.get(way).is_none_or(|line| line.attributes.is("type", "virtual"))
}

fn ends(map: &MapIndex, way: LineStringId) -> Option<[End; 2]> {
    let points = &map.map.linestrings.get(way)?.points;
    let end = |id: PointId| Some((id, map.map.points.get(id)?.position));
    Some([end(*points.first()?)?, end(*points.last()?)?])
}

/// Whether two nodes may become one: they lie on one level, and are neither the two corners of one end of a lane nor the ends of one
/// bound of it, as of a lane that turns around between two that run against each other: that bound would be a point.
fn may_become_one(map: &MapIndex, lanes: [usize; 2], from: PointId, to: PointId) -> bool {
    let height = |id| map.map.points.get(id).and_then(|point| point.ele());
    let step = height(from).zip(height(to)).map_or(0.0, |(a, b)| (a - b).abs());
    let next = lanes.iter().flat_map(|&lane| map.followers(lane).iter().chain(map.predecessors(lane)));
    let has_both = |lane: &Lane| {
        let is_both = |ids: [PointId; 2]| ids.contains(&from) && ids.contains(&to);
        let [start, end] = [lane.start.ids, lane.end.ids];
        [start, end, [start[0], end[0]], [start[1], end[1]]].into_iter().any(is_both)
    };
    step <= WALL_HEIGHT && !lanes.iter().chain(next).any(|&lane| has_both(&map.lanes[lane]))
}
