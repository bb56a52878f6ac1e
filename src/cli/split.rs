//! `split`: a map in, its cells out.

use std::path::PathBuf;

use crate::api::{Configuration, split};
use crate::cells::Divided;
use crate::report::failure::Failure;

use super::args::CLEAN;
use super::input;
use super::output::{self, Progress};
use clap::Args;

/// Width and height of a cell, metres, unless another is asked for.
pub const CELL: u32 = 100;

/// Divide a Lanelet2 map into cells that Autoware loads one by one around the vehicle
#[derive(Debug, Args)]
pub struct SplitArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    pub map: PathBuf,
    /// Directory for the folder lanelet2_map.osm with the cells, lanelet2_map_metadata.yaml, and copies of
    /// map_projector_info.yaml and lanewright.toml; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Width and height of a cell, whole metres
    #[arg(long, value_name = "M", default_value_t = CELL, value_parser = clap::value_parser!(u32).range(1..))]
    pub size: u32,
}

/// Divides the map and says what came of it.
pub fn run(args: &SplitArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let divided = split(&args.map, &args.output, args.size, &Configuration::default(), &|doing| progress.next(doing))?;
    drop(progress);
    output::tell(&args.output, &format!("{}\n{}", output::shown(&args.output), counts(&divided)))?;
    Ok(CLEAN)
}

/// How many cells there are, and how much of the map stands in more than one.
pub fn counts(divided: &Divided) -> String {
    let Divided { cells, elements, written, .. } = divided;
    let more = 100.0 * (*written as f64 / (*elements).max(1) as f64 - 1.0);
    let counts = input::counts(&[(cells.len(), "cell", "cells"), (*elements, "element", "elements")]);
    format!("{counts}  {more:>6.0} % more in all cells, for what stands in several\n")
}
