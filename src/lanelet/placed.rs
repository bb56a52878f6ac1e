//! The map as the existing validator holds it (profile `tier4`), where that is another than Autoware itself makes of it.

use std::borrow::Cow;

use super::align::align_in_space;
use super::index::view::{Spot, spot};
use super::{Bound, Lanelet, LaneletId, LaneletMap};
use crate::geometry::Point as Place;
use crate::projection::{LonLat, Projector};

/// The map with other places or other directions of bounds; `None` where nothing differs.
///
/// The loader reads latitudes and longitudes only: a point without them lies at 0, 0, and `local_x` says nothing. Bounds
/// are aligned in space, and once more when the map is complete, which turns back some ambiguous ones.
pub fn placed(map: &LaneletMap) -> Option<LaneletMap> {
    let mut own = Cow::Borrowed(map);
    if map.local {
        let places: Vec<LonLat> = map.points.iter().map(|point| point.lonlat().unwrap_or_default()).collect();
        let found = Projector::in_squares(&places);
        for (point, place) in own.to_mut().points.as_mut_slice().iter_mut().zip(found) {
            point.position = place.map_or_else(Place::origin, |(place, _)| place);
        }
    }
    let turned: Vec<(LaneletId, [Bound; 2])> =
        own.lanelets.iter().filter_map(|lanelet| Some((lanelet.id, turned(&own, lanelet)?))).collect();
    for (id, [left, right]) in turned {
        if let Some(lanelet) = own.to_mut().lanelets.get_mut(id) {
            (lanelet.left, lanelet.right) = (left, right);
        }
    }
    match own {
        Cow::Owned(map) => Some(map),
        Cow::Borrowed(_) => None,
    }
}

/// The bounds of a lanelet if they are used in other directions than it says.
fn turned(map: &LaneletMap, lanelet: &Lanelet) -> Option<[Bound; 2]> {
    let [left, right] = aligned(map, lanelet, 2);
    ([left, right] != [lanelet.left, lanelet.right]).then_some([left, right])
}

/// The bounds of a lanelet as the loader first aligns them.
pub fn aligned_once(map: &LaneletMap, lanelet: &Lanelet) -> [Bound; 2] {
    aligned(map, lanelet, 1)
}

/// The bounds of a lanelet, aligned this many times in succession.
fn aligned(map: &LaneletMap, lanelet: &Lanelet, times: usize) -> [Bound; 2] {
    let mut bounds = [lanelet.left, lanelet.right].map(|bound| Bound { inverted: false, ..bound });
    for _ in 0..times {
        let spots = |bound: Bound| -> Vec<Spot> { map.bound_points(bound).map(spot).collect() };
        let (left, right) = align_in_space(&spots(bounds[0]), &spots(bounds[1]));
        bounds[0].inverted ^= left;
        bounds[1].inverted ^= right;
    }
    bounds
}
