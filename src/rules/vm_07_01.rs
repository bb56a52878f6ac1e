//! vm-07-01: the roads that lead to an intersection are drawn as far as its traffic is seen.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::lanelet::index::MapIndex;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    least: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut approaches: Vec<usize> = map
        .traffic
        .iter()
        .flat_map(|traffic| &traffic.movements)
        .flat_map(|movement| map.predecessors(movement.lane))
        .copied()
        .filter(|&lane| map.movement(lane).is_none() && map.lanes[lane].is_for_cars())
        .collect();
    approaches.sort_unstable();
    approaches.dedup();
    for at in approaches {
        let length = upstream(map, at, params.least);
        if length >= params.least {
            continue;
        }
        let lane = &map.lanes[at];
        let message = format!("Approach lane {} is drawn for {length:.1} m only.", lane.id);
        findings.push(
            Finding::new("short-approach", Subject::Lanelet(lane.id.0), message)
                .measured(length, params.least, "m")
                .at(Place::Line(lane.start.points.to_vec())),
        );
    }
    findings
}

/// The length of road (m) that leads to the end of a lane, as far as it matters.
fn upstream(map: &MapIndex, at: usize, enough: f64) -> f64 {
    let mut longest: f64 = 0.0;
    let mut open = vec![(map.lanes[at].length(), at)];
    let mut seen = vec![at];
    while let Some((length, lane)) = open.pop() {
        longest = longest.max(length);
        if longest >= enough {
            break;
        }
        for &before in map.predecessors(lane).iter().filter(|before| !seen.contains(before)).collect::<Vec<_>>() {
            seen.push(before);
            open.push((length + map.lanes[before].length(), before));
        }
    }
    longest
}
