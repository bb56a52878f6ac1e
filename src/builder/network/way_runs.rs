//! The parts of ways that the data holds: a way is cut at nodes that are missing or far away.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Point;

use super::access::Drivable;

/// Neighbouring nodes of a way farther apart than this, metres, have a wrong coordinate: even roads through deserts have nodes
/// closer than that. Sampling such a road every few metres would fill the memory.
const FARTHEST: f64 = 20_000.0;

/// A part of a way without missing nodes.
pub(super) struct Run {
    /// Index of the way in the list of drivable ways.
    pub way: usize,
    pub nodes: Vec<i64>,
    /// Whether the way goes on outside the extract before the first and after the last node.
    pub edge: [bool; 2],
}

/// The parts of a way between missing nodes.
pub(super) fn runs(
    index: usize,
    drivable: &Drivable<'_>,
    positions: &FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) -> Vec<Run> {
    let way = drivable.way;
    let missing = way.nodes.iter().filter(|id| !positions.contains_key(id)).count();
    if missing > 0 {
        let message = format!("way {} refers to {missing} nodes that are not in the data; it is cut there", way.id);
        notes.push(Finding::new("node-missing", Subject::Way(way.id), message).graded(Severity::Info));
    }
    let is_near = |a: &i64, b: &i64| match (positions.get(a), positions.get(b)) {
        (Some(a), Some(b)) => (b - a).norm() <= FARTHEST,
        _ => true,
    };
    let torn = way.nodes.windows(2).filter(|pair| !is_near(&pair[0], &pair[1])).count();
    if torn > 0 {
        let message =
            format!("way {} has neighbouring nodes more than {} km apart; it is cut there", way.id, FARTHEST / 1000.0);
        notes.push(Finding::new("node-far", Subject::Way(way.id), message).graded(Severity::Warning));
    }
    let mut runs = Vec::new();
    let mut first = 0;
    for known in way.nodes.split(|id| !positions.contains_key(id)) {
        for part in known.chunk_by(is_near) {
            let edge = [first > 0, first + part.len() < way.nodes.len()];
            runs.push(Run { way: index, nodes: part.to_vec(), edge });
            first += part.len();
        }
        // The missing node.
        first += 1;
    }
    // A single node beside the border of the extract has no geometry.
    runs.retain(|run| run.nodes.len() > 1 || missing + torn == 0);
    runs
}
