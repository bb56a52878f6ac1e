//! The bounds of the ways through an intersection: lines that neighbours share.

use std::borrow::Cow;
use std::sync::OnceLock;

use rustc_hash::FxHashMap;

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::map::point_index::PointIndex;
use crate::geometry::diverge::{Measured, diverge};
use crate::geometry::{Point, curve};
use crate::lanelet::{Attributes, Bound, LineStringId, PointId};

/// Lines between two nodes of an intersection, each drawn once.
#[derive(Clone, Debug, Default)]
pub struct SharedBounds {
    lines: Vec<Line>,
    /// For every node where lines end, the other ends of those lines, each with the last line to there.
    ends: FxHashMap<PointId, Vec<(PointId, u32)>>,
    points: PointIndex,
}

/// The line of a bound.
#[derive(Clone, Debug)]
pub struct Line {
    id: LineStringId,
    /// Its points, from the node where it begins to that where it ends, ...
    nodes: Vec<PointId>,
    /// ... and where they lie.
    places: Vec<Point>,
    /// From its begin and from its end, where that is asked for.
    measured: [OnceLock<Option<Measured>>; 2],
}

impl Line {
    /// As a bound that begins at a node.
    pub fn bound(&self, from: PointId) -> Bound {
        Bound { line: self.id, inverted: !self.begins_at(from) }
    }

    /// Its places in order from a node.
    pub fn places(&self, from: PointId) -> Cow<'_, [Point]> {
        match self.begins_at(from) {
            true => Cow::Borrowed(&self.places),
            false => Cow::Owned(self.places.iter().rev().copied().collect()),
        }
    }

    /// The points between its ends and where they lie, in order from a node.
    pub fn inner(&self, from: PointId) -> Vec<(PointId, Point)> {
        let inner = 1..self.nodes.len() - 1;
        let points = inner.map(|i| (self.nodes[i], self.places[i]));
        if self.begins_at(from) { points.collect() } else { points.rev().collect() }
    }

    fn begins_at(&self, node: PointId) -> bool {
        self.nodes[0] == node
    }

    fn measured(&self, from: PointId) -> Option<&Measured> {
        let (begins, places) = (self.begins_at(from), self.places.iter().copied());
        let measure = || if begins { Measured::new(places) } else { Measured::new(places.rev()) };
        self.measured[usize::from(!begins)].get_or_init(measure).as_ref()
    }
}

impl SharedBounds {
    /// The line from one node to another, or back.
    pub fn line(&self, from: PointId, to: PointId) -> Option<&Line> {
        let (_, at) = self.ends.get(&from)?.iter().find(|(end, _)| *end == to)?;
        self.lines.get(*at as usize)
    }

    /// Makes room for so many more lines.
    pub fn reserve(&mut self, more: usize) {
        self.lines.reserve(more);
        self.ends.reserve(more);
    }

    /// Every point of every line and where it lies, in order of the lines' ids.
    pub fn points(&self) -> impl Iterator<Item = (PointId, Point)> {
        let lines = self.ends.values().flatten().map(|(_, at)| &self.lines[*at as usize]);
        let mut lines: Vec<&Line> = lines.collect();
        lines.sort_unstable_by_key(|line| line.id);
        lines.dedup_by_key(|line| line.id);
        lines.into_iter().flat_map(|line| line.nodes.iter().copied().zip(line.places.iter().copied()))
    }

    /// Adds the line of a bound between two nodes that exist, from the place of the one to that of the other.
    pub fn draw(
        &mut self,
        assembly: &mut MapBuilder,
        key: Key,
        [a, b]: [PointId; 2],
        places: &[Point],
        attributes: Attributes,
    ) -> Bound {
        // The pair of nodes is unordered, so that the same bound has the same id whichever way it was drawn.
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        let key = key.word("bound").number(low.0).number(high.0);
        let clean = curve::untangled(places);
        let heights = assembly.heights_along(&clean, [a, b]);
        let inner = 1.min(clean.len())..clean.len().max(2) - 1;
        let number = |i: usize| i as i64 - 1;
        let between = inner.map(|i| {
            let make = || assembly.point_at(key.number(number(i)), clean[i], heights[i], Attributes::new());
            self.points.at(clean[i], make)
        });
        let ends = [(a, clean.first()), (b, clean.last())].map(|(id, place)| (id, place.copied().unwrap_or_default()));
        let mut points: Vec<(PointId, Point)> = Vec::with_capacity(clean.len().max(2));
        points.push(ends[0]);
        points.extend(between);
        points.push(ends[1]);
        points.dedup_by_key(|(id, _)| *id);
        let (nodes, places): (Vec<PointId>, Vec<Point>) = points.into_iter().unzip();
        let id = assembly.line(key, nodes.clone(), attributes);
        self.insert([a, b], Line { id, nodes, places, measured: Default::default() })
    }

    /// Keeps the places of a line that is to be drawn from one node to another beside the lines that end on either node.
    pub fn beside_others(&self, [from, to]: [PointId; 2], mut places: Vec<Point>) -> Vec<Point> {
        for node in [from, to] {
            let mut own = None;
            let ends = self.ends.get(&node).into_iter().flatten();
            for (_, at) in ends.filter(|(end, _)| ![from, to].contains(end)) {
                own = own.or_else(|| Measured::new(places.iter().copied()));
                let other = self.lines.get(*at as usize).and_then(|other| other.measured(node));
                let (Some(line), Some(other)) = (&own, other) else { continue };
                if let Some(apart) = diverge(line, other) {
                    (places, own) = (apart, None);
                }
            }
            places.reverse();
        }
        places
    }

    fn insert(&mut self, [from, to]: [PointId; 2], line: Line) -> Bound {
        let at = self.lines.len() as u32;
        for (end, other) in [(from, to), (to, from)] {
            let ends = self.ends.entry(end).or_default();
            ends.iter_mut().filter(|(end, _)| *end == other).for_each(|(_, line)| *line = at);
            ends.push((other, at));
        }
        let bound = line.bound(from);
        self.lines.push(line);
        bound
    }
}
