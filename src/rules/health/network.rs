//! The net of lanes: rings too small to drive, parts that hang together with nothing.

use crate::diagnostic::{Finding, Place};
use crate::lanelet::index::MapIndex;

use super::params::{Params, subject};

/// A ring of more lanelets than this has pieces too short to be lanes, and those are told of already.
const MOST_PIECES: usize = 12;

pub fn judge(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings: Vec<Finding> = (0..map.lanes.len()).filter_map(|at| ring(map, params, at)).collect();
    findings.extend(islands(map));
    findings
}

/// The shortest way from the end of a lane back to its start, if no vehicle can turn on a ring that short. The finding is about
/// the first lane on it.
fn ring(map: &MapIndex, params: &Params, at: usize) -> Option<Finding> {
    if !map.lanes[at].vehicle {
        return None;
    }
    let mut open = vec![(map.lanes[at].length(), vec![at])];
    while let Some((length, path)) = open.pop() {
        let last = *path.last()?;
        for &next in map.followers(last) {
            if next == at && length < params.shortest_loop {
                let ids: Vec<String> = path.iter().map(|&lane| map.lanes[lane].id.to_string()).collect();
                let message = match &ids[..] {
                    [id] => format!("Lane {id} follows itself after {length:.1} m."),
                    _ => format!("Lanes {} form a ring of {length:.1} m.", ids.join(", ")),
                };
                let finding = Finding::new("loop", subject(map, at), message)
                    .measured(length, params.shortest_loop, "m")
                    .at(Place::Polygon(map.lanes[at].outline.clone()));
                return Some(
                    path.iter().skip(1).fold(finding, |all, &lane| all.with(subject(map, lane), "in the ring")),
                );
            }
            let longer = length + map.lanes[next].length();
            if next > at
                && longer < params.shortest_loop
                && map.lanes[next].vehicle
                && path.len() < MOST_PIECES
                && !path.contains(&next)
            {
                open.push((longer, path.iter().copied().chain([next]).collect()));
            }
        }
    }
    None
}

/// Fewer lanes than this are no net from which something could be cut off.
const NET: usize = 10;

/// Parts of the net that no lane connects to its largest part.
fn islands(map: &MapIndex) -> Vec<Finding> {
    let lanes: Vec<usize> = (0..map.lanes.len()).filter(|&at| map.lanes[at].vehicle).collect();
    let mut part = vec![usize::MAX; map.lanes.len()];
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for &first in &lanes {
        if part[first] != usize::MAX {
            continue;
        }
        part[first] = parts.len();
        let mut members = vec![first];
        let mut next = 0;
        while let Some(&at) = members.get(next) {
            next += 1;
            let beside = map.lanes[at].bounds.iter().flat_map(|&way| map.users_of(way));
            for &other in map.followers(at).iter().chain(map.predecessors(at)).chain(beside) {
                if map.lanes[other].vehicle && part[other] == usize::MAX {
                    part[other] = parts.len();
                    members.push(other);
                }
            }
        }
        parts.push(members);
    }
    let largest = parts.iter().map(Vec::len).max().unwrap_or_default();
    if largest < NET {
        return Vec::new();
    }
    // If both halves have one size, it is unknown which of them is out of place.
    let main = parts.iter().position(|members| members.len() == largest);
    let others = parts.iter().enumerate().filter(|(at, _)| Some(*at) != main).map(|(_, members)| members);
    let finding = |members: &Vec<usize>| {
        let first = members.iter().copied().min()?;
        let message = match members.len() {
            1 => format!("Lane {} is connected to no other lane.", map.lanes[first].id),
            count => format!(
                "{count} lanes, {} the first, are connected with each other but not with the rest.",
                map.lanes[first].id
            ),
        };
        Some(Finding::new("island", subject(map, first), message).at(Place::Polygon(map.lanes[first].outline.clone())))
    };
    others.filter_map(finding).collect()
}
