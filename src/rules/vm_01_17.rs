//! vm-01-17: a strip for people on foot lies between a road and its border.

use super::{NoParams, Rule, side_lane};
use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

/// See `rules/vm-01-17.md`.
pub struct PedestrianLane;

impl Rule for PedestrianLane {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        side_lane::judge(map, "pedestrian_lane", true)
    }
}
