//! Lines across lanes.

use crate::geometry::{Point, Polyline, left_of, segment_crossing};
use crate::lanelet::LineStringId;
use crate::lanelet::index::Lane;

/// No bound is looked for farther than this, metres, from the middle of a lane.
const REACH: f64 = 12.0;

/// Where a line meets the bounds of a lane, left and right.
pub type LaneletEnds = [(LineStringId, Point); 2];

/// The straight across a lane, this far (m) along its middle.
pub fn cross_line(lane: &Lane, station: f64) -> Option<LaneletEnds> {
    let center = lane.center.as_ref()?;
    let (middle, left) = (center.at(station), left_of(center.direction(station)));
    let meets = |points: &[Point], sign: f64| {
        let far = middle + left * (sign * REACH);
        let crossings = points.windows(2).filter_map(|w| segment_crossing(middle, far, w[0], w[1]));
        let nearest = crossings.map(|(_, _, at)| at).min_by(|a, b| (a - middle).norm().total_cmp(&(b - middle).norm()));
        nearest.or_else(|| Some(Polyline::new(points.iter().copied())?.project(middle).point))
    };
    Some([(lane.bounds[0], meets(&lane.left, 1.0)?), (lane.bounds[1], meets(&lane.right, -1.0)?)])
}

/// Where along the middle of a lane (m) a line, made longer by `extra` metres at both ends, crosses it.
pub fn crosses(lane: &Lane, [a, b]: [Point; 2], extra: f64) -> Option<f64> {
    let along = (b - a).try_normalize(Polyline::MERGE)? * extra;
    let center = lane.center.as_ref()?;
    let mut segments = center.segments().zip(center.stations());
    segments.find_map(|((c, d), before)| {
        let (.., place) = segment_crossing(a - along, b + along, c, d)?;
        Some(before + (place - c).norm())
    })
}
