//! Bridges that the data lacks: ways cross on one level without a common node, though roads of their kind do not meet.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use crate::builder::ids::Key;
use crate::builder::tags::road_class::RoadClass;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Point;

use super::access::Drivable;
use super::frame::level;
use super::way_pieces::WayPiece;

/// A bridge reaches this far from the middle of the road below, metres along its way: over a motorway with its shoulders.
const HALF_BRIDGE: f64 = 30.0;
/// Between a bridge and the end of a piece there is at least this, metres; else the bridge reaches to the end.
const LEAST: f64 = 10.0;
/// A bridge does not end nearer than this to a node, metres.
const BRIDGE_FROM_NODE: f64 = 1.0;
/// Places along a segment are told apart by a tenth of a metre.
const UNITS_PER_METRE: f64 = 10.0;
/// Ways that cross at an angle with a smaller sine than this, 30 degrees, rather lead beside each other, as a ramp does that is drawn
/// across the edge of its motorway.
const LEAST_SINE: f64 = 0.5;

/// Whether two ways that cross without a common node cannot meet: motorways and trunk roads have no crossings at grade,
/// and what crosses above or below the ground crosses in the air.
pub(super) fn is_needed(ways: [&Drivable<'_>; 2]) -> bool {
    !ways.iter().all(|way| way.class > RoadClass::Trunk && level(&way.way.tags) == 0.0)
}

/// Which of two ways passes above the other: one on a bridge, not one in a tunnel, else the smaller road; of equal ones always those
/// of one name.
fn upper(ways: [&Drivable<'_>; 2]) -> usize {
    let rank = |one: &Drivable<'_>| {
        let tags = &one.way.tags;
        let is_tagged = |key: &str| tags.get(key).is_some_and(|value| value != "no");
        let name = tags.get("name").or_else(|| tags.get("ref")).unwrap_or_default().to_owned();
        (is_tagged("bridge"), !is_tagged("tunnel"), one.class, one.link, name, one.way.id)
    };
    let [first, second] = ways.map(rank);
    usize::from(second > first)
}

/// The note that way `upper` is assumed to pass above way `lower`; `moved` is the one on the bridge or in the tunnel.
fn note([upper, lower]: [i64; 2], moved: i64) -> Finding {
    let by = if moved == upper { "on a bridge" } else { "in a tunnel" };
    let message = format!(
        "ways {upper} and {lower} cross without a common node, on one level, where roads of their kind do not meet: way {moved} is \
         assumed to lie {by}; tag it"
    );
    let note = Finding::new("bridge-assumed", Subject::Way(moved), message).graded(Severity::Info);
    note.with(Subject::Way(if moved == upper { lower } else { upper }), "crossed")
}

/// A place on a piece: its index, and the distance along it, metres.
pub(super) type PlaceOn = (usize, f64);

/// Where two pieces cross.
pub(super) struct WayCrossing {
    /// On either of them.
    pub places: [PlaceOn; 2],
    /// The sine of the angle between them.
    pub sine: f64,
}

/// A part of a piece on an assumed bridge, or in an assumed tunnel.
#[derive(Clone, Copy, Debug)]
struct Span {
    /// From where to where, metres along the piece.
    ends: [f64; 2],
    /// Levels above its way.
    by: i8,
}

impl Span {
    fn has(&self, station: f64) -> bool {
        (self.ends[0]..=self.ends[1]).contains(&station)
    }
}

/// The parts of pieces that lie on assumed bridges and in assumed tunnels.
pub(super) struct Bridges<'a> {
    pieces: &'a [WayPiece],
    ways: &'a [Drivable<'a>],
    of_piece: BTreeMap<usize, Vec<Span>>,
}

