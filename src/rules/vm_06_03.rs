//! vm-06-03: the lanes on which nobody may stop are those that tell of it.

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::{NoParams, area_element};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let view = map.view();
    let mut findings = area_element::apart(view, "no_parking_area", &["road"]);
    findings.extend(area_element::not_told(view, "no_parking_area"));
    findings
}
