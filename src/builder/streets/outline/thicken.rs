//! Thickens the arms: the two edges of each road, from the intersection outwards.

use super::sizes::{KERB_RADIUS, KERB_RADIUS_MINOR};
use crate::builder::network::{End, RoadEnd, RoadNetwork, Stations};
use crate::builder::tags::road_class::RoadClass;
use crate::geometry::spatial_hash::Bounds;
use crate::geometry::{Point, Polyline, left_of};

/// Longest miter join as a multiple of the offset; longer ones are bevelled.
pub const MITER_LIMIT: f64 = 2.0;

/// A road as seen from one of its ends.
#[derive(Clone, Debug)]
pub struct ThickenedArm {
    /// The road end at the intersection.
    pub road_end: RoadEnd,
    /// Its line, from the intersection outwards.
    pub line: Polyline,
    /// Length of the line, metres.
    pub length: f64,
    /// Half its width, metres.
    pub half: f64,
    /// Radius of the kerb to an equal road at a right angle, metres.
    pub kerb: f64,
    /// Left edge, outwards.
    pub left: Polyline,
    /// Right edge, outwards.
    pub right: Polyline,
    /// The bounding boxes of both edges.
    bounds: [Bounds; 2],
}

/// An edge of an arm, looking outwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The left edge.
    Left,
    /// The right edge.
    Right,
}

impl Side {
    /// The sign of an offset to this side.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

impl ThickenedArm {
    /// The arm at this road end.
    pub fn new(network: &RoadNetwork, arm: RoadEnd) -> Self {
        let road = network.road(arm.road);
        let line = match arm.end {
            End::Start => road.line.clone(),
            End::End => road.line.reversed(),
        };
        Self::from_line(arm, line, road.half_width(), Self::kerb_of(road.class))
    }

    /// Radius of the kerb between roads of this class at a right angle, metres.
    pub fn kerb_of(class: RoadClass) -> f64 {
        let minor = matches!(class, RoadClass::Service | RoadClass::Track);
        if minor { KERB_RADIUS_MINOR } else { KERB_RADIUS }
    }

    /// An arm along `line`, which runs outwards.
    pub fn from_line(road_end: RoadEnd, line: Polyline, half: f64, kerb: f64) -> Self {
        let edge = |side: Side| line.offset(side.sign() * half, MITER_LIMIT).unwrap_or_else(|| line.clone());
        let (left, right) = (edge(Side::Left), edge(Side::Right));
        let bounds = [&left, &right].map(Polyline::bounds);
        Self { road_end, length: line.length(), left, right, bounds, line, half, kerb }
    }

    /// One of its edges.
    pub fn edge(&self, side: Side) -> &Polyline {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }

    /// The bounding box of an edge.
    pub fn bounds(&self, side: Side) -> Bounds {
        self.bounds[usize::from(side == Side::Right)]
    }

    /// The stations of its cut and of the cut at its other end, metres outwards.
    pub fn outwards(&self, kept: &[Stations]) -> [f64; 2] {
        outwards(self.road_end, self.length, kept)
    }

    /// The end of the cross-section at `station`, metres.
    pub fn corner(&self, station: f64, side: Side) -> Point {
        self.line.at(station) + left_of(self.line.direction(station)) * (side.sign() * self.half)
    }
}

/// The stations of the cut at a road end and of the cut at the other end, metres from this end of a road of this length.
pub fn outwards(arm: RoadEnd, length: f64, kept: &[Stations]) -> [f64; 2] {
    let [from, to] = kept[arm.road];
    match arm.end {
        End::Start => [from, to],
        End::End => [length - to, length - from],
    }
}
