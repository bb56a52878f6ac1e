//! Lines that people on foot do not pass: guard rails, walls, fences.

use crate::geometry::{Point, Polyline, polygon};
use crate::lanelet::index::thresholds;
use crate::lanelet::index::{Lane, MapIndex, extent};
use crate::lanelet::{LineString, LineStringId};

/// The types of line that Autoware's prediction takes for a barrier.
pub const KINDS: [&str; 3] = ["guard_rail", "wall", "fence"];

/// How far apart (m) a barrier is looked at.
const LOOKED_AT_EVERY: f64 = 0.25;

/// A barrier with its places.
pub struct Barrier<'m> {
    /// Its id.
    pub id: LineStringId,
    /// Its type.
    pub kind: &'m str,
    /// Where it is.
    pub line: Polyline,
    /// Mean height, metres; `None` if no point has one.
    height: Option<f64>,
}

/// All barriers of a map.
pub fn all<'m>(map: &MapIndex<'m>) -> Vec<Barrier<'m>> {
    map.map.linestrings.iter().filter_map(|line| Barrier::new(map, line)).collect()
}

impl<'m> Barrier<'m> {
    fn new(map: &MapIndex<'m>, line: &'m LineString) -> Option<Self> {
        let kind = line.attributes.get("type").filter(|kind| KINDS.contains(kind))?;
        let points: Vec<_> = map.map.points.get_each(line.points.iter().copied()).collect();
        let places = Polyline::new(points.iter().map(|point| point.position))?;
        if !places.points().iter().all(|p| p.x.is_finite() && p.y.is_finite()) {
            return None;
        }
        let heights: Vec<f64> = points.iter().filter_map(|point| point.ele()).collect();
        let height = (!heights.is_empty()).then(|| heights.iter().sum::<f64>() / heights.len() as f64);
        Some(Self { id: line.id, kind, line: places, height })
    }

    /// Lanes whose box the barrier meets, on its level, by position.
    pub fn lanes_near(&self, map: &MapIndex) -> Vec<usize> {
        let [low, high] = extent(self.line.points());
        let mut near = map.lanes_near(low, high);
        near.retain(|&at| self.on_level(&map.lanes[at]));
        near
    }

    fn on_level(&self, lane: &Lane) -> bool {
        let [low, high] = lane.heights;
        let apart = thresholds::GRADE_SEPARATION;
        self.height.is_none_or(|height| height >= low - apart && height <= high + apart)
    }

    /// The places along the barrier, a step apart, that lie in an area and as deep in it as `deep` wants them.
    pub fn inside(&self, ring: &[Point], deep: impl Fn(Point) -> bool) -> Vec<Point> {
        let [low, high] = extent(ring);
        let length = self.line.length();
        let pieces = (length / LOOKED_AT_EVERY).ceil().clamp(1.0, Polyline::MOST_PIECES);
        let stations = (0..pieces as usize).map(|i| (i as f64 + 0.5) * length / pieces);
        let places = self.line.at_each(stations).into_iter();
        // A fence around a site passes by many lanes, of which each is near only a few of its places.
        let near = places.filter(|p| p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y);
        near.filter(|&p| polygon::contains(ring, p) && deep(p)).collect()
    }
}
