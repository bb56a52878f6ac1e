//! Stop lines, traffic lights and signs, and the regulatory elements that tie them to lanes.

pub mod controlled_arm;
pub mod crosswalk;
pub mod light_places;
pub mod mid_block_signals;
pub mod pedestrian_signals;
pub(crate) mod priority_road;
pub mod signal_arrows;
pub mod stop_line;
pub mod stop_line_segments;
pub mod vehicle_signals;
pub mod walkway;
