//! Cuts ways where they cross each other on one level without a common node: on the ground their traffic meets there, and nobody turns;
//! where roads of their kind do not meet, one of them passes above the other.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::ids::Key;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::spatial_hash::SpatialHash;
use crate::geometry::{Point, cross, segment_crossing};

use super::access::Drivable;
use super::assumed_bridges::{Bridges, WayCrossing, is_needed, stations};
use super::same_place::SAME_PLACE;
use super::way_pieces::WayPiece;
use super::{Intersection, Road, TurnRestriction};

/// A way with more crossings without a node than these ...
const MOST_CROSSINGS: usize = 12;
/// ... that are closer to each other than this (m) was drawn or converted wrongly: no streets cross so often.
const LEAST_BLOCK: f64 = 20.0;

/// Whether a way of some length (m) has so many crossings without a node that it is not cut there.
pub(super) fn too_many_crossings(count: usize, length: f64) -> bool {
    count > MOST_CROSSINGS && length < count as f64 * LEAST_BLOCK
}

/// Says that a way is not cut where it crosses others, or itself.
pub(super) fn left_uncut(way: i64, count: usize, what: &str) -> Finding {
    let message = format!(
        "way {way} crosses {what} {count} times without a common node, on a few metres each: too many for a road; it is not cut \
         there"
    );
    Finding::new("too-many-crossings", Subject::Way(way), message).graded(Severity::Warning)
}

/// A segment of a piece.
#[derive(Clone, Copy)]
struct Segment {
    piece: usize,
    /// Its first node, by its position in the piece.
    at: usize,
    ends: [Point; 2],
}

impl Segment {
    /// A place on the segment: the index of its piece, and the distance along that, metres.
    fn place_on(&self, pieces: &[WayPiece], positions: &FxHashMap<i64, Point>, place: Point) -> (usize, f64) {
        (self.piece, stations(&pieces[self.piece], positions)[self.at] + (place - self.ends[0]).norm())
    }
}

/// Where two segments cross.
struct Crossing {
    segments: [Segment; 2],
    place: Point,
    node: i64,
}

