//! Makes the roads private that only gates with `access=private` lead to.

use rustc_hash::FxHashSet;

use super::{End, IntersectionIx, RoadEnd, RoadIx, RoadNetwork};

/// Most length of road, metres, that counts as ground behind a gate: beyond it lies a quarter with streets of its own.
const MOST: f64 = 1_000.0;
/// How far that ground may reach from its gate, metres, as the crow flies. So whether a road is private depends on roads within
/// twice this distance, however large the map is.
const PRIVATE_WAY: f64 = 250.0;

/// Takes from the public the roads behind the gates at these nodes: those on a side of a gate from which no other road leads
/// on, while on another side it does.
pub(super) fn close(network: &mut RoadNetwork, gates: &FxHashSet<i64>) {
    let is_gate = |at: IntersectionIx| network.intersection(at).nodes.iter().any(|node| gates.contains(node));
    let mut private: Vec<RoadIx> = Vec::new();
    for gate in IntersectionIx::all(network.intersections.len()).filter(|&at| is_gate(at)) {
        let arms = &network.intersection(gate).arms;
        let sides: Vec<Option<FxHashSet<RoadIx>>> = arms.iter().map(|arm| behind(network, *arm, &is_gate)).collect();
        if sides.iter().any(Option::is_none) {
            private.extend(sides.into_iter().flatten().flatten());
        }
    }
    for road in private {
        network.roads[road].public = false;
    }
}

/// The roads that lie behind a gate: the road that leaves it here, and all that are connected with it without another gate
/// between them. `None` if they are longer than [`MOST`], reach farther than [`PRIVATE_WAY`], or the map ends among them.
fn behind(
    network: &RoadNetwork,
    gate: RoadEnd,
    is_gate: &impl Fn(IntersectionIx) -> bool,
) -> Option<FxHashSet<RoadIx>> {
    let place = network.intersection(network.intersection_at(gate)).position;
    let (mut found, mut to_visit, mut length) = (FxHashSet::default(), vec![gate.road], 0.0);
    while let Some(road) = to_visit.pop() {
        if !found.insert(road) {
            continue;
        }
        let line = &network.road(road).line;
        length += line.length();
        if length > MOST || line.points().iter().any(|point| (point - place).norm() > PRIVATE_WAY) {
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
