//! What is known of the intersections that a change of the network left as they were.

use std::hash::{DefaultHasher, Hash, Hasher};

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::road_network::{Intersection, RoadNetwork};
use crate::geometry::Polyline;

use super::{Arm, OutlineOptions, plan, uncut};

/// How far the arms of one intersection are cut back, by what lies around it. Consolidation asks again after every
/// round, which changes few intersections.
#[derive(Debug, Default)]
pub struct Memory {
    /// By the fingerprint of all that decides.
    known: FxHashMap<u64, Trims>,
}

/// Per arm: see [`super::general::Star`].
#[derive(Clone, Debug)]
pub(super) struct Trims {
    /// How far it must be trimmed.
    pub least: Vec<f64>,
    /// How far it should be trimmed.
    pub wanted: Vec<f64>,
}

impl Memory {
    /// How far the arms of every intersection are cut back in a network whose roads are whole.
    pub(super) fn trims(&mut self, network: &RoadNetwork, options: &OutlineOptions) -> Vec<Trims> {
        let within = uncut(network);
        let shapes: Vec<u64> = network.roads.par_iter().map(|road| shape(&road.line, road.half_width())).collect();
        let all: Vec<(u64, Trims)> = network
            .intersections
            .par_iter()
            .map(|intersection| {
                let print = fingerprint(network, intersection, &shapes, options);
                let trims = self.known.get(&print).cloned().unwrap_or_else(|| {
                    let star = plan(network, intersection, &within, options).star;
                    Trims { least: star.least, wanted: star.trims }
                });
                (print, trims)
            })
            .collect();
        self.known = all.iter().cloned().collect();
        all.into_iter().map(|(_, trims)| trims).collect()
    }
}

/// The same for intersections of the same shape, seen from the same arms; `shapes` are those of the roads.
fn fingerprint(network: &RoadNetwork, intersection: &Intersection, shapes: &[u64], options: &OutlineOptions) -> u64 {
    let mut print = DefaultHasher::new();
    (&intersection.nodes, intersection.map_edge).hash(&mut print);
    for at in &intersection.arms {
        let road = network.road(at.road);
        (at.end, road.node(at.end), shapes[at.road.0 as usize]).hash(&mut print);
        Arm::kerb_of(road.class, options).to_bits().hash(&mut print);
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
