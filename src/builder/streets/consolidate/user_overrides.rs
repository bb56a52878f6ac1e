//! Decisions of the user about merging.

use rustc_hash::FxHashMap;

use crate::builder::network::{IntersectionIx, Road, RoadIx, RoadNetwork};
use crate::geometry::Point;

/// A decision of the user about some roads.
#[derive(Clone, Debug, PartialEq)]
pub struct MergeOverride {
    /// Which roads.
    pub of: OverrideTarget,
    /// Whether they lie inside an intersection.
    pub merge: bool,
}

/// The roads of an override.
#[derive(Clone, Debug, PartialEq)]
pub enum OverrideTarget {
    /// Those made from an OpenStreetMap way.
    Way(i64),
    /// Those between any two of these OpenStreetMap nodes.
    Nodes(Vec<i64>),
    /// The one nearest to this point, local metres.
    Near(Point),
}

/// The largest distance of a road from the point, metres.
const ROAD_AT_POINT: f64 = 10.0;

/// For each road the index of its first override.
pub fn overridden(network: &RoadNetwork, wishes: &[MergeOverride]) -> FxHashMap<RoadIx, usize> {
    let mut found = FxHashMap::default();
    for (i, wish) in wishes.iter().enumerate() {
        for road in targets(network, &wish.of) {
            found.entry(road).or_insert(i);
        }
    }
    found
}

fn targets(network: &RoadNetwork, target: &OverrideTarget) -> Vec<RoadIx> {
    let roads = RoadIx::all(network.roads.len());
    match target {
        OverrideTarget::Way(way) => roads.filter(|ix| network.road(*ix).ways.contains(way)).collect(),
        OverrideTarget::Nodes(nodes) => {
            let holds = |ix: IntersectionIx| network.intersection(ix).nodes.iter().any(|node| nodes.contains(node));
            let is_between = |road: &Road| road.from != road.to && holds(road.from) && holds(road.to);
            roads.filter(|ix| is_between(network.road(*ix))).collect()
        }
        OverrideTarget::Near(point) => {
            let nearest = roads.map(|ix| (network.road(ix).line.distance(*point), ix));
            let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            nearest.filter(|(distance, _)| *distance <= ROAD_AT_POINT).map(|(_, ix)| ix).into_iter().collect()
        }
    }
}
