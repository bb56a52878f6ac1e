//! Reuses the plans of intersections that a change of the network does not concern.

use std::hash::{DefaultHasher, Hash, Hasher};

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::{Intersection, RoadNetwork, Stations};
use crate::geometry::Polyline;
use crate::parallel::InSmallParts;

use super::intersection_plan::{IntersectionPlan, IntersectionSite};
use super::thicken::ThickenedArm;
use super::uncut;

/// The plans of intersections by their surroundings. Each round of consolidation changes few intersections, and later stages do
/// not move most roads.
#[derive(Debug, Default)]
pub struct PlanCache {
    /// By fingerprint of all inputs.
    known: FxHashMap<u64, IntersectionPlan>,
}

impl PlanCache {
    /// The plan of every intersection, for uncut roads.
    pub(super) fn plans<'m>(&'m mut self, network: &RoadNetwork) -> impl Iterator<Item = &'m IntersectionPlan> {
        let within = uncut(network);
        let prints = fingerprints(network);
        let unknown = prints
            .par_iter()
            .in_small_parts()
            .zip(&network.intersections)
            .filter(|(print, _)| !self.known.contains_key(print));
        let plan = |intersection| IntersectionSite::new(network, intersection, &within).plan.into_owned();
        let new: Vec<(u64, IntersectionPlan)> =
            unknown.map(|(print, intersection)| (*print, plan(intersection))).collect();
        self.known.extend(new);
        prints.into_iter().map(|print| &self.known[&print])
    }

    /// Every intersection with its plan. Only plans with an outline are reused: the others depend on the cuts in `within`.
    pub(super) fn sites<'a>(&'a self, network: &'a RoadNetwork, within: &[Stations]) -> Vec<IntersectionSite<'a>> {
        let prints = fingerprints(network);
        let site = |(intersection, print): (&'a Intersection, &u64)| match self.known.get(print) {
            Some(plan) if plan.outline.is_some() => IntersectionSite::known(network, intersection, plan),
            _ => IntersectionSite::new(network, intersection, within),
        };
        network.intersections.par_iter().in_small_parts().zip(&prints).map(site).collect()
    }
}

fn fingerprints(network: &RoadNetwork) -> Vec<u64> {
    let shapes: Vec<u64> =
        network.roads.par_iter().in_small_parts().map(|road| shape(&road.line, road.half_width())).collect();
    network.intersections.par_iter().in_small_parts().map(|i| fingerprint(network, i, &shapes)).collect()
}

/// A hash of all that the plan of an intersection depends on; `shapes` are the hashes of the roads' shapes.
fn fingerprint(network: &RoadNetwork, intersection: &Intersection, shapes: &[u64]) -> u64 {
    let mut print = DefaultHasher::new();
    (&intersection.nodes, intersection.map_edge).hash(&mut print);
    for arm in &intersection.arms {
        let road = network.road(arm.road);
        (arm.end, road.node(arm.end), shapes[arm.road]).hash(&mut print);
        ThickenedArm::kerb_of(road.class).to_bits().hash(&mut print);
    }
    for inner in &intersection.inner {
        (inner.key.first, inner.key.last, shape(&inner.line, inner.section.width())).hash(&mut print);
    }
    print.finish()
}

fn shape(line: &Polyline, width: f64) -> u64 {
    let mut print = DefaultHasher::new();
    width.to_bits().hash(&mut print);
    line.points().len().hash(&mut print);
    for p in line.points() {
        print.write_u64(p.x.to_bits());
        print.write_u64(p.y.to_bits());
    }
    print.finish()
}
