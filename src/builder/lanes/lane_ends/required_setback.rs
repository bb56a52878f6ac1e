//! The setbacks that the lanelets between roads require.

use rayon::prelude::*;

use crate::builder::network::network_diff::NetworkDiff;
use crate::builder::network::{End, IntersectionIx, Road, RoadNetwork, Stations};
use crate::parallel::InSmallParts;

use super::turn_setback::{EndSetbacks, comfort_setbacks, shift_setbacks, turn_setbacks};

/// What remains of a road, metres, wherever its outlines cut it.
const ROAD_LEAST: f64 = 1.0;

/// The setbacks that the ends of roads require behind their outlines, metres.
pub struct RequiredSetbacks {
    /// Per road: the stations where its outlines cut it, clamped to its line.
    pub(super) least: Vec<Stations>,
    /// Per road: whether it meets another face to face at its ends.
    pub(super) joined: Vec<[bool; 2]>,
    intersections: Vec<IntersectionSetbacks>,
}

/// The setbacks around an intersection, metres; none where roads meet face to face.
#[derive(Default)]
struct IntersectionSetbacks {
    required: EndSetbacks,
    /// Those of the required without which lanelets would weave.
    weaving: EndSetbacks,
    comfort: EndSetbacks,
}

impl RequiredSetbacks {
    /// `joined` tells at which intersections roads meet face to face and require no room. `kept` are the stations between which
    /// the outlines leave each road.
    pub fn new(network: &RoadNetwork, kept: &[Stations], joined: impl Fn(IntersectionIx) -> bool + Sync) -> Self {
        let none = network.intersections.iter().map(|_| None).collect();
        Self::complete(network, least_cuts(network, kept, &joined), none, joined)
    }

    /// The same setbacks for a network that was made from the one for which they were found.
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
            let mut arms = network.intersection(ix).arms.iter();
            arms.all(|at| origins.of(at.road).is_some_and(|old| least[at.road][at.end] == self.least[old][at.end]))
                .then(|| {
                    let mut setbacks = std::mem::take(&mut self.intersections[old]);
                    let ends = setbacks.required.iter_mut().chain(&mut setbacks.weaving).chain(&mut setbacks.comfort);
                    ends.for_each(|(at, _)| at.road = origins.now(at.road).unwrap_or(at.road));
                    setbacks
                })
        });
        let known = known.collect();
        Self::complete(network, least, known, joined)
    }

    /// Finds the setbacks that are not known yet.
    fn complete(
        network: &RoadNetwork,
        least: Vec<Stations>,
        known: Vec<Option<IntersectionSetbacks>>,
        joined: impl Fn(IntersectionIx) -> bool + Sync,
    ) -> Self {
        let find = |(i, known): (usize, Option<IntersectionSetbacks>)| {
            let arms = &network.intersections[i].arms;
            let crossed = arms.len() >= 2 && !joined(IntersectionIx::new(i));
            let found = || {
                let weaving = shift_setbacks(network, arms, &least);
                let required = [&weaving[..], &turn_setbacks(network, arms, &least)].concat();
                IntersectionSetbacks { required, weaving, comfort: comfort_setbacks(network, arms, &least) }
            };
            known.or_else(|| crossed.then(found)).unwrap_or_default()
        };
        let intersections = known.into_par_iter().in_small_parts().enumerate().map(find).collect();
        let joined = network.roads.iter().map(|road| End::BOTH.map(|end| joined(road.intersection(end)))).collect();
        Self { least, joined, intersections }
    }

    /// Raises setbacks, per road, to the required ones, those against weaving, and those for comfort.
    pub(super) fn raise(&self, setbacks: &mut [[f64; 2]], weaving: &mut [[f64; 2]], comfort: &mut [[f64; 2]]) {
        let raise = |all: &mut [[f64; 2]], to: &EndSetbacks| {
            for (at, by) in to {
                let setback = &mut all[at.road][at.end];
                *setback = setback.max(*by);
            }
        };
        for found in &self.intersections {
            raise(setbacks, &found.required);
            raise(weaving, &found.weaving);
            raise(comfort, &found.comfort);
        }
    }
}

/// Per road, see [`least_cut`].
fn least_cuts(
    network: &RoadNetwork,
    kept: &[Stations],
    joined: &(impl Fn(IntersectionIx) -> bool + Sync),
) -> Vec<Stations> {
    let cut = |(i, road): (usize, &Road)| {
        let length = road.line.length();
        let [start, end] = kept.get(i).copied().unwrap_or([0.0, length]);
        least_cut([if joined(road.from) { 0.0 } else { start }, if joined(road.to) { length } else { end }], length)
    };
    network.roads.par_iter().in_small_parts().enumerate().map(cut).collect()
}

/// The outline's cut, clamped to a line of this length, metres, of which a part remains.
fn least_cut(cut: Stations, length: f64) -> Stations {
    let [start, end] = cut.map(|station| station.clamp(0.0, length));
    if end - start >= ROAD_LEAST.min(length / 2.0) {
        return [start, end];
    }
    let middle = ((start + end) / 2.0).clamp(length / 4.0, length * 3.0 / 4.0);
    let half = ROAD_LEAST.min(length / 2.0) / 2.0;
    [middle - half, middle + half]
}
