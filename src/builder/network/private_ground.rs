//! Makes the roads private that only gates with `access=private` lead to.

use rustc_hash::FxHashSet;

use super::{End, IntersectionIx, RoadEnd, RoadIx, RoadNetwork};

/// Most length of road, metres, that counts as ground behind a gate: beyond it lies a quarter with streets of its own.
const MOST: f64 = 1_000.0;

/// Takes from the public the roads behind the gates at these nodes: those on a side of a gate from which no other road leads
/// on, while on another side it does.
pub(super) fn close(network: &mut RoadNetwork, gates: &FxHashSet<i64>) {
    let is_gate = |at: IntersectionIx| network.intersection(at).nodes.iter().any(|node| gates.contains(node));
    let mut private: Vec<RoadIx> = Vec::new();
    for gate in IntersectionIx::all(network.intersections.len()).filter(|&at| is_gate(at)) {
        let arms = &network.intersection(gate).arms;
        let sides: Vec<Option<FxHashSet<RoadIx>>> =
            arms.iter().map(|arm| behind(network, arm.road, &is_gate)).collect();
        if sides.iter().any(Option::is_none) {
            private.extend(sides.into_iter().flatten().flatten());
        }
    }
    for road in private {
        network.roads[road].public = false;
    }
}

/// All roads that are connected with this one without a gate between them; `None` if they are more than [`MOST`] or the map
/// ends among them.
fn behind(network: &RoadNetwork, road: RoadIx, is_gate: &impl Fn(IntersectionIx) -> bool) -> Option<FxHashSet<RoadIx>> {
    let (mut found, mut to_visit, mut length) = (FxHashSet::default(), vec![road], 0.0);
    while let Some(road) = to_visit.pop() {
        if !found.insert(road) {
            continue;
        }
        length += network.road(road).line.length();
        if length > MOST {
            return None;
        }
        for at in End::BOTH.map(|end| network.intersection_at(RoadEnd { road, end })) {
            if network.intersection(at).map_edge {
                return None;
            }
            if !is_gate(at) {
                to_visit.extend(network.intersection(at).arms.iter().map(|arm| arm.road));
            }
        }
    }
    Some(found)
}
