//! Maps roads and intersections of a network to those of an earlier state of it, so that unchanged parts are not drawn again.

use rustc_hash::FxHashMap;

use super::{IntersectionIx, RoadEnd, RoadIx, RoadKey, RoadNetwork};

/// The keys and arms of a network, to compare it with a later one.
pub struct NetworkSnapshot {
    roads: Vec<RoadKey>,
    /// The nodes of every intersection, and the roads that ended there.
    intersections: Vec<(Vec<i64>, Vec<RoadEnd>)>,
}

impl NetworkSnapshot {
    /// The snapshot of a network.
    pub fn of(network: &RoadNetwork) -> Self {
        Self {
            roads: network.roads.iter().map(|road| road.key).collect(),
            intersections: network.intersections.iter().map(|i| (i.nodes.clone(), i.arms.clone())).collect(),
        }
    }

    /// The roads that ended at an intersection.
    pub fn arms(&self, ix: IntersectionIx) -> &[RoadEnd] {
        &self.intersections[ix].1
    }
}

/// The old and new indices of roads and intersections.
pub struct NetworkDiff {
    /// The old index by new road; `None` if there was none.
    of: Vec<Option<RoadIx>>,
    /// The new index by old road.
    now: Vec<Option<RoadIx>>,
    /// The old index of the same nodes by new intersection.
    intersections: Vec<Option<IntersectionIx>>,
    /// Whether the same roads end there, by new intersection.
    untouched: Vec<bool>,
}

impl NetworkDiff {
    /// Compares a network with an earlier one; the roads of both are sorted by key.
    pub fn between(before: &NetworkSnapshot, network: &RoadNetwork) -> Self {
        let mut now = vec![None; before.roads.len()];
        let mut of = Vec::with_capacity(network.roads.len());
        for road in &network.roads {
            let old = before.roads.binary_search(&road.key).ok();
            if let Some(old) = old {
                now[old] = Some(RoadIx::new(of.len()));
            }
            of.push(old.map(RoadIx::new));
        }
        let nodes = before.intersections.iter().map(|(nodes, _)| &nodes[..]);
        let known: FxHashMap<&[i64], u32> = nodes.zip(0..).collect();
        let same_nodes = network.intersections.iter().map(|i| known.get(&i.nodes[..]).copied().map(IntersectionIx));
        let intersections: Vec<_> = same_nodes.collect();
        let mut diff = Self { of, now, intersections, untouched: Vec::new() };
        let untouched = network.intersections.iter().zip(&diff.intersections).map(|(new, old)| {
            let old_arms = old.map(|old| before.arms(old));
            old_arms.is_some_and(|old| new.arms.iter().map(|arm| diff.of_end(*arm)).eq(old.iter().copied().map(Some)))
        });
        diff.untouched = untouched.collect();
        diff
    }

    /// The old indices of all roads, by their new ones; `None` if a road is new.
    pub fn roads(&self) -> impl Iterator<Item = (RoadIx, Option<RoadIx>)> {
        self.of.iter().enumerate().map(|(new, old)| (RoadIx::new(new), *old))
    }

    /// The old index of a road; `None` if it is new.
    pub fn of(&self, road: RoadIx) -> Option<RoadIx> {
        self.of[road]
    }

    /// A road end with the old index of its road; `None` if the road is new.
    pub fn of_end(&self, arm: RoadEnd) -> Option<RoadEnd> {
        Some(RoadEnd { road: self.of(arm.road)?, ..arm })
    }

    /// The new index of an old road; `None` if it is gone.
    pub fn now(&self, road: RoadIx) -> Option<RoadIx> {
        self.now[road]
    }

    /// The old index of the intersection with the same nodes.
    pub fn of_intersection(&self, ix: IntersectionIx) -> Option<IntersectionIx> {
        self.intersections[ix]
    }

    /// The old index of the intersection with the same nodes and the same arms.
    pub fn untouched(&self, ix: IntersectionIx) -> Option<IntersectionIx> {
        self.of_intersection(ix).filter(|_| self.untouched[ix])
    }
}
