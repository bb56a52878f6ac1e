//! vm-07-04: heights are above the ellipsoid, not above the sea.

use serde::Deserialize;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::Point;
use crate::lanelet::index::MapIndex;

use super::geoid;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    below_sea: f64,
}

/// A map of which most heights differ by less (m) is drawn flat: its height is a placeholder.
const FLAT: f64 = 0.01;
/// This near, degrees, to latitude and longitude 0 a map lies nowhere.
const NOWHERE: f64 = 1.0;
/// The share of points, lowest and highest, that does not count for that.
const OUTLIERS: f64 = 0.1;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let bounds = map.map.linestrings.iter().filter(|line| !map.users_of(line.id).is_empty());
    let points = bounds.flat_map(|line| &line.points).filter_map(|&id| map.map.points.get(id));
    let mut places: Vec<[f64; 3]> = points.filter_map(placed).collect();
    places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let at = |share: f64| places.get((share * places.len() as f64) as usize).copied();
    let (Some(low), Some(middle), Some(high)) = (at(OUTLIERS), at(0.5), at(1.0 - OUTLIERS)) else {
        return Vec::new();
    };
    let [ele, lat, lon] = middle;
    // The origin of simulators, which is no place on earth.
    if lat.abs().max(lon.abs()) < NOWHERE {
        return Vec::new();
    }
    let sea = geoid::above_ellipsoid(lat, lon);
    if high[0] - low[0] < FLAT || sea - ele <= params.below_sea {
        return Vec::new();
    }
    let message = format!(
        "The lanes are at ele {ele:.1} m, but the sea is at {sea:.0} m above the ellipsoid here: heights above the sea?"
    );
    vec![Finding::new("below-sea", Subject::Map, message).measured(sea - ele, params.below_sea, "m")]
}

/// Height, latitude and longitude of a point that has all three.
fn placed(point: &Point) -> Option<[f64; 3]> {
    let place = point.lonlat().filter(|place| (place.lat, place.lon) != (0.0, 0.0))?;
    point.ele().filter(|ele| ele.is_finite()).map(|ele| [ele, place.lat, place.lon])
}
