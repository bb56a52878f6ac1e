//! Nodes of different ids at one place, where bounds should be joined.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, angle_between};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{LineString, LineStringId, PointId};
use crate::rules::crowd::MOST;
use crate::rules::near_nodes::NodeClusters;

/// Nodes nearer than this are one place, metres: no editor draws and no survey measures finer.
const ONE_PLACE: f64 = 0.005;
/// Nodes with heights farther apart than this, metres, are above each other.
const ONE_HEIGHT: f64 = 0.5;
/// Where a lane leads into another no farther apart than this, metres, and bends no more than `STRAIGHT_ON` degrees, other rules
/// tell of the nodes.
const LED_TO: f64 = 0.5;
const STRAIGHT_ON: f64 = 30.0;

pub fn judge(map: &MapIndex) -> Vec<Finding> {
    let bounds: Vec<&LineString> = bounds(map);
    let mut findings: Vec<Finding> = bounds.iter().filter_map(|line| point_bound(map, line)).collect();
    findings.extend(ends(map, &bounds));
    findings
}

/// The bounds of lanes that vehicles drive on, each once, by id.
fn bounds<'m>(map: &MapIndex<'m>) -> Vec<&'m LineString> {
    let drivable = map.lanes.iter().filter(|lane| lane.is_drivable());
    let ways: BTreeSet<LineStringId> = drivable.flat_map(|lane| lane.bounds).collect();
    ways.into_iter().filter_map(|way| map.map.linestrings.get(way)).collect()
}

fn place(map: &MapIndex, id: PointId) -> Option<Point> {
    map.map.points.get(id).map(|point| point.position)
}

/// A bound whose nodes, of different ids, all lie on one place.
fn point_bound(map: &MapIndex, line: &LineString) -> Option<Finding> {
    let first = place(map, *line.points.first()?)?;
    let different = line.points.iter().any(|id| *id != line.points[0]);
    let is_one = line.points.iter().filter_map(|&id| place(map, id)).all(|at| (at - first).norm() < ONE_PLACE);
    if !different || !is_one {
        return None;
    }
    let message = format!("All nodes of bound {} lie on one place; it has no length.", line.id);
    let finding = Finding::new("point-bound", Subject::LineString(line.id.0), message).at(Place::Point(first));
    let users = map.users_of(line.id).iter().map(|&lane| Subject::Lanelet(map.lanes[lane].id.0));
    Some(users.fold(finding, |finding, lane| finding.with(lane, "lane")))
}

/// Ends of bounds that lie on a node of another bound and are another node.
fn ends(map: &MapIndex, bounds: &[&LineString]) -> Vec<Finding> {
    let mut by_cell: FxHashMap<[i64; 2], Vec<(PointId, usize)>> = FxHashMap::default();
    let cell = |at: Point| [(at.x / ONE_PLACE).floor() as i64, (at.y / ONE_PLACE).floor() as i64];
    for (at, line) in bounds.iter().enumerate() {
        for &id in &line.points {
            if let Some(place) = place(map, id) {
                by_cell.entry(cell(place)).or_default().push((id, at));
            }
        }
    }
    let mut pairs: BTreeMap<[PointId; 2], [usize; 2]> = BTreeMap::new();
    let mut met: FxHashMap<[usize; 2], usize> = FxHashMap::default();
    for (at, line) in bounds.iter().enumerate() {
        let ends = [line.points.first(), line.points.last()];
        for &id in &line.points {
            let Some(here) = place(map, id) else { continue };
            let [x, y] = cell(here);
            let near = |at: i64| at.saturating_sub(1)..=at.saturating_add(1);
            let around = near(x).flat_map(|x| near(y).map(move |y| [x, y]));
            // In a crowd all nodes are compared with the same first ones, which joins them into one cluster.
            let others = around.filter_map(|cell| by_cell.get(&cell).map(|all| &all[..all.len().min(MOST)]));
            for &(other, theirs) in others.flatten() {
                let joined = line.points.contains(&other) || bounds[theirs].points.contains(&id);
                if other == id || theirs == at || joined || !is_one_place(map, id, other) {
                    continue;
                }
                *met.entry([at.min(theirs), at.max(theirs)]).or_default() += 1;
                if ends.contains(&Some(&id)) {
                    pairs.entry([id.min(other), id.max(other)]).or_insert([at, theirs]);
                }
            }
        }
    }
    let told = told_as_near_misses(map);
    // Each meeting was counted from both lines. Lines that meet more than once lie on each other: they are one line drawn twice.
    let is_doubled = |[a, b]: [usize; 2]| met.get(&[a.min(b), a.max(b)]).is_some_and(|count| *count > 2);
    pairs.retain(|pair, lines| !told.contains(pair) && !is_doubled(*lines));
    let clusters = NodeClusters::of(map, pairs.keys().copied(), ONE_PLACE * 2.0);
    let findings = pairs.iter().filter(|(pair, _)| clusters.tells(**pair)).map(|(pair, lines)| {
        let [a, b] = pair;
        let [x, y] = lines.map(|line| bounds[line].id);
        let message = format!("Nodes {a} and {b} lie on one place; bounds {x} and {y} meet there and are not joined.");
        let finding = Finding::new("same-place", Subject::Point(b.0), message)
            .with(Subject::Point(a.0), "other node")
            .with(Subject::LineString(x.0), "bound")
            .with(Subject::LineString(y.0), "bound");
        let finding = finding.at(place(map, *a).map_or(Place::Unknown, Place::Point));
        let mut finding = clusters.made_one(map, finding, *pair);
        // Lanes may come to follow each other that did not.
        if let Some(fix) = &mut finding.fix {
            fix.safe = false;
        }
        finding
    });
    findings.collect()
}

fn is_one_place(map: &MapIndex, a: PointId, b: PointId) -> bool {
    let [Some(a), Some(b)] = [a, b].map(|id| map.map.points.get(id)) else { return false };
    let level = a.ele().zip(b.ele()).is_none_or(|(a, b)| (a - b).abs() < ONE_HEIGHT);
    level && (a.position - b.position).norm() < ONE_PLACE
}

/// Pairs of nodes across which a lane would lead on into another: health/near-miss and vm-03-04/near-miss tell of these.
fn told_as_near_misses(map: &MapIndex) -> FxHashSet<[PointId; 2]> {
    let mut pairs = FxHashSet::default();
    for lane in &map.lanes {
        for other in map.edges_near(lane.end.middle(), LED_TO, false) {
            let start = map.lanes[other].start;
            let apart = (0..2).map(|side| (lane.end.points[side] - start.points[side]).norm()).fold(0.0, f64::max);
            let ahead = lane.heading_out().zip(map.lanes[other].heading_in());
            let bends = ahead.is_none_or(|(a, b)| angle_between(a, b).abs().to_degrees() > STRAIGHT_ON);
            if apart >= LED_TO || bends {
                continue;
            }
            for side in 0..2 {
                let [a, b] = [lane.end.ids[side], start.ids[side]];
                pairs.insert([a.min(b), a.max(b)]);
            }
        }
    }
    pairs
}
