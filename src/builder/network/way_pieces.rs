//! Ways cut into pieces where they meet, end, touch themselves or leave the extract.

use std::collections::hash_map::Entry;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Point;

use super::access::Drivable;

/// Nodes of one way closer together than this (metres) are one: below the resolution of OpenStreetMap's coordinates.
const SAME_PLACE: f64 = 0.015;

/// Neighbouring nodes of a way farther apart than this (metres) tell of a wrong coordinate, not of a road: even roads
/// through deserts have nodes closer than that. What is laid out metre by metre would else fill the memory.
const FARTHEST: f64 = 20_000.0;

/// A piece of a way between two nodes that end it.
#[derive(Debug)]
pub(super) struct WayPiece {
    /// Index of the way in the list of drivable ways.
    pub way: usize,
    /// At least two, no neighbours alike.
    pub nodes: Vec<i64>,
    /// Tells apart pieces of one way between the same two nodes.
    pub turn: u32,
    /// Whether the way goes on outside the extract, before the first and behind the last node.
    pub edge: [bool; 2],
}

impl WayPiece {
    /// Its first and its last node.
    pub fn ends(&self) -> [i64; 2] {
        [self.nodes[0], self.nodes[self.nodes.len() - 1]]
    }
}

/// The part of a way whose nodes are all there.
struct Run {
    way: usize,
    nodes: Vec<i64>,
    edge: [bool; 2],
}

/// Cuts the ways. `positions` holds every node that exists. Of pieces over the same nodes only the one of the
/// highest class remains.
pub(super) fn pieces(
    ways: &[Drivable<'_>],
    positions: &FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) -> Vec<WayPiece> {
    let mut runs: Vec<Run> = ways.iter().enumerate().flat_map(|(i, way)| runs(i, way, positions, notes)).collect();
    merge_coincident(&mut runs, positions);
    runs.retain(|run| {
        let long = run.nodes.len() >= 2;
        if !long {
            let way = ways[run.way].way.id;
            let message = format!("way {way} has a part without length; it is passed over");
            notes.push(Finding::new("way-skipped", Subject::Way(way), message).graded(Severity::Info));
        }
        long
    });
    let ends = ends(&runs);
    let cut = runs.iter().flat_map(|run| cut(run, &ends)).collect();
    let mut pieces = without_duplicates(cut, ways, notes);
    number(&mut pieces, ways);
    pieces
}

/// The stretches of a way between missing nodes.
fn runs(
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
    let mut at = 0;
    for stretch in way.nodes.split(|id| !positions.contains_key(id)) {
        for part in stretch.chunk_by(is_near) {
            let (first, behind) = (at, at + part.len());
            at = behind;
            let edge = [first > 0, behind < way.nodes.len()];
            runs.push(Run { way: index, nodes: part.to_vec(), edge });
        }
        // The missing node between two stretches.
        at += 1;
    }
    // A single node left of a way that goes on outside holds no geometry.
    runs.retain(|run| run.nodes.len() > 1 || missing + torn == 0);
    runs
}

/// Makes one node of neighbours that lie at one place, in every run, and drops repetitions.
fn merge_coincident(runs: &mut [Run], positions: &FxHashMap<i64, Point>) {
    let mut alias: FxHashMap<i64, i64> = FxHashMap::default();
    for pair in runs.iter().flat_map(|run| run.nodes.windows(2)) {
        let (Some(a), Some(b)) = (positions.get(&pair[0]), positions.get(&pair[1])) else { continue };
        if (a - b).norm() < SAME_PLACE {
            let (a, b) = (root(&mut alias, pair[0]), root(&mut alias, pair[1]));
            if a != b {
                alias.insert(a.max(b), a.min(b));
            }
        }
    }
    for run in runs {
        for id in &mut run.nodes {
            *id = root(&mut alias, *id);
        }
        run.nodes.dedup();
    }
}

/// The node that stands for `id`; shortens the way there for the next time.
fn root(alias: &mut FxHashMap<i64, i64>, mut id: i64) -> i64 {
    while let Some(&next) = alias.get(&id) {
        if let Some(&behind) = alias.get(&next) {
            alias.insert(id, behind);
        }
        id = next;
    }
    id
}

/// The nodes that end a piece: used twice, first or last of a run, or the tip where a way turns back on itself.
fn ends(runs: &[Run]) -> FxHashSet<i64> {
    let mut seen: FxHashSet<i64> = FxHashSet::default();
    let mut ends: FxHashSet<i64> = FxHashSet::default();
    for run in runs {
        ends.extend([run.nodes[0], run.nodes[run.nodes.len() - 1]]);
        ends.extend(run.nodes.windows(3).filter(|w| w[0] == w[2]).map(|w| w[1]));
        ends.extend(run.nodes.iter().filter(|id| !seen.insert(**id)));
    }
    ends
}

fn cut(run: &Run, ends: &FxHashSet<i64>) -> Vec<WayPiece> {
    let mut pieces = Vec::new();
    let last = run.nodes.len() - 1;
    let mut start = 0;
    for (i, id) in run.nodes.iter().enumerate().skip(1) {
        if i == last || ends.contains(id) {
            let edge = [start == 0 && run.edge[0], i == last && run.edge[1]];
            pieces.push(WayPiece { way: run.way, nodes: run.nodes[start..=i].to_vec(), turn: 0, edge });
            start = i;
        }
    }
    pieces
}

/// Keeps one of the pieces that run over the same nodes, in whichever direction.
fn without_duplicates(mut pieces: Vec<WayPiece>, ways: &[Drivable<'_>], notes: &mut Vec<Finding>) -> Vec<WayPiece> {
    let rank = |piece: &WayPiece| (ways[piece.way].link, ways[piece.way].class, ways[piece.way].way.id);
    pieces.sort_by_key(rank);
    let mut kept: FxHashMap<Vec<i64>, i64> = FxHashMap::default();
    pieces.retain(|piece| {
        let way = ways[piece.way].way.id;
        let (a, b) = (piece.nodes[0], piece.nodes[piece.nodes.len() - 1]);
        let mut nodes = piece.nodes.clone();
        if b < a || (a == b && nodes[nodes.len() - 2] < nodes[1]) {
            nodes.reverse();
        }
        let first = match kept.entry(nodes) {
            Entry::Vacant(entry) => {
                entry.insert(way);
                return true;
            }
            Entry::Occupied(entry) => *entry.get(),
        };
        let message = format!("way {way} repeats way {first} between nodes {a} and {b}; one of them is kept");
        let note = Finding::new("way-duplicate", Subject::Way(way), message).graded(Severity::Warning);
        notes.push(note.with(Subject::Way(first), "kept"));
        false
    });
    pieces
}

/// Sorts by way and ends, and numbers the pieces of one way between the same two nodes in their order along it.
fn number(pieces: &mut [WayPiece], ways: &[Drivable<'_>]) {
    let ends = |p: &WayPiece| (ways[p.way].way.id, p.nodes[0], p.nodes[p.nodes.len() - 1]);
    // Stable: pieces of one way still stand in their order along it.
    pieces.sort_by_key(ends);
    for i in 1..pieces.len() {
        if ends(&pieces[i]) == ends(&pieces[i - 1]) {
            pieces[i].turn = pieces[i - 1].turn + 1;
        }
    }
}
