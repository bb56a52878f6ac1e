//! Nodes that lie close together and were meant to be one: all of a heap at once, however many.

use std::collections::BTreeMap;

use crate::diagnostic::{Edit, Finding};
use crate::geometry::Point;
use crate::lanelet::PointId;
use crate::lanelet::index::MapIndex;

/// The oldest node that one is to become.
fn root(older: &BTreeMap<PointId, PointId>, mut id: PointId) -> PointId {
    while let Some(&next) = older.get(&id) {
        id = next;
    }
    id
}

/// For each of several nodes that are to be one, all of them: the oldest, which stays, first.
pub struct Heaps(BTreeMap<PointId, Vec<PointId>>);

impl Heaps {
    /// Those of pairs that are to be one. A heap of which a node is no closer than `limit` (m) to the oldest is none: it would be moved
    /// farther than any of its findings says.
    pub fn of(map: &MapIndex, pairs: impl Iterator<Item = [PointId; 2]>, limit: f64) -> Self {
        let mut older: BTreeMap<PointId, PointId> = BTreeMap::new();
        let mut ids: Vec<PointId> = Vec::new();
        for pair in pairs {
            ids.extend(pair);
            let [a, b] = pair.map(|id| root(&older, id));
            if a != b {
                older.insert(a.max(b), a.min(b));
            }
        }
        ids.sort_unstable();
        ids.dedup();
        let mut heaps: BTreeMap<PointId, Vec<PointId>> = BTreeMap::new();
        for id in ids {
            heaps.entry(root(&older, id)).or_default().push(id);
        }
        let is_close = |ids: &[PointId]| {
            let places = ids.iter().filter_map(|&id| Some(map.map.points.get(id)?.position));
            let all: Vec<Point> = places.collect();
            all.iter().all(|one| all.first().is_some_and(|first| (one - first).norm() < limit))
        };
        heaps.retain(|_, ids| is_close(ids));
        Self(heaps.into_values().flat_map(|ids| ids.clone().into_iter().map(move |id| (id, ids.clone()))).collect())
    }

    /// The finding that two nodes are to be one, with the fix that makes one of all of their heap.
    pub fn made_one(&self, finding: Finding, [older, newer]: [PointId; 2]) -> Finding {
        let pair = vec![older, newer];
        let (to, from) = self.0.get(&older).unwrap_or(&pair).split_first().unwrap_or((&older, &[]));
        let edits: Vec<Edit> = from.iter().map(|one| Edit::MergePoints { from: one.0, to: to.0 }).collect();
        let names: Vec<String> = from.iter().map(ToString::to_string).collect();
        finding.fixed_by(format!("use node {to} instead of {}", names.join(", ")), true, edits)
    }
}
