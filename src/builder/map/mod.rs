//! Room 5: the map under construction, its ids and its points.

pub mod assembly;
pub(crate) mod places;
