//! The bounds of turning lanelets: lines that neighbours share.

use std::borrow::Cow;
use std::sync::OnceLock;

use rustc_hash::FxHashMap;

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::map::point_index::PointIndex;
use crate::geometry::diverge::{Measured, Room, diverge};
use crate::geometry::{Point, curve};
use crate::lanelet::{Attributes, Bound, LineStringId, PointId};

/// Lines between two nodes of an intersection, each drawn once.
#[derive(Clone, Debug, Default)]
pub struct SharedBounds {
    lines: Vec<BoundLine>,
    /// By node: the other ends of the lines that end there, each with the latest line to it, by index.
    ends: FxHashMap<PointId, Vec<(PointId, u32)>>,
    /// By the nodes at which a movement begins and ends: whether the line between them is the left, and the right, bound of one.
    sides: FxHashMap<[PointId; 2], [bool; 2]>,
    points: PointIndex,
}

/// The line of a bound.
#[derive(Clone, Debug)]
pub struct BoundLine {
    /// What other lines between the same nodes have in common with it.
    key: Key,
    id: LineStringId,
    nodes: Vec<PointId>,
    /// The places of its nodes.
    places: Vec<Point>,
    /// Measured from its begin and from its end, on demand.
    measured: [OnceLock<Option<Measured>>; 2],
}

impl BoundLine {
    /// The bound that begins at a node.
    pub fn bound(&self, from: PointId) -> Bound {
        Bound { line: self.id, inverted: !self.begins_at(from) }
    }

