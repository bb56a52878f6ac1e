//! Options and results of consolidation.

use crate::builder::network::{RoadIx, RoadKey};

use super::user_overrides::MergeOverride;

/// A road with less than this between its cuts, metres, lies inside an intersection: it has no room for a waiting vehicle.
pub const SHORT: f64 = 5.0;
/// As [`SHORT`], for a road between two signalised nodes: less than two waiting cars.
pub const SHORT_BETWEEN_SIGNALS: f64 = 12.0;
/// As [`SHORT`], for a road across the median of a dual carriageway: less than three waiting cars.
pub const SHORT_ACROSS_MEDIAN: f64 = 18.0;

/// Limits for merging.
#[derive(Clone, Debug)]
pub struct ConsolidateOptions {
    /// A road of a roundabout with less than this between its cuts, metres, lies inside an intersection: a lanelet needs more.
    pub short_on_ring: f64,
    /// Largest extent of a merged intersection, metres.
    pub reach: f64,
    /// Largest ground between its roads, square metres, that a merged intersection covers however little ground its roads have.
    pub island: f64,
    /// The largest number of rounds.
    pub rounds: usize,
    /// Decisions of the user.
    pub wishes: Vec<MergeOverride>,
}

impl Default for ConsolidateOptions {
    fn default() -> Self {
        Self { short_on_ring: 3.0, reach: 90.0, island: 0.0, rounds: 8, wishes: Vec::new() }
    }
}

/// Why a road was merged, or why a candidate was not.
#[derive(Clone, Debug, PartialEq)]
pub struct MergeNote {
    /// The road.
    pub key: RoadKey,
    /// Whether it became part of an intersection.
    pub merged: bool,
    /// Why.
    pub reason: MergeReason,
    /// Length between its cuts, metres.
    pub left: f64,
    /// The index of the deciding [`MergeOverride`].
    pub wish: Option<usize>,
}

/// The reason to merge a road or to keep it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MergeReason {
    /// The user decided.
    Wish,
    /// `junction=intersection`.
    Tagged,
    /// It has no room for a vehicle between its cuts.
    Short,
    /// It lies between two signalised nodes and has room for less than two cars.
    BetweenSignals,
    /// It crosses the median of a dual carriageway and has room for less than three cars.
    AcrossMedian,
    /// Turning lanelets at one end run over it, and it has no room to be cut back.
    Overrun,
    /// Kept apart: it has a stop line.
    OwnStopLine,
    /// Kept apart: the whole roundabout would collapse.
    Roundabout,
    /// Kept apart: the merged intersection would cover an island that traffic drives around.
    Island,
    /// Kept apart: the merged intersection would reach too far.
    Reach,
    /// Kept apart: it divides a long row of intersections without room between them.
    Row,
    /// Kept apart: too many roads would meet in the merged intersection.
    Crowded,
    /// Kept apart: an arm would be enclosed by the merged intersection.
    Enclosed,
    /// Kept apart: it ends at the edge of the map or at a dead end.
    Edge,
}

/// The decision on one road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MergeVerdict {
    /// The road.
    pub road: RoadIx,
    /// Whether it lies inside an intersection.
    pub merge: bool,
    /// Why.
    pub reason: MergeReason,
    /// Length between its cuts, metres; negative if they overlap.
    pub left: f64,
    /// The index of the deciding [`MergeOverride`].
    pub wish: Option<usize>,
}
