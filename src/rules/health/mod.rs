//! health: what no requirement forbids, and what planners break on all the same.

mod borders;
mod ends;
mod links;
mod network;
mod shape;

use serde::Deserialize;

use super::Rule;
use super::moves::Moves;
use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::MapIndex;

/// See `rules/health.md`.
pub struct Health;

/// See the document.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    least_length: f64,
    tilt: f64,
    least_tilt: f64,
    near_miss: f64,
    gap: f64,
    straight_on: f64,
    shortest_loop: f64,
    map_border: f64,
    turning_place: f64,
}

impl Rule for Health {
    type Params = Params;

    fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
        let moves = Moves::new(map);
        let links = links::Links::new(map, params);
        let mut findings = shape::judge(map, params);
        findings.extend(borders::judge(map));
        findings.extend(ends::judge(map, params, &moves, &links));
        findings.extend(network::judge(map, params));
        findings.extend(links.into_findings());
        findings
    }
}

fn subject(map: &MapIndex, lane: usize) -> Subject {
    Subject::Lanelet(map.lanes[lane].id.0)
}
