//! What the ends of roads need for the ways between them, however far they are cut back.

use rayon::prelude::*;

use crate::builder::network::network_diff::NetworkDiff;
use crate::builder::network::{IntersectionIx, RoadEnd, RoadNetwork, Stations};
use crate::parallel::Finely;

use super::dead_end::clearances;
use super::setback::{comfort, turn_setbacks};

/// What must remain of a road, metres, whatever the outline says.
const ROAD_LEAST: f64 = 1.0;

/// What the ends of roads need.
pub struct RequiredSetbacks {
    /// Per road: the stations where its outlines, held to its length, would cut it.
    pub(super) least: Vec<Stations>,
    /// Per intersection.
    ways: Vec<Wanted>,
    /// How far dead ends are cut back.
    dead_ends: Vec<(RoadEnd, f64)>,
}

/// How far to cut the roads of an intersection back, and how much farther for comfort; nothing where it has no ways.
#[derive(Default)]
struct Wanted {
    needed: Vec<(RoadEnd, f64)>,
    wished: Vec<(RoadEnd, f64)>,
}

impl RequiredSetbacks {
    /// `joined` tells which intersections need no room: there the roads meet face to face. `kept` are the stations between
    /// which the outlines leave each road.
    pub fn new(network: &RoadNetwork, kept: &[Stations], joined: impl Fn(IntersectionIx) -> bool + Sync) -> Self {
        let none = network.intersections.iter().map(|_| None).collect();
        Self::completed(network, least_cuts(network, kept, &joined), none, joined)
    }

    /// The same for a network that followed from another, whose needs these are.
    #[must_use]
    pub fn renewed(
        mut self,
        origins: &NetworkDiff,
        network: &RoadNetwork,
        kept: &[Stations],
        joined: impl Fn(IntersectionIx) -> bool + Sync,
    ) -> Self {
        let least = least_cuts(network, kept, &joined);
        let known = (0..network.intersections.len()).map(|i| {
            let ix = IntersectionIx::new(i);
            let old = origins.untouched(ix)?;
            let same = |at: &RoadEnd| least[at.road][at.end] == self.least[origins.of(at.road)][at.end];
            network.intersection(ix).arms.iter().all(same).then(|| {
                let mut wanted = std::mem::take(&mut self.ways[old]);
                let ends = wanted.needed.iter_mut().chain(&mut wanted.wished);
                ends.for_each(|(at, _)| at.road = origins.now(at.road).unwrap_or(at.road));
                wanted
            })
        });
        let known = known.collect();
        Self::completed(network, least, known, joined)
    }

    /// Finds what is not known yet.
    fn completed(
        network: &RoadNetwork,
        least: Vec<Stations>,
        known: Vec<Option<Wanted>>,
        joined: impl Fn(IntersectionIx) -> bool + Sync,
    ) -> Self {
        let wanted = |(i, known): (usize, Option<Wanted>)| {
            let arms = &network.intersections[i].arms;
            let passed = arms.len() >= 2 && !joined(IntersectionIx::new(i));
            let find =
                || Wanted { needed: turn_setbacks(network, arms, &least), wished: comfort(network, arms, &least) };
            known.or_else(|| passed.then(find)).unwrap_or_default()
        };
        let ways = known.into_par_iter().finely().enumerate().map(wanted).collect();
        let dead_ends = clearances(network, &least);
        Self { least, ways, dead_ends }
    }

    /// Raises setbacks to what is needed, and wishes to what is wished.
    pub(super) fn raise(&self, setbacks: &mut [[f64; 2]], wishes: &mut [[f64; 2]]) {
        let raise = |of: &mut [[f64; 2]], asked: &[(RoadEnd, f64)]| {
            for (at, by) in asked {
                let back = &mut of[at.road][at.end];
                *back = back.max(*by);
            }
        };
        for Wanted { needed, wished } in &self.ways {
            raise(setbacks, needed);
            raise(wishes, wished);
        }
        raise(setbacks, &self.dead_ends);
    }
}

fn least_cuts(
    network: &RoadNetwork,
    kept: &[Stations],
    joined: &(impl Fn(IntersectionIx) -> bool + Sync),
) -> Vec<[f64; 2]> {
    (0..network.roads.len()).into_par_iter().finely().map(|i| least_cut(network, kept, i, joined)).collect()
}

/// The outline's cut, held to the line and to a least length; the whole line where roads meet face to face.
fn least_cut(
    network: &RoadNetwork,
    kept: &[Stations],
    index: usize,
    joined: &impl Fn(IntersectionIx) -> bool,
) -> [f64; 2] {
    let road = &network.roads[index];
    let length = road.line.length();
    let [mut start, mut end] = kept.get(index).copied().unwrap_or([0.0, length]);
    if joined(road.from) {
        start = 0.0;
    }
    if joined(road.to) {
        end = length;
    }
    let (start, end) = (start.clamp(0.0, length), end.clamp(0.0, length));
    if end - start >= ROAD_LEAST.min(length / 2.0) {
        return [start, end];
    }
    let middle = ((start + end) / 2.0).clamp(length / 4.0, length * 3.0 / 4.0);
    let half = ROAD_LEAST.min(length / 2.0) / 2.0;
    [middle - half, middle + half]
}
