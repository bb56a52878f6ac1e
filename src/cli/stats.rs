//! `stats`: a map in, numbers out.

use std::io::{Error, Write};
use std::path::PathBuf;

use crate::lanelet::index::MapIndex;
use crate::report::HarmlessJson;
use crate::report::failure::Failure;
use crate::report::stats::Stats;

use super::args::CLEAN;
use super::output::{self, Progress};
use crate::api::{Configuration, Loaded};
use clap::{Args, ValueEnum};

/// Show what a Lanelet2 map contains: counts, lengths, widths, curvature, connected parts, what it lacks
#[derive(Debug, Args)]
pub struct StatsArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    pub map: PathBuf,
    /// For people or for programs
    #[arg(long, value_enum, default_value_t = StatsFormat::Text)]
    pub format: StatsFormat,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StatsFormat {
    Text,
    Json,
}

/// Measures the map and prints the numbers.
pub fn run(args: &StatsArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let loaded = Loaded::read(args.map.as_path(), &Configuration::default())?;
    progress.next("measuring");
    let index = MapIndex::new(&loaded.map, &loaded.faults, &loaded.settings);
    let stats = Stats::of(&index);
    drop(progress);
    match args.format {
        StatsFormat::Text => output::print(&stats.text())?,
        StatsFormat::Json => output::print_with(|out| {
            writeln!(HarmlessJson::new(out), "{}", serde_json::to_string_pretty(&stats).map_err(Error::other)?)
        })?,
    }
    Ok(CLEAN)
}
