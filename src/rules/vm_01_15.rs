//! vm-01-15: a road shoulder lies between a lane and the border of the road.

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
    /// Whether to speak of strips whose border is a copy of the road's, too, of which vm-01-16 speaks.
    copies: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let reach = (!params.copies).then_some(Reach { apart: params.apart, share: params.share });
    side_lane::judge(map, "road_shoulder", RoadType::Shoulder, reach, false)
}
