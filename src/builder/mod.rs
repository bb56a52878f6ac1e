//! From OpenStreetMap to a Lanelet2 map, one stage a file. Each stage borrows what came before and returns a new value.
//!
//! ```text
//! OsmData ─road_network→ RoadNetwork ─consolidate→ RoadNetwork ─outline→ Outlines ─lanes→ Lanes ─movement→ Movements
//!     └→ conflict, crosswalk, control, right_of_way ─assemble→ LaneletMap
//! ```
//!
//! Widths come before the outline (the cut-back needs the roads' edges), lane borders after it (they end at the cut).
//! Everything speaks of near and far, never of left and right, except where a tag or a role does.

pub(crate) mod across;
pub mod alignment;
pub mod area;
pub mod assemble;
pub mod assembly;
pub mod beside;
pub(crate) mod blinker;
mod build;
pub mod conflict;
pub mod connection;
pub mod consolidate;
pub mod control;
pub mod course;
pub mod cramped;
pub mod cross_section;
pub mod crosswalk;
pub mod cycle;
pub mod dead_lanes;
pub mod draft;
pub mod driving_side;
pub mod geojson;
pub mod grid;
pub mod heights;
pub mod ids;
pub mod inside;
pub mod join;
pub(crate) mod lane_choice;
pub mod lanes;
pub(crate) mod marking;
pub(crate) mod midway;
pub mod movement;
pub mod origins;
pub mod outline;
pub(crate) mod overhead;
pub mod paths;
pub(crate) mod pen;
pub(crate) mod places;
pub mod restricted;
pub mod ring;
pub mod road_network;
pub mod seam;
pub mod settle;
pub mod sidecar;
pub mod single_lanes;
pub mod sound;
pub(crate) mod speed;
pub mod streets;
pub mod stretch;
pub(crate) mod tags;
#[cfg(test)]
mod tests;
pub mod walkway;

pub use build::{BuildError, BuildOptions, Built, Plan, Summary, UNMET_WISH, build, build_plan, plan};