    /// Its places, in order from a node.
    pub fn places(&self, from: PointId) -> Cow<'_, [Point]> {
        match self.begins_at(from) {
            true => Cow::Borrowed(&self.places),
            false => Cow::Owned(self.places.iter().rev().copied().collect()),
        }
    }

    /// The points between its ends and their places, in order from a node.
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
    /// The line between two nodes, whichever its direction.
    pub fn line(&self, from: PointId, to: PointId) -> Option<&BoundLine> {
        let (_, line) = self.ends.get(&from)?.iter().find(|(end, _)| *end == to)?;
        self.lines.get(*line as usize)
    }

    /// Reserves room for this number of lines more.
    pub fn reserve(&mut self, more: usize) {
        self.lines.reserve(more);
        self.ends.reserve(more);
    }

    /// Every point of every line and its place, in order of the lines' ids.
    pub fn points(&self) -> impl Iterator<Item = (PointId, Point)> {
        let lines = self.ends.values().flatten().map(|(_, line)| &self.lines[*line as usize]);
        let mut lines: Vec<&BoundLine> = lines.collect();
        lines.sort_unstable_by_key(|line| line.id);
        lines.dedup_by_key(|line| line.id);
        lines.into_iter().flat_map(|line| line.nodes.iter().copied().zip(line.places.iter().copied()))
    }

    /// Says that a movement has its bound on this side, 0 left, 1 right, between the nodes where it begins and ends.
    pub fn plan(&mut self, nodes: [PointId; 2], side: usize) {
        if let Some(used) = self.sides.entry(nodes).or_default().get_mut(side) {
            *used = true;
        }
    }

    /// Adds the line of a bound along places from one node to another.
    pub fn draw(
        &mut self,
        assembly: &mut MapBuilder,
        key: Key,
        [a, b]: [PointId; 2],
        places: &[Point],
        attributes: Attributes,
    ) -> Bound {
        // The lower node first: a bound has the same id in either direction.
        let of_nodes = key.word("bound").number(a.min(b).0).number(a.max(b).0);
        let earlier = self.lines.iter().filter(|line| line.key == of_nodes).count();
        let key = if earlier == 0 { of_nodes } else { of_nodes.word("again").number(earlier as i64) };
        let clean = curve::untangled(places);
        let heights = assembly.heights_along(&clean, [a, b]);
        let mut points: Vec<(PointId, Point)> = Vec::with_capacity(clean.len().max(2));
        points.push((a, clean.first().copied().unwrap_or_default()));
        points.extend((1.min(clean.len())..clean.len().max(2) - 1).map(|i| {
            let make = || assembly.point_at(key.number(i as i64 - 1), clean[i], heights[i], Attributes::new());
            self.points.at(clean[i], make)
        }));
        points.push((b, clean.last().copied().unwrap_or_default()));
        points.dedup_by_key(|(id, _)| *id);
        let (nodes, places): (Vec<PointId>, Vec<Point>) = points.into_iter().unzip();
        let id = assembly.line(key, nodes.clone(), attributes);
        let measured = Default::default();
        self.insert([a, b], BoundLine { key: of_nodes, id, nodes, places, measured })
    }

    /// Takes up a line that is drawn already.
    pub fn adopt(&mut self, assembly: &MapBuilder, line: LineStringId) {
        let nodes = assembly.line_of(line).map(|line| line.points.clone()).unwrap_or_default();
        let (Some(&from), Some(&to)) = (nodes.first(), nodes.last()) else { return };
        let key = Key::new("adopted").number(line.0);
        let (places, measured) = (assembly.positions(&nodes), Default::default());
        self.insert([from, to], BoundLine { key, id: line, nodes, places, measured });
    }

    /// Moves the places of a new line between two nodes to its own side of the other lines that end on either node. Lines between
    /// two lanes that part need that most.
    pub fn beside_others(&self, [from, to]: [PointId; 2], mut places: Vec<Point>) -> Vec<Point> {
        for node in [from, to] {
            let mut own = None;
            let ends = self.ends.get(&node).into_iter().flatten();
            for (end, line) in ends.filter(|(end, _)| ![from, to].contains(end)) {
                own = own.or_else(|| Measured::new(places.iter().copied()));
                let Some(bound) = self.lines.get(*line as usize) else { continue };
                let (Some(line), Some(other)) = (&own, bound.measured(node)) else { continue };
                let room = if node == from { self.room(from, [to, *end]) } else { Room::USUAL };
                if let Some(apart) = diverge(line, other, room) {
                    (places, own) = (apart, None);
                }
            }
            places.reverse();
        }
        places
    }

    /// The room between two lines that begin at one node: the right bound of a lane belongs to the left of the left bound of the
    /// lane to its right, whatever other lanelets share them.
    fn room(&self, from: PointId, [to, other]: [PointId; 2]) -> Room {
        let [own, other] = [to, other].map(|end| self.sides.get(&[from, end]).copied().unwrap_or_default());
        match [own[1] && other[0], own[0] && other[1]] {
            [left, right] if left != right => Room::parting(left),
            _ => Room::USUAL,
        }
    }

    fn insert(&mut self, [from, to]: [PointId; 2], line: BoundLine) -> Bound {
        let index = self.lines.len() as u32;
        for (end, other) in [(from, to), (to, from)] {
            let ends = self.ends.entry(end).or_default();
            ends.iter_mut().filter(|(end, _)| *end == other).for_each(|(_, line)| *line = index);
            ends.push((other, index));
        }
        let bound = line.bound(from);
        self.lines.push(line);
        bound
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::map::map_builder::MapPart;

    use super::*;

    #[test]
    fn lines_of_two_lanes_part_whatever_other_lanelets_share_them() {
        let (from, [a, b]) = (PointId(1), [2, 3].map(PointId));
        let planned = |uses: &[(PointId, usize)]| {
            let mut bounds = SharedBounds::default();
            uses.iter().for_each(|&(to, side)| bounds.plan([from, to], side));
            bounds
        };
        let turn_and_straight = planned(&[(a, 1), (b, 0), (b, 1)]);
        assert_eq!(turn_and_straight.room(from, [a, b]), Room::parting(true), "the left lane turns left");
        assert_eq!(turn_and_straight.room(from, [b, a]), Room::parting(false));
        let both_share_both = planned(&[(a, 0), (a, 1), (b, 0), (b, 1)]);
        assert_eq!(both_share_both.room(from, [a, b]), Room::USUAL, "either way one lane crosses the other");
        assert_eq!(planned(&[(a, 0), (b, 0)]).room(from, [a, b]), Room::USUAL, "lanelets of one lane");
    }

    #[test]
    fn the_id_of_a_second_line_between_two_nodes_does_not_depend_on_the_points_of_the_first() {
        let drawn = |inner: usize| {
            let mut assembly = MapBuilder::default();
            let ends = [0.0, 60.0].map(|x| Point::new(x, 0.0));
            let nodes = [0, 1].map(|i: usize| assembly.point(Key::new("end").number(i as i64), ends[i], 0.0));
            let line = |inner: usize, y: f64| {
                let between = (1..=inner).map(|i| Point::new(60.0 * i as f64 / (inner + 1) as f64, y));
                [vec![ends[0]], between.collect(), vec![ends[1]]].concat()
            };
            let mut bounds = SharedBounds::default();
            let mut draw =
                |places: &[Point]| bounds.draw(&mut assembly, Key::new("path"), nodes, places, Attributes::new()).line;
            let lines = [draw(&line(inner, 3.0)), draw(&line(5, -3.0))];
            let second = assembly.line_of(lines[1]).map(|line| line.points.clone());
            (lines, second, assembly.finish(MapPart::default()).repeated_ids())
        };
        let (few, many) = (drawn(1), drawn(20));
        assert_eq!((&few.0, &few.1, &few.2, &many.2), (&many.0, &many.1, &vec![], &vec![]));
        assert_ne!(few.0[0], few.0[1]);
    }
}
