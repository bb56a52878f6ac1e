//! Diagnostics and maps made readable: for people, for CI, for other programs. Knows no rule.

mod concise;
pub mod draw;
mod explain;
pub mod failure;
mod source;
mod text;
mod verdict;

pub use concise::{concise, summary};
pub use explain::{explain, list};
pub use source::{Position, Sources};
pub use text::{GRAPHICAL_LIMIT, TextStyle, text};
pub use verdict::{FailOn, exit_code, worst};
