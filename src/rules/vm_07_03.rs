//! vm-07-03: guard rails and fences stand beside the lanes, not on them.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::Polyline;
use crate::lanelet::RoadType;
use crate::lanelet::index::MapIndex;

use super::barrier;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    depth: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    for barrier in barrier::all(map) {
        for at in barrier.lanes_near(map) {
            let lane = &map.lanes[at];
            let bounds = [&lane.left, &lane.right].map(|bound| Polyline::new(bound.iter().copied()));
            let [Some(left), Some(right)] = bounds else { continue };
            if lane.kind != RoadType::Road || !lane.vehicle {
                continue;
            }
            let deep = |p| left.distance(p).min(right.distance(p));
            let places = barrier.inside(&lane.outline, |p| deep(p) > params.depth);
            let Some(depth) = places.iter().map(|&p| deep(p)).max_by(f64::total_cmp) else { continue };
            let message = format!("The {} {} stands {depth:.1} m inside lane {}.", barrier.kind, barrier.id, lane.id);
            findings.push(
                Finding::new("on-lane", Subject::LineString(barrier.id.0), message)
                    .with(Subject::Lanelet(lane.id.0), "lane")
                    .measured(depth, params.depth, "m")
                    .at(Place::Line(places)),
            );
        }
    }
    findings
}
