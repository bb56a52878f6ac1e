//! Roads and where they meet: OpenStreetMap's ways cut at shared nodes, in local metres.

mod access;
mod arm_order;
mod connectivity;
mod crossing_assignment;
mod features;
pub(crate) mod frame;
mod index;
mod islands;
pub mod network_diff;
mod read;
pub mod road_end;
mod short_dead_ends;
mod signal_assignment;
mod stop_lines;
#[cfg(test)]
mod tests;
pub mod turn;
mod turn_relations;
pub mod turn_restrictions;
pub mod unreachable_lanes;
mod way_cross_sections;
mod way_pieces;

use crate::geometry::spatial_hash::Bounds;
use crate::geometry::{Point, Polyline, Vector};
use crate::osm::{Tags, Text};
use crate::settings::{BesideSettings, MarkingSettings};

use super::ids::Key;
use super::tags::cross_section::{CrossSection, Travel};
use super::tags::road_class::{DrivingSide, RoadClass};
pub(crate) use access::class as class_of;
pub(crate) use arm_order::{Ray, clockwise};
pub(crate) use connectivity::cross;
pub use frame::ToMetres;
pub use islands::Island;
pub use read::{NetworkError, NetworkOptions, NetworkReading, UNMET_ROAD, road_network};

use std::fmt;

/// Index of a road in [`RoadNetwork::roads`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RoadIx(pub u32);

impl RoadIx {
    /// The road at a position in [`RoadNetwork::roads`].
    pub fn new(position: usize) -> Self {
        Self(position as u32)
    }

    /// Its position in [`RoadNetwork::roads`].
    pub fn position(self) -> usize {
        self.0 as usize
    }
}

/// Index of an intersection in [`RoadNetwork::intersections`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct IntersectionIx(pub u32);

impl IntersectionIx {
    /// The intersection at a position in [`RoadNetwork::intersections`].
    pub fn new(position: usize) -> Self {
        Self(position as u32)
    }

    /// Its position in [`RoadNetwork::intersections`].
    pub fn position(self) -> usize {
        self.0 as usize
    }
}

/// One of the two ends of a road's line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// Where the line begins.
    Start,
    /// Where the line ends.
    End,
}

/// Where a road is cut at its start and at its end: distances along its line, metres. Indexed by [`End`].
pub type Stations = [f64; 2];

impl End {
    /// Both, in their order along the line.
    pub const BOTH: [Self; 2] = [Self::Start, Self::End];

    /// Its position in pairs with one value for each end.
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

    /// The travel along the line that leads to this end.
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

/// Something on the road at a node that is not an intersection, or at the node of the intersection itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Distance along the road's line, metres.
    pub station: f64,
    /// Id of the OpenStreetMap node; of a stop line's first.
    pub node: i64,
    /// What it is.
    pub kind: FeatureKind,
}

/// The kinds of [`Feature`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FeatureKind {
    /// People cross here; whether lights protect them.
    Crossing {
        /// `crossing=traffic_signals` or its like.
        signals: bool,
        /// Painted: `crossing=marked|zebra|uncontrolled|traffic_signals` or `crossing:markings` other than `no`.
        marked: bool,
    },
    /// Lights for vehicles that travel as given (`Both` where the tags do not tell).
    Signals(Travel),
    /// A stop sign for vehicles that travel as given.
    Stop(Travel),
    /// A give-way sign for vehicles that travel as given.
    GiveWay(Travel),
    /// Where vehicles that travel as given stop: a painted line, or a light or sign whose tags say whom it faces. They stop there
    /// if what rules the intersection lets them.
    StopLine(Travel),
    /// A sidewalk that is mapped as a way of its own leads across a road on private ground.
    Sidewalk,
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
    /// The middle of the whole cross-section, in local metres.
    pub line: Polyline,
    /// Height at each vertex of the line, metres; empty where all are 0.
    pub heights: Vec<f64>,
    /// What lies across it, left to right along the line.
    pub section: CrossSection,
    /// Class from `highway`.
    pub class: RoadClass,
    /// Whether it is a `_link`.
    pub link: bool,
    /// Vertical level: `layer`, else 1 on a bridge, -1 in a tunnel, else 0.
    pub level: f64,
    /// `junction=roundabout` or `circular`.
    pub roundabout: bool,
    /// Whether the public may drive here; `false` gives `location=private`.
    pub public: bool,
    /// `name`, else `ref`.
    pub name: Option<Text>,
    /// km/h per direction of travel (forward, backward), from `maxspeed*`, else a default of class and country.
    pub speed: [f64; 2],
    /// Crossings, lights and signs by station.
    pub features: Vec<Feature>,
    /// All tags of the way.
    pub tags: Tags,
}

