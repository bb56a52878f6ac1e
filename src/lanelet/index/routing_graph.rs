//! Lanelet2's routing graph: who may pass, who follows, who lies beside, who conflicts.

use rustc_hash::FxHashMap;

use super::drawn_centerline::length_for_routes;
use super::view::{Seen, View};
use crate::lanelet::lane_change::{LaneChange, Participant};
use crate::lanelet::{Bound, Lanelet, LineStringId, PointId};

/// The participant and the traffic rules of a graph: Lanelet2's rules of a country, or the validator's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rules {
    /// A car, by Lanelet2's rules for Germany.
    Car,
    /// A car, by the validator's rules: along everything that vehicles or people use lengthwise.
    AnyLane,
    /// A pedestrian, by the validator's rules.
    Pedestrian,
}

const CAR: [&str; 4] = ["road", "highway", "play_street", "exit"];
const LANES: [&str; 7] =
    ["road_shoulder", "pedestrian_lane", "bicycle_lane", "emergency_lane", "walkway", "stairs", "shared_walkway"];

impl Rules {
    fn participant(self) -> &'static str {
        match self {
            Self::Car | Self::AnyLane => "vehicle",
            Self::Pedestrian => "pedestrian",
        }
    }

    /// Who changes lanes.
    fn who(self) -> Participant {
        match self {
            Self::Car | Self::AnyLane => Participant::Vehicle,
            Self::Pedestrian => Participant::Pedestrian,
        }
    }

    /// Whether a lanelet may be passed: participants, where any is named, decide alone; else the subtype.
    pub fn pass(self, lanelet: &Lanelet) -> bool {
        if let Some(said) = self.said(lanelet, "participant", false) {
            return said;
        }
        let Some(subtype) = lanelet.attributes.get("subtype") else { return true };
        let more = || LANES.contains(&subtype);
        CAR.contains(&subtype)
            || match self {
                Self::Car => false,
                Self::AnyLane => more(),
                Self::Pedestrian => more() || subtype == "crosswalk",
            }
    }

    /// Whether a lanelet is passed in one direction only. People on foot go both ways unless a tag says otherwise.
    fn one_way(self, lanelet: &Lanelet) -> bool {
        self.said(lanelet, "one_way", true).unwrap_or(self != Self::Pedestrian)
    }

    /// The value of the tag `KEY` or `KEY:participant`; `None` if no tag begins with the key, and `otherwise` if no such tag is
    /// for the participant, or its value means neither yes nor no.
    fn said(self, lanelet: &Lanelet, key: &str, otherwise: bool) -> Option<bool> {
        let mut named: Vec<(&str, &str)> =
            lanelet.attributes.iter().filter(|(name, _)| name.starts_with(key)).collect();
        named.sort_unstable();
        let own = |name: &str| {
            name.strip_prefix(key).is_some_and(|rest| {
                rest.is_empty() || rest.strip_prefix(':').is_some_and(|who| self.participant().starts_with(who))
            })
        };
        let value = named.iter().find(|(name, _)| own(name)).map(|(_, value)| *value);
        (!named.is_empty()).then_some(match value {
            Some("yes" | "true" | "1") => true,
            Some("no" | "false" | "0") => false,
            _ => otherwise,
        })
    }
}

/// A bound with the direction in which it is used.
type Side = (LineStringId, bool);

/// A lanelet, or a lanelet driven against its direction.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    seen: usize,
    inverted: bool,
    start: [PointId; 2],
    end: [PointId; 2],
    left: Side,
    right: Side,
}

impl Vertex {
    fn new(at: usize, seen: &Seen<'_>) -> Option<Self> {
        let [start, end] = seen.ends()?.map(|edge| edge.map(|point| point.id));
        let side = |bound: Bound| (bound.line, bound.inverted);
        let (left, right) = (side(seen.lanelet.left), side(seen.lanelet.right));
        Some(Self { seen: at, inverted: false, start, end, left, right })
    }

    /// Whether two lanelets have a bound in common, or one follows the other, the first in either direction.
    fn touches(&self, other: &Self) -> bool {
        let turned = self.against();
        self.left == other.right
            || self.right == other.left
            || turned.right == other.left
            || turned.left == other.right
            || self.end == other.start
            || other.end == self.start
            || turned.end == other.start
    }

