//! Cuts ways into pieces where they meet, end, touch themselves or leave the extract.

use std::collections::hash_map::Entry;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Point;

use super::access::Drivable;
use super::crowded_ground;
use super::same_place::join_at_same_place;
use super::way_runs::{Run, runs};

/// A piece of a way between two nodes that end it.
#[derive(Debug)]
pub(super) struct WayPiece {
    /// Index of the way in the list of drivable ways.
    pub way: usize,
    /// At least two; neighbours differ.
    pub nodes: Vec<i64>,
    /// Tells apart pieces of one way between the same two nodes.
    pub turn: u32,
    /// Whether the way goes on outside the extract before the first and after the last node.
    pub edge: [bool; 2],
    /// How many levels it lies above its way, on a bridge that is assumed, or below it in a tunnel.
    pub raised: i8,
}

impl WayPiece {
    /// Its first and its last node.
    pub fn ends(&self) -> [i64; 2] {
        [self.nodes[0], self.nodes[self.nodes.len() - 1]]
    }

    /// The parts of the piece between new nodes within its segments; `cuts` gives these in their order along it.
    pub fn cut_within(self, cuts: &[(usize, i64)]) -> Vec<Self> {
        let Self { way, edge, raised, .. } = self;
        let (mut parts, mut nodes) = (Vec::new(), Vec::new());
        let mut cuts = cuts.iter().peekable();
        for (segment, id) in self.nodes.into_iter().enumerate() {
            nodes.push(id);
            while let Some(&(_, new)) = cuts.next_if(|(within, _)| *within == segment) {
                nodes.push(new);
                let edge = [parts.is_empty() && edge[0], false];
                parts.push(Self { way, nodes: std::mem::replace(&mut nodes, vec![new]), turn: 0, edge, raised });
            }
        }
        parts.push(Self { way, nodes, turn: 0, edge: [parts.is_empty() && edge[0], edge[1]], raised });
        parts
    }
}

/// Cuts the ways where they meet and at the nodes `at`. `positions` holds every node that exists. Of pieces over the same nodes
/// only that of the highest class remains. They are not [numbered](number) yet.
pub(super) fn pieces(
    ways: &[Drivable<'_>],
    at: impl Iterator<Item = i64>,
    positions: &FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) -> Vec<WayPiece> {
    let runs: Vec<Run> = ways.iter().enumerate().flat_map(|(i, way)| runs(i, way, positions, notes)).collect();
    let mut runs = crowded_ground::thinned(runs, ways, positions, notes);
    join_at_same_place(&mut runs, ways, positions, notes);
    for run in runs.extract_if(.., |run| run.nodes.len() < 2) {
        let way = ways[run.way].way.id;
        let message = format!("way {way} has a part without length; it is passed over");
        notes.push(Finding::new("way-skipped", Subject::Way(way), message).graded(Severity::Info));
    }
    let mut ends = ends(&runs);
    ends.extend(at);
    let cut = runs.iter().flat_map(|run| cut(run, &ends)).collect();
    without_duplicates(cut, ways, notes)
}

/// The nodes at which pieces end: used twice, first or last of a run, or where a way turns back on itself.
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
            pieces.push(WayPiece { way: run.way, nodes: run.nodes[start..=i].to_vec(), turn: 0, edge, raised: 0 });
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
        let [a, b] = piece.ends();
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
pub(super) fn number(pieces: &mut [WayPiece], ways: &[Drivable<'_>]) {
    let ends = |piece: &WayPiece| (ways[piece.way].way.id, piece.ends());
    // A stable sort keeps the pieces of a way in their order along it.
    pieces.sort_by_key(ends);
    for i in 1..pieces.len() {
        if ends(&pieces[i]) == ends(&pieces[i - 1]) {
            pieces[i].turn = pieces[i - 1].turn + 1;
        }
    }
}
