//! Which findings follow from another one: a point in the wrong place spoils every lanelet that uses it.

use rustc_hash::FxHashMap;

use super::split_code;
use crate::diagnostic::{Diagnostic, Subject};
use crate::lanelet::{LaneletId, LaneletMap, LineStringId, PointId, PolygonId};

/// What says that a point lies in the wrong place.
const MISPLACED: &str = "node/coordinate";
/// Rules whose findings follow from no place.
const OF_THEIR_OWN: [&str; 3] = ["projector", "ids", "node"];

/// For each finding the one that it follows from, by position.
pub fn causes(found: &[Diagnostic], map: &LaneletMap) -> Vec<Option<usize>> {
    let misplaced = found.iter().enumerate().filter(|(_, one)| one.code == MISPLACED);
    let misplaced: FxHashMap<PointId, usize> =
        misplaced.filter_map(|(at, one)| Some((PointId(one.finding.subject.id()?), at))).collect();
    let cause = |one: &Diagnostic| {
        let own = misplaced.is_empty() || OF_THEIR_OWN.contains(&split_code(&one.code).0);
        let points = if own { Vec::new() } else { points_of(map, one.finding.subject) };
        points.iter().find_map(|point| misplaced.get(point)).copied()
    };
    found.iter().map(cause).collect()
}

/// The points that a primitive is made of.
fn points_of(map: &LaneletMap, subject: Subject) -> Vec<PointId> {
    let line = |id: LineStringId| map.linestrings.get(id).map_or(&[][..], |line| &line.points);
    match subject {
        Subject::Point(id) => vec![PointId(id)],
        Subject::LineString(id) => line(LineStringId(id)).to_vec(),
        Subject::Polygon(id) => map.polygons.get(PolygonId(id)).map(|ring| ring.points.clone()).unwrap_or_default(),
        Subject::Lanelet(id) => {
            let lanelet = map.lanelets.get(LaneletId(id));
            let bounds = lanelet.into_iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]);
            bounds.flat_map(line).copied().collect()
        }
        _ => Vec::new(),
    }
}
