//! Roads and where they meet: OpenStreetMap's ways cut at shared nodes, in local metres.

mod access;
pub mod approach_control;
mod arm_order;
mod assumed_bridges;
mod barriers;
mod closed_by;
mod connectivity;
mod crossing_assignment;
mod crossing_ways;
mod crowded_ground;
mod features;
pub(crate) mod frame;
#[cfg(test)]
pub(crate) mod hand_drawn;
mod index;
mod islands;
mod mid_block_signals;
pub mod network_diff;
mod passage;
mod private_ground;
mod read;
pub mod resolved_restrictions;
mod restriction_relations;
pub mod road_end;
mod same_place;
mod self_crossings;
mod short_dead_ends;
pub mod signal_assignment;
mod small_rings;
mod stop_line_assignment;
mod streets_nearby;
#[cfg(test)]
mod tests;
pub mod turn_angle;
mod turning_loops;
mod twin_ways;
pub mod unreachable_lanes;
mod untold_carriageways;
mod way_cross_sections;
mod way_pieces;
mod way_runs;
mod whole_roundabouts;

use crate::geometry::spatial_hash::Bounds;
use crate::geometry::{Point, Polyline, Vector};
use crate::osm::{Tags, Text};
use crate::settings::{BesideSettings, MarkingSettings};

use super::ids::Key;
use super::tags::cross_section::{CrossSection, Travel};
use super::tags::road_class::{DrivingSide, RoadClass};

pub(crate) use access::class as class_of;
pub(crate) use arm_order::{Ray, clockwise};
pub use closed_by::ClosedBy;
pub(crate) use connectivity::cross;
pub use frame::ToMetres;
pub use index::{IntersectionIx, RoadIx};
pub use islands::Island;
pub use read::{NetworkError, NetworkOptions, NetworkReading, UNMET_ROAD, is_driven, is_highway, road_network};
pub use whole_roundabouts::WholeRoundabouts;

use std::collections::BTreeSet;
use std::fmt;

/// One of the two ends of a road's line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// Where the line begins.
    Start,
    /// Where the line ends.
    End,
}

/// At most this number of directions of roads is joined at one intersection, two for a road of both directions, one for a one-way road:
/// each that leads in is joined to each that leads out, and all of these lanelets must be kept off each other. The largest real place
/// known, a crossing of two dual carriageways with bus roads in Seoul, has 17 roads, most of them one-way.
pub const MOST_DIRECTIONS: usize = 32;

/// Where a road is cut at its start and at its end: distances along its line, metres. Indexed by [`End`].
pub type Stations = [f64; 2];

impl End {
    /// Both ends, in order along the line.
    pub const BOTH: [Self; 2] = [Self::Start, Self::End];

    /// Its position in a pair with one value for each end.
    pub fn index(self) -> usize {
        match self {
            Self::Start => 0,
            Self::End => 1,
        }
    }

    /// The other end of the same line.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Start => Self::End,
            Self::End => Self::Start,
        }
    }

    /// The direction of travel that leads to this end.
    pub fn inbound(self) -> Travel {
        match self {
            Self::Start => Travel::Backward,
            Self::End => Travel::Forward,
        }
    }
}

/// A road where it meets an intersection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RoadEnd {
    /// The road.
    pub road: RoadIx,
    /// Which of its ends.
    pub end: End,
}

/// What identifies a road from one build to the next, whatever changes elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RoadKey {
    /// Id of the OpenStreetMap way.
    pub way: i64,
    /// Id of the node where this piece of the way begins.
    pub first: i64,
    /// Id of the node where it ends.
    pub last: i64,
    /// Tells apart pieces of one way between the same two nodes: 0 for the first.
    pub turn: u32,
}

impl fmt::Display for RoadKey {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}-{}:{}", self.way, self.first, self.last, self.turn)
    }
}

/// A crossing, light or sign on a road, between its intersections or on the node of one of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Distance along the road's line, metres.
    pub station: f64,
    /// Id of its OpenStreetMap node; a mapped stop line has that of its first node.
    pub node: i64,
    /// What it is.
    pub kind: FeatureKind,
}

/// The kinds of [`Feature`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FeatureKind {
    /// People on foot cross here.
    Crossing {
        /// Lights protect them: `crossing=traffic_signals` or a similar value.
        signals: bool,
        /// Painted: `crossing=marked|zebra|uncontrolled|traffic_signals` or `crossing:markings` other than `no`.
        marked: bool,
    },
    /// Lights for vehicles in this direction of travel (`Both` if the tags name none), of an intersection or a crossing.
    Signals(Travel),
    /// Lights for vehicles in this direction of travel that hold them where they stand, between intersections and away from
    /// crossings.
    MidBlockSignals(Travel),
    /// A stop sign for vehicles in this direction of travel.
    Stop(Travel),
    /// A give-way sign for vehicles in this direction of travel.
    GiveWay(Travel),
    /// Where vehicles in this direction of travel stop, if the intersection is controlled: a painted line, or a light or sign
    /// whose tags name the direction.
    StopLine(Travel),
    /// A sidewalk with a way of its own crosses a road on private ground.
    Sidewalk,
}

