//! Nodes that lie close together and were meant to be one: all of a cluster at once, however many.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Edit, Finding};
use crate::lanelet::PointId;
use crate::lanelet::index::{MapIndex, UnionFind};

/// Clusters of nodes that become one node. The oldest node, which stays, comes first.
pub struct NodeClusters {
    clusters: Vec<Vec<PointId>>,
    /// The cluster of each node.
    of_node: FxHashMap<PointId, usize>,
}

impl NodeClusters {
    /// The clusters of these pairs. A cluster with a node that is `limit` (m) or more from the oldest is left out: it would move
    /// farther than any of its findings says.
    pub fn of(map: &MapIndex, pairs: impl Iterator<Item = [PointId; 2]>, limit: f64) -> Self {
        let pairs: Vec<[PointId; 2]> = pairs.collect();
        let mut ids: Vec<PointId> = pairs.iter().flatten().copied().collect();
        ids.sort_unstable();
        ids.dedup();
        let mut sets = UnionFind::new(ids.len());
        for [a, b] in &pairs {
            let [a, b] = [a, b].map(|id| ids.partition_point(|one| one < id));
            sets.join(a, b);
        }
        let mut by_root: Vec<Vec<PointId>> = vec![Vec::new(); ids.len()];
        ids.iter().enumerate().for_each(|(at, id)| by_root[sets.root(at)].push(*id));
        let place = |id: &PointId| map.map.points.get(*id).map(|point| point.position);
        let is_close = |cluster: &Vec<PointId>| {
            let Some(oldest) = cluster.first().and_then(place) else { return false };
            cluster.iter().filter_map(place).all(|one| (one - oldest).norm() < limit)
        };
        let clusters: Vec<Vec<PointId>> = by_root.into_iter().filter(is_close).collect();
        let of_node = clusters.iter().enumerate().flat_map(|(at, cluster)| cluster.iter().map(move |&id| (id, at)));
        Self { of_node: of_node.collect(), clusters }
    }

    /// The finding that two nodes are to be one, with the fix that makes one of all of their cluster.
    pub fn made_one(&self, finding: Finding, pair: [PointId; 2]) -> Finding {
        let cluster = self.of_node.get(&pair[0]).and_then(|&at| self.clusters.get(at));
        let [to, from @ ..] = cluster.map_or(&pair[..], Vec::as_slice) else { return finding };
        let edits: Vec<Edit> = from.iter().map(|one| Edit::MergePoints { from: one.0, to: to.0 }).collect();
        let names: Vec<String> = from.iter().map(ToString::to_string).collect();
        finding.fixed_by(format!("use node {to} instead of {}", names.join(", ")), true, edits)
    }
}
