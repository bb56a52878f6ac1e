//! vm-06-05: a detection area has an element with a stop line that road lanelets refer to.

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::{NoParams, area_element};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    area_element::judge(map.view(), "detection_area", &["road"])
}
