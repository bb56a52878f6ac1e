//! vm-01-16: a road shoulder and the road beside it have one way between them.

use serde::Deserialize;

use crate::diagnostic::Finding;
use crate::lanelet::RoadType;
use crate::lanelet::index::MapIndex;

use super::parallel_bounds::Reach;
use super::side_lane;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    apart: f64,
    share: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let reach = Reach { apart: params.apart, share: params.share };
    side_lane::judge_copies(map, RoadType::Shoulder, "road_shoulder", reach)
}
