//! vm-01-15: a road shoulder lies between a lane and the border of the road.

use serde::Deserialize;

use crate::diagnostic::Finding;
use crate::lanelet::RoadType;
use crate::lanelet::index::MapIndex;

use super::parallel_bounds::Reach;
use super::{Rule, side_lane};

/// See `rules/vm-01-15.md`.
pub struct RoadShoulder;

/// See the document.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    apart: f64,
    share: f64,
    /// Whether to speak of strips whose border is a copy of the road's, too, of which vm-01-16 speaks.
    copies: bool,
}

impl Rule for RoadShoulder {
    type Params = Params;

    fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
        let reach = (!params.copies).then_some(Reach { apart: params.apart, share: params.share });
        side_lane::judge(map, "road_shoulder", RoadType::Shoulder, reach, false)
    }
}
