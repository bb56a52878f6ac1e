//! vm-01-13: on a wide road without a middle line the two lanes lie side by side at its middle.

use serde::Deserialize;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::LineStringId;
use crate::lanelet::index::MapIndex;

use super::opposing_overlap;
use super::opposing_overlap::{OpposingOverlap, is_plain, width};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    overlap: f64,
    stacked: f64,
    off: f64,
    narrow: f64,
}

/// Lanes that overlap by less, m2, touch.
const LEAST_AREA: f64 = 0.5;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    // Where lanes branch or join, roads meet, be no area drawn there: their ways lie over each other.
    let branches = |at: usize| map.siblings(at).next().is_some() || map.ending_at(map.lanes[at].end.ids).len() > 1;
    let partly = |pair: &OpposingOverlap| {
        let share = (params.overlap..params.stacked).contains(&pair.share);
        share && pair.area >= LEAST_AREA && !pair.swapped && !pair.lanes.into_iter().any(branches)
    };
    let mut findings: Vec<Finding> =
        opposing_overlap::all(map).iter().filter(|pair| partly(pair)).map(|pair| overlap(map, params, pair)).collect();
    for at in (0..map.lanes.len()).filter(|&at| is_plain(map, at) && !map.is_at_unmarked(at)) {
        findings.extend([0, 1].into_iter().filter_map(|side| beside(map, params, at, side)));
    }
    findings
}

fn overlap(map: &MapIndex, params: &Params, pair: &OpposingOverlap) -> Finding {
    let [id, other] = pair.lanes.map(|lane| map.lanes[lane].id);
    let percent = pair.share * 100.0;
    let message = format!(
        "Lanelets {id} and {other} run against each other and overlap by {percent:.0} %: neither side by side nor stacked."
    );
    let finding = Finding::new("overlap", Subject::Lanelet(id.0), message);
    finding.with(Subject::Lanelet(other.0), "oncoming lane").measured(percent, params.overlap * 100.0, "%")
}

/// Whether nothing is painted along a way.
fn unpainted(map: &MapIndex, way: LineStringId) -> bool {
    map.map.linestrings.get(way).is_some_and(|line| matches!(line.attributes.get("type"), None | Some("virtual")))
}

/// A road of two lanes and no middle line: each lane with one neighbour, which comes against it.
fn beside(map: &MapIndex, params: &Params, at: usize, side: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let way = lane.bounds[side];
    if !unpainted(map, way) {
        return None;
    }
    let users: Vec<usize> = map.users_of(way).to_vec();
    let [first, second] = users[..] else { return None };
    let other = if first == at { second } else { first };
    let oncoming = &map.lanes[other];
    let alone = |lane: usize| {
        let outer = map.lanes[lane].bounds[1 - side];
        map.users_of(outer).iter().all(|&user| user == lane || !map.lanes[user].is_for_cars())
    };
    if at > other || oncoming.bounds[side] != way || !is_plain(map, other) || !alone(at) || !alone(other) {
        return None;
    }
    let (mine, theirs) = (width(lane)?, width(oncoming)?);
    let finding = |fault, message: String| {
        Finding::new(fault, Subject::LineString(way.0), message)
            .with(Subject::Lanelet(lane.id.0), "lane")
            .with(Subject::Lanelet(oncoming.id.0), "oncoming lane")
    };
    let narrow = mine.min(theirs);
    if narrow < params.narrow {
        let message = format!(
            "Lanelets {} and {} share a road without middle line and are {narrow:.2} m wide: too narrow to pass.",
            lane.id, oncoming.id
        );
        return Some(finding("narrow", message).measured(narrow, params.narrow, "m"));
    }
    let off = (mine - theirs).abs() / 2.0;
    let message = format!(
        "Border {way} between lanelets {} and {} lies {off:.2} m off the middle of their road.",
        lane.id, oncoming.id
    );
    (off > params.off).then(|| finding("off-middle", message).measured(off, params.off, "m"))
}
