//! vm-06-03: the lanes on which nobody may stop are those that tell of it.

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::{NoParams, Rule, area_element};

/// See `rules/vm-06-03.md`.
pub struct NoStoppingSign;

impl Rule for NoStoppingSign {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        let view = map.view();
        let mut findings = area_element::apart(view, "no_parking_area", &["road"]);
        findings.extend(area_element::not_told(view, "no_parking_area"));
        findings
    }
}
