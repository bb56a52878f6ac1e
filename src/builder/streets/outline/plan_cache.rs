//! What is known of the intersections that a change of the network left as they were.

use std::hash::{DefaultHasher, Hash, Hasher};

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::{Intersection, RoadNetwork, Stations};
use crate::geometry::Polyline;
use crate::parallel::Finely;

use super::intersection_plan::{IntersectionPlan, IntersectionSite};
use super::thicken::ThickenedArm;
use super::{OutlineOptions, uncut};

/// The plans of intersections, by what lies around them. Consolidation asks again after every round, which changes few
/// intersections; where no road is moved afterwards, the outline is what was planned.
#[derive(Debug, Default)]
pub struct PlanCache {
    /// By the fingerprint of all that decides.
    known: FxHashMap<u64, IntersectionPlan>,
}

impl PlanCache {
    /// The plan of every intersection in a network whose roads are whole.
    pub(super) fn plans<'m>(
        &'m mut self,
        network: &RoadNetwork,
        options: &OutlineOptions,
    ) -> impl Iterator<Item = &'m IntersectionPlan> {
        let within = uncut(network);
        let prints = fingerprints(network, options);
        let unknown =
            prints.par_iter().finely().zip(&network.intersections).filter(|(print, _)| !self.known.contains_key(print));
        let plan = |intersection| IntersectionSite::new(network, intersection, &within, options).plan.into_owned();
        let new: Vec<(u64, IntersectionPlan)> =
            unknown.map(|(print, intersection)| (*print, plan(intersection))).collect();
        self.known.extend(new);
        prints.into_iter().map(|print| &self.known[&print])
    }

    /// Every intersection of a network with its plan. That of stars which close by their own corners is remembered; others
    /// come out of the ground between them only step by step, from where `within` has them.
    pub(super) fn sites<'a>(
        &'a self,
        network: &'a RoadNetwork,
        within: &[Stations],
        options: &'a OutlineOptions,
    ) -> Vec<IntersectionSite<'a>> {
        let prints = fingerprints(network, options);
        let site = |(intersection, print): (&'a Intersection, &u64)| match self.known.get(print) {
            Some(plan) if plan.outline.is_some() => IntersectionSite::known(network, intersection, plan, options),
            _ => IntersectionSite::new(network, intersection, within, options),
        };
        network.intersections.par_iter().finely().zip(&prints).map(site).collect()
    }
}

/// The fingerprint of every intersection.
fn fingerprints(network: &RoadNetwork, options: &OutlineOptions) -> Vec<u64> {
    let shapes: Vec<u64> = network.roads.par_iter().finely().map(|road| shape(&road.line, road.half_width())).collect();
    network.intersections.par_iter().finely().map(|at| fingerprint(network, at, &shapes, options)).collect()
}

/// The same for intersections of the same shape, seen from the same arms; `shapes` are those of the roads.
fn fingerprint(network: &RoadNetwork, intersection: &Intersection, shapes: &[u64], options: &OutlineOptions) -> u64 {
    let mut print = DefaultHasher::new();
    (&intersection.nodes, intersection.map_edge).hash(&mut print);
    for at in &intersection.arms {
        let road = network.road(at.road);
        (at.end, road.node(at.end), shapes[at.road]).hash(&mut print);
        ThickenedArm::kerb_of(road.class, options).to_bits().hash(&mut print);
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