impl<'a> Bridges<'a> {
    /// Separates the ways at those of these crossings where they cannot meet and have one level, in order, with a note for each. A bridge
    /// or tunnel is not assumed where it would meet another way on its own level.
    pub(super) fn find(
        (pieces, ways): (&'a [WayPiece], &'a [Drivable<'a>]),
        positions: &FxHashMap<i64, Point>,
        crossings: &[WayCrossing],
        notes: &mut Vec<Finding>,
    ) -> Self {
        let mut found = Self { pieces, ways, of_piece: BTreeMap::new() };
        let mut of_piece: FxHashMap<usize, Vec<(f64, PlaceOn)>> = FxHashMap::default();
        for &WayCrossing { places: [a, b], .. } in crossings {
            of_piece.entry(a.0).or_default().push((a.1, b));
            of_piece.entry(b.0).or_default().push((b.1, a));
        }
        for WayCrossing { places: both, .. } in crossings.iter().filter(|crossing| crossing.sine >= LEAST_SINE) {
            let drivable = both.map(|(piece, _)| &ways[pieces[piece].way]);
            let [one, other] = both.map(|place| found.level_at(place));
            if one != other || !is_needed(drivable) {
                continue;
            }
            let above = upper(drivable);
            let ids = [above, 1 - above].map(|i| drivable[i].way.id);
            let ways_out = [(both[above], 1, ids[0]), (both[1 - above], -1, ids[1])];
            for (place, by, moved) in ways_out {
                let span = Span { ends: span_around(&pieces[place.0], positions, place.1), by };
                if found.is_free(place.0, span, &of_piece[&place.0]) {
                    found.of_piece.entry(place.0).or_default().push(span);
                    notes.push(note(ids, moved));
                    break;
                }
            }
        }
        found.of_piece.values_mut().for_each(merge);
        found
    }

    fn way(&self, piece: usize) -> &Drivable<'a> {
        &self.ways[self.pieces[piece].way]
    }

    fn level_at(&self, (piece, station): PlaceOn) -> f64 {
        let spans = self.of_piece.get(&piece).into_iter().flatten();
        let by = spans.filter(|span| span.has(station)).map(|span| span.by).next().unwrap_or(0);
        level(&self.way(piece).way.tags) + f64::from(by)
    }

    /// Whether a piece meets no other way on its new level, and no way on the ground that it meets now.
    fn is_free(&self, piece: usize, span: Span, crossed: &[(f64, PlaceOn)]) -> bool {
        let new = level(&self.way(piece).way.tags) + f64::from(span.by);
        let overlaps = |other: &Span| other.ends[0] < span.ends[1] + LEAST && span.ends[0] < other.ends[1] + LEAST;
        let mut others = self.of_piece.get(&piece).into_iter().flatten();
        let is_clear = |(_, other): &(f64, PlaceOn)| {
            self.level_at(*other) != new && is_needed([self.way(piece), self.way(other.0)])
        };
        let mut within = crossed.iter().filter(|(station, _)| span.has(*station));
        others.all(|other| other.by == span.by || !overlaps(other)) && within.all(is_clear)
    }

    /// The ends of bridges and tunnels within pieces: the index of the piece, the number of the segment, the distance along it, metres,
    /// and the node there with its place.
    pub(super) fn ends(&self, positions: &FxHashMap<i64, Point>) -> Vec<(usize, (usize, f64, i64), Point)> {
        let mut ends = Vec::new();
        for (&index, spans) in &self.of_piece {
            let piece = &self.pieces[index];
            let stations = stations(piece, positions);
            let length = stations.last().copied().unwrap_or_default();
            let within = spans.iter().flat_map(|span| span.ends).filter(|end| *end > 0.0 && *end < length);
            for end in within {
                let segment = stations.partition_point(|station| *station <= end) - 1;
                let along = end - stations[segment];
                let [a, b] = [0, 1].map(|i| positions[&piece.nodes[segment + i]]);
                // The same in every tile that has the segment, wherever the tile cuts the way.
                let key = Key::new("assumed bridge").number(self.way(index).way.id).number(piece.nodes[segment]);
                let node = key.number((along * UNITS_PER_METRE).round() as i64).new_node();
                ends.push((index, (segment, along, node), a + (b - a).normalize() * along));
            }
        }
        ends
    }

    /// What they raise and lower.
    pub(super) fn into_levels(self) -> AssumedLevels {
        AssumedLevels { of_piece: self.of_piece }
    }
}

/// The parts of pieces that lie above or below their ways.
pub(super) struct AssumedLevels {
    of_piece: BTreeMap<usize, Vec<Span>>,
}

impl AssumedLevels {
    /// Raises or lowers those of the parts of a piece that lie on its bridges and in its tunnels.
    pub(super) fn apply(&self, piece: usize, parts: &mut [WayPiece], positions: &FxHashMap<i64, Point>) {
        let Some(spans) = self.of_piece.get(&piece) else { return };
        let mut from = 0.0;
        for part in parts {
            let length = stations(part, positions).last().copied().unwrap_or_default();
            let middle = from + length / 2.0;
            part.raised = spans.iter().find(|span| span.has(middle)).map_or(0, |span| span.by);
            from += length;
        }
    }
}

/// The part of a piece that a bridge over this place takes.
fn span_around(piece: &WayPiece, positions: &FxHashMap<i64, Point>, station: f64) -> [f64; 2] {
    let stations = stations(piece, positions);
    let length = stations.last().copied().unwrap_or_default();
    let [from, to] = [station - HALF_BRIDGE, station + HALF_BRIDGE].map(|end| clear_of(&stations, end));
    [if from < LEAST { 0.0 } else { from }, if to > length - LEAST { length } else { to }]
}

/// Sorts spans, and makes one of those that touch.
fn merge(spans: &mut Vec<Span>) {
    spans.sort_by(|a, b| a.ends[0].total_cmp(&b.ends[0]));
    spans.dedup_by(|next, last| {
        let touches = next.by == last.by && next.ends[0] < last.ends[1] + LEAST;
        if touches {
            last.ends[1] = last.ends[1].max(next.ends[1]);
        }
        touches
    });
}

/// The distances of a piece's nodes along it, metres.
pub(super) fn stations(piece: &WayPiece, positions: &FxHashMap<i64, Point>) -> Vec<f64> {
    let places = piece.nodes.windows(2).map(|pair| (positions[&pair[1]] - positions[&pair[0]]).norm());
    let mut sum = 0.0;
    let behind = places.map(|length| {
        sum += length;
        sum
    });
    std::iter::once(0.0).chain(behind.collect::<Vec<f64>>()).collect()
}

/// The nearest place to this one that is not close to a node, metres.
fn clear_of(stations: &[f64], end: f64) -> f64 {
    let near = stations.iter().find(|station| (end - **station).abs() < BRIDGE_FROM_NODE);
    near.map_or(end, |station| station + BRIDGE_FROM_NODE)
}
