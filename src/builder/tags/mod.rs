//! Reads lanes, widths, speeds and markings from tags.

pub(crate) mod admission;
pub mod cross_section;
pub mod driving_side;
pub(crate) mod marking;
pub mod road_class;
pub mod side_strips;
pub(crate) mod speed;
mod speed_limits;
pub(crate) mod values;
