//! Which arm of a merged intersection leads to which: the allowed paths over its inner roads.

use crate::builder::network::road_end::{leads_in, leads_out, other_end};
use crate::builder::network::{IntersectionIx, RoadEnd, RoadIx, RoadNetwork, TurnRestriction};

use rustc_hash::FxHashMap;

/// The largest number of steps of a search: a cluster with more paths is damaged data.
const MAX_STEPS: usize = 20_000;

/// Turn restrictions by their `from` end.
pub struct RestrictionIndex<'a>(FxHashMap<RoadEnd, Vec<&'a TurnRestriction>>);

impl<'a> RestrictionIndex<'a> {
    /// The index of all restrictions of a network.
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

/// The pairs of outer arms (from, to) that a vehicle can drive between. `members` are the merged intersections; `inner` says
/// whether a road lies inside.
pub fn passages(
    network: &RoadNetwork,
    members: &[IntersectionIx],
    inner: &dyn Fn(RoadIx) -> bool,
    rules: &RestrictionIndex<'_>,
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

/// A depth-first search over simple paths.
struct Search<'a> {
    network: &'a RoadNetwork,
    members: &'a [IntersectionIx],
    inner: &'a dyn Fn(RoadIx) -> bool,
    rules: &'a RestrictionIndex<'a>,
    /// The road ends of arrival, the outer arm first.
    path: Vec<RoadEnd>,
    found: Vec<RoadEnd>,
    steps: usize,
}

impl Search<'_> {
    /// Extends the path by every arm of an intersection.
    fn extend(&mut self, here: IntersectionIx) {
        self.steps += 1;
        if self.steps > MAX_STEPS {
            return;
        }
        let network = self.network;
        for &next in &network.intersection(here).arms {
            let came_from = self.path[self.path.len() - 1];
            if next.road == came_from.road || !leads_out(network, next) || !self.allowed(here, next) {
                continue;
            }
            if !(self.inner)(next.road) {
                self.found.push(next);
                continue;
            }
            let arrival = other_end(next);
            let there = network.road(next.road).intersection(arrival.end);
            if there != here && !self.has_passed(there, next.road) && self.members.contains(&there) {
                self.path.push(arrival);
                self.extend(there);
                self.path.pop();
            }
        }
    }

    /// Whether the path has passed an intersection of one node, or this road. One of several nodes may be passed twice, over others of
    /// its nodes: its passages tell.
    fn has_passed(&self, there: IntersectionIx, road: RoadIx) -> bool {
        let passed = &self.path[1..];
        let is_there = |end: &RoadEnd| self.network.road(end.road).intersection(other_end(*end).end) == there;
        let one_node = self.network.intersection(there).nodes.len() == 1;
        passed.iter().any(|end| end.road == road || one_node && is_there(end))
    }

    /// Whether passages and restrictions let the path go on over `next`.
    fn allowed(&self, here: IntersectionIx, next: RoadEnd) -> bool {
        if let Some(passages) = &self.network.intersection(here).passages {
            let came_from = self.path[self.path.len() - 1];
            if !passages.contains(&(came_from, next)) {
                return false;
            }
        }
        self.path.iter().enumerate().all(|(i, arrival)| {
            let since = &self.path[i + 1..];
            self.rules.from(*arrival).iter().all(|r| allows(r, since, next))
        })
    }
}

/// Whether a restriction whose `from` end the path has passed allows `next`; `since` has the arrivals after it.
fn allows(restriction: &TurnRestriction, since: &[RoadEnd], next: RoadEnd) -> bool {
    let along = since.len() <= restriction.via.len()
        && since.iter().zip(&restriction.via).all(|(arrival, via)| arrival.road == *via);
    if !along {
        return true;
    }
    match restriction.via.get(since.len()) {
        // On the `via` roads, a mandatory turn allows only the next of them.
        Some(via) => !restriction.only || next.road == *via,
        None => restriction.only == (next == restriction.to),
    }
}