impl FeatureKind {
    /// The kind with its direction of travel changed, if it has one.
    #[must_use]
    pub fn map_travel(self, change: impl Fn(Travel) -> Travel) -> Self {
        match self {
            Self::Crossing { .. } | Self::Sidewalk => self,
            Self::Signals(travel) => Self::Signals(change(travel)),
            Self::MidBlockSignals(travel) => Self::MidBlockSignals(change(travel)),
            Self::Stop(travel) => Self::Stop(change(travel)),
            Self::GiveWay(travel) => Self::GiveWay(change(travel)),
            Self::StopLine(travel) => Self::StopLine(change(travel)),
        }
    }
}

/// A piece of road between two intersections.
#[derive(Clone, Debug)]
pub struct Road {
    /// What identifies it from one build to the next.
    pub key: RoadKey,
    /// The OpenStreetMap ways it was made from.
    pub ways: Vec<i64>,
    /// Intersection where its line begins.
    pub from: IntersectionIx,
    /// Intersection where its line ends.
    pub to: IntersectionIx,
    /// The middle of the whole cross-section, local metres.
    pub line: Polyline,
    /// Height at each vertex of the line, metres; empty where all are 0.
    pub heights: Vec<f64>,
    /// Its strips, left to right along the line.
    pub section: CrossSection,
    /// Class from `highway`.
    pub class: RoadClass,
    /// Whether it is a `_link`.
    pub link: bool,
    /// Vertical level: `layer`, else 1 on a bridge, -1 in a tunnel, else 0.
    pub level: f64,
    /// Whether it is part of a roundabout: `junction=roundabout` or `circular`.
    pub roundabout: bool,
    /// Whether the public may drive here; `false` gives `location=private`.
    pub public: bool,
    /// `name`, else `ref`.
    pub name: Option<Text>,
    /// Speed limit forward and backward, km/h: from `maxspeed*`, else the default of class and country.
    pub speed: [f64; 2],
    /// Crossings, lights and signs by station.
    pub features: Vec<Feature>,
    /// All tags of its way.
    pub tags: Tags,
}

impl Road {
    /// The key of a map element of this kind that is made from the road.
    pub fn key_of(&self, kind: &str) -> Key {
        let key = self.key;
        Key::new(kind).number(key.way).number(key.first).number(key.last).number(i64::from(key.turn))
    }

    /// The OpenStreetMap node at one end.
    pub fn node(&self, end: End) -> i64 {
        match end {
            End::Start => self.key.first,
            End::End => self.key.last,
        }
    }

    /// The first or last point of its line, local metres.
    pub fn place(&self, end: End) -> Point {
        match end {
            End::Start => self.line.first(),
            End::End => self.line.last(),
        }
    }

    /// The intersection at one end.
    pub fn intersection(&self, end: End) -> IntersectionIx {
        match end {
            End::Start => self.from,
            End::End => self.to,
        }
    }

    /// Half the width of the whole cross-section, metres.
    pub fn half_width(&self) -> f64 {
        self.section.width() / 2.0
    }

    /// Its only direction of travel; `None` if vehicles use both directions, or none.
    pub fn one_way(&self) -> Option<Travel> {
        self.section.one_way()
    }

    /// The bounding box of each segment of its line, widened by half the road's width.
    pub(crate) fn segment_bounds(&self) -> impl Iterator<Item = Bounds> {
        let around = Vector::repeat(self.half_width());
        self.line.segments().map(move |(p, q)| [p.inf(&q) - around, p.sup(&q) + around])
    }
}

/// Where roads meet, change or end.
#[derive(Clone, Debug)]
pub struct Intersection {
    /// Ids of the OpenStreetMap nodes it was made from, ascending; one unless it was merged.
    pub nodes: Vec<i64>,
    /// Mean of its nodes.
    pub position: Point,
    /// The road ends that meet here, clockwise seen from above, starting at the smallest [`RoadKey`]. A loop appears
    /// twice.
    pub arms: Vec<RoadEnd>,
    /// Whether the data ends here: a way goes on to missing nodes, or a single road ends on or outside the bounds of the data.
    pub map_edge: bool,
    /// What keeps vehicles from all turns, if the build ends a road here before its intersection.
    pub closed_by: Option<ClosedBy>,
    /// Whether it has traffic lights, on its nodes or on its arms.
    pub signals: bool,
    /// `highway=stop` with `stop=all`, or stop signs on every arm.
    pub all_way_stop: bool,
    /// `highway=mini_roundabout`, `turning_circle`, `turning_loop`.
    pub circle: Option<Text>,
    /// The roads inside, if several nodes were merged: their ground is part of the outline and no vehicle waits on them.
    pub inner: Vec<InnerRoad>,
    /// Which arm leads to which (from, to) over the inner roads and their restrictions, if several nodes were merged.
    /// `None`: every arm leads to every other, within [`RoadNetwork::restrictions`].
    pub passages: Option<Vec<(RoadEnd, RoadEnd)>>,
    /// Traffic islands nearby, in order of their ways.
    pub islands: Vec<Island>,
}

