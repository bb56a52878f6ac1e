//! Where a road is cut before an intersection, and where people cross it.

use crate::builder::network::{End, FeatureKind, Road, RoadIx, Stations};
use crate::geometry::Vector;

/// Breadth of a crosswalk along the road, metres: the usual painted zebra.
pub const CROSSWALK_BREADTH: f64 = 3.0;
/// From the stop line to the crosswalk, metres: official maps have 1.2 to 4.2.
pub const STOP_GAP: f64 = 2.0;
/// The least that lies between them, metres, where the stop line is mapped.
pub(super) const STOP_GAP_LEAST: f64 = 1.2;
/// The most that may lie between them, metres, where it is not.
pub const STOP_GAP_MOST: f64 = 4.0;
/// What a vehicle takes that waits, metres.
pub const VEHICLE: f64 = 5.0;
/// What must remain of a road, metres, before its ends are cut back further than the outline asks: the stop lines at both its
/// ends stay apart. A turn that a car can take needs the rest more than it does.
pub const ROAD_LEFT: f64 = 2.0;

/// A place where people cross the carriageway.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadCrossing {
    /// Id of the OpenStreetMap node.
    pub node: i64,
    /// The road it crosses.
    pub road: RoadIx,
    /// Its middle on the road's line, metres.
    pub station: f64,
    /// The intersection it belongs to, by the arm; `None` between intersections.
    pub arm: Option<End>,
}

/// Where every road is cut, and the crossings.
#[derive(Clone, Debug, Default)]
pub struct ConnectionLines {
    /// Per road: the stations between which its own lanes run.
    pub kept: Vec<Stations>,
    /// Per road: the directions there into the intersections at its ends.
    pub inward: Vec<[Vector; 2]>,
    /// Per road: the stations where its outlines, held to its length, would cut it.
    pub least: Vec<Stations>,
    /// In order of roads and stations.
    pub crossings: Vec<RoadCrossing>,
    /// Per road.
    pub(super) cuts: Vec<RoadCut>,
}

impl ConnectionLines {
    /// Whether all roads are cut, and crossed, at the same stations.
    pub fn agree(&self, other: &Self) -> bool {
        self.kept == other.kept && self.crossings == other.crossings
    }

    /// How a road is cut: known beforehand where the same is asked of it, and nothing else has changed at its ends.
    pub fn cut(&self, road: RoadIx) -> &RoadCut {
        &self.cuts[road]
    }
}

/// What is asked of the cuts of a road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SetbackDemand {
    pub(super) least: Stations,
    pub(super) setbacks: [f64; 2],
    pub(super) wishes: [f64; 2],
    pub(super) stops: [bool; 2],
}

/// Where a road is cut.
#[derive(Clone, Debug)]
pub struct RoadCut {
    pub(super) asked: SetbackDemand,
    /// The stations between which its own lanes run.
    pub kept: Stations,
    /// The directions there into the intersections at its ends.
    pub inward: [Vector; 2],
    /// In order of stations.
    pub(super) crossings: Vec<RoadCrossing>,
}

impl RoadCut {
    /// The same of a road that may have had another index.
    pub(super) fn of(&self, road: RoadIx) -> Self {
        let mut cut = self.clone();
        cut.crossings.iter_mut().for_each(|crossing| crossing.road = road);
        cut
    }
}

/// Whether lights protect the people on a crossing, by the tags of its node or of the way on foot through it.
pub fn has_lights(road: &Road, crossing: &RoadCrossing) -> bool {
    let lights = |kind| matches!(kind, FeatureKind::Crossing { signals: true, .. });
    road.features.iter().any(|feature| feature.node == crossing.node && lights(feature.kind))
}
