//! Changes that need the finished map, and elements that the user adds.

pub(crate) mod cross_line;
pub(crate) mod grade_separation;
pub(crate) mod map_editor;
pub(crate) mod shared_borders;
pub(crate) mod tier4;
pub(crate) mod turn_signal;
pub mod user_elements;
