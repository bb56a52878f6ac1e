//! Straight lines across lanes.

use crate::geometry::{Point, Polyline, left_of, segment_crossing};
use crate::lanelet::LineStringId;
use crate::lanelet::index::Lane;

/// The bounds of a lane lie at most this far, metres, from its middle.
const BOUND_FROM_MIDDLE: f64 = 12.0;

/// Where a line meets the bounds of a lane, left and right.
pub type LaneletEnds = [(LineStringId, Point); 2];

/// The line straight across a lane at a station of its middle, metres.
pub fn cross_line(lane: &Lane, station: f64) -> Option<LaneletEnds> {
    let center = lane.center.as_ref()?;
    let (middle, left) = (center.at(station), left_of(center.direction(station)));
    let meet = |points: &[Point], sign: f64| {
        let far = middle + left * (sign * BOUND_FROM_MIDDLE);
        let crossings = points.windows(2).filter_map(|w| segment_crossing(middle, far, w[0], w[1]));
        let nearest = crossings.map(|(_, _, p)| p).min_by(|a, b| (a - middle).norm().total_cmp(&(b - middle).norm()));
        nearest.or_else(|| Some(Polyline::new(points.iter().copied())?.project(middle).point))
    };
    Some([(lane.bounds[0], meet(&lane.left, 1.0)?), (lane.bounds[1], meet(&lane.right, -1.0)?)])
}

/// The station, metres, at which a line crosses the middle of a lane. The line is extended by `extra` metres at both ends.
pub fn crosses(lane: &Lane, [a, b]: [Point; 2], extra: f64) -> Option<f64> {
    let along = (b - a).try_normalize(Polyline::MERGE)? * extra;
    let center = lane.center.as_ref()?;
    let mut segments = center.segments().zip(center.stations());
    segments.find_map(|((c, d), station)| {
        let (.., crossing) = segment_crossing(a - along, b + along, c, d)?;
        Some(station + (crossing - c).norm())
    })
}
