//! Areas: relations of `type=multipolygon`, whose lines close one ring. Autoware does not publish a map with an area whose ring does
//! not close.

use std::collections::VecDeque;

use rustc_hash::FxHashMap;

use crate::diagnostic::Subject;
use crate::geometry::{Point as PlanePoint, polygon, simple_ring};
use crate::lanelet::{Area, AreaId, Bound, Condition, LineStringId, PointId, RingFault};
use crate::osm::{ElementKind, Relation};

use super::Loader;

/// Lines one behind the other, and the points over which they run.
struct Chain {
    lines: Vec<Bound>,
    points: Vec<PointId>,
}

impl Chain {
    fn of(line: LineStringId, points: Vec<PointId>) -> Self {
        Self { lines: vec![Bound { line, inverted: false }], points }
    }

    fn turn_around(&mut self) {
        self.points.reverse();
        self.lines.reverse();
        self.lines.iter_mut().for_each(|line| line.inverted = !line.inverted);
    }
}

/// The lines of a role that are not yet part of a ring.
struct OpenLines {
    lines: Vec<Option<Chain>>,
    /// For each end point the lines that have it, in file order.
    by_end: FxHashMap<PointId, VecDeque<usize>>,
    left: usize,
}

impl OpenLines {
    fn new(lines: Vec<Chain>) -> Self {
        let mut by_end: FxHashMap<PointId, VecDeque<usize>> = FxHashMap::default();
        for (at, line) in lines.iter().enumerate() {
            for end in [line.points.first(), line.points.last()].into_iter().flatten() {
                by_end.entry(*end).or_default().push_back(at);
            }
        }
        Self { left: lines.len(), lines: lines.into_iter().map(Some).collect(), by_end }
    }

    fn take(&mut self, at: usize) -> Option<Chain> {
        let line = self.lines[at].take();
        self.left -= usize::from(line.is_some());
        line
    }

    /// The first line that begins or ends in a point, turned so that it begins there.
    fn take_from(&mut self, end: PointId) -> Option<Chain> {
        while let Some(at) = self.by_end.get_mut(&end)?.pop_front() {
            let Some(mut line) = self.take(at) else { continue };
            if line.points.last() == Some(&end) {
                line.turn_around();
            }
            return Some(line);
        }
        None
    }
}

impl Loader<'_> {
    /// What the loader makes of the relation. What it reports becomes a fault.
    pub(super) fn area(&mut self, relation: &Relation) -> Option<Area> {
        let outer = self.rings(relation, "outer")?;
        let count = outer.len();
        let Ok([mut ring]) = <[Chain; 1]>::try_from(outer) else {
            self.ring_fault(relation, RingFault::Rings(count));
            return None;
        };
        let holes = self.rings(relation, "inner").map_or(0, |rings| rings.len());
        if polygon::signed_area(&self.places(&ring.points)) > 0.0 {
            ring.turn_around();
        }
        // The last point is the first again.
        ring.points.pop();
        let (attributes, span) = (relation.tags.clone(), Some(relation.span.clone()));
        Some(Area { id: AreaId(relation.id), outer: ring.lines, points: ring.points, holes, attributes, span })
    }

    fn ring_fault(&mut self, relation: &Relation, fault: RingFault) {
        self.fault(Subject::Relation(relation.id), &relation.span, Condition::BrokenArea(fault));
    }

    /// The rings that the lines of a role close; `None` if no ring closes and a line of the role has a fault, which is reported then.
    /// A last line that closes no ring is ignored without a report.
    fn rings(&mut self, relation: &Relation, role: &'static str) -> Option<Vec<Chain>> {
        let (lines, mut told) = self.lines_of(relation, role);
        let mut open = OpenLines::new(lines);
        let mut rings = Vec::new();
        for at in 0..open.lines.len() {
            let Some(mut ring) = open.take(at) else { continue };
            while let (Some(first), Some(&last)) = (ring.points.first(), ring.points.last()) {
                if *first == last {
                    if self.goes_round(&ring.points) {
                        rings.push(ring);
                    } else {
                        self.ring_fault(relation, RingFault::Crossing { role });
                        told = true;
                    }
                    break;
                }
                let left = open.left;
                match open.take_from(last) {
                    Some(next) => {
                        ring.points.extend(next.points.into_iter().skip(1));
                        ring.lines.extend(next.lines);
                    }
                    None => {
                        if left > 0 {
                            self.ring_fault(relation, RingFault::Open { role });
                            told = true;
                        }
                        break;
                    }
                }
            }
        }
        (!rings.is_empty() || !told).then_some(rings)
    }

    /// The lines of a role, and whether a member is none.
    fn lines_of(&mut self, relation: &Relation, role: &'static str) -> (Vec<Chain>, bool) {
        let (mut lines, mut told) = (Vec::new(), false);
        let members = relation.members.iter().filter(|one| one.role == role && self.osm.contains(one.kind, one.id));
        let members: Vec<(ElementKind, i64)> = members.map(|one| (one.kind, one.id)).collect();
        for (kind, id) in members {
            let line = self.loaded.map.linestrings.get(LineStringId(id)).filter(|_| kind == ElementKind::Way);
            if let Some(line) = line {
                lines.push(Chain::of(line.id, line.points.clone()));
            } else {
                self.ring_fault(relation, RingFault::NoLine { role, kind, id });
                told = true;
            }
        }
        (lines, told)
    }

    fn places(&self, points: &[PointId]) -> Vec<PlanePoint> {
        points.iter().filter_map(|&id| self.loaded.map.points.get(id)).map(|point| point.position).collect()
    }

    /// Whether a closed line is the outline of a single piece of ground.
    fn goes_round(&self, ring: &[PointId]) -> bool {
        let mut ring = self.places(ring);
        ring.dedup();
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        ring.len() >= 3 && simple_ring::is_simple(&ring)
    }
}
