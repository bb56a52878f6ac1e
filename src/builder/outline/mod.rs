//! The outline of every intersection, and how far each road is cut back for it.

use crate::geometry::Point;

use super::road_network::RoadEnd;

/// Which method made an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Case {
    /// The extract ends here.
    MapEdge,
    /// One road ends.
    DeadEnd,
    /// Two roads continue each other, perhaps with another width.
    Degenerate,
    /// Nearly parallel roads part or join.
    Ramp,
    /// Every other star of roads.
    General,
    /// Several nodes became one intersection.
    Merged,
    /// The method failed; a simple shape stands in.
    Fallback,
}

/// Where a road is cut at an intersection, seen by someone who looks from the road into the intersection.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The road and which of its ends.
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
    pub case: Case,
    /// The cuts in clockwise order, the order of the intersection's arms.
    pub cuts: Vec<Cut>,
    /// `corners[i]` runs clockwise from `cuts[i]` to the next cut, both ends included: the kerb between two roads.
    pub corners: Vec<Vec<Point>>,
    /// The whole ring, clockwise, not closed: each cut's left end... corner chain... next cut.
    pub ring: Vec<Point>,
}

/// Outlines and cuts of a whole network.
#[derive(Clone, Debug)]
pub struct Outlines {
    /// Per road: the stations of its line between which it remains, start and end.
    pub kept: Vec<[f64; 2]>,
    /// Per intersection.
    pub intersections: Vec<Outline>,
}
