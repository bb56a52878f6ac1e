//! Lights between intersections: those that belong to no intersection hold vehicles where people cross, or where they stand.

use rustc_hash::FxHashSet;

use super::road_end::from_cut;
use super::signal_assignment::{approaches, controls_arm, is_crossing};
use super::{End, FeatureKind, IntersectionIx, Road, RoadEnd, RoadIx, RoadNetwork};

/// Lights belong to a crossing within this distance along the road, metres.
const LIGHT_FROM_CROSSING: f64 = 15.0;

/// Gives each light that no intersection has to the nearest crossing, which then has lights, or makes it one by itself. Where two
/// roads meet there is no intersection for lights.
pub(super) fn find(network: &mut RoadNetwork) {
    let assigned = assigned(network);
    let mut lit = Vec::new();
    let mut alone = Vec::new();
    for (ix, road) in RoadIx::all(network.roads.len()).zip(&network.roads) {
        for (i, feature) in road.features.iter().enumerate() {
            let is_free = matches!(feature.kind, FeatureKind::Signals(_)) && !assigned.contains(&feature.node);
            if is_free && !is_at_junction(network, road, feature.node) {
                match crossing_nearby(network, ix, feature.station) {
                    Some(crossing) => lit.push(crossing),
                    None => alone.push((ix, i)),
                }
            }
        }
    }
    for (road, i) in lit {
        if let FeatureKind::Crossing { signals, .. } = &mut network.roads[road].features[i].kind {
            *signals = true;
        }
    }
    for (road, i) in alone {
        let kind = &mut network.roads[road].features[i].kind;
        if let FeatureKind::Signals(travel) = *kind {
            *kind = FeatureKind::MidBlockSignals(travel);
        }
    }
    network.intersections.iter_mut().filter(|at| at.arms.len() == 2).for_each(|at| at.signals = false);
}

/// The nodes of the lights that stand before intersections.
fn assigned(network: &RoadNetwork) -> FxHashSet<i64> {
    let mut nodes = FxHashSet::default();
    let junctions = IntersectionIx::all(network.intersections.len()).filter(|ix| is_crossing(network, *ix));
    for arm in junctions.flat_map(|ix| approaches(network, ix)) {
        controls_arm(network, arm, |feature| {
            if matches!(feature.kind, FeatureKind::Signals(_)) {
                nodes.insert(feature.node);
            }
            false
        });
    }
    nodes
}

/// Whether the node is an end of the road where it does not just go on as one other road: an intersection, or a dead end.
fn is_at_junction(network: &RoadNetwork, road: &Road, node: i64) -> bool {
    let ends = End::BOTH.into_iter().filter(|end| road.node(*end) == node);
    ends.map(|end| network.intersection(road.intersection(end))).any(|at| at.arms.len() != 2)
}

/// The nearest crossing to a station of a road, as its road and number among the road's features. It may lie on the road that goes
/// on from there.
fn crossing_nearby(network: &RoadNetwork, ix: RoadIx, station: f64) -> Option<(RoadIx, usize)> {
    let road = network.road(ix);
    let whole = [0.0, road.line.length()];
    let own = crossings(network, ix).map(|(i, place)| (ix, i, (place - station).abs()));
    let beyond = End::BOTH.into_iter().filter_map(|end| {
        let arm = RoadEnd { road: ix, end };
        let at = network.intersection(network.intersection_at(arm));
        let next = at.arms.iter().find(|next| **next != arm)?;
        (at.arms.len() == 2).then_some((*next, from_cut(whole, end, station)))
    });
    let beyond = beyond.flat_map(|(next, before)| {
        let whole = [0.0, network.road(next.road).line.length()];
        crossings(network, next.road).map(move |(i, place)| (next.road, i, before + from_cut(whole, next.end, place)))
    });
    let near = own.chain(beyond).filter(|(.., distance)| *distance <= LIGHT_FROM_CROSSING);
    near.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(road, i, _)| (road, i))
}

/// The crossings of a road: the number among its features, and the station.
fn crossings(network: &RoadNetwork, ix: RoadIx) -> impl Iterator<Item = (usize, f64)> + '_ {
    let features = network.road(ix).features.iter().enumerate();
    features
        .filter(|(_, feature)| matches!(feature.kind, FeatureKind::Crossing { .. }))
        .map(|(i, one)| (i, one.station))
}
