//! Roads and intersections as they lie on the ground: the stages of the geometry in their order.

pub mod alignment;
pub mod consolidate;
pub mod heights;
pub mod outline;
pub mod snap_grid;

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::diagnostic::{Finding, Place, Severity, Subject};

use super::network::{InnerRoad, Intersection, RoadNetwork};
use alignment::{lay_side_by_side, narrow_roads, smooth_bends};
use consolidate::{ConsolidateOptions, MergeNote, consolidate, join_continuations};
use heights::{HeightOptions, with_heights};
use outline::{OutlineOptions, Outlines, PlanCache, outlines_within, overlaps, remaining, wanted};

/// What the stages of the geometry may be told.
#[derive(Clone, Debug, Default)]
pub struct StreetOptions {
    /// Which nodes are one intersection.
    pub consolidate: ConsolidateOptions,
    /// The shape of the outlines.
    pub outline: OutlineOptions,
    /// How high the roads lie.
    pub heights: HeightOptions,
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
/// overlap laid abreast, those narrowed that find no room, all laid at their height, and every intersection outlined.
pub fn streets(network: RoadNetwork, options: &StreetOptions) -> Streets {
    let network = join_continuations(network);
    // On the grid from the beginning, a road that nothing moves keeps its shape to the end.
    let network = snap_grid::snap_network(smooth_bends(network));
    let mut memory = PlanCache::default();
    let kept = |network: &RoadNetwork| remaining(network, &options.outline, &mut memory);
    let (network, merges) = consolidate(network, &options.consolidate, kept);
    let cut = wanted(&network, &options.outline, &mut memory);
    let (network, mut findings) = narrow_roads(lay_side_by_side(network, &cut), &cut);
    let (network, steep) = with_heights(network, &cut, &options.heights);
    findings.extend(steep);
    let network = with_unique_keys(snap_grid::snap_network(network));
    let (outlines, failed) = outlines_within(&network, &cut, &options.outline, &memory);
    let network = in_key_order(network, &outlines);
    findings.extend(failed);
    let (whole, overlaps) = rayon::join(|| merged_whole(&network), || overlaps(&network, &outlines));
    findings.extend(whole.into_iter().chain(overlaps));
    let (outlines, ()) = rayon::join(|| snap_grid::snap_outlines(outlines), || drop((memory, cut)));
    Streets { network, outlines, merges, findings }
}

/// Gives every road a key of its own: pieces that were joined may begin and end like another of the same way.
fn with_unique_keys(mut network: RoadNetwork) -> RoadNetwork {
    let mut taken = FxHashSet::default();
    for road in &mut network.roads {
        while !taken.insert(road.key) {
            road.key.turn += 1;
        }
    }
    network
}

/// Lets the arms of every intersection follow each other as their cuts do on its outline.
fn in_key_order(mut network: RoadNetwork, outlines: &Outlines) -> RoadNetwork {
    for (intersection, outline) in network.intersections.iter_mut().zip(&outlines.intersections) {
        intersection.arms.clear();
        intersection.arms.extend(outline.cuts.iter().map(|cut| cut.at));
    }
    network
}

/// A finding for every way that lies whole within intersections, so that no road of the output tells of it.
fn merged_whole(network: &RoadNetwork) -> Vec<Finding> {
    let left: FxHashSet<i64> = network.roads.iter().flat_map(|road| road.ways.iter().copied()).collect();
    let inner = network.intersections.iter().flat_map(|at| at.inner.iter().map(move |inner| (at, inner)));
    let whole: BTreeMap<i64, _> = inner
        .flat_map(|(at, inner)| inner.ways.iter().map(move |way| (*way, (at, inner))))
        .filter(|(way, _)| !left.contains(way))
        .collect();
    let finding = |(way, (at, inner)): (i64, (&Intersection, &InnerRoad))| {
        let node = at.nodes.first().copied().unwrap_or_default();
        let message = format!("way {way} lies within the intersection at node {node} and became part of it");
        let place = Place::Point(inner.line.at(inner.line.length() / 2.0));
        Finding::new("way-merged", Subject::Way(way), message).at(place).graded(Severity::Info)
    };
    whole.into_iter().map(finding).collect()
}

#[cfg(test)]
mod tests;
