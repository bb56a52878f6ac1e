//! Room 10: lanes and intersections are laid out until no lanelet runs over the end of another road's lane.

pub mod cramped;
pub mod draft;
pub mod settle;
