//! access: who may drive on a lanelet, and how fast, by what Autoware and Lanelet2 make of its tags.

mod closed;
mod not_road;
mod speed;

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::NoParams;
pub use not_road::meant_subtype;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let mut findings = not_road::judge(map);
    findings.extend(closed::judge(map));
    findings.extend(speed::judge(map));
    findings
}
