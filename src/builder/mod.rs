//! From OpenStreetMap to a Lanelet2 map: a module for each stage, in the order of the table in `docs/architecture.md`.
//!
//! ```text
//! OsmData ─network→ RoadNetwork ─streets→ Streets ─layout→ lanes and movements ─assemble, postprocess→ LaneletMap
//! ```
//!
//! Widths come before the outline (the cut-back needs the roads' edges), lane borders after it (they end at the cut).
//! Everything speaks of near and far, never of left and right, except where a tag or a role does.

pub(crate) mod assemble;
mod build;
pub(crate) mod control;
pub mod geojson;
#[warn(clippy::indexing_slicing)]
pub(crate) mod ids;
pub(crate) mod intersection;
#[warn(clippy::indexing_slicing)]
pub mod lane_export;
pub(crate) mod lanes;
pub(crate) mod layout;
pub(crate) mod map;
pub mod network;
pub(crate) mod opendrive;
#[warn(clippy::indexing_slicing)]
pub mod options;
pub(crate) mod postprocess;
pub mod streets;
#[warn(clippy::indexing_slicing)]
pub mod tags;
#[cfg(test)]
mod tests;

pub use build::{BuildError, Built, MERGE_UNMET, Summary, build, build_opendrive, build_plan, plan, uncontested};
pub use opendrive::{FileLane, Placing, note as opendrive_note};
pub use options::{BuildOptions, Plan};
pub use postprocess::user_elements::UNDRAWN;
