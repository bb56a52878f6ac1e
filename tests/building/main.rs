//! Streets, networks and maps that are built from OpenStreetMap: sample maps, hand-drawn streets, real extracts, random data.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

mod areas;
#[path = "../common/mod.rs"]
mod common;
mod connectivity;
mod extracts;
mod geojson;
mod handed_cases;
mod heights;
mod lane_stitching;
mod networks;
mod opendrive;
mod opendrive_joints;
mod opendrive_lanes;
mod opendrive_signals;
mod pictures;
mod quality;
mod random_towns;
mod reference_crossings;
mod road_network;
mod samples;
mod tier4;
mod tiles;
