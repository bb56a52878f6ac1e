//! Walkways across roads as the existing validator judges them (vm-01-19): road by road, where vm-03-13 asks for the whole
//! walkway.

use geo::{BooleanOps, Distance, Euclidean};

use super::{Issue, Params, issue};
use crate::diagnostic::Subject;
use crate::geometry::polygon;
use crate::lanelet::Point;
use crate::lanelet::index::view::{Seen, View};

/// Least distance (m) from the roads at either end.
const OVERHANG: f64 = 3.0;

/// `walkway_intersection`.
pub fn walkways(view: &View, _: &Params) -> Vec<Issue> {
    view.lanelets.iter().filter(|seen| seen.is("walkway")).flat_map(|seen| judge(view, seen)).collect()
}

fn judge(view: &View, seen: &Seen) -> Vec<Issue> {
    let (id, subject) = (seen.id(), Subject::Lanelet(seen.id().0));
    let near = view.near(seen.extent, 0.0).into_iter().map(|at| &view.lanelets[at]);
    let roads: Vec<(&Seen, f64)> = near
        .filter(|road| road.is("road") || road.is("private"))
        .filter_map(|road| Some((road, overhang(seen, road)?)))
        .collect();
    if roads.is_empty() {
        return vec![issue(1, subject, format!("Walkway {id} crosses no road."))];
    }
    let short = roads.into_iter().filter(|(_, overhang)| *overhang < OVERHANG);
    short
        .map(|(road, overhang)| {
            issue(2, subject, format!("Walkway {id} reaches only {overhang:.2} m beyond road lanelet {}.", road.id()))
        })
        .collect()
}

/// How far the nearer end of a walkway lies from what it has in common with a road; `None` where they do not meet.
fn overhang(walkway: &Seen, road: &Seen) -> Option<f64> {
    let common = polygon::to_geo(&walkway.outline).intersection(&polygon::to_geo(&road.outline));
    let piece = common.0.first()?;
    let line = |[a, b]: [&Point; 2]| {
        let [a, b] = [a, b].map(|point| geo::Coord { x: point.position.x, y: point.position.y });
        geo::Line::new(a, b)
    };
    let ends = walkway.ends()?.map(|edge| Euclidean.distance(&line(edge), piece));
    Some(ends[0].min(ends[1]))
}
