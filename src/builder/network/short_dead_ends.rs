//! Removes dead ends too short to drive into: beyond the road that they branch from they have no room for a car.

use rustc_hash::FxHashMap;

use crate::builder::tags::cross_section::SectionReading;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Polyline;

use super::access::Drivable;
use super::way_pieces::WayPiece;

/// Length of a small car, metres.
pub(super) const CAR: f64 = 4.0;

/// The pieces with their lines, without dead ends that reach less than a car's length beyond the road that they branch from;
/// with a note for each.
pub(super) fn without_short_dead_ends(
    pieces: Vec<(WayPiece, Polyline)>,
    drivable: &[Drivable<'_>],
    layouts: &FxHashMap<usize, SectionReading>,
    notes: &mut Vec<Finding>,
) -> Vec<(WayPiece, Polyline)> {
    let mut at_node: FxHashMap<i64, Vec<(usize, f64)>> = FxHashMap::default();
    for (i, (piece, _)) in pieces.iter().enumerate() {
        for node in piece.ends() {
            at_node.entry(node).or_default().push((i, layouts[&piece.way].section.width() / 2.0));
        }
    }
    let stubs: Vec<Option<f64>> =
        (0..pieces.len()).map(|i| room_beyond(i, &pieces, &at_node).filter(|room| *room < CAR)).collect();
    let kept = pieces.into_iter().zip(stubs).filter_map(|((piece, line), stub)| {
        let Some(room) = stub else { return Some((piece, line)) };
        let way = drivable[piece.way].way.id;
        let [a, b] = piece.ends();
        let message =
            format!("way {way} is not built between nodes {a} and {b}: of this dead end no car's length is left");
        let note = Finding::new("way-skipped", Subject::Way(way), message).measured(room.max(0.0), CAR, "m");
        notes.push(note.graded(Severity::Info));
        None
    });
    kept.collect()
}

/// Length of a dead end, metres, beyond the edge of the widest road that it branches from; `None` for other pieces. `at_node`
/// holds the pieces at each node with half their widths.
fn room_beyond(
    index: usize,
    pieces: &[(WayPiece, Polyline)],
    at_node: &FxHashMap<i64, Vec<(usize, f64)>>,
) -> Option<f64> {
    let (piece, line) = &pieces[index];
    let [first, last] = piece.ends();
    let is_open = |node: i64, edge: bool| at_node[&node].len() == 1 && !edge;
    let branch = match [is_open(first, piece.edge[0]), is_open(last, piece.edge[1])] {
        [true, false] => last,
        [false, true] => first,
        _ => return None,
    };
    let others = at_node[&branch].iter().filter(|(other, _)| *other != index);
    // With fewer than two longer roads it is the end of a road, or all roads are short.
    let branches = others.clone().filter(|(other, _)| pieces[*other].1.length() > line.length()).count() > 1;
    let widest = others.map(|(_, half)| *half).fold(0.0, f64::max);
    branches.then(|| line.length() - widest)
}