    fn against(self) -> Self {
        let turned = |(line, inverted): Side| (line, !inverted);
        let [[a, b], [c, d]] = [self.start, self.end];
        let (left, right) = (turned(self.right), turned(self.left));
        Self { inverted: true, start: [d, c], end: [b, a], left, right, ..self }
    }
}

/// The graph of one kind of participant.
#[derive(Debug)]
pub struct Graph<'v, 'm> {
    view: &'v View<'m>,
    rules: Rules,
    vertices: Vec<Vertex>,
    /// For every lanelet its vertex, if it may be passed.
    of: Vec<Option<usize>>,
    by_start: FxHashMap<[PointId; 2], Vec<usize>>,
    by_end: FxHashMap<[PointId; 2], Vec<usize>>,
    by_left: FxHashMap<Side, Vec<usize>>,
    by_right: FxHashMap<Side, Vec<usize>>,
}

impl<'v, 'm> Graph<'v, 'm> {
    /// Makes the graph.
    pub fn new(view: &'v View<'m>, rules: Rules) -> Self {
        let mut vertices = Vec::new();
        let mut of = vec![None; view.lanelets.len()];
        for (at, seen) in view.lanelets.iter().enumerate().filter(|(_, seen)| rules.pass(seen.lanelet)) {
            let Some(vertex) = Vertex::new(at, seen) else { continue };
            of[at] = Some(vertices.len());
            vertices.push(vertex);
            if !rules.one_way(seen.lanelet) {
                vertices.push(vertex.against());
            }
        }
        Self {
            view,
            rules,
            of,
            by_start: grouped(vertices.iter().map(|vertex| vertex.start)),
            by_end: grouped(vertices.iter().map(|vertex| vertex.end)),
            by_left: grouped(vertices.iter().map(|vertex| vertex.left)),
            by_right: grouped(vertices.iter().map(|vertex| vertex.right)),
            vertices,
        }
    }

    /// Whether a lanelet may be passed.
    pub fn passes(&self, at: usize) -> bool {
        self.of[at].is_some()
    }

    fn linked(&self, at: usize, next: impl Fn(&Vertex) -> Vec<usize>) -> Vec<usize> {
        let Some(vertex) = self.of[at].map(|vertex| self.vertices[vertex]) else { return Vec::new() };
        let others = next(&vertex).into_iter().map(|other| self.vertices[other]);
        others.filter(|other| other.seen != at || other.inverted == vertex.inverted).map(|other| other.seen).collect()
    }

    /// Lanelets that start where this one ends.
    pub fn following(&self, at: usize) -> Vec<usize> {
        self.linked(at, |vertex| self.by_start.get(&vertex.end).cloned().unwrap_or_default())
    }

    /// Lanelets that end where this one starts.
    pub fn previous(&self, at: usize) -> Vec<usize> {
        self.linked(at, |vertex| self.by_end.get(&vertex.start).cloned().unwrap_or_default())
    }

    /// The lanelet on the left over a bound that may not be changed over.
    pub fn adjacent_left(&self, at: usize) -> Option<usize> {
        self.beside(at, 0).next().map(|other| other.seen)
    }

    /// The lanelet on the right over a bound that may not be changed over.
    pub fn adjacent_right(&self, at: usize) -> Option<usize> {
        self.beside(at, 1).next().map(|other| other.seen)
    }

    /// The lanelets on the left and on the right over bounds that may not be changed over. Of several on one side it is the first by
    /// `rank`.
    pub fn adjacent(&self, at: usize, rank: &[usize]) -> [Option<usize>; 2] {
        let first = |side| self.beside(at, side).min_by_key(|other| (other.inverted, rank[other.seen]));
        [0, 1].map(|side| first(side).map(|other| other.seen))
    }

    /// What lies to the left (0) or to the right (1) over a bound that may not be changed over.
    fn beside(&self, at: usize, side: usize) -> impl Iterator<Item = &Vertex> {
        let own = self
            .vertex(at)
            .map(|vertex| [vertex.left, vertex.right][side])
            .filter(|&own| !self.is_open(own, side == 0));
        let others = own.and_then(|own| [&self.by_right, &self.by_left][side].get(&own));
        others.into_iter().flatten().map(|&other| &self.vertices[other]).filter(move |other| other.seen != at)
    }

