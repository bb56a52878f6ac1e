//! Room 12: what only the whole map tells, and what the user adds.

pub(crate) mod cross_line;
pub(crate) mod grade_separation;
pub(crate) mod map_editor;
pub(crate) mod turn_signal;
pub mod user_elements;
