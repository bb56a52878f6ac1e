//! Where lanelets of the file lie that did not load.

use rustc_hash::FxHashSet;

use super::{Edge, MapIndex};
use crate::diagnostic::Subject;
use crate::lanelet::{Condition, LineStringId, PointId};

impl MapIndex<'_> {
    /// Whether a lanelet that did not load begins or ends at this edge: no lane is missing there, the loader's finding says what is wrong.
    pub fn is_at_unloaded(&self, edge: &Edge) -> bool {
        let points = self.unloaded.get_or_init(|| self.points_of_unloaded());
        edge.ids.iter().all(|id| points.contains(id))
    }

    /// The points of the bounds of all lanelets that did not load.
    fn points_of_unloaded(&self) -> FxHashSet<PointId> {
        let named = self.faults.iter().filter(|fault| matches!(fault.subject, Subject::Lanelet(_)));
        let several = named.flat_map(|fault| match &fault.condition {
            Condition::BoundCount { ways, .. } => ways.as_slice(),
            _ => &[],
        });
        let usable = self.map.dummies.lanelets.iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]);
        let lines = several.map(|&way| LineStringId(way)).chain(usable);
        lines.filter_map(|line| self.map.linestrings.get(line)).flat_map(|line| line.points.iter().copied()).collect()
    }
}
