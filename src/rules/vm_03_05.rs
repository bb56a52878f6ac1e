//! vm-03-05: a movement through an intersection is one lanelet, not two.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Polyline, polygon};
use crate::lanelet::PolygonId;
use crate::lanelet::index::{Intersection, MapIndex};

use super::merged_lanelets;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    depth: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    for lane in 0..map.lanes.len() {
        for &follower in map.followers(lane) {
            if follower != lane
                && let Some(area) = divided(map, params, lane, follower)
            {
                findings.push(finding(map, lane, follower, area));
            }
        }
    }
    findings
}

/// The area inside which the first lane ends and the second goes on. `Some(None)` is an intersection without one.
fn divided(map: &MapIndex, params: &Params, lane: usize, follower: usize) -> Option<Option<PolygonId>> {
    if let Some(intersection) = map.in_same_intersection(lane, follower) {
        return Some(intersection.area);
    }
    if !map.lanes[lane].is_drivable() || !map.lanes[follower].is_drivable() {
        return None;
    }
    let both = [lane, follower];
    let near = both.iter().flat_map(|&at| map.intersections_touching(at));
    let mut inside = near.filter(|intersection| ends_inside(map, params, lane, intersection));
    inside.next().map(|intersection| intersection.area)
}

/// Whether a lane ends deep inside an area, on its level.
fn ends_inside(map: &MapIndex, params: &Params, lane: usize, intersection: &Intersection) -> bool {
    let lane = &map.lanes[lane];
    let end = lane.end.middle();
    let ring = &intersection.ring;
    let Some(border) = Polyline::new(ring.iter().chain(ring.first()).copied()) else { return false };
    polygon::contains(ring, end) && border.distance(end) > params.depth && map.is_on_level_of(&lane.end, intersection)
}

fn finding(map: &MapIndex, lane: usize, follower: usize, area: Option<PolygonId>) -> Finding {
    let (first, second) = (&map.lanes[lane], &map.lanes[follower]);
    let area_name = area.map_or("the intersection".to_owned(), |area| format!("area {area}"));
    let message = format!("Lanelets {} and {} form one movement of {area_name}; merge them.", first.id, second.id);
    let finding = Finding::new("divided", Subject::Lanelet(first.id.0), message)
        .with(Subject::Lanelet(second.id.0), "second piece")
        .at(Place::Line(first.end.points.to_vec()));
    let finding = match area {
        Some(area) => finding.with(Subject::Polygon(area.0), "intersection area"),
        None => finding,
    };
    match merged_lanelets::edits(map, lane, follower) {
        Some(edits) => finding.fixed_by(format!("merge lanelet {} into {}", second.id, first.id), false, edits),
        None => finding,
    }
}
