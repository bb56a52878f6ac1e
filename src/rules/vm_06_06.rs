//! vm-06-06: a bus stop has an element.

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::{NoParams, area_element};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    area_element::unreferenced(map.view(), "bus_stop_area")
}
