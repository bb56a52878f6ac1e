//! Room 12: what only the whole map tells, and what the user adds.

pub(crate) mod across;
pub(crate) mod blinker;
pub mod inside;
pub(crate) mod overhead;
pub(crate) mod pen;
