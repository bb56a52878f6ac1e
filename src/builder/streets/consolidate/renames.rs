//! New names for road ends and intersections after an edit of a network.

use rustc_hash::FxHashMap;

use crate::builder::network::{End, Intersection, IntersectionIx, LaneConnection, Road, RoadEnd, RoadIx};

/// Where the road ends and intersections of a network are after an edit.
#[derive(Default)]
pub struct Renames {
    /// For each end of a replaced road: the end that took its place, if any.
    pub replaced: FxHashMap<RoadEnd, Option<RoadEnd>>,
    /// The new index by old road; `None` if it is gone.
    pub roads: Vec<Option<RoadIx>>,
    /// The new index by old intersection.
    pub intersections: Vec<IntersectionIx>,
}

impl Renames {
    /// The end that took the place of this one, by old index; `None` if it is gone.
    pub fn latest(&self, mut arm: RoadEnd) -> Option<RoadEnd> {
        while let Some(next) = self.replaced.get(&arm) {
            arm = (*next)?;
        }
        Some(arm)
    }

    /// The road that took the place of this one, by old index; `None` if it is gone.
    pub fn latest_road(&self, mut road: RoadIx) -> Option<RoadIx> {
        while let [Some(start), Some(end)] = End::BOTH.map(|end| self.replaced.get(&RoadEnd { road, end })) {
            // A joined road keeps one end of each of its parts; a divided one has two roads in its place.
            road = start.or(*end)?.road;
        }
        Some(road)
    }

    /// The end that took the place of this one, by new index; `None` if it is gone.
    pub fn arm(&self, arm: RoadEnd) -> Option<RoadEnd> {
        let RoadEnd { road, end } = self.latest(arm)?;
        Some(RoadEnd { road: self.roads[road]?, end })
    }

    /// The road between the new intersections.
    pub fn road(&self, road: &mut Road) {
        (road.from, road.to) = (self.intersections[road.from], self.intersections[road.to]);
    }

    /// The intersection with its new arms.
    pub fn intersection(&self, mut intersection: Intersection) -> Intersection {
        intersection.arms = intersection.arms.into_iter().filter_map(|arm| self.arm(arm)).collect();
        intersection.passages = intersection.passages.map(|passages| {
            passages.into_iter().filter_map(|(from, to)| Some((self.arm(from)?, self.arm(to)?))).collect()
        });
        intersection
    }

    /// The connection between the new arms; `None` if one is gone.
    pub fn connection(&self, c: LaneConnection) -> Option<LaneConnection> {
        Some(LaneConnection { from: self.arm(c.from)?, to: self.arm(c.to)?, ..c })
    }
}
