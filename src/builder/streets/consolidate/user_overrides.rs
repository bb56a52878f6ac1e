//! Roads that the user decided.

use rustc_hash::FxHashMap;

use crate::builder::network::{IntersectionIx, RoadIx, RoadNetwork};
use crate::geometry::Point;

/// What a user wants of some roads, whatever the decision would be.
#[derive(Clone, Debug, PartialEq)]
pub struct MergeOverride {
    /// Which roads.
    pub of: OverrideTarget,
    /// `true`: they lie inside an intersection; `false`: they do not.
    pub merge: bool,
}

/// Which roads a wish is about.
#[derive(Clone, Debug, PartialEq)]
pub enum OverrideTarget {
    /// Those made from an OpenStreetMap way.
    Way(i64),
    /// Those between any two of these OpenStreetMap nodes.
    Nodes(Vec<i64>),
    /// The one nearest to a place in local metres.
    Near(Point),
}

/// A road further than this from a place, metres, is not the one that is meant.
const NEAR: f64 = 10.0;

/// Per road the wish about it, by its index; the first of several.
pub fn wished(network: &RoadNetwork, wishes: &[MergeOverride]) -> FxHashMap<RoadIx, usize> {
    let mut found = FxHashMap::default();
    for (i, wish) in wishes.iter().enumerate() {
        for road in meant(network, &wish.of) {
            found.entry(road).or_insert(i);
        }
    }
    found
}

fn meant(network: &RoadNetwork, wished: &OverrideTarget) -> Vec<RoadIx> {
    let roads = || (0..network.roads.len() as u32).map(RoadIx);
    match wished {
        OverrideTarget::Way(way) => roads().filter(|ix| network.road(*ix).ways.contains(way)).collect(),
        OverrideTarget::Nodes(nodes) => {
            let holds = |ix: IntersectionIx| network.intersection(ix).nodes.iter().any(|node| nodes.contains(node));
            let between = |ix: &RoadIx| {
                let road = network.road(*ix);
                road.from != road.to && holds(road.from) && holds(road.to)
            };
            roads().filter(between).collect()
        }
        OverrideTarget::Near(place) => {
            let nearest = roads().map(|ix| (network.road(ix).line.distance(*place), ix));
            let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            nearest.filter(|(distance, _)| *distance <= NEAR).map(|(_, ix)| ix).into_iter().collect()
        }
    }
}
