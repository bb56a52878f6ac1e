//! Diagnostics and maps made readable: for people, for CI, for other programs.

pub mod draw;
pub mod failure;
