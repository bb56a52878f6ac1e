//! Where a road is cut before an intersection, and where people cross it.

use rustc_hash::FxHashMap;

use crate::builder::network::road_end::is_between_crossings;
use crate::builder::network::{End, FeatureKind, Road, RoadIx, RoadKey, RoadNetwork, Stations};
use crate::builder::tags::cross_section::Travel;
use crate::geometry::Vector;

/// Breadth of a crosswalk along the road, metres: the usual painted zebra.
pub const CROSSWALK_BREADTH: f64 = 3.0;
/// From the stop line to the crosswalk, metres: official maps have 1.2 to 4.2.
pub const STOP_GAP: f64 = 2.0;
/// The smallest such gap, metres, where the stop line is mapped.
pub(super) const STOP_GAP_LEAST: f64 = 1.2;
/// The largest such gap, metres, where it is not mapped.
pub const STOP_GAP_MOST: f64 = 4.0;
/// Length of road that a waiting vehicle occupies, metres.
pub const VEHICLE: f64 = 5.0;
/// Setbacks leave this much of a road, metres, so that the stop lines at its ends stay apart; turns need the rest more.
pub const ROAD_LEFT: f64 = 2.0;
/// Between two intersections setbacks leave this much of a road, metres, a waiting vehicle and half a metre, if a car can take all
/// turns all the same.
pub const ROAD_LEFT_BETWEEN: f64 = VEHICLE + 0.5;

/// A place where people cross the carriageway, or where lights hold vehicles though nobody crosses.
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
    /// The direction of travel that lights hold where nobody crosses; `None` for a crosswalk.
    pub lights_only: Option<Travel>,
}

/// Where every road is cut, and the crossings.
#[derive(Clone, Debug, Default)]
pub struct ConnectionLines {
    /// Per road: the stations between which its own lanes run.
    pub kept: Vec<Stations>,
    /// Per road: the unit directions there into the intersections at its ends.
    pub inward: Vec<[Vector; 2]>,
    /// Per road: the stations where its outlines cut it, clamped to its line.
    pub least: Vec<Stations>,
    /// In order of roads and stations.
    pub crossings: Vec<RoadCrossing>,
    /// Per road.
    pub(super) cuts: Vec<RoadCut>,
}

/// What takes the room of a waiting vehicle on a road between two intersections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Squeeze {
    /// Lanelets that would run over its ends or weave, and turns as tight as a car can take.
    Least,
    /// The same, and turns as wide as it takes so that they are not drawn too tight.
    Needed,
    /// All that makes turns easier, too: with the needed alone they stay too tight.
    Easy,
}

/// Roads that do not keep the room of a waiting vehicle.
pub type SqueezedRoads = FxHashMap<RoadKey, Squeeze>;

/// How much of a road setbacks leave, metres: the needed ones, and those that only make turns easier.
pub fn least_left(network: &RoadNetwork, squeezed: &SqueezedRoads, road: &Road) -> [f64; 2] {
    let kept = if is_between_crossings(network, road) { ROAD_LEFT_BETWEEN } else { ROAD_LEFT };
    match squeezed.get(&road.key) {
        None => [kept; 2],
        Some(Squeeze::Least | Squeeze::Needed) => [ROAD_LEFT, kept],
        Some(Squeeze::Easy) => [ROAD_LEFT; 2],
    }
}

impl ConnectionLines {
    /// Whether all roads have their cuts and crossings at the same stations.
    pub fn agree(&self, other: &Self) -> bool {
        self.kept == other.kept && self.crossings == other.crossings
    }

    /// The cut of a road; it stays the same for the same demand if nothing else changes at the road's ends.
    pub fn cut(&self, road: RoadIx) -> &RoadCut {
        &self.cuts[road]
    }
}

/// The setbacks of both ends of a road behind its outlines, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SetbackDemand {
    /// How much of the road setbacks leave: the needed ones, and those that only make turns easier.
    pub(super) left: [f64; 2],
    /// Where its outlines cut it.
    pub(super) least: Stations,
    pub(super) setbacks: [f64; 2],
    /// The part of each setback that keeps the cut behind lanelets that run over the road.
    pub(super) firm: [f64; 2],
    /// The part of each setback without which lanelets would weave.
    pub(super) weaving: [f64; 2],
    /// The larger setbacks that it has if it is long enough.
    pub(super) comfort: [f64; 2],
    /// Whether it is cut where a stop line is mapped.
    pub(super) stops: [bool; 2],
    /// Whether it meets another road face to face: it is not cut back there.
    pub(super) joined: [bool; 2],
}

/// Where a road is cut.
#[derive(Clone, Debug)]
pub struct RoadCut {
    pub(super) demand: SetbackDemand,
    /// The stations between which its own lanes run.
    pub kept: Stations,
    /// The unit directions there into the intersections at its ends.
    pub inward: [Vector; 2],
    /// How far its lanes go straight on from there, over a crosswalk and the gap before it, metres.
    pub straight: [f64; 2],
    /// In order of stations.
    pub(super) crossings: Vec<RoadCrossing>,
}

impl RoadCut {
    /// The same cut under the road's present index.
    pub(super) fn of(&self, road: RoadIx) -> Self {
        let mut cut = self.clone();
        cut.crossings.iter_mut().for_each(|crossing| crossing.road = road);
        cut
    }
}

/// Whether a crossing has lights, by the tags of its node, of the footway over it, or of a node nearby.
pub fn has_lights(road: &Road, crossing: &RoadCrossing) -> bool {
    let lights = |kind| matches!(kind, FeatureKind::Crossing { signals: true, .. });
    crossing.lights_only.is_some()
        || road.features.iter().any(|feature| feature.node == crossing.node && lights(feature.kind))
}
