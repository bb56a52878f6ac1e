//! Thickens each road: its two edges, seen from an intersection outwards.

use crate::builder::network::{End, RoadEnd, RoadNetwork};
use crate::builder::tags::road_class::RoadClass;
use crate::geometry::spatial_hash::Bounds;
use crate::geometry::{Point, Polyline, left_of};

use super::OutlineOptions;

/// A miter joint reaches at most this many times the offset; beyond it the joint is bevelled.
pub const MITER_LIMIT: f64 = 2.0;

/// A road as seen from one of its ends.
#[derive(Clone, Debug)]
pub struct ThickenedArm {
    /// The road and the end from which it is seen.
    pub at: RoadEnd,
    /// Its line, from the intersection outwards.
    pub line: Polyline,
    /// Length of the line, metres.
    pub length: f64,
    /// Half its width, metres.
    pub half: f64,
    /// Radius of the kerb where it meets its like at a right angle, metres.
    pub kerb: f64,
    /// Left edge, outwards.
    pub left: Polyline,
    /// Right edge, outwards.
    pub right: Polyline,
    /// The boxes around both edges.
    reach: [Bounds; 2],
}

/// Which edge of an arm, seen from the intersection outwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Counter-clockwise of the line.
    Left,
    /// Clockwise of it.
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
    /// The arm of `network` at this road end.
    pub fn new(network: &RoadNetwork, at: RoadEnd, options: &OutlineOptions) -> Self {
        let road = network.road(at.road);
        let line = match at.end {
            End::Start => road.line.clone(),
            End::End => road.line.reversed(),
        };
        Self::from_line(at, line, road.half_width(), Self::kerb_of(road.class, options))
    }

    /// Radius of the kerb where a road of this class meets its like at a right angle, metres.
    pub fn kerb_of(class: RoadClass, options: &OutlineOptions) -> f64 {
        let minor = matches!(class, RoadClass::Service | RoadClass::Track);
        if minor { options.kerb_radius_minor } else { options.kerb_radius }
    }

    /// An arm along `line`, which runs from the intersection outwards.
    pub fn from_line(at: RoadEnd, line: Polyline, half: f64, kerb: f64) -> Self {
        let edge = |side: Side| line.offset(side.sign() * half, MITER_LIMIT).unwrap_or_else(|| line.clone());
        let (left, right) = (edge(Side::Left), edge(Side::Right));
        let reach = [&left, &right].map(Polyline::bounds);
        Self { at, length: line.length(), left, right, reach, line, half, kerb }
    }

    /// One of its edges.
    pub fn edge(&self, side: Side) -> &Polyline {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }

    /// The box around an edge.
    pub fn reach(&self, side: Side) -> Bounds {
        self.reach[usize::from(side == Side::Right)]
    }

    /// End of the cross-section at `station`.
    pub fn corner(&self, station: f64, side: Side) -> Point {
        self.line.at(station) + left_of(self.line.direction(station)) * (side.sign() * self.half)
    }
}
