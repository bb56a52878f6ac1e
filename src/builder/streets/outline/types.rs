//! Outlines and their cuts.

use crate::builder::network::{RoadEnd, Stations};
use crate::geometry::Point;

/// The method that made an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OutlineCase {
    /// The extract ends here.
    MapEdge,
    /// One road ends.
    DeadEnd,
    /// Two roads meet.
    Degenerate,
    /// Nearly parallel roads diverge or merge.
    Ramp,
    /// Any other roads meet.
    General,
    /// Several nodes became one intersection.
    Merged,
    /// No method worked: the convex hull of the cuts.
    Fallback,
}

/// Where a road is cut at an intersection; left and right looking from the road into the intersection.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlineCut {
    /// The road end.
    pub at: RoadEnd,
    /// Left end of the cut.
    pub left: Point,
    /// Right end of the cut.
    pub right: Point,
}

/// The outline of one intersection.
#[derive(Clone, Debug)]
pub struct Outline {
    /// How it was made.
    pub case: OutlineCase,
    /// The cuts, clockwise. Their order differs from that of the arms if roads cross each other before their cuts.
    pub cuts: Vec<OutlineCut>,
    /// `corners[i]` runs clockwise from the left end of `cuts[i]` to the right end of the next cut, both included: the
    /// kerb between two roads.
    pub corners: Vec<Vec<Point>>,
    /// The whole ring, clockwise, not closed: each cut from right to left, then the corner to the next cut. Empty at the edge of
    /// the map.
    pub ring: Vec<Point>,
}

/// Outlines and cuts of a network.
#[derive(Clone, Debug)]
pub struct Outlines {
    /// Per road: the stations between which it remains, metres.
    pub kept: Vec<Stations>,
    /// Per intersection.
    pub intersections: Vec<Outline>,
}
