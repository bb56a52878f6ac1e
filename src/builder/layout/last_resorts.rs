//! With which limits roads are merged that the usual limits keep apart, where nothing else can be merged.

use rustc_hash::FxHashSet;

use crate::builder::network::{RoadIx, RoadKey};
use crate::builder::streets::consolidate::{ConsolidateOptions, MergeNote, MergeReason};

use super::map_layout::Layout;
use super::roads_inside::roads_abreast;

/// An island of at most this area, square metres, lies inside an intersection if no vehicle can wait on the roads around it.
const SMALL_ISLAND: f64 = 250.0;

/// Where lanelets run over the end of a road on which no vehicle can wait, the intersection may reach this many times as far as otherwise:
/// the lanelets of both intersections would lie on each other.
const OVERRUN_REACH: f64 = 2.0;

/// Roads that are merged with other limits.
pub struct LastResort {
    /// For which reason the usual limits keep them apart.
    refused: MergeReason,
    /// The roads.
    pub roads: Vec<RoadIx>,
    keys: FxHashSet<RoadKey>,
    /// The limits.
    pub options: ConsolidateOptions,
}

impl LastResort {
    /// Whether a road that was not merged may be with these limits.
    pub fn may_help(&self, note: &MergeNote) -> bool {
        !note.merged && note.reason == self.refused && self.keys.contains(&note.key)
    }
}

/// How roads inside intersections are merged where nothing else can be, in the order of trial.
pub fn last_resorts(layout: &Layout, roads: &[RoadIx]) -> [LastResort; 3] {
    let network = &layout.network;
    let usual = ConsolidateOptions::default();
    let overrun: FxHashSet<RoadIx> = layout.overrun().map(|at| at.road).collect();
    let overrun = roads.iter().copied().filter(|road| overrun.contains(road)).collect();
    let resort = |refused, roads: Vec<RoadIx>, options| {
        let keys = roads.iter().map(|road| network.road(*road).key).collect();
        LastResort { refused, roads, keys, options }
    };
    let reaching = |reach| ConsolidateOptions { reach, ..usual.clone() };
    let around_island = ConsolidateOptions { island: SMALL_ISLAND, ..usual.clone() };
    [
        resort(MergeReason::Reach, roads_abreast(network, roads), reaching(f64::INFINITY)),
        resort(MergeReason::Reach, overrun, reaching(OVERRUN_REACH * usual.reach)),
        resort(MergeReason::Island, roads.to_vec(), around_island),
    ]
}
