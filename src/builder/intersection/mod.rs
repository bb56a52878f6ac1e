//! Room 9: movements through an intersection, their lanelets and its area.

pub mod area;
pub mod conflict;
pub mod course;
pub mod cycle;
pub(crate) mod lane_choice;
pub(crate) mod midway;
pub mod movement;
pub mod movement_types;
pub mod paths;
pub mod ring;
