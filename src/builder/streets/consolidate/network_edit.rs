//! A network while roads are joined or removed. References to old roads are renamed once, at the end.

use crate::builder::network::{
    End, Intersection, IntersectionIx, Road, RoadEnd, RoadIx, RoadKey, RoadNetwork, TurnRestriction,
};
use crate::geometry::Point;

use rustc_hash::FxHashSet;

use super::renames::Renames;

/// A network under change. Indices of intersections stay until [`NetworkEdit::finish`]; a joined road gets a new index.
pub struct NetworkEdit {
    network: RoadNetwork,
    gone: Vec<bool>,
    renames: Renames,
}

impl NetworkEdit {
    /// Starts with the unchanged network.
    pub fn new(network: RoadNetwork) -> Self {
        let gone = vec![false; network.roads.len()];
        Self { network, gone, renames: Renames::default() }
    }

    /// The road of this index, gone or not.
    pub fn road(&self, ix: RoadIx) -> &Road {
        self.network.road(ix)
    }

    /// The intersection of this index with its current arms.
    pub fn intersection(&self, ix: IntersectionIx) -> &Intersection {
        self.network.intersection(ix)
    }

    /// All intersections.
    pub fn intersections(&self) -> impl Iterator<Item = IntersectionIx> + use<> {
        IntersectionIx::all(self.network.intersections.len())
    }

    /// Replaces two roads by `road`. `place` maps an end of theirs to the end of it that takes its place.
    pub fn join(&mut self, old: [RoadIx; 2], road: Road, place: impl Fn(RoadEnd) -> Option<End>) {
        let new = RoadIx::new(self.network.roads.len());
        self.network.roads.push(road);
        self.gone.push(false);
        self.replace(&old, |end| place(end).map(|end| RoadEnd { road: new, end }));
    }

    /// The intersections where a restriction forbids to go on: roads that meet there stay apart.
    ///
    /// Of a restriction over roads that nothing else joins this is the last one.
    pub fn forbidden_joints(&self) -> FxHashSet<IntersectionIx> {
        let network = &self.network;
        let is_joint = |ix: IntersectionIx| network.intersection(ix).arms.len() == 2;
        let forbids = network.restrictions.iter().filter(|r| !r.only && r.from.road != r.to.road);
        let joints = forbids.filter_map(|r| {
            let inner = r.via.iter().flat_map(|road| [network.road(*road).from, network.road(*road).to]);
            inner.chain([network.intersection_at(r.from)]).all(is_joint).then(|| network.intersection_at(r.to))
        });
        joints.collect()
    }

    /// Replaces a road by two pieces along its line, which meet at a new node.
    pub fn divide(&mut self, old: RoadIx, pieces: [Road; 2], (node, position): (i64, Point)) {
        let between = IntersectionIx::new(self.network.intersections.len());
        let [first, second] = [0, 1].map(|i| RoadIx::new(self.network.roads.len() + i));
        let [mut before, mut behind] = pieces;
        (before.to, behind.from) = (between, between);
        let mut arms = vec![RoadEnd { road: first, end: End::End }, RoadEnd { road: second, end: End::Start }];
        if behind.key < before.key {
            arms.reverse();
        }
        self.network.roads.extend([before, behind]);
        self.gone.extend([false; 2]);
        self.network.intersections.push(Intersection::of_arms(vec![node], position, arms));
        self.replace(&[old], |end| {
            Some(match end.end {
                End::Start => RoadEnd { road: first, end: End::Start },
                End::End => RoadEnd { road: second, end: End::End },
            })
        });
    }