impl Intersection {
    /// Where nothing but these arms is known.
    pub(crate) fn of_arms(nodes: Vec<i64>, position: Point, arms: Vec<RoadEnd>) -> Self {
        Self {
            nodes,
            position,
            arms,
            map_edge: false,
            closed_by: None,
            signals: false,
            all_way_stop: false,
            circle: None,
            inner: Vec::new(),
            passages: None,
            islands: Vec::new(),
        }
    }

    /// The smallest id of its nodes, which names it in findings; 0 without nodes.
    pub fn first_node(&self) -> i64 {
        self.nodes.first().copied().unwrap_or_default()
    }
}

/// A road that became part of a merged intersection.
#[derive(Clone, Debug)]
pub struct InnerRoad {
    /// Its key; `first` and `last` are nodes of the intersection.
    pub key: RoadKey,
    /// The OpenStreetMap ways it was made from.
    pub ways: Vec<i64>,
    /// The middle of its cross-section from node `first` to node `last`, local metres.
    pub line: Polyline,
    /// Its strips, left to right along the line.
    pub section: CrossSection,
    /// Whether it was part of a roundabout.
    pub roundabout: bool,
}

/// A turn restriction between roads.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TurnRestriction {
    /// Id of the relation; 0 where two ways cross without a node.
    pub relation: i64,
    /// The road end over which the `from` way arrives.
    pub from: RoadEnd,
    /// The `via` roads in order; empty for a `via` node.
    pub via: Vec<RoadIx>,
    /// The road end over which the `to` way leaves.
    pub to: RoadEnd,
    /// `true` for `only_*`, which prohibits every other turn; `false` for `no_*`.
    pub only: bool,
}

/// Which lanes of one road lead to which of another, from an OpenStreetMap relation.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LaneConnection {
    /// Id of the relation.
    pub relation: i64,
    /// The road end over which the lanes arrive.
    pub from: RoadEnd,
    /// The road end over which they leave.
    pub to: RoadEnd,
    /// Pairs of lanes for motor vehicles (from, to), each counted from 1 on the left in the direction of travel.
    pub lanes: Vec<[usize; 2]>,
}

/// Roads, and where they meet.
#[derive(Clone, Debug, Default)]
pub struct RoadNetwork {
    /// Which side people drive on.
    pub side: DrivingSide,
    /// ISO 3166-1 code of the country, if it is known.
    pub country: Option<Text>,
    /// Which bicycle lanes, shoulders and sidewalks are drawn.
    pub beside: BesideSettings,
    /// Lane markings without tags.
    pub markings: MarkingSettings,
    /// In order of their keys.
    pub roads: Vec<Road>,
    /// In order of their smallest node id.
    pub intersections: Vec<Intersection>,
    /// Prohibited and mandatory turns.
    pub restrictions: Vec<TurnRestriction>,
    /// Which lanes lead to which, from relations.
    pub connections: Vec<LaneConnection>,
    /// Whether every lane leads to all lanes of the road it turns into.
    pub fan_out: bool,
}

impl RoadNetwork {
    /// The road of this index.
    pub fn road(&self, ix: RoadIx) -> &Road {
        &self.roads[ix]
    }

    /// The intersection of this index.
    pub fn intersection(&self, ix: IntersectionIx) -> &Intersection {
        &self.intersections[ix]
    }

    /// The index of the intersection at a road end.
    pub fn intersection_at(&self, arm: RoadEnd) -> IntersectionIx {
        self.road(arm.road).intersection(arm.end)
    }

    /// The roads that are at most `roads` roads away from an intersection; its own are 1 away. The search does not go on over roads
    /// longer than `short`, metres.
    pub fn roads_around(&self, at: IntersectionIx, roads: usize, short: f64) -> BTreeSet<RoadIx> {
        let (mut around, mut rim, mut seen) = (BTreeSet::new(), vec![at], BTreeSet::from([at]));
        for _ in 0..roads {
            for arm in std::mem::take(&mut rim).into_iter().flat_map(|at| &self.intersection(at).arms) {
                around.insert(arm.road);
                let road = self.road(arm.road);
                let next = road.intersection(arm.end.other());
                rim.extend((road.line.length() <= short && seen.insert(next)).then_some(next));
            }
        }
        around
    }
}
