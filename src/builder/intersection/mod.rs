//! Movements through an intersection, their lanelets and its area.

pub mod area_outline;
pub mod bicycle_lanelets;
pub mod conflict;
pub(crate) mod lane_assignment;
pub mod lane_reassignment;
pub mod movement;
pub mod movement_types;
pub mod ring_movements;
pub mod roundabout;
pub(crate) mod shared_bounds;
pub mod street_path;
pub mod turn_centerline;
pub mod turn_direction;
pub mod turning_lanelets;
pub mod undrivable;
