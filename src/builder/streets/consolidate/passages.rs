//! Which arm of a merged intersection leads to which: paths over its inner roads, as signs and directions allow.

use crate::builder::network::road_end::{leads_in, leads_out, other_end};
use crate::builder::network::{IntersectionIx, RoadEnd, RoadIx, RoadNetwork, TurnRestriction};

use rustc_hash::FxHashMap;

/// Longer searches than this end: a cluster with so many paths is damaged data, and what was found stands.
const MAX_STEPS: usize = 20_000;

/// Turn restrictions by the road end where they begin.
pub struct Rules<'a>(FxHashMap<RoadEnd, Vec<&'a TurnRestriction>>);

impl<'a> Rules<'a> {
    /// An index over all restrictions of a network.
    pub fn new(restrictions: &'a [TurnRestriction]) -> Self {
        let mut index: FxHashMap<RoadEnd, Vec<&TurnRestriction>> = FxHashMap::default();
        for restriction in restrictions {
            index.entry(restriction.from).or_default().push(restriction);
        }
        Self(index)
    }

    fn from(&self, arrival: RoadEnd) -> &[&'a TurnRestriction] {
        self.0.get(&arrival).map_or(&[], Vec::as_slice)
    }
}

/// The pairs of outer arms that a vehicle can drive between. `members` are the intersections that merge, `inner`
/// tells whether a road lies inside.
pub fn passages(
    network: &RoadNetwork,
    members: &[IntersectionIx],
    inner: &dyn Fn(RoadIx) -> bool,
    rules: &Rules<'_>,
) -> Vec<(RoadEnd, RoadEnd)> {
    let mut found = Vec::new();
    for &member in members {
        for &arm in &network.intersection(member).arms {
            if !inner(arm.road) && leads_in(network, arm) {
                let mut search =
                    Search { network, members, inner, rules, path: vec![arm], found: Vec::new(), steps: 0 };
                search.extend(member);
                search.found.sort();
                search.found.dedup();
                found.extend(search.found.into_iter().map(|to| (arm, to)));
            }
        }
    }
    found.sort();
    found
}

/// A depth-first walk over simple paths: no intersection twice.
struct Search<'a> {
    network: &'a RoadNetwork,
    members: &'a [IntersectionIx],
    inner: &'a dyn Fn(RoadIx) -> bool,
    rules: &'a Rules<'a>,
    /// Road ends where the vehicle arrived, the outer arm first.
    path: Vec<RoadEnd>,
    found: Vec<RoadEnd>,
    steps: usize,
}

impl Search<'_> {
    fn extend(&mut self, at: IntersectionIx) {
        self.steps += 1;
        if self.steps > MAX_STEPS {
            return;
        }
        let network = self.network;
        for &next in &network.intersection(at).arms {
            let came_from = self.path[self.path.len() - 1];
            if next.road == came_from.road || !leads_out(network, next) || !self.allowed(at, next) {
                continue;
            }
            if !(self.inner)(next.road) {
                self.found.push(next);
                continue;
            }
            let arrival = other_end(next);
            let there = network.road(next.road).intersection(arrival.end);
            let seen = there == at
                || self.path[1..].iter().any(|e| network.road(e.road).intersection(other_end(*e).end) == there);
            if !seen && self.members.contains(&there) {
                self.path.push(arrival);
                self.extend(there);
                self.path.pop();
            }
        }
    }

    /// Whether the restrictions let the path go on over `next`.
    fn allowed(&self, at: IntersectionIx, next: RoadEnd) -> bool {
        if let Some(passages) = &self.network.intersection(at).passages {
            let came_from = self.path[self.path.len() - 1];
            if !passages.contains(&(came_from, next)) {
                return false;
            }
        }
        self.path.iter().enumerate().all(|(i, arrival)| {
            let behind = &self.path[i + 1..];
            self.rules.from(*arrival).iter().all(|r| allows(r, behind, next))
        })
    }
}

/// Whether a restriction whose `from` was taken lets a path go on over `next`; `behind` are the arrivals since then.
fn allows(restriction: &TurnRestriction, behind: &[RoadEnd], next: RoadEnd) -> bool {
    let along = behind.len() <= restriction.via.len()
        && behind.iter().zip(&restriction.via).all(|(arrival, via)| arrival.road == *via);
    if !along {
        return true;
    }
    match restriction.via.get(behind.len()) {
        // Still on the way through its `via` roads: a mandatory turn leaves no other way.
        Some(via) => !restriction.only || next.road == *via,
        None => restriction.only == (next == restriction.to),
    }
}
