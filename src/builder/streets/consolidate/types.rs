//! What may be decided about merging nodes, and what was decided of a road.

use crate::builder::network::{RoadIx, RoadKey};

use super::user_overrides::MergeOverride;

/// Limits of the decision, metres unless said otherwise.
#[derive(Clone, Debug)]
pub struct ConsolidateOptions {
    /// A road with less than this left between its two cuts has no room for a vehicle to wait: it lies inside.
    pub short: f64,
    /// As `short`, for a piece of a roundabout's ring: less than a lanelet takes.
    pub short_on_ring: f64,
    /// As `short`, for a road between two signalised nodes: less than two waiting cars.
    pub short_between_signals: f64,
    /// As `short`, for a road across the median of a dual carriageway: less than three waiting cars.
    pub short_across_median: f64,
    /// A road tagged `junction=intersection` longer than this is a tagging mistake.
    pub tagged: f64,
    /// No merged intersection reaches further than this across; beyond, it is a network of its own.
    pub reach: f64,
    /// More rounds than this mean that the decision does not settle.
    pub rounds: usize,
    /// Roads that the user decided.
    pub wishes: Vec<MergeOverride>,
}

impl Default for ConsolidateOptions {
    fn default() -> Self {
        Self {
            short: 5.0,
            short_on_ring: 3.0,
            short_between_signals: 12.0,
            short_across_median: 18.0,
            tagged: 60.0,
            reach: 90.0,
            rounds: 8,
            wishes: Vec::new(),
        }
    }
}

/// Why a road was merged, or was not although something spoke for it.
#[derive(Clone, Debug, PartialEq)]
pub struct MergeNote {
    /// The road.
    pub key: RoadKey,
    /// Whether it became part of an intersection.
    pub merged: bool,
    /// What decided.
    pub reason: MergeReason,
    /// Metres between its two cuts.
    pub left: f64,
    /// The wish that decided, by its index.
    pub wish: Option<usize>,
}

/// What speaks for or against merging a road.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MergeReason {
    /// The user says so.
    Wish,
    /// `junction=intersection`.
    Tagged,
    /// Nothing, or too little for a vehicle, is left between its cuts.
    Short,
    /// It lies between two signalised nodes and holds less than two cars.
    BetweenSignals,
    /// It crosses the median of a dual carriageway and holds less than three cars.
    AcrossMedian,
    /// What passes an end of it runs over it, and it has no room to be cut back.
    Overrun,
    /// Kept apart: a stop line of its own stands on it.
    OwnStopLine,
    /// Kept apart: the whole roundabout would collapse.
    Roundabout,
    /// Kept apart: traffic drives around an island that the merged intersection would cover.
    Island,
    /// Kept apart: the merged intersection would reach too far.
    Reach,
    /// Kept apart: an arm would be enclosed by the merged intersection.
    Enclosed,
    /// Kept apart: an end of it is the edge of the map, or no intersection at all.
    Edge,
}

/// The decision on one road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MergeVerdict {
    /// The road.
    pub road: RoadIx,
    /// Whether it lies inside an intersection.
    pub merge: bool,
    /// What decided.
    pub reason: MergeReason,
    /// Metres between its two cuts; negative where they overlap.
    pub left: f64,
    /// The wish that decided, by its index.
    pub wish: Option<usize>,
}
