//! The strip of road that the vehicles on a lanelet sweep.

use geo::Intersects;

use super::params::Params;
use super::road_network::RoadNetwork;
use crate::geometry::polygon::to_geo;
use crate::geometry::{Point, left_of};
use crate::lanelet::index::extent;
use crate::lanelet::index::view::{boxes_meet, covered_by};

/// Metres between two places of a strip.
const STRIP_STEP: f64 = 1.0;

/// The outline of what vehicles sweep that drive along the middle of a lanelet.
#[derive(Debug)]
pub struct Strip {
    extent: [Point; 2],
    outline: geo::Polygon<f64>,
}

impl Strip {
    fn new(ring: &[Point]) -> Self {
        Self { extent: extent(ring), outline: to_geo(ring) }
    }

    /// Whether a place lies in it.
    pub fn holds(&self, place: Point) -> bool {
        covered_by(place, &self.outline)
    }

    /// Whether two strips, or a strip and a lanelet, have a place in common.
    pub fn meets(&self, other: &Self) -> bool {
        boxes_meet(self.extent, other.extent) && self.outline.intersects(&other.outline)
    }
}

impl RoadNetwork<'_, '_> {
    /// What vehicles sweep on a lanelet if each keeps this close (m) to its middle; `None` where the lanelet has none.
    pub fn strip(&self, at: usize, astray: f64, params: &Params) -> Option<Strip> {
        let line = self.center(at)?.resampled(STRIP_STEP);
        let places = line.points();
        let half = params.half_width() + astray;
        let side = |i: usize, sign: f64| {
            let (low, high) = (i.saturating_sub(1), (i + 1).min(places.len() - 1));
            Some(places[i] + left_of((places[high] - places[low]).try_normalize(1e-6)?) * (sign * half))
        };
        let left = (0..places.len()).filter_map(|i| side(i, 1.0));
        let ring: Vec<Point> = left.chain((0..places.len()).rev().filter_map(|i| side(i, -1.0))).collect();
        Some(Strip::new(&ring))
    }

    /// The ground under a vehicle that approaches a lanelet, so far (m) before it and a metre wider than the vehicle on either side;
    /// `None` where the lanelet has no begin.
    pub fn approach(&self, at: usize, length: f64, params: &Params) -> Option<Strip> {
        /// How far (m) a lane may bend away from straight.
        const BEND: f64 = 1.0;
        let line = self.center(at)?;
        let heading = line.direction(0.0);
        let (aside, back) = (left_of(heading) * (params.half_width() + BEND), heading * length);
        let start = line.first();
        Some(Strip::new(&[start + aside, start - aside, start - aside - back, start + aside - back]))
    }

    /// The whole surface of a lanelet.
    pub fn surface(&self, at: usize) -> Strip {
        Strip::new(&self.seen(at).outline)
    }
}
