//! Areas: relations of `type=multipolygon`. The map keeps their tags alone; but Autoware does not publish a map with an
//! area whose ring does not close.

use std::collections::VecDeque;

use rustc_hash::FxHashMap;

use crate::diagnostic::Subject;
use crate::geometry::simple_ring;
use crate::lanelet::{Condition, LineStringId, PointId, RingFault};
use crate::osm::{ElementKind, Relation};

use super::Loader;

/// The lines of a role that are not yet part of a ring.
struct OpenLines {
    lines: Vec<Option<Vec<PointId>>>,
    /// For each end point the lines that have it, in file order.
    by_end: FxHashMap<PointId, VecDeque<usize>>,
    left: usize,
}

impl OpenLines {
    fn new(lines: Vec<Vec<PointId>>) -> Self {
        let mut by_end: FxHashMap<PointId, VecDeque<usize>> = FxHashMap::default();
        for (at, line) in lines.iter().enumerate() {
            for end in [line.first(), line.last()].into_iter().flatten() {
                by_end.entry(*end).or_default().push_back(at);
            }
        }
        Self { left: lines.len(), lines: lines.into_iter().map(Some).collect(), by_end }
    }

    fn take(&mut self, at: usize) -> Option<Vec<PointId>> {
        let line = self.lines[at].take();
        self.left -= usize::from(line.is_some());
        line
    }

    /// The first line that begins or ends in a point, turned so that it begins there.
    fn take_from(&mut self, end: PointId) -> Option<Vec<PointId>> {
        while let Some(at) = self.by_end.get_mut(&end)?.pop_front() {
            let Some(mut line) = self.take(at) else { continue };
            if line.last() == Some(&end) {
                line.reverse();
            }
            return Some(line);
        }
        None
    }
}

impl Loader<'_> {
    /// Whether the loader makes an area of the relation. What the loader reports becomes a fault.
    pub(super) fn area(&mut self, relation: &Relation) -> bool {
        let outer = self.rings(relation, "outer");
        if outer != Some(1) {
            // If a line is at fault, its fault is reported already.
            if let Some(rings) = outer {
                self.ring_fault(relation, RingFault::Rings(rings));
            }
            return false;
        }
        self.rings(relation, "inner");
        true
    }

    fn ring_fault(&mut self, relation: &Relation, fault: RingFault) {
        self.fault(Subject::Relation(relation.id), &relation.span, Condition::BrokenArea(fault));
    }

    /// The number of rings that the lines of a role close; `None` if no ring closes and a line of the role has a fault. A last
    /// line that closes no ring is ignored without a report.
    fn rings(&mut self, relation: &Relation, role: &'static str) -> Option<usize> {
        let (lines, mut told) = self.lines_of(relation, role);
        let mut open = OpenLines::new(lines);
        let mut rings = 0;
        for at in 0..open.lines.len() {
            let Some(mut ring) = open.take(at) else { continue };
            while let (Some(first), Some(&last)) = (ring.first(), ring.last()) {
                if *first == last {
                    if self.goes_round(&ring) {
                        rings += 1;
                    } else {
                        self.ring_fault(relation, RingFault::Crossing { role });
                        told = true;
                    }
                    break;
                }
                let left = open.left;
                match open.take_from(last) {
                    Some(next) => ring.extend(next),
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
        (rings > 0 || !told).then_some(rings)
    }

    /// The lines of a role, and whether a member is none.
    fn lines_of(&mut self, relation: &Relation, role: &'static str) -> (Vec<Vec<PointId>>, bool) {
        let (mut lines, mut told) = (Vec::new(), false);
        let members = relation.members.iter().filter(|one| one.role == role && self.osm.contains(one.kind, one.id));
        let members: Vec<(ElementKind, i64)> = members.map(|one| (one.kind, one.id)).collect();
        for (kind, id) in members {
            let line = self.loaded.map.linestrings.get(LineStringId(id)).filter(|_| kind == ElementKind::Way);
            if let Some(line) = line {
                lines.push(line.points.clone());
            } else {
                self.ring_fault(relation, RingFault::NoLine { role, kind, id });
                told = true;
            }
        }
        (lines, told)
    }

    /// Whether a closed line is the outline of a single piece of ground.
    fn goes_round(&self, ring: &[PointId]) -> bool {
        let mut ring: Vec<_> =
            ring.iter().filter_map(|&id| self.loaded.map.points.get(id)).map(|point| point.position).collect();
        ring.dedup();
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        ring.len() >= 3 && simple_ring::is_simple(&ring)
    }
}