    /// Whether the graph has an edge between two lanelets: one follows the other, or a lane change leads from one to the other,
    /// allowed or not. Of several lanelets beside one on the same side, the graph keeps the last by `rank`.
    pub fn linked_to(&self, x: usize, y: usize, rank: &[usize]) -> bool {
        let (Some(a), Some(b)) = (self.vertex(x), self.vertex(y)) else { return false };
        let last = |others: Option<&Vec<usize>>| {
            let vertex = |&&at: &&usize| (self.vertices[at].inverted, rank[self.vertices[at].seen]);
            others.into_iter().flatten().filter(|&&at| self.vertices[at].seen != x).max_by_key(vertex).copied()
        };
        let beside = |side: Side, to_left: bool, others: Option<&Vec<usize>>| {
            !self.is_open(side, to_left) || last(others).is_some_and(|at| self.of[y] == Some(at))
        };
        a.end == b.start
            || b.end == a.start
            || (a.left == b.right && beside(a.left, true, self.by_right.get(&a.left)))
            || (a.right == b.left && beside(a.right, false, self.by_left.get(&a.right)))
    }

    fn vertex(&self, at: usize) -> Option<&Vertex> {
        Some(&self.vertices[self.of[at]?])
    }

    /// Whether a bound may be crossed to the left, or to the right, as its lanelet sees it.
    fn is_open(&self, (line, inverted): Side, to_left: bool) -> bool {
        let over = LaneChange::over(self.view.map, Bound { line, inverted }, self.rules.who());
        if to_left { over.to_left } else { over.to_right }
    }

    /// Whether two lanelets conflict: both may be passed, their interiors meet, they have no bound in common, neither follows the
    /// other, and they do not start together in opposite directions.
    pub fn conflict(&self, x: usize, y: usize) -> bool {
        let (Some(a), Some(b)) = (self.vertex(x), self.vertex(y)) else { return false };
        let lanelets = &self.view.lanelets;
        // A lanelet for both directions conflicts if it does in one of them.
        let against = self.vertices.get(self.of[y].map_or(0, |at| at + 1)).filter(|other| other.seen == y);
        let apart = |b: &Vertex| !a.touches(b);
        x != y && (apart(b) || against.is_some_and(apart)) && lanelets[x].meets(&lanelets[y])
    }

    /// The lanelets that a lanelet conflicts with, in file order.
    pub fn conflicting(&self, at: usize) -> Vec<usize> {
        if !self.passes(at) {
            return Vec::new();
        }
        let near = self.view.near(self.view.lanelets[at].extent, 0.0);
        near.into_iter().filter(|&other| self.conflict(at, other)).collect()
    }

    /// The shortest way from one lanelet to another without changing lanes, both included.
    pub fn path(&self, from: usize, to: usize) -> Option<Vec<usize>> {
        if !self.passes(from) || !self.passes(to) {
            return None;
        }
        let length = |at: usize| length_for_routes(&self.view.lanelets[at]);
        let mut best: FxHashMap<usize, (f64, Option<usize>)> = FxHashMap::from_iter([(from, (0.0, None))]);
        let mut open = std::collections::BTreeSet::from_iter([(0_u64, from)]);
        while let Some((_, at)) = open.pop_first() {
            if at == to {
                let before = |at: &usize| best.get(at).and_then(|&(_, before)| before);
                let mut path: Vec<usize> = std::iter::successors(Some(to), before).collect();
                path.reverse();
                return Some(path);
            }
            let cost = best.get(&at).map_or(0.0, |&(cost, _)| cost) + length(at);
            for next in self.following(at) {
                if best.get(&next).is_none_or(|&(known, _)| cost < known) {
                    best.insert(next, (cost, Some(at)));
                    // Positive numbers keep their order as bits.
                    open.insert((cost.to_bits(), next));
                }
            }
        }
        None
    }
}

fn grouped<K: std::hash::Hash + Eq>(keys: impl Iterator<Item = K>) -> FxHashMap<K, Vec<usize>> {
    let mut groups: FxHashMap<K, Vec<usize>> = FxHashMap::default();
    for (at, key) in keys.enumerate() {
        groups.entry(key).or_default().push(at);
    }
    groups
}
