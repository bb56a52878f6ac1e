//! Room 8: roads get lanes, up to where they end before an intersection.

pub mod beside;
pub(crate) mod border;
pub mod connection;
pub mod cut;
pub mod join;
pub(crate) mod renewed;
pub mod road_lanes;
pub mod seam;
pub mod sound;
pub mod types;
