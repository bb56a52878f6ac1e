//! What all intersections of a map are built from.

use crate::builder::control::signal_arrows::SignalArrows;
use crate::builder::lanes::types::Lanes;
use crate::builder::network::{RoadEnd, RoadNetwork, WholeRoundabouts};

use super::crossings::Crossings;

/// What all intersections are built from.
pub(super) struct MapContext<'a> {
    pub(super) network: &'a RoadNetwork,
    /// Its whole, round roundabouts.
    pub(super) roundabouts: &'a WholeRoundabouts,
    pub(super) lanes: &'a Lanes,
    pub(super) crossings: &'a Crossings,
    pub(super) arrows: &'a SignalArrows,
    /// The ends of roads with pedestrian signals only, which get lights for vehicles, too; in order.
    pub(super) guarded: &'a [RoadEnd],
    /// Whether bicycle lanes are lanelets of subtype road, which others watch and yield to.
    pub(super) as_roads: bool,
}
