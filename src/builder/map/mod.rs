//! The map under construction, its ids and its points.

#[warn(clippy::indexing_slicing)]
pub mod map_builder;
pub(crate) mod point_index;
