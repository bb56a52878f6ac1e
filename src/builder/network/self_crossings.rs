//! Cuts ways where they cross themselves without a node: a road that crosses itself on one level meets itself there.

use rustc_hash::FxHashMap;

use crate::builder::ids::Key;
use crate::diagnostic::Finding;
use crate::geometry::spatial_hash::SpatialHash;
use crate::geometry::{Point, angle_between, segment_crossing};

use super::access::Drivable;
use super::crossing_ways::{left_uncut, too_many_crossings};
use super::same_place::SAME_PLACE;
use super::way_pieces::WayPiece;

/// A shorter loop, metres, is a slip of the mapper, not a road: cars do not drive around it.
const LEAST_LOOP: f64 = 20.0;

/// Cuts the pieces where they cross themselves; `positions` receives the places.
pub(super) fn cut_at_self_crossings(
    pieces: Vec<WayPiece>,
    ways: &[Drivable<'_>],
    positions: &mut FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) -> Vec<WayPiece> {
    let cut = |piece: WayPiece| {
        let places: Vec<Point> = piece.nodes.iter().map(|id| positions[id]).collect();
        let crossings = if turns_round(&places) { self_crossings(&places) } else { Vec::new() };
        if crossings.is_empty() {
            return vec![piece];
        }
        let length = places.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        if too_many_crossings(crossings.len(), length) {
            notes.push(left_uncut(ways[piece.way].way.id, crossings.len(), "itself"));
            return vec![piece];
        }
        let mut cuts: Vec<(usize, f64, i64)> = Vec::new();
        for crossing in crossings {
            let [i, j] = crossing.segments;
            let key = Key::new("self crossing").number(ways[piece.way].way.id);
            let node = key.number(piece.nodes[i]).number(piece.nodes[j]).new_node();
            positions.insert(node, crossing.place);
            cuts.extend([i, j].map(|segment| (segment, (crossing.place - places[segment]).norm(), node)));
        }
        cuts.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let cuts: Vec<(usize, i64)> = cuts.into_iter().map(|(segment, _, node)| (segment, node)).collect();
        piece.cut_within(&cuts)
    };
    pieces.into_iter().flat_map(cut).collect()
}

/// Whether a line turns by half a circle at least; no other can cross itself.
fn turns_round(places: &[Point]) -> bool {
    let turn = |w: &[Point]| angle_between(w[1] - w[0], w[2] - w[1]).abs();
    places.windows(3).map(turn).sum::<f64>() > std::f64::consts::PI
}

/// Where two segments of a line cross.
struct SelfCrossing {
    /// The lower index first.
    segments: [usize; 2],
    place: Point,
}

/// Where a line crosses itself and closes a loop that can be driven.
fn self_crossings(places: &[Point]) -> Vec<SelfCrossing> {
    let steps: Vec<f64> = places.windows(2).map(|w| (w[1] - w[0]).norm()).collect();
    let stations: Vec<f64> = steps.iter().scan(0.0, |sum, step| Some(std::mem::replace(sum, *sum + step))).collect();
    let boxes = places.windows(2).map(|w| [w[0].inf(&w[1]), w[0].sup(&w[1])]).collect();
    let side = steps.iter().sum::<f64>() / steps.len() as f64;
    let mut found = SpatialHash::new(boxes, side.max(1.0)).pairs(|i, j| {
        let ends = [places[i], places[i + 1], places[j], places[j + 1]];
        let (_, _, place) = segment_crossing(ends[0], ends[1], ends[2], ends[3])?;
        let is_within = ends.iter().all(|end| (end - place).norm() > SAME_PLACE);
        let loop_length = stations[j] + (place - places[j]).norm() - stations[i] - (place - places[i]).norm();
        (is_within && loop_length >= LEAST_LOOP).then_some(SelfCrossing { segments: [i, j], place })
    });
    found.sort_unstable_by_key(|crossing| crossing.segments);
    found.dedup_by_key(|crossing| crossing.segments);
    found
}
