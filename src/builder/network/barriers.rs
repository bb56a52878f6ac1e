//! Ends roads at nodes that cars cannot pass: a barrier such as a bollard, or access tags that close the node.
//!
//! The road ends on both sides of the node. Where buses may pass, or cars in one direction, a piece of road for them joins the two ends.

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::ids::Key;
use crate::builder::tags::admission::{Admitted, admission};
use crate::builder::tags::cross_section::Travel;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Point;
use crate::osm::{OsmData, Tags};

use super::End;
use super::access::{Access, Drivable};
use super::passage::{Passage, passage};
use super::short_dead_ends::CAR;
use super::way_pieces::WayPiece;

/// How far before the node a road ends, metres: with the last metres of a dead end this leaves a gap that nobody takes for a
/// missing piece of a lane.
const SETBACK: f64 = 1.5;

/// The same where roads meet at an angle, so that their ends lie apart.
const SETBACK_AT_ANGLE: f64 = 5.0;

/// Roads whose directions differ by less than this cosine from opposite ones meet without an angle: 30 degrees.
const OPPOSITE: f64 = -0.866;

/// How far the piece of those who pass reaches on either side of the node, metres, and most as a share of the road there.
const PIECE_PAST: (f64, f64) = (8.0, 0.4);

/// Keys of a node whose values a note tells.
const TELLING: [&str; 10] =
    ["barrier", "bollard", "kerb", "locked", "motorcar", "motor_vehicle", "vehicle", "access", "bus", "psv"];

/// The nodes of drivable ways that not every car passes.
pub(super) struct Barriers<'a> {
    nodes: FxHashMap<i64, (Passage, &'a Tags)>,
    /// How many ways there are without those of the pieces past barriers.
    ways: usize,
    /// For ways with a node that not all pass, by index: the index of the same way as a road of those who do.
    ways_past: FxHashMap<(usize, Passage), usize>,
}

/// The end of a piece at a barrier.
#[derive(Clone, Copy)]
struct PieceEnd {
    piece: usize,
    end: End,
}

impl<'a> Barriers<'a> {
    /// Reads the tags of `ids`, the nodes of drivable ways in ascending order; adds the ways of pieces past them to
    /// `drivable`.
    pub fn read(osm: &'a OsmData, ids: &[i64], drivable: &mut Vec<Drivable<'_>>) -> Self {
        let tagged = osm.nodes.iter().filter(|node| !node.tags.is_empty() && ids.binary_search(&node.id).is_ok());
        let nodes: FxHashMap<i64, (Passage, &Tags)> =
            tagged.filter_map(|node| Some((node.id, (passage(&node.tags)?, &node.tags)))).collect();
        let ways = drivable.len();
        let mut ways_past = FxHashMap::default();
        for way in 0..ways {
            let passages = drivable[way].way.nodes.iter().filter_map(|id| nodes.get(id)).map(|(passage, _)| *passage);
            let passages: Vec<Passage> = passages.filter(|passage| passage.is_of_some()).collect();
            for passage in passages {
                ways_past.entry((way, passage)).or_insert_with(|| {
                    drivable.push(match passage {
                        Passage::OneWay(only) => Drivable { only: Some(only), ..drivable[way] },
                        _ => Drivable { access: Access::Bus, ..drivable[way] },
                    });
                    drivable.len() - 1
                });
            }
        }
        Self { nodes, ways, ways_past }
    }

    /// How many ways there are without those of pieces past barriers that were added.
    pub fn ways(&self) -> usize {
        self.ways
    }

    /// The nodes at which pieces are to end.
    pub fn nodes(&self) -> impl Iterator<Item = i64> {
        self.nodes.iter().filter(|(_, (passage, _))| *passage != Passage::Gate).map(|(id, _)| *id)
    }

    /// The nodes of gates to private ground.
    pub fn private_gates(&self) -> FxHashSet<i64> {
        self.nodes.iter().filter(|(_, (passage, _))| *passage == Passage::Private).map(|(id, _)| *id).collect()
    }

