//! The geometry of roads and intersections: its stages in their order.

pub mod alignment;
pub mod consolidate;
pub mod heights;
pub mod lane_drop;
pub mod lane_opening;
pub mod outline;
pub mod snap_grid;

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::diagnostic::{Finding, Place, Severity, Subject};

use super::network::{InnerRoad, Intersection, RoadNetwork};
use alignment::{end_before_carriageways, lay_side_by_side, narrow_roads, smooth_bends, straight_at_forks};
use consolidate::{ConsolidateOptions, MergeNote, consolidate, join_continuations};
use heights::{HeightOptions, with_heights};
use outline::{Outlines, PlanCache, outlines_within, remaining, resolve_overlaps, wanted};

/// Options of the stages.
#[derive(Clone, Debug, Default)]
pub struct StreetOptions {
    /// Merging of intersections.
    pub consolidate: ConsolidateOptions,
    /// Heights of the roads.
    pub heights: HeightOptions,
}

/// The geometry of a road network.
#[derive(Clone, Debug)]
pub struct Streets {
    /// Aligned roads and merged intersections.
    pub network: RoadNetwork,
    /// Outlines of the intersections, and the stations between which the roads remain.
    pub outlines: Outlines,
    /// Why roads were merged into intersections, or were kept.
    pub merges: Vec<MergeNote>,
    /// Compromises in the layout.
    pub findings: Vec<Finding>,
}

/// Lays out the streets: joins pieces of one road, eases bends, merges intersections, ends roads before carriageways that they are not
/// joined to, moves overlapping roads side by side, leads lanes straight on at forks, narrows those without room, sets heights, makes the outlines, and leaves out of
/// their corners what other roads cover.
pub fn streets(network: RoadNetwork, options: &StreetOptions) -> Streets {
    let network = join_continuations(network);
    // Snapped now, a road that no stage moves keeps its shape.
    let network = snap_grid::snap_network(smooth_bends(network));
    let mut cache = PlanCache::default();
    let kept = |network: &RoadNetwork| remaining(network, &mut cache);
    let (network, merges, mut findings) = consolidate(network, &options.consolidate, kept);
    let network = end_before_carriageways(network);
    let cut = wanted(&network, &mut cache);
    let (network, crowded) = lay_side_by_side(network, &cut);
    let (network, narrowed) = narrow_roads(straight_at_forks(network), &cut);
    let (network, steep) = with_heights(network, &cut, &options.heights);
    findings.extend(crowded.into_iter().chain(narrowed));
    findings.extend(steep);
    let network = with_unique_keys(snap_grid::snap_network(network));
    let (mut outlines, failed) = outlines_within(&network, &cut, &cache);
    let network = with_arms_in_cut_order(network, &outlines);
    findings.extend(failed);
    let (merged, overlaps) = rayon::join(|| fully_merged(&network), || resolve_overlaps(&network, &mut outlines));
    findings.extend(merged.into_iter().chain(overlaps));
    let (outlines, ()) = rayon::join(|| snap_grid::snap_outlines(outlines), || drop((cache, cut)));
    Streets { network, outlines, merges, findings }
}

/// Makes the keys of roads unique: a joined road may have the ends of another of the same way.
fn with_unique_keys(mut network: RoadNetwork) -> RoadNetwork {
    let mut taken = FxHashSet::default();
    for road in &mut network.roads {
        while !taken.insert(road.key) {
            road.key.turn += 1;
        }
    }
    network
}

/// Orders the arms of every intersection as their cuts on its outline.
fn with_arms_in_cut_order(mut network: RoadNetwork, outlines: &Outlines) -> RoadNetwork {
    for (intersection, outline) in network.intersections.iter_mut().zip(&outlines.intersections) {
        intersection.arms.clear();
        intersection.arms.extend(outline.cuts.iter().map(|cut| cut.at));
    }
    network
}

/// A finding for every way that lies within intersections completely.
fn fully_merged(network: &RoadNetwork) -> Vec<Finding> {
    let left: FxHashSet<i64> = network.roads.iter().flat_map(|road| road.ways.iter().copied()).collect();
    let inner = network.intersections.iter().flat_map(|i| i.inner.iter().map(move |inner| (i, inner)));
    let merged: BTreeMap<i64, _> = inner
        .flat_map(|(i, inner)| inner.ways.iter().map(move |way| (*way, (i, inner))))
        .filter(|(way, _)| !left.contains(way))
        .collect();
    let finding = |(way, (intersection, inner)): (i64, (&Intersection, &InnerRoad))| {
        let node = intersection.first_node();
        let message = format!("way {way} lies within the intersection at node {node} and became part of it");
        let place = Place::Point(inner.line.at(inner.line.length() / 2.0));
        Finding::new("way-merged", Subject::Way(way), message).at(place).graded(Severity::Info)
    };
    merged.into_iter().map(finding).collect()
}

#[cfg(test)]
mod tests;
