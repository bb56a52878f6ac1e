//! Lanes and intersections are laid out until no lanelet runs over the end of another road's lane.

mod close_intersections;
mod lane_drops;
mod lane_openings;
mod last_resorts;
pub mod layout_loop;
pub mod map_layout;
mod roads_inside;
pub mod short_links;
