//! The fix that moves the ends of lanes onto a stop line, along the bounds that lead there.

use std::collections::BTreeSet;

use crate::diagnostic::{Edit, Subject};
use crate::geometry::{Point, line_crossing};
use crate::lanelet::index::{MapIndex, StopLine};
use crate::lanelet::{Bound, LineStringId, PointId};

/// Ends are moved no farther than this, metres: a stop line that is farther away belongs to another place of the lane.
const FARTHEST: f64 = 3.0;
/// Ends this close to the line, metres, stay.
const ENDS_ON_LINE: f64 = 0.05;

/// The edits that put both corners of a lane's start onto a stop line: each moves along the bound before it or behind it, and the
/// vertices that it passes go over to the bounds of the lanes on its other side. `None` where a bound does not lead to the line.
pub fn onto(map: &MapIndex, lane: usize, line: &StopLine) -> Option<Vec<Edit>> {
    let &before = map.predecessors(lane).first()?;
    let mut edits = Vec::new();
    for (side, (&corner, &place)) in map.lanes[lane].start.ids.iter().zip(&map.lanes[lane].start.points).enumerate() {
        if off(line, place) <= ENDS_ON_LINE {
            continue;
        }
        let bound = |at: usize| {
            let lanelet = map.lanes[at].lanelet;
            Some(if side == 0 { lanelet.left } else { lanelet.right })
        };
        let (behind, ahead) = (bound(before)?, bound(lane)?);
        let back: Vec<Place> = places(map, behind).into_iter().rev().collect();
        let forth = places(map, ahead);
        let (way, cut) = match cut(&back, line) {
            Some(cut) => (behind.line, cut),
            None => (ahead.line, self::cut(&forth, line)?),
        };
        edits.extend(moved(map, corner, way, &cut));
    }
    (!edits.is_empty()).then_some(edits)
}

type Place = (PointId, Point);

/// Where a bound meets the line: between which of its vertices, and those that are passed on the way there from the corner.
struct Cut {
    between: [PointId; 2],
    share: f64,
    passed: Vec<PointId>,
}

fn places(map: &MapIndex, bound: Bound) -> Vec<Place> {
    map.map.bound_points(bound).map(|point| (point.id, point.position)).collect()
}

/// Distance from the line, as long as it would be.
fn off(line: &StopLine, place: Point) -> f64 {
    let along = line.ends[1] - line.ends[0];
    (crate::geometry::cross(along, place - line.ends[0]) / along.norm()).abs()
}

/// The first place at which a bound, from its corner on, meets the line.
fn cut(bound: &[Place], line: &StopLine) -> Option<Cut> {
    let (mut far, mut passed) = (0.0, Vec::new());
    for pair in bound.windows(2) {
        let [(from, a), (to, b)] = [pair[0], pair[1]];
        let meets = line_crossing(a, b - a, line.ends[0], line.ends[1] - line.ends[0]);
        if let Some((share, _, place)) = meets.filter(|(share, ..)| (0.0..1.0).contains(share)) {
            return (far + (place - a).norm() <= FARTHEST).then_some(Cut { between: [from, to], share, passed });
        }
        far += (b - a).norm();
        passed.push(to);
    }
    None
}

/// The corner at its new place, and the vertices that it passes in the bounds on its other side.
fn moved(map: &MapIndex, corner: PointId, way: LineStringId, cut: &Cut) -> Vec<Edit> {
    let [from, to] = cut.between;
    let mut edits = vec![Edit::PlaceBetween { point: corner.0, from: from.0, to: to.0, share: cut.share }];
    if cut.passed.is_empty() {
        return edits;
    }
    let points = |way: LineStringId| map.map.linestrings.get(way).map_or(&[][..], |line| &line.points[..]);
    let kept = points(way).iter().filter(|id| !cut.passed.contains(id));
    edits.push(Edit::SetVertices { way: Subject::LineString(way.0), points: kept.map(|id| id.0).collect() });
    for other in beyond(map, corner, way) {
        let mut grown: Vec<i64> = points(other).iter().map(|id| id.0).collect();
        // From the corner's new place to its old one.
        let passed: Vec<i64> = cut.passed.iter().rev().map(|id| id.0).collect();
        if grown.first() == Some(&corner.0) {
            grown.splice(1..1, passed);
        } else {
            let end = grown.len().saturating_sub(1);
            grown.splice(end..end, passed.into_iter().rev());
        }
        edits.push(Edit::SetVertices { way: Subject::LineString(other.0), points: grown });
    }
    edits
}

/// The other bounds that begin or end in a corner, of the lanes that go on there.
fn beyond(map: &MapIndex, corner: PointId, way: LineStringId) -> BTreeSet<LineStringId> {
    let users = map.users_of(way).iter();
    let next = users.flat_map(|&user| map.followers(user).iter().chain(map.predecessors(user)));
    let bounds = next.flat_map(|&lane| map.lanes[lane].bounds).filter(|&other| other != way);
    let ends_here = |other: &LineStringId| {
        let points = map.map.linestrings.get(*other).map_or(&[][..], |line| &line.points[..]);
        points.first() == Some(&corner) || points.last() == Some(&corner)
    };
    bounds.filter(ends_here).collect()
}
