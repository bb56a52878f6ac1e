//! The local plane of a road network in metres, and the vertical level of a way.

use crate::geometry::Point;
use crate::osm::Tags;
use crate::projection::LonLat;

/// Projects longitudes and latitudes to local metres, many at once, in their order.
pub type ToMetres<'a> = &'a (dyn Fn(&[LonLat]) -> Vec<Point> + Sync);

/// Vertical level: `layer`, else 1 on a bridge, -1 in a tunnel, else 0.
pub(super) fn level(tags: &Tags) -> f64 {
    if let Some(layer) = tags.get("layer").and_then(|v| v.trim().parse::<f64>().ok())
        && layer.is_finite()
    {
        return layer;
    }
    let set = |key| tags.get(key).is_some_and(|v| v != "no");
    match () {
        () if set("bridge") => 1.0,
        // A passage through a building stays on the ground.
        () if set("tunnel") && !tags.is("tunnel", "building_passage") => -1.0,
        () => 0.0,
    }
}
