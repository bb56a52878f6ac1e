//! Maps that are loaded, judged by the rules, reported and fixed.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

mod area_doors;
mod areas;
mod autoware_names;
#[path = "../common/mod.rs"]
mod common;
mod cures_that_fit;
mod dead_ends;
mod differences;
mod divided_lanelets;
mod divided_maps;
mod driving_side;
mod element_extents;
mod false_alarms;
#[path = "../fault_injection/mod.rs"]
mod fault_injection;
mod first_screen;
mod fix_of_each_fault;
mod fixes;
mod floors_and_gaps;
mod formats;
mod lanelet2_claims;
mod loader;
mod malformed_input;
mod mirror_image;
mod official_findings;
mod official_maps;
mod planner_attention;
mod planner_readme;
mod projections;
mod routes;
mod rules;
mod said_of_strangers;
mod said_of_turns;
mod shapes_of_strangers;
mod strangers_maps;
mod tier4_conformance;
mod two_way;
mod unloaded_lanelets;
mod unmarked_intersections;
mod words;
