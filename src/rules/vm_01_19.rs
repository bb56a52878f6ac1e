//! vm-01-19: a walkway crosses a road, and reaches beyond it on both sides.

use geo::{BooleanOps, Distance, Euclidean};
use serde::Deserialize;

use super::Rule;
use super::view::{Seen, View};
use crate::diagnostic::{Finding, Subject};
use crate::geometry::polygon;
use crate::lanelet::Point;
use crate::lanelet::index::MapIndex;

/// See `rules/vm-01-19.md`.
pub struct Walkway;

/// See the document.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    overhang: f64,
}

impl Rule for Walkway {
    type Params = Params;

    fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
        if !map.map.lanelets.iter().any(|lanelet| lanelet.attributes.is("subtype", "walkway")) {
            return Vec::new();
        }
        let view = View::new(map.map);
        view.lanelets.iter().filter(|seen| seen.is("walkway")).flat_map(|seen| judge(&view, params, seen)).collect()
    }
}

fn judge(view: &View, params: &Params, seen: &Seen) -> Vec<Finding> {
    let (id, subject) = (seen.id(), Subject::Lanelet(seen.id().0));
    let near = view.near(seen.extent, 0.0).into_iter().map(|at| &view.lanelets[at]);
    let roads: Vec<(&Seen, f64)> = near
        .filter(|road| road.is("road") || road.is("private"))
        .filter_map(|road| Some((road, overhang(seen, road)?)))
        .collect();
    if roads.is_empty() {
        return vec![Finding::new("idle", subject, format!("Walkway {id} crosses no road."))];
    }
    let short = roads.into_iter().filter(|(_, overhang)| *overhang < params.overhang);
    short
        .map(|(road, overhang)| {
            let message = format!("Walkway {id} reaches only {overhang:.2} m beyond road lanelet {}.", road.id());
            let finding = Finding::new("short", subject, message).with(Subject::Lanelet(road.id().0), "road");
            finding.measured(overhang, params.overhang, "m")
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
