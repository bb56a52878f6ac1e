//! Lanes that lie side by side at one end and all lie on each other at the other end.

use std::collections::BTreeMap;

use crate::diagnostic::{Finding, Severity};
use crate::lanelet::PointId;
use crate::lanelet::index::MapIndex;

use super::params::subject;

/// So many lanes on one edge are a fan: one lane may open, or end, beside another there.
const LEAST: usize = 3;

pub fn judge(map: &MapIndex) -> Vec<Finding> {
    [false, true].into_iter().flat_map(|closes| fans(map, closes)).collect()
}

/// Lanes outside intersections that begin, or if it `closes` end, on one edge, and lie side by side at their other ends.
fn fans(map: &MapIndex, closes: bool) -> Vec<Finding> {
    let ends = |at: usize| {
        let (start, end) = (map.lanes[at].start.ids, map.lanes[at].end.ids);
        if closes { [end, start] } else { [start, end] }
    };
    let [open, begin] = if closes { ["close", "end"] } else { ["open", "begin"] };
    let mut on_edge: BTreeMap<[PointId; 2], Vec<usize>> = BTreeMap::new();
    for (at, lane) in map.lanes.iter().enumerate() {
        if lane.vehicle && !lane.bicycle && map.movement(at).is_none() && map.intersections_of(at).is_empty() {
            on_edge.entry(ends(at)[0]).or_default().push(at);
        }
    }
    let fan = |lanes: Vec<usize>| {
        let far = |at: usize| ends(at)[1];
        let beside = |at: usize| lanes.iter().copied().find(|&other| other != at && far(at)[1] == far(other)[0]);
        let leftmost = lanes.iter().copied().find(|&at| lanes.iter().all(|&other| far(other)[1] != far(at)[0]))?;
        let mut row: Vec<usize> = std::iter::successors(Some(leftmost), |&at| beside(at)).take(lanes.len()).collect();
        row.sort_unstable_by_key(|&at| map.lanes[at].id);
        (row.len() >= LEAST).then_some(row)
    };
    let rows = on_edge.into_values().filter(|lanes| lanes.len() >= LEAST).filter_map(fan);
    // Turns of one approach.
    let of_roads = rows.filter(|row| !row.iter().any(|&lane| map.is_at_unmarked(lane)));
    let told = of_roads.filter_map(|row| {
        let (&first, others) = row.split_first()?;
        let message = format!(
            "{} lanes {open} at once: lanelet {} and those beside it {begin} in one place.",
            row.len(),
            map.lanes[first].id
        );
        let finding = Finding::new("fan", subject(map, first), message).graded(Severity::Info);
        Some(others.iter().fold(finding, |all, &lane| all.with(subject(map, lane), "beside it")))
    });
    told.collect()
}
