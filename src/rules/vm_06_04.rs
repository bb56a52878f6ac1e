//! vm-06-04: an area without stopping has an element that road lanelets refer to.

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::{NoParams, area_element};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    area_element::judge(map.view(), "no_stopping_area", &["road"])
}
