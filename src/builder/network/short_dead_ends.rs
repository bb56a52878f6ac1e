//! Dead ends too short to drive into: what is left of them beside the road that they leave holds no car.

use rustc_hash::FxHashMap;

use crate::builder::tags::cross_section::SectionReading;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Polyline;

use super::access::Drivable;
use super::way_pieces::WayPiece;

/// Length of a small car, metres.
const CAR: f64 = 4.0;

/// Takes away the pieces that end within a car's length beside a road that they leave, with a note each. `centres` has
/// the lines of the pieces.
pub(super) fn without_short_dead_ends(
    pieces: Vec<(WayPiece, Polyline)>,
    drivable: &[Drivable<'_>],
    layouts: &FxHashMap<usize, SectionReading>,
    notes: &mut Vec<Finding>,
) -> Vec<(WayPiece, Polyline)> {
    let half_width = |piece: &WayPiece| layouts[&piece.way].section.width() / 2.0;
    let mut at_node: FxHashMap<i64, Vec<(usize, f64)>> = FxHashMap::default();
    for (i, (piece, _)) in pieces.iter().enumerate() {
        for node in piece.ends() {
            at_node.entry(node).or_default().push((i, half_width(piece)));
        }
    }
    // Metres beside the widest road at the one end, where the other is a dead end.
    let left = |i: usize| {
        let (piece, line) = &pieces[i];
        let [first, last] = piece.ends();
        let open = |side: usize| at_node[&piece.ends()[side]].len() == 1 && !piece.edge[side];
        let left_at = match [open(0), open(1)] {
            [true, false] => last,
            [false, true] => first,
            _ => return None,
        };
        let others = at_node[&left_at].iter().filter(|(other, _)| *other != i);
        // Of a road that but goes on it is the end, and where all are short they are what there is.
        let through = others.clone().filter(|(other, _)| pieces[*other].1.length() > line.length()).count() > 1;
        let widest = others.map(|(_, half)| *half).fold(0.0, f64::max);
        through.then(|| line.length() - widest).filter(|left| *left < CAR)
    };
    let stubs: Vec<Option<f64>> = (0..pieces.len()).map(left).collect();
    let kept = pieces.into_iter().zip(stubs).filter_map(|((piece, line), stub)| {
        let Some(left) = stub else { return Some((piece, line)) };
        let way = drivable[piece.way].way.id;
        let [a, b] = piece.ends();
        let message =
            format!("way {way} is not built between nodes {a} and {b}: of this dead end no car's length is left");
        let note = Finding::new("way-skipped", Subject::Way(way), message).measured(left.max(0.0), CAR, "m");
        notes.push(note.graded(Severity::Info));
        None
    });
    kept.collect()
}
