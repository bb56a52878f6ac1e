//! vm-06-02: an area without parking has an element that road lanelets refer to.

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::{NoParams, area_element};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    area_element::judge(map.view(), "no_parking_area")
}
