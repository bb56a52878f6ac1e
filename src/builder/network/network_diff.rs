//! What the roads and intersections of a network were in the one that it followed from, when some roads were taken into
//! intersections or left out: all that stays as it was need not be made again.

use rustc_hash::FxHashMap;

use super::{IntersectionIx, RoadEnd, RoadIx, RoadKey, RoadNetwork};

/// What is known of a network after others followed from it.
pub struct NetworkSnapshot {
    roads: Vec<RoadKey>,
    /// The nodes of every intersection, and the roads that ended there.
    intersections: Vec<(Vec<i64>, Vec<RoadEnd>)>,
}

impl NetworkSnapshot {
    /// What is to be known of a network.
    pub fn of(network: &RoadNetwork) -> Self {
        Self {
            roads: network.roads.iter().map(|road| road.key).collect(),
            intersections: network.intersections.iter().map(|at| (at.nodes.clone(), at.arms.clone())).collect(),
        }
    }

    /// The roads that ended at an intersection.
    pub fn arms(&self, ix: IntersectionIx) -> &[RoadEnd] {
        &self.intersections[ix].1
    }
}

/// The indices of roads and intersections before and after.
pub struct NetworkDiff {
    /// Per road of now.
    of: Vec<RoadIx>,
    /// Per road of before.
    now: Vec<Option<RoadIx>>,
    /// Per intersection of now: the one of the same nodes.
    intersections: Vec<Option<IntersectionIx>>,
    /// Per intersection of now: whether the same roads end there.
    untouched: Vec<bool>,
}

impl NetworkDiff {
    /// Compares a network with the one before, among whose roads all of its roads were; both are in order of their keys.
    pub fn between(before: &NetworkSnapshot, network: &RoadNetwork) -> Self {
        let mut now = vec![None; before.roads.len()];
        let mut of = Vec::with_capacity(network.roads.len());
        for road in &network.roads {
            let was = before.roads.partition_point(|old| *old < road.key);
            now[was] = Some(RoadIx(of.len() as u32));
            of.push(RoadIx::new(was));
        }
        let nodes = before.intersections.iter().map(|(nodes, _)| &nodes[..]);
        let known: FxHashMap<&[i64], u32> = nodes.zip(0..).collect();
        let same_nodes = network.intersections.iter().map(|at| known.get(&at.nodes[..]).copied().map(IntersectionIx));
        let intersections: Vec<_> = same_nodes.collect();
        let mut origins = Self { of, now, intersections, untouched: Vec::new() };
        let untouched = network.intersections.iter().zip(&origins.intersections).map(|(at, was)| {
            let arms = was.map_or(&[][..], |was| before.arms(was));
            let same = |(arm, was): (&RoadEnd, &RoadEnd)| origins.of_end(*arm) == *was;
            was.is_some() && at.arms.len() == arms.len() && at.arms.iter().zip(arms).all(same)
        });
        origins.untouched = untouched.collect();
        origins
    }

    /// What a road was before.
    pub fn of(&self, road: RoadIx) -> RoadIx {
        self.of[road]
    }

    /// What an end of a road was before.
    pub fn of_end(&self, at: RoadEnd) -> RoadEnd {
        RoadEnd { road: self.of(at.road), ..at }
    }

    /// What a road is now; `None` if it is gone.
    pub fn now(&self, road: RoadIx) -> Option<RoadIx> {
        self.now[road]
    }

    /// The roads of before that are gone.
    pub fn gone(&self) -> impl Iterator<Item = RoadIx> {
        self.now.iter().zip(0..).filter(|(now, _)| now.is_none()).map(|(_, was)| RoadIx(was))
    }

    /// What an intersection of the same nodes was before.
    pub fn of_intersection(&self, ix: IntersectionIx) -> Option<IntersectionIx> {
        self.intersections[ix]
    }

    /// What an intersection was before, if it is of the same nodes and the same roads end there.
    pub fn untouched(&self, ix: IntersectionIx) -> Option<IntersectionIx> {
        self.of_intersection(ix).filter(|_| self.untouched[ix])
    }
}