    /// Parts the pieces that meet at a closed node; `positions` receives the places where they end. Notes what stands at the
    /// nodes.
    pub fn part(
        &self,
        mut pieces: Vec<WayPiece>,
        ways: &[Drivable<'_>],
        positions: &mut FxHashMap<i64, Point>,
        notes: &mut Vec<Finding>,
    ) -> Vec<WayPiece> {
        let mut at_barriers: BTreeMap<i64, Vec<PieceEnd>> = BTreeMap::new();
        for (i, piece) in pieces.iter().enumerate() {
            for end in End::BOTH.into_iter().filter(|end| !piece.edge[*end]) {
                let node = piece.ends()[end];
                if self.nodes.get(&node).is_some_and(|(passage, _)| !passage.is_gate()) {
                    at_barriers.entry(node).or_default().push(PieceEnd { piece: i, end });
                }
            }
        }
        notes.extend(self.gates(&pieces));
        let mut lost = vec![false; pieces.len()];
        at_barriers.retain(|_, ends| ends.len() > 1);
        for (node, ends) in at_barriers {
            let (mut passage, tags) = self.nodes[&node];
            if let Passage::OneWay(only) = passage {
                if ends.len() != 2 {
                    notes.push(not_built(node, tags));
                    continue;
                }
                if !is_open(&ways[pieces[ends[0].piece].way], only) {
                    passage = Passage::Nobody;
                }
            }
            notes.push(note(node, passage, tags));
            let goes_on = passage.is_of_some() && ends.len() == 2;
            let setback = setback(&ends, &pieces, positions);
            let mut beyond = Vec::new();
            for PieceEnd { piece, end } in &ends {
                let piece = &mut pieces[*piece];
                let setback =
                    if goes_on { PIECE_PAST.0.min(PIECE_PAST.1 * length(&piece.nodes, positions)) } else { setback };
                let key = Key::new("barrier").number(node).number(ways[piece.way].way.id);
                beyond.push(shorten(piece, *end, setback, key, positions));
            }
            for (PieceEnd { piece, .. }, beyond) in ends.iter().zip(&beyond) {
                lost[*piece] |= beyond.is_none();
            }
            if let (true, [Some(before), Some(after)]) = (goes_on, &beyond[..]) {
                pieces.push(self.piece_past(passage, &pieces[ends[0].piece], ends[0].end, before, after));
                lost.push(false);
            }
        }
        notes.extend(pieces.iter().zip(&lost).filter(|(_, lost)| **lost).map(|(piece, _)| left_out(piece, ways)));
        let mut lost = lost.into_iter();
        pieces.retain(|_| lost.next() != Some(true));
        pieces
    }

    /// A note for each gate on these pieces.
    fn gates(&self, pieces: &[WayPiece]) -> Vec<Finding> {
        let gate = |id: &i64| self.nodes.get(id).filter(|(passage, _)| passage.is_gate()).map(|gate| (*id, gate));
        let gates: BTreeMap<i64, _> = pieces.iter().flat_map(|piece| &piece.nodes).filter_map(gate).collect();
        gates.into_iter().map(|(node, (passage, tags))| note(node, *passage, tags)).collect()
    }

    /// The piece of road of those who pass a barrier, in the direction of the way of the first of the two pieces that it joins.
    /// `before` and `after` lead from their ends to the barrier.
    fn piece_past(&self, passage: Passage, first: &WayPiece, end: End, before: &[i64], after: &[i64]) -> WayPiece {
        let mut nodes: Vec<i64> = before.iter().chain(after.iter().rev().skip(1)).copied().collect();
        if end == End::Start {
            nodes.reverse();
        }
        WayPiece { way: self.ways_past[&(first.way, passage)], nodes, turn: 0, edge: [false; 2], raised: first.raised }
    }
}

/// How far before their common node roads are to end, metres.
fn setback(ends: &[PieceEnd], pieces: &[WayPiece], positions: &FxHashMap<i64, Point>) -> f64 {
    let outward = |at: &PieceEnd| {
        let nodes = &pieces[at.piece].nodes;
        let (node, next) = match at.end {
            End::Start => (nodes[0], nodes[1]),
            End::End => (nodes[nodes.len() - 1], nodes[nodes.len() - 2]),
        };
        (positions[&next] - positions[&node]).normalize()
    };
    match ends {
        [a, b] if outward(a).dot(&outward(b)) < OPPOSITE => SETBACK,
        _ => SETBACK_AT_ANGLE,
    }
}

/// Ends the piece earlier by a number of metres, at a new node. Returns the nodes from there to the old end, or `None` if less
/// than the length of a car would be left.
fn shorten(
    piece: &mut WayPiece,
    end: End,
    setback: f64,
    key: Key,
    positions: &mut FxHashMap<i64, Point>,
) -> Option<Vec<i64>> {
    if length(&piece.nodes, positions) < setback + CAR {
        return None;
    }
    if end == End::Start {
        piece.nodes.reverse();
    }
    let mut beyond = Vec::new();
    let mut left = setback;
    while let [.., previous, last] = piece.nodes[..] {
        let (from, to) = (positions[&last], positions[&previous]);
        let step = (to - from).norm();
        beyond.push(last);
        piece.nodes.pop();
        if step > left {
            let new = key.number(previous).number(last).new_node();
            positions.insert(new, from + (to - from) * (left / step));
            piece.nodes.push(new);
            beyond.push(new);
            break;
        }
        left -= step;
    }
    if end == End::Start {
        piece.nodes.reverse();
    }
    beyond.reverse();
    Some(beyond)
}

/// Length of the line through the nodes, metres.
fn length(nodes: &[i64], positions: &FxHashMap<i64, Point>) -> f64 {
    nodes.windows(2).map(|pair| (positions[&pair[1]] - positions[&pair[0]]).norm()).sum()
}

/// The tags of a node that tell who passes it.
fn telling(tags: &Tags) -> String {
    let stem = |key: &str| key.split(':').next().is_some_and(|stem| TELLING.contains(&stem));
    let told = tags.iter().filter(|(key, _)| stem(key));
    told.map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(", ")
}

/// A node at which more than two pieces of road meet, so that its tags do not tell on which of them a direction is closed.
fn not_built(node: i64, tags: &Tags) -> Finding {
    let message = format!(
        "node {node} closes a direction ({}), but roads meet there, so it does not tell of which; it is passed over, and belongs on a \
         node of one way",
        telling(tags)
    );
    Finding::new("road-closed", Subject::Node(node), message).graded(Severity::Info)
}

/// Whether a way is open to cars in this direction.
fn is_open(way: &Drivable<'_>, travel: Travel) -> bool {
    let admitted = admission(&way.way.tags, way.class, way.link);
    let toward = if travel == Travel::Backward { admitted.backward } else { admitted.forward };
    toward > Admitted::Buses
}

/// What stands at a node where roads are parted, or a gate that the map leads through.
fn note(node: i64, passage: Passage, tags: &Tags) -> Finding {
    let told = telling(tags);
    let (fault, message) = match passage {
        Passage::Nobody => {
            ("road-closed", format!("node {node} is closed to cars ({told}); the roads end on both sides"))
        }
        Passage::Buses => {
            ("road-closed", format!("only buses pass node {node} ({told}); for cars the roads end there"))
        }
        Passage::OneWay(only) => {
            let along = if only == Travel::Forward { "along" } else { "against" };
            (
                "road-closed",
                format!("cars pass node {node} only {along} its way ({told}); lanes in the other direction end there"),
            )
        }
        Passage::Private => {
            ("gate", format!("the map leads through the gate to private ground at node {node} ({told})"))
        }
        Passage::Gate => ("gate", format!("the map leads through the gate at node {node} ({told})")),
    };
    Finding::new(fault, Subject::Node(node), message).graded(Severity::Info)
}

/// A piece that is too short to end before a barrier.
fn left_out(piece: &WayPiece, ways: &[Drivable<'_>]) -> Finding {
    let way = ways[piece.way].way.id;
    let message = format!("way {way} has a part too short to end before a barrier; it is not built");
    Finding::new("way-skipped", Subject::Way(way), message).graded(Severity::Info)
}
