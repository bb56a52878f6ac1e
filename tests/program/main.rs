//! The program as its users run it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

mod check;
#[cfg(unix)]
mod ci;
mod cli;
#[path = "../common/mod.rs"]
mod common;
mod divided;
mod foreign_text;
mod hostile_input;
#[cfg(unix)]
mod interrupted;
mod keep;
mod merge;
mod options;
mod pbf;
#[path = "../fault_injection/pbf.rs"]
mod pbf_fields;
mod planner;
#[cfg(unix)]
mod review;
mod small_inputs;
#[cfg(unix)]
mod team;
mod tier4;
mod tiles;
#[cfg(unix)]
mod users_files;
mod view;
