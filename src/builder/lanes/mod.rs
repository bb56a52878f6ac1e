//! Roads get lanes, up to where they end before an intersection.

pub(crate) mod border;
pub(crate) mod driven_borders;
pub mod gore;
pub mod lane_ends;
pub mod lanelet_validity;
pub(crate) mod reuse;
pub mod road_continuation;
pub mod road_cut;
pub mod road_lanes;
pub mod side_lanes;
pub mod types;