/// Cuts the pieces where they cross another way on the ground, and where assumed bridges end; `positions` receives the places. Gives the
/// new nodes where ways cross on the ground, too.
///
/// The data says neither that the ways are connected nor that one passes above the other. Most such places are crossings of small
/// streets that lack a node. Motorways and trunk roads cross nothing at grade: there a bridge lacks its tags.
pub(super) fn cut_at_crossings(
    pieces: Vec<WayPiece>,
    ways: &[Drivable<'_>],
    positions: &mut FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) -> (Vec<WayPiece>, Vec<i64>) {
    let mut found = crossings(&pieces, ways, positions);
    let id = |segment: &Segment| ways[pieces[segment.piece].way].way.id;
    found.sort_by_key(|crossing| (crossing.segments.map(|segment| id(&segment)), crossing.node));
    leave_out_crowded(&mut found, &pieces, ways, positions, notes);
    let places = |crossing: &Crossing| {
        let [a, b] = crossing.segments.map(|Segment { ends: [from, to], .. }| (to - from).normalize());
        let places = crossing.segments.map(|segment| segment.place_on(&pieces, positions, crossing.place));
        WayCrossing { places, sine: cross(a, b).abs() }
    };
    let everywhere: Vec<_> = found.iter().map(places).collect();
    let bridges = Bridges::find((&pieces, ways), positions, &everywhere, notes);
    let drivable = |segment: &Segment| &ways[pieces[segment.piece].way];
    found.retain(|crossing| {
        let both = crossing.segments.each_ref().map(drivable);
        !is_needed(both)
    });
    let mut cuts: FxHashMap<usize, Vec<(usize, f64, i64)>> = FxHashMap::default();
    for (piece, cut, place) in bridges.ends(positions) {
        positions.insert(cut.2, place);
        cuts.entry(piece).or_default().push(cut);
    }
    for Crossing { segments, place, node } in &found {
        positions.insert(*node, *place);
        for segment in segments {
            let along = (place - segment.ends[0]).norm();
            cuts.entry(segment.piece).or_default().push((segment.at, along, *node));
        }
        let [a, b] = segments.each_ref().map(id);
        let message = format!(
            "ways {a} and {b} cross without a common node, on one level: an intersection on which nobody turns unless \
             one of them ends there; join them, or tag the bridge"
        );
        let note = Finding::new("crossing-without-node", Subject::Way(a), message).graded(Severity::Info);
        notes.push(note.with(Subject::Way(b), "crossed"));
    }
    let levels = bridges.into_levels();
    let cut = |(i, piece): (usize, WayPiece)| {
        let Some(mut cuts) = cuts.remove(&i) else {
            let mut whole = vec![piece];
            levels.apply(i, &mut whole, positions);
            return whole;
        };
        cuts.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut parts = piece.cut_within(&cuts.into_iter().map(|(at, _, node)| (at, node)).collect::<Vec<_>>());
        levels.apply(i, &mut parts, positions);
        parts
    };
    let parts = pieces.into_iter().enumerate().flat_map(cut).collect();
    (parts, found.into_iter().map(|crossing| crossing.node).collect())
}

/// Leaves out the crossings of ways that have too many.
fn leave_out_crowded(
    found: &mut Vec<Crossing>,
    pieces: &[WayPiece],
    ways: &[Drivable<'_>],
    positions: &FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) {
    let of = |segment: &Segment| pieces[segment.piece].way;
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    found
        .iter()
        .flat_map(|crossing| &crossing.segments)
        .for_each(|segment| *counts.entry(of(segment)).or_default() += 1);
    counts.retain(|_, count| *count > MOST_CROSSINGS);
    if counts.is_empty() {
        return;
    }
    let mut lengths: FxHashMap<usize, f64> = FxHashMap::default();
    for piece in pieces.iter().filter(|piece| counts.contains_key(&piece.way)) {
        let length = stations(piece, positions).last().copied().unwrap_or_default();
        *lengths.entry(piece.way).or_default() += length;
    }
    counts.retain(|way, count| too_many_crossings(*count, lengths.get(way).copied().unwrap_or_default()));
    found.retain(|crossing| !crossing.segments.iter().any(|segment| counts.contains_key(&of(segment))));
    notes.extend(counts.into_iter().map(|(way, count)| left_uncut(ways[way].way.id, count, "others")));
}

/// Where pieces of different ways cross, on one level or not, away from their nodes.
fn crossings(pieces: &[WayPiece], ways: &[Drivable<'_>], positions: &FxHashMap<i64, Point>) -> Vec<Crossing> {
    let segments: Vec<Segment> = pieces
        .par_iter()
        .enumerate()
        .flat_map_iter(|(index, piece)| {
            let ends = piece.nodes.windows(2).map(|pair| [positions[&pair[0]], positions[&pair[1]]]);
            ends.enumerate().map(move |(at, ends)| Segment { piece: index, at, ends })
        })
        .collect();
    let length: f64 = segments.iter().map(|segment| (segment.ends[1] - segment.ends[0]).norm()).sum();
    let side = length / segments.len().max(1) as f64;
    let boxes = segments.iter().map(|Segment { ends: [a, b], .. }| [a.inf(b), a.sup(b)]).collect();
    let mut found = SpatialHash::new(boxes, side.max(1.0)).pairs(|i, j| {
        let mut both = [segments[i], segments[j]];
        let way = |segment: &Segment| &ways[pieces[segment.piece].way].way;
        both.sort_by_key(|segment| way(segment).id);
        let storeys = both.each_ref().map(|segment| way(segment).tags.get("level"));
        if way(&both[0]).id == way(&both[1]).id || storeys[0] != storeys[1] {
            return None;
        }
        let [[a, b], [c, d]] = both.map(|segment| segment.ends);
        let (_, _, place) = segment_crossing(a, b, c, d)?;
        let is_within = [a, b, c, d].iter().all(|end| (end - place).norm() > SAME_PLACE);
        let node = || {
            let key = both.iter().fold(Key::new("crossing ways"), |key, segment| {
                key.number(way(segment).id).number(pieces[segment.piece].nodes[segment.at])
            });
            key.new_node()
        };
        is_within.then(|| Crossing { segments: both, place, node: node() })
    });
    found.sort_unstable_by_key(|crossing| crossing.node);
    found.dedup_by_key(|crossing| crossing.node);
    found
}

/// The prohibitions of turns where two ways cross at these nodes, which are ascending. Where the end of a road reached less than a
/// car's length beyond the other one, three arms are left: that road ends there, and its traffic turns.
pub(super) fn prohibited_turns(intersections: &[Intersection], roads: &[Road], nodes: &[i64]) -> Vec<TurnRestriction> {
    let crossed = intersections
        .iter()
        .filter(|one| one.arms.len() == 4 && matches!(one.nodes[..], [node] if nodes.binary_search(&node).is_ok()));
    let turns = crossed.flat_map(|intersection| {
        let arms = || intersection.arms.iter().copied();
        arms().flat_map(move |from| arms().map(move |to| (from, to)))
    });
    let across = turns.filter(|(from, to)| roads[from.road].key.way != roads[to.road].key.way);
    across.map(|(from, to)| TurnRestriction { relation: 0, from, via: Vec::new(), to, only: false }).collect()
}
