//! Roads and intersections as they lie on the ground: the stages of the geometry in their order.

use rustc_hash::FxHashSet;

use crate::diagnostic::Finding;

use super::alignment::{abreast, ease};
use super::consolidate::{ConsolidateOptions, MergeNote, consolidate, join};
use super::grid;
use super::outline::{Memory, OutlineOptions, Outlines, outlines_within, overlaps, remaining, wanted};
use super::road_network::RoadNetwork;

/// What the stages of the geometry may be told.
#[derive(Clone, Debug, Default)]
pub struct StreetOptions {
    /// Which nodes are one intersection.
    pub consolidate: ConsolidateOptions,
    /// The shape of the outlines.
    pub outline: OutlineOptions,
}

/// The geometry of a road network.
#[derive(Clone, Debug)]
pub struct Streets {
    /// Roads where their carriageways lie, and intersections merged.
    pub network: RoadNetwork,
    /// Outlines of the intersections, and what remains of the roads between them.
    pub outlines: Outlines,
    /// Why roads were merged into intersections, or were not.
    pub merges: Vec<MergeNote>,
    /// What could not be made as it should.
    pub findings: Vec<Finding>,
}

/// Lays out the streets: pieces of one road are joined, bends eased, the nodes of one intersection merged, roads that
/// overlap laid abreast, and every intersection outlined.
pub fn streets(network: RoadNetwork, options: &StreetOptions) -> Streets {
    let network = ease(join(network));
    let mut memory = Memory::default();
    let kept = |network: &RoadNetwork| remaining(network, &options.outline, &mut memory);
    let (network, merges) = consolidate(network, &options.consolidate, kept);
    let cut = wanted(&network, &options.outline, &mut memory);
    let network = told_apart(grid::network(abreast(network, &cut)));
    let (outlines, mut findings) = outlines_within(&network, &cut, &options.outline);
    findings.extend(overlaps(&network, &outlines.kept));
    let outlines = grid::outlines(outlines);
    Streets { network, outlines, merges, findings }
}

/// Gives every road a key of its own: pieces that were joined may begin and end like another of the same way.
fn told_apart(mut network: RoadNetwork) -> RoadNetwork {
    let mut taken = FxHashSet::default();
    for road in &mut network.roads {
        while !taken.insert(road.key) {
            road.key.turn += 1;
        }
    }
    network
}

#[cfg(test)]
mod tests;
