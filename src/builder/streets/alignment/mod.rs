//! Bends, shifts and shortens OpenStreetMap's lines so that roads of their width can follow them.

mod dead_ends;
mod narrow_roads;
mod parallel_roads;
mod side_order;
mod smooth_bends;
mod straight_forks;

use rayon::prelude::*;

use crate::builder::network::{Road, RoadNetwork};
use crate::geometry::Polyline;
use crate::parallel::InSmallParts;

use smooth_bends::{INNER_RADIUS, TIGHTEST};

pub use dead_ends::end_before_carriageways;
pub use narrow_roads::narrow_roads;
pub use parallel_roads::lay_side_by_side;
pub use smooth_bends::eased;
pub use straight_forks::{straight_at_forks, straight_where};

/// The network with the bends of every road eased for its width.
#[must_use]
pub fn smooth_bends(mut network: RoadNetwork) -> RoadNetwork {
    network.roads.par_iter_mut().in_small_parts().for_each(|road| {
        let line = eased(&road.line, road.half_width());
        set_line(road, line);
    });
    network
}

/// Replaces the line of a road; its features stay where they are.
fn set_line(road: &mut Road, line: Polyline) {
    for feature in &mut road.features {
        feature.station = line.project(road.line.at(feature.station)).station;
    }
    road.line = line;
}
