//! health: what no requirement forbids, and what planners break on all the same.

mod borders;
mod ends;
mod fans;
mod holes;
mod links;
mod narrow;
mod network;
mod params;
mod shape;
mod street_ends;
mod wide;

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::routing_moves::RoutingMoves;

use params::Params;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let moves = RoutingMoves::new(map);
    let links = links::Links::new(map, params, &moves);
    let mut findings = shape::judge(map, params);
    findings.extend(borders::judge(map));
    findings.extend(ends::judge(map, params, &moves, &links));
    findings.extend(fans::judge(map));
    findings.extend(narrow::judge(map, params, &moves));
    findings.extend(wide::judge(map, params));
    findings.extend(network::judge(map, params, &moves, &links));
    findings.extend(links.into_findings());
    findings
}
