//! vm-06-06: a bus stop has an element.

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::{NoParams, Rule, area_element};

/// See `rules/vm-06-06.md`.
pub struct BusStopElement;

impl Rule for BusStopElement {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        area_element::unreferenced(map.view(), "bus_stop_area")
    }
}
