//! Nodes that lie close together and were meant to be one: all of a cluster at once, however many.

use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::Polyline;
use crate::lanelet::PointId;
use crate::lanelet::index::{Lane, MapIndex, UnionFind};

use super::crowd;

/// Nodes that differ by more in height, metres, lie above each other: no survey drifts so far within one joint.
const ONE_FLOOR: f64 = 1.0;

/// Whether two nodes lie on one floor; `true` if a height is unknown.
pub fn are_on_one_floor(map: &MapIndex, one: PointId, other: PointId) -> bool {
    let height = |id| map.map.points.get(id).and_then(|point| point.ele());
    height(one).zip(height(other)).is_none_or(|(a, b)| (a - b).abs() <= ONE_FLOOR)
}

/// Clusters of nodes that become one node. The oldest node, which stays, comes first.
pub struct NodeClusters {
    clusters: Vec<Cluster>,
    /// The cluster of each node.
    of_node: FxHashMap<PointId, usize>,
}

struct Cluster {
    nodes: Vec<PointId>,
    /// Whether all of them become one.
    close: bool,
    /// The lanes that its pairs keep apart: all of them connect once it is one node.
    lanes: BTreeSet<usize>,
    /// The pairs for which there is a finding, if not for all.
    told: Option<FxHashSet<[PointId; 2]>>,
}

impl NodeClusters {
    /// The clusters of these pairs. A cluster with a node that is `limit` (m) or more from the oldest, or above it, is left out: it
    /// would move farther than any of its findings says.
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
            let Some((first, oldest)) = cluster.first().and_then(|id| Some((*id, place(id)?))) else { return false };
            let is_there = |id: &PointId| place(id).is_none_or(|one| (one - oldest).norm() < limit);
            cluster.iter().all(|id| is_there(id) && are_on_one_floor(map, first, *id))
        };
        let mut clusters: Vec<Cluster> = (by_root.into_iter().filter(|nodes| !nodes.is_empty()))
            .map(|nodes| {
                let told = (nodes.len() > crowd::MOST).then(FxHashSet::default);
                Cluster { close: is_close(&nodes), lanes: BTreeSet::new(), told, nodes }
            })
            .collect();
        let of_node = clusters.iter().enumerate();
        let of_node = of_node.flat_map(|(at, cluster)| cluster.nodes.iter().map(move |&id| (id, at)));
        let of_node: FxHashMap<PointId, usize> = of_node.collect();
        for pair in pairs {
            let Some(cluster) = of_node.get(&pair[0]).and_then(|&at| clusters.get_mut(at)) else { continue };
            let most = if cluster.close { 1 } else { crowd::MOST };
            if let Some(told) = cluster.told.as_mut().filter(|told| told.len() < most) {
                told.insert(pair);
            }
        }
        Self { of_node, clusters }
    }

    /// The same, where it is known which lanes each pair keeps apart.
    pub fn between<'a>(mut self, pairs: impl Iterator<Item = ([PointId; 2], &'a [[usize; 2]])>) -> Self {
        for (pair, lanes) in pairs {
            if let Some(cluster) = self.of_node.get(&pair[0]).and_then(|&at| self.clusters.get_mut(at)) {
                cluster.lanes.extend(lanes.iter().flatten());
            }
        }
        self
    }

    fn of_pair(&self, pair: [PointId; 2]) -> Option<&Cluster> {
        self.of_node.get(&pair[0]).and_then(|&at| self.clusters.get(at))
    }

    /// Whether a pair has a finding of its own. Of many nodes at one place one finding tells for all, or the first ones do.
    pub fn tells(&self, pair: [PointId; 2]) -> bool {
        let told = self.of_pair(pair).and_then(|cluster| cluster.told.as_ref());
        told.is_none_or(|told| told.contains(&pair))
    }

    /// The finding that two nodes are to be one, with the fix that makes one of all of their cluster; it names all lanes that connect then.
    pub fn made_one(&self, map: &MapIndex, mut finding: Finding, pair: [PointId; 2]) -> Finding {
        let cluster = self.of_pair(pair);
        if let Some(Cluster { nodes, told: Some(_), .. }) = cluster {
            let many = crowd::too_many(nodes.len(), "nodes lie so close to each other");
            finding.message = format!("{} {many}", finding.message);
        }
        let lanes = cluster
            .into_iter()
            .filter(|cluster| cluster.lanes.len() <= crowd::MOST)
            .flat_map(|cluster| &cluster.lanes)
            .map(|&at| Subject::Lanelet(map.lanes[at].id.0));
        for lane in lanes {
            if !finding.related.iter().any(|one| one.subject == lane) {
                finding = finding.with(lane, "connects there, too");
            }
        }
        let together = cluster.filter(|cluster| cluster.close);
        let [to, from @ ..] = together.map_or(&pair[..], |cluster| &cluster.nodes) else { return finding };
        let edits: Vec<Edit> = from.iter().map(|one| Edit::MergePoints { from: one.0, to: to.0 }).collect();
        let names: Vec<String> = from.iter().map(ToString::to_string).collect();
        finding.fixed_by(format!("use node {to} instead of {}", names.join(", ")), true, edits)
    }
}
/// The nodes at which the border of a lanelet begins and ends, the lower id first: were they one, the lanelet would be gone. A border
/// without length is no lanelet's yet.
pub fn ends_of_borders(map: &MapIndex) -> FxHashSet<[PointId; 2]> {
    let sides = |lane: &Lane| {
        let (start, end) = (lane.start, lane.end);
        let has_length = move |side: &usize| (end.points[*side] - start.points[*side]).norm() > Polyline::MERGE;
        [0, 1].into_iter().filter(has_length).map(move |side| [start.ids[side], end.ids[side]])
    };
    map.lanes.iter().flat_map(sides).map(|[a, b]| [a.min(b), a.max(b)]).collect()
}
