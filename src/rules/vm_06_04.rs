//! vm-06-04: an area without stopping has an element that road lanelets refer to.

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::{NoParams, Rule, area_element};

/// See `rules/vm-06-04.md`.
pub struct NoStopping;

impl Rule for NoStopping {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        area_element::judge(map.view(), "no_stopping_area")
    }
}
