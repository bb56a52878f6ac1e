//! A network while roads are joined two by two: what named the old roads is renamed once, at the end.

use rustc_hash::FxHashMap;

use crate::builder::network::{
    End, Intersection, IntersectionIx, LaneConnection, Road, RoadEnd, RoadIx, RoadKey, RoadNetwork, TurnRestriction,
};

/// A network under change. Indices of intersections stay until [`Edit::finish`]; a joined road takes a new index.
pub struct NetworkEdit {
    network: RoadNetwork,
    gone: Vec<bool>,
    /// For each end of a road that is gone: the end that took its place, if any did.
    renames: FxHashMap<RoadEnd, Option<RoadEnd>>,
}

impl NetworkEdit {
    /// Starts with the whole network.
    pub fn new(network: RoadNetwork) -> Self {
        let gone = vec![false; network.roads.len()];
        Self { network, gone, renames: FxHashMap::default() }
    }

    /// The road of this index, gone or not.
    pub fn road(&self, ix: RoadIx) -> &Road {
        self.network.road(ix)
    }

    /// The intersection of this index with its arms as they are by now.
    pub fn intersection(&self, ix: IntersectionIx) -> &Intersection {
        self.network.intersection(ix)
    }

    /// All intersections.
    pub fn intersections(&self) -> impl Iterator<Item = IntersectionIx> + use<> {
        (0..self.network.intersections.len() as u32).map(IntersectionIx)
    }

    /// Puts `road` in the place of two roads. `place` tells which end of it takes the place of an end of theirs.
    pub fn join(&mut self, old: [RoadIx; 2], road: Road, place: impl Fn(RoadEnd) -> Option<End>) {
        let new = RoadIx(self.network.roads.len() as u32);
        self.network.roads.push(road);
        self.gone.push(false);
        self.replace(&old, |end| place(end).map(|end| RoadEnd { road: new, end }));
    }

    /// Takes a road away.
    pub fn remove(&mut self, road: RoadIx) {
        self.replace(&[road], |_| None);
    }

    fn replace(&mut self, old: &[RoadIx], place: impl Fn(RoadEnd) -> Option<RoadEnd>) {
        let mut touched = vec![];
        for &ix in old {
            self.gone[ix] = true;
            touched.extend([self.road(ix).from, self.road(ix).to]);
            for end in End::BOTH {
                let end = RoadEnd { road: ix, end };
                self.renames.insert(end, place(end));
            }
        }
        touched.sort();
        touched.dedup();
        for ix in touched {
            let arms = std::mem::take(&mut self.network.intersections[ix].arms);
            let mut arms: Vec<RoadEnd> = arms.into_iter().filter_map(|arm| self.renamed(arm)).collect();
            arms.dedup();
            if arms.len() > 1 && arms.first() == arms.last() {
                arms.pop();
            }
            self.network.intersections[ix].arms = arms;
        }
    }

    /// What an end is called by now; `None` if nothing took its place.
    fn renamed(&self, end: RoadEnd) -> Option<RoadEnd> {
        renamed(&self.renames, end)
    }

    /// The network that is left, its roads in order of their keys, without intersections that have no road.
    pub fn finish(self) -> RoadNetwork {
        let Self { network, gone, renames } = self;
        if renames.is_empty() && is_finished(&network) {
            return network;
        }
        let RoadNetwork { roads, intersections, restrictions, connections, .. } = network;
        let mut place = vec![None; roads.len()];
        // Roads are large: they are moved once, to where they belong.
        let mut left: Vec<(RoadKey, usize)> = Vec::with_capacity(roads.len());
        left.extend((roads.iter().map(|road| road.key).zip(0..)).filter(|(_, old)| !gone[*old]));
        left.sort_unstable();
        left.iter().zip(0..).for_each(|((_, old), new)| place[*old] = Some(RoadIx(new)));
        let renamed = |end: RoadEnd| {
            let end = renamed(&renames, end)?;
            Some(RoadEnd { road: place[end.road]?, end: end.end })
        };
        let mut kept: Vec<Intersection> = Vec::with_capacity(intersections.len());
        let mut moved: Vec<IntersectionIx> = Vec::with_capacity(intersections.len());
        for mut intersection in intersections {
            moved.push(IntersectionIx(kept.len() as u32));
            if intersection.arms.is_empty() {
                continue;
            }
            intersection.arms = intersection.arms.iter().filter_map(|arm| renamed(*arm)).collect();
            if let Some(passages) = &mut intersection.passages {
                *passages = passages.iter().filter_map(|(a, b)| Some((renamed(*a)?, renamed(*b)?))).collect();
                passages.sort();
                passages.dedup();
            }
            kept.push(intersection);
        }
        let moved = |at: IntersectionIx| moved[at];
        let mut roads: Vec<Option<Road>> = roads.into_iter().map(Some).collect();
        let roads = left.iter().filter_map(|(_, old)| {
            let mut road = roads[*old].take()?;
            (road.from, road.to) = (moved(road.from), moved(road.to));
            Some(road)
        });
        let restricted = |mut r: TurnRestriction| {
            let mut via = Vec::new();
            for road in &r.via {
                // A road that was joined lives on under both its ends, or under one of them.
                let [start, end] = End::BOTH.map(|end| renamed(RoadEnd { road: *road, end }));
                via.push(start.or(end)?.road);
            }
            via.dedup();
            (r.from, r.to, r.via) = (renamed(r.from)?, renamed(r.to)?, via);
            Some(r)
        };
        let connected = |c: LaneConnection| Some(LaneConnection { from: renamed(c.from)?, to: renamed(c.to)?, ..c });
        RoadNetwork {
            roads: roads.collect(),
            intersections: kept,
            restrictions: restrictions.into_iter().filter_map(restricted).collect(),
            connections: connections.into_iter().filter_map(connected).collect(),
            ..network
        }
    }
}

/// Whether a network is as [`Edit::finish`] leaves one.
fn is_finished(network: &RoadNetwork) -> bool {
    network.roads.is_sorted_by_key(|road| road.key) && network.intersections.iter().all(|at| !at.arms.is_empty())
}

/// What an end is called after all renames; `None` if nothing took its place.
fn renamed(renames: &FxHashMap<RoadEnd, Option<RoadEnd>>, mut end: RoadEnd) -> Option<RoadEnd> {
    while let Some(next) = renames.get(&end) {
        end = (*next)?;
    }
    Some(end)
}
