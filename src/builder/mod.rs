//! From OpenStreetMap to a Lanelet2 map: a room for each stage, in the order of the table in `docs/architecture.md`.
//!
//! ```text
//! OsmData ─network→ RoadNetwork ─streets→ Streets ─layout→ lanes and movements ─assemble, postprocess→ LaneletMap
//! ```
//!
//! Widths come before the outline (the cut-back needs the roads' edges), lane borders after it (they end at the cut).
//! Everything speaks of near and far, never of left and right, except where a tag or a role does.

pub mod assemble;
mod build;
pub mod control;
pub mod geojson;
#[warn(clippy::indexing_slicing)]
pub mod ids;
pub mod intersection;
#[warn(clippy::indexing_slicing)]
pub mod lane_export;
pub mod lanes;
pub mod layout;
pub mod map;
pub mod network;
#[warn(clippy::indexing_slicing)]
pub mod options;
pub mod postprocess;
pub mod streets;
#[warn(clippy::indexing_slicing)]
pub mod tags;
#[cfg(test)]
mod tests;

pub use build::{BuildError, Built, Summary, UNMET_WISH, build, build_plan, plan, uncontested};
pub use options::{BuildOptions, Plan};
