//! `stats`: a map in, numbers out.

use std::io::Error;

use crate::lanelet::index::{MapIndex, Thresholds};
use crate::report::failure::Failure;
use crate::report::stats::Stats;

use super::output::{self, Progress};
use super::{CLEAN, StatsArgs, StatsFormat};
use crate::api::{Configuration, Loaded};

/// Measures the map and prints the numbers.
pub fn run(args: &StatsArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let loaded = Loaded::read(args.map.as_path(), &Configuration::default())?;
    progress.next("measuring");
    let index = MapIndex::new(&loaded.map, &loaded.faults, &loaded.settings, Thresholds::default());
    let stats = Stats::of(&index);
    drop(progress);
    output::print_with(|out| match args.format {
        StatsFormat::Text => out.write_all(stats.text().as_bytes()),
        StatsFormat::Json => writeln!(out, "{}", serde_json::to_string_pretty(&stats).map_err(Error::other)?),
    })?;
    Ok(CLEAN)
}
