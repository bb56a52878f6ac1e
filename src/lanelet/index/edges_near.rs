//! Lanes by the places where they start and end. Where thousands lie over each other, few of them end near a place.

use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

use crate::geometry::{Point, Vector};

use super::types::MapIndex;

impl MapIndex<'_> {
    /// Lanes of which the middle of the last edge (`end`), or of the first, lies no farther from a place, metres, by position. Some lie a
    /// little farther: all in a square.
    pub fn edges_near(&self, place: Point, reach: f64, end: bool) -> Vec<usize> {
        let trees = self.edges.get_or_init(|| {
            [false, true].map(|end| {
                let middle = |lane: &super::Lane| if end { lane.end.middle() } else { lane.start.middle() };
                let places = self.lanes.iter().map(middle).enumerate();
                RTree::bulk_load(places.map(|(at, p)| GeomWithData::new([p.x, p.y], at)).collect())
            })
        });
        let [low, high] = [-reach, reach].map(|by| place + Vector::repeat(by));
        let square = AABB::from_corners([low.x, low.y], [high.x, high.y]);
        let mut found: Vec<usize> = trees[usize::from(end)].locate_in_envelope(&square).map(|edge| edge.data).collect();
        found.sort_unstable();
        found
    }
}