impl Road {
    /// The key of an element of a kind that is made of it.
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

    /// Where its line begins or ends, in local metres.
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

    /// Half the width of the whole cross-section.
    pub fn half_width(&self) -> f64 {
        self.section.width() / 2.0
    }

    /// The boxes of local metres that hold what each segment of its line covers by its whole width.
    pub(crate) fn reaches(&self) -> impl Iterator<Item = Bounds> {
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
    /// Whether the data ends here: a way goes on to nodes that are missing, or one road ends on the rim of the data's
    /// bounds, or outside of them, where it is not known what else there is.
    pub map_edge: bool,
    /// Whether lights rule it: a `traffic_signals` node in it, or on its arms where the tags place them there.
    pub signals: bool,
    /// `highway=stop` with `stop=all`, or stop signs on every arm.
    pub all_way_stop: bool,
    /// `highway=mini_roundabout`, `turning_circle`, `turning_loop`.
    pub circle: Option<Text>,
    /// The roads that lie inside, where several nodes were merged into one intersection: their ground belongs to the
    /// outline, nobody queues on them.
    pub inner: Vec<InnerRoad>,
    /// Which arm leads to which, where several nodes were merged: what the inner roads and the restrictions between
    /// them allow. `None`: every arm leads to every other, within the restrictions.
    pub passages: Option<Vec<(RoadEnd, RoadEnd)>>,
    /// Ground nearby that nobody drives on, in order of the ways around it.
    pub islands: Vec<Island>,
}

/// A road that became part of a merged intersection.
#[derive(Clone, Debug)]
pub struct InnerRoad {
    /// What identified it; `first` and `last` are nodes of the intersection.
    pub key: RoadKey,
    /// The OpenStreetMap ways it was made from.
    pub ways: Vec<i64>,
    /// The middle of its cross-section, in local metres, from node `first` to node `last`.
    pub line: Polyline,
    /// What lay across it.
    pub section: CrossSection,
    /// Whether it was a piece of a roundabout's ring.
    pub roundabout: bool,
}

/// A turn restriction between roads.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnRestriction {
    /// Id of the relation.
    pub relation: i64,
    /// Where the turn begins: the road ends at the intersection where the `from` way arrives.
    pub from: RoadEnd,
    /// Roads in between, in order; empty for a `via` node.
    pub via: Vec<RoadIx>,
    /// The first road end after the turn.
    pub to: RoadEnd,
    /// `true` for `only_*`: every other way on is prohibited; `false` for `no_*`.
    pub only: bool,
}

/// Which lanes of one road lead to which of another, as a relation of OpenStreetMap tells.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneConnection {
    /// Id of the relation.
    pub relation: i64,
    /// Where the lanes arrive.
    pub from: RoadEnd,
    /// Where they go on.
    pub to: RoadEnd,
    /// Pairs of lanes for motor vehicles, each counted from 1 on the left in the direction of travel.
    pub lanes: Vec<[usize; 2]>,
}

/// Roads, and where they meet.
#[derive(Clone, Debug, Default)]
pub struct RoadNetwork {
    /// Which side people drive on.
    pub side: DrivingSide,
    /// ISO 3166-1 code of the country, where it is known: conventions follow it.
    pub country: Option<Text>,
    /// What is drawn beside the lanes for cars.
    pub beside: BesideSettings,
    /// What is painted where the tags are silent.
    pub markings: MarkingSettings,
    /// In order of their keys.
    pub roads: Vec<Road>,
    /// In order of their smallest node id.
    pub intersections: Vec<Intersection>,
    /// Prohibited and mandatory turns.
    pub restrictions: Vec<TurnRestriction>,
    /// Which lanes lead to which, where something tells it.
    pub connections: Vec<LaneConnection>,
    /// Whether every lane leads to all lanes of the road that it turns into.
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
}
