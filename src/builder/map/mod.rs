//! Room 5: the map under construction, its ids and its points.

pub mod map_builder;
pub(crate) mod point_index;
