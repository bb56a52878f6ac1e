//! The outline of an intersection, where it cuts the roads, and what may be decided about it.

use crate::builder::network::{RoadEnd, Stations};
use crate::geometry::Point;

/// Which method made an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OutlineCase {
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
pub struct OutlineCut {
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
    pub case: OutlineCase,
    /// The cuts in clockwise order: that of the intersection's arms, but where roads cross each other before their cuts.
    pub cuts: Vec<OutlineCut>,
    /// `corners[i]` runs clockwise from the left end of `cuts[i]` to the right end of the next cut, both included: the
    /// kerb between two roads.
    pub corners: Vec<Vec<Point>>,
    /// The whole ring, clockwise, not closed: each cut from right to left, then the corner to the next cut. Empty at
    /// the edge of the map, where nothing is cut off.
    pub ring: Vec<Point>,
}

/// Outlines and cuts of a whole network.
#[derive(Clone, Debug)]
pub struct Outlines {
    /// Per road: the stations of its line between which it remains, start and end.
    pub kept: Vec<Stations>,
    /// Per intersection.
    pub intersections: Vec<Outline>,
}

/// Sizes that shape the outlines, metres.
#[derive(Clone, Debug)]
pub struct OutlineOptions {
    /// Radius of the kerb between two roads that meet at a right angle.
    pub kerb_radius: f64,
    /// The same where a service road or a track takes part.
    pub kerb_radius_minor: f64,
    /// A kerb's curve begins at most so far from the collision of the two edges.
    pub kerb_reach: f64,
    /// Roads that part at a small angle are cut back at most so many times the wider one's width: the rest of their
    /// overlap is no part of the intersection.
    pub reach: f64,
    /// Distance between a cut and the collision that decided it, so that corners never fall together.
    pub margin: f64,
    /// Every road is cut back at least so far where it meets another.
    pub least_trim: f64,
    /// What remains of a road at least, where it is long enough.
    pub least_road: f64,
}

impl Default for OutlineOptions {
    fn default() -> Self {
        Self {
            kerb_radius: 4.0,
            kerb_radius_minor: 2.5,
            kerb_reach: 4.0,
            reach: 2.0,
            margin: 0.2,
            least_trim: 0.5,
            least_road: 1.5,
        }
    }
}
