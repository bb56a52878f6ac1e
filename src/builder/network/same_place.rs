//! Joins the nodes of ways that lie at one place, so that roads meet there.

use rustc_hash::{FxHashMap, FxHashSet};

use rayon::prelude::*;

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Point;

use super::access::Drivable;
use super::frame::level;
use super::way_runs::Run;

/// Nodes of a way closer together than this, metres, are one: it is about the resolution of OpenStreetMap's coordinates.
pub(super) const SAME_PLACE: f64 = 0.015;

/// Joins neighbouring nodes of a way at the same place, and nodes with the same coordinates of ways on the same level: an import
/// or a slip of the editor left two nodes where two roads meet. The smallest id remains.
pub(super) fn join_at_same_place(
    runs: &mut [Run],
    ways: &[Drivable<'_>],
    positions: &FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) {
    let mut alias: FxHashMap<i64, i64> = FxHashMap::default();
    for pair in runs.iter().flat_map(|run| run.nodes.windows(2)) {
        let (Some(a), Some(b)) = (positions.get(&pair[0]), positions.get(&pair[1])) else { continue };
        if (a - b).norm() < SAME_PLACE {
            unite(&mut alias, pair[0], pair[1]);
        }
    }
    for [a, b] in twins(runs, ways, positions) {
        if unite(&mut alias, a, b) {
            let message = format!("nodes {a} and {b} lie at one place, on ways of one level; the ways meet there");
            let note = Finding::new("node-twin", Subject::Node(a), message).graded(Severity::Info);
            notes.push(note.with(Subject::Node(b), "the other"));
        }
    }
    for run in runs {
        for id in &mut run.nodes {
            *id = root(&mut alias, *id);
        }
        run.nodes.dedup();
    }
}

/// The pairs of nodes with the same coordinates, of ways on the same level, ascending.
fn twins(runs: &[Run], ways: &[Drivable<'_>], positions: &FxHashMap<i64, Point>) -> Vec<[i64; 2]> {
    let mut places: Vec<(u64, u64, i64)> =
        positions.iter().map(|(id, point)| (point.x.to_bits(), point.y.to_bits(), *id)).collect();
    places.par_sort_unstable();
    let is_same = |a: &(u64, u64, i64), b: &(u64, u64, i64)| (a.0, a.1) == (b.0, b.1);
    let crowded: Vec<_> = places.chunk_by(is_same).filter(|nodes| nodes.len() > 1).collect();
    if crowded.is_empty() {
        return Vec::new();
    }
    let crowding: FxHashSet<i64> = crowded.iter().flat_map(|nodes| nodes.iter().map(|node| node.2)).collect();
    let mut levels: FxHashMap<i64, Vec<(u64, Option<&str>)>> = FxHashMap::default();
    for run in runs {
        let tags = &ways[run.way].way.tags;
        for id in run.nodes.iter().filter(|id| crowding.contains(id)) {
            // The storeys of a car park lie above each other and differ by `level` only.
            levels.entry(*id).or_default().push((level(tags).to_bits(), tags.get("level")));
        }
    }
    let levels_of = |id: i64| levels.get(&id).map_or(&[][..], Vec::as_slice);
    let share_level = |a: i64, b: i64| levels_of(a).iter().any(|level| levels_of(b).contains(level));
    let pairs = crowded.iter().flat_map(|nodes| {
        let pairs = nodes.iter().enumerate().flat_map(|(i, a)| nodes[i + 1..].iter().map(|b| [a.2, b.2]));
        pairs.filter(|[a, b]| share_level(*a, *b))
    });
    let mut pairs: Vec<[i64; 2]> = pairs.collect();
    pairs.sort_unstable();
    pairs
}

/// Whether two nodes that were not one became one.
fn unite(alias: &mut FxHashMap<i64, i64>, a: i64, b: i64) -> bool {
    let (a, b) = (root(alias, a), root(alias, b));
    if a != b {
        alias.insert(a.max(b), a.min(b));
    }
    a != b
}

/// The node that `id` was merged into: union-find with path halving.
fn root(alias: &mut FxHashMap<i64, i64>, mut id: i64) -> i64 {
    while let Some(&next) = alias.get(&id) {
        if let Some(&after) = alias.get(&next) {
            alias.insert(id, after);
        }
        id = next;
    }
    id
}
