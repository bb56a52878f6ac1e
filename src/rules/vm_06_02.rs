//! vm-06-02: an area without parking has an element that lanelets refer to on which vehicles drive or pull over.

use serde::Deserialize;

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

use super::area_element;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    roads_only: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let referrers: &[&str] = if params.roads_only { &["road"] } else { &["road", "road_shoulder"] };
    area_element::judge(map.view(), "no_parking_area", referrers)
}
