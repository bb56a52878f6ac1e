//! Builds Autoware-ready Lanelet2 maps from road centre lines and holds any Lanelet2 map against Autoware's
//! vector-map requirements.
//!
//! Each layer uses those below it and none above:
//!
//! ```text
//! layer 4   main, cli                                 arguments in, exit code out
//! layer 3   builder | rules | triage | fix | report   none of them imports another
//!           tiles | cells | three_way
//! layer 2   planner                                   what Autoware's planner will do with a map
//!           lanelet, requirement, settings            the map in Lanelet2's words; a document of rules/ parsed
//!           lane_stitching                              lanes stitched and painted, kept so through edits
//!           element_edits                             edits of one element, in its own text
//! layer 1   osm, terrain, diagnostic, projection, geometry, text  know nothing of ours
//! ```
//!
//! The verbs of the command line are functions of this crate, on files or on bytes:
//!
//! ```
#![doc = include_str!("../examples/build.rs")]
//! ```
//!
//! ```
#![doc = include_str!("../examples/check.rs")]
//! ```
//!
//! Units, said once: metres, seconds, radians; speeds as maps write them (km/h); coordinates in the plane are
//! east, north. Angles turn counter-clockwise, so a left turn is positive.

// CONTRIBUTING.md says why the modules that do not warn of indices have some.
#[warn(clippy::indexing_slicing)]
pub mod api;
pub mod builder;
#[warn(clippy::indexing_slicing)]
pub mod cancel;
pub mod cells;
#[cfg(feature = "cli")]
pub mod cli;
#[warn(clippy::indexing_slicing)]
pub mod diagnostic;
#[warn(clippy::indexing_slicing)]
mod element_edits;
#[warn(clippy::indexing_slicing)]
pub mod fix;
pub mod geometry;
pub mod lane_stitching;
pub mod lanelet;
#[warn(clippy::indexing_slicing)]
pub mod osm;
#[warn(clippy::indexing_slicing)]
mod parallel;
pub mod planner;
pub mod projection;
pub mod report;
#[warn(clippy::indexing_slicing)]
pub mod requirement;
pub mod rules;
#[warn(clippy::indexing_slicing)]
pub mod settings;
#[warn(clippy::indexing_slicing)]
pub mod terrain;
#[warn(clippy::indexing_slicing)]
pub mod text;
pub mod three_way;
#[warn(clippy::indexing_slicing)]
pub mod tiles;
#[warn(clippy::indexing_slicing)]
pub mod triage;
#[warn(clippy::indexing_slicing)]
pub mod xodr;

pub use api::{Input, build, check, fix, geometry};
