//! vm-01-14: on a narrow road that is driven in both directions, the lanes of both directions lie on each other.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::{Lane, MapIndex};

use super::opposing_overlap;
use super::opposing_overlap::{OpposingOverlap, width};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    stacked: f64,
    wide: f64,
    list: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let pairs = opposing_overlap::all(map).into_iter().filter(|pair| pair.swapped || pair.share >= params.stacked);
    pairs.filter_map(|pair| judge(map, params, &pair)).collect()
}

fn judge(map: &MapIndex, params: &Params, pair: &OpposingOverlap) -> Option<Finding> {
    let [lane, other] = pair.lanes.map(|lane| &map.lanes[lane]);
    let finding = |fault, message: String| {
        Finding::new(fault, Subject::Lanelet(lane.id.0), message)
            .with(Subject::Lanelet(other.id.0), "lane of the other direction")
    };
    if !pair.swapped {
        let message =
            format!("Lanelets {} and {} lie on each other but do not have the same two bounds.", lane.id, other.id);
        let found = finding("not-shared", message);
        let edits = shared(lane, other);
        let safe = !edits.is_empty();
        return Some(if safe { found.fixed_by("use the same bounds for both", true, edits) } else { found });
    }
    let wide = width(lane)?;
    if wide > params.wide {
        let message = format!(
            "Lanelets {} and {} lie on each other on a road of {wide:.1} m: two vehicles can pass.",
            lane.id, other.id
        );
        return Some(finding("wide", message).measured(wide, params.wide, "m"));
    }
    let message = format!("Lanelets {} and {} are one narrow road, driven to and fro.", lane.id, other.id);
    params.list.then(|| finding("stacked", message))
}

/// How the second lane comes to have the first one's bounds: only where it keeps its four corners.
fn shared(lane: &Lane, other: &Lane) -> Vec<Edit> {
    let [start, end] = [lane.start.ids, lane.end.ids];
    if other.start.ids != [end[1], end[0]] || other.end.ids != [start[1], start[0]] {
        return Vec::new();
    }
    let sides = [(other.bounds[0], lane.bounds[1]), (other.bounds[1], lane.bounds[0])];
    let differ = sides.into_iter().filter(|(from, to)| from != to);
    differ.map(|(from, to)| Edit::ReplaceWay { lanelet: other.id.0, from: from.0, to: to.0 }).collect()
}
