//! vm-01-15: a road shoulder lies between a lane and the border of the road.

use super::{NoParams, Rule, side_lane};
use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

/// See `rules/vm-01-15.md`.
pub struct RoadShoulder;

impl Rule for RoadShoulder {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        side_lane::judge(map, "road_shoulder", false)
    }
}
