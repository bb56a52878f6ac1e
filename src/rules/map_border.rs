//! Where a map ends: the outline around all that vehicles drive on.

use crate::geometry::{Polyline, polygon};
use crate::lanelet::index::MapIndex;

/// The convex outline of all lanes for vehicles, closed; `None` if there are none.
pub fn border(map: &MapIndex) -> Option<Polyline> {
    let lanes = map.lanes.iter().filter(|lane| lane.vehicle);
    let hull = polygon::convex_hull(lanes.flat_map(|lane| lane.outline.iter().copied()));
    Polyline::new(hull.iter().chain(hull.first()).copied())
}