    /// Removes a road.
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
                self.renames.replaced.insert(end, place(end));
            }
        }
        touched.sort();
        touched.dedup();
        for ix in touched {
            let arms = std::mem::take(&mut self.network.intersections[ix].arms);
            let mut arms: Vec<RoadEnd> = arms.into_iter().filter_map(|arm| self.renames.latest(arm)).collect();
            arms.dedup();
            if arms.len() > 1 && arms.first() == arms.last() {
                arms.pop();
            }
            self.network.intersections[ix].arms = arms;
        }
    }

    /// The remaining network: roads in order of their keys, no intersections without roads.
    pub fn finish(self) -> RoadNetwork {
        let Self { network, gone, mut renames } = self;
        if renames.replaced.is_empty() && is_finished(&network) {
            return network;
        }
        let RoadNetwork { roads, mut intersections, restrictions, connections, .. } = network;
        renames.roads = vec![None; roads.len()];
        // Sorts the keys instead of the roads, which are large.
        let mut left: Vec<(RoadKey, usize)> = Vec::with_capacity(roads.len());
        left.extend((roads.iter().map(|road| road.key).zip(0..)).filter(|(_, old)| !gone[*old]));
        left.sort_unstable();
        left.iter().zip(0..).for_each(|((_, old), new)| renames.roads[*old] = Some(RoadIx(new)));
        let numbers = intersections.iter().scan(0, |next, intersection| {
            let number = *next;
            *next += u32::from(!intersection.arms.is_empty());
            Some(IntersectionIx(number))
        });
        renames.intersections = numbers.collect();
        intersections.retain(|intersection| !intersection.arms.is_empty());
        let restrictions = restrictions.into_iter().filter_map(|r| renamed_restriction(r, &renames, &roads)).collect();
        let mut roads: Vec<Option<Road>> = roads.into_iter().map(Some).collect();
        let roads = left.iter().filter_map(|(_, old)| {
            let mut road = roads[*old].take()?;
            renames.road(&mut road);
            Some(road)
        });
        RoadNetwork {
            roads: roads.collect(),
            intersections: intersections.into_iter().map(|i| with_sorted_passages(renames.intersection(i))).collect(),
            restrictions,
            connections: connections.into_iter().filter_map(|c| renames.connection(c)).collect(),
            ..network
        }
    }
}

/// Whether a network is as [`NetworkEdit::finish`] leaves it.
fn is_finished(network: &RoadNetwork) -> bool {
    network.roads.is_sorted_by_key(|road| road.key) && network.intersections.iter().all(|i| !i.arms.is_empty())
}

fn with_sorted_passages(mut intersection: Intersection) -> Intersection {
    if let Some(passages) = &mut intersection.passages {
        passages.sort();
        passages.dedup();
    }
    intersection
}

/// The restriction between the new arms; `None` if a road is gone. `roads` has all roads that ever were, at the intersections of
/// `renames`' start.
///
/// Where its first or its last road was joined with the road behind or before it, it begins or ends where that road does.
fn renamed_restriction(r: TurnRestriction, renames: &Renames, roads: &[Road]) -> Option<TurnRestriction> {
    let path = std::iter::once(r.from.road).chain(r.via.iter().copied()).chain([r.to.road]);
    let mut path = path.map(|road| renames.latest_road(road)).collect::<Option<Vec<RoadIx>>>()?;
    path.dedup();
    let [first, .., last] = path[..] else { return None };
    let [second, before_last] = [path[1], path[path.len() - 2]];
    let end = |arm: RoadEnd, road: RoadIx, beside: RoadIx| {
        renames.latest(arm).or_else(|| {
            let other = &roads[beside];
            let ends = End::BOTH.into_iter().find(|end| {
                let here = roads[road].intersection(*end);
                here == other.from || here == other.to
            });
            ends.map(|end| RoadEnd { road, end })
        })
    };
    let [from, to] =
        [(r.from, first, second), (r.to, last, before_last)].map(|(arm, road, beside)| end(arm, road, beside));
    let via = path[1..path.len() - 1].iter().map(|road| renames.roads[*road]).collect::<Option<Vec<RoadIx>>>()?;
    Some(TurnRestriction { from: renames.arm(from?)?, to: renames.arm(to?)?, via, ..r })
}
