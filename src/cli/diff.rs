//! `diff`: two maps in, what changed between them out.

use std::io::{Error, Write};
use std::path::{Path, PathBuf};

use crate::lanelet::{LaneletMap, open};
use crate::report::diff::Diff;
use crate::report::failure::Failure;
use crate::report::html::changes_page;
use crate::report::{HarmlessJson, visible_lines};

use super::args::{CLEAN, metres, output_file};
use super::output::{self, Progress};
use super::report_page;
use crate::api::files;
use crate::api::load::open_failure;
use clap::{Args, ValueEnum};

/// Show what changed between two Lanelet2 maps, by element and meaning; exit code 1 if anything did
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// The map as it was: a .osm file, a directory of them, or a map directory
    pub old: PathBuf,
    /// The map as it is
    pub new: PathBuf,
    /// For people or for programs
    #[arg(long, value_enum, default_value_t = DiffFormat::Text)]
    pub format: DiffFormat,
    /// What lies this close to where it was, metres, has not moved
    #[arg(long, value_name = "M", default_value_t = 0.001, value_parser = metres)]
    pub tolerance: f64,
    /// Write the changes, too: one HTML page with each element before and after, side by side
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    pub report: Option<PathBuf>,
}

/// How a diff is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DiffFormat {
    Text,
    Json,
}

/// Exit code where the maps differ, as diff(1) has it.
const DIFFERENT: u8 = 1;

/// Compares the maps and prints what changed.
pub fn run(args: &DiffArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let new = open(&args.new, None).map_err(open_failure)?;
    // In the metres of the new map, so that a map that changed its projection has not moved.
    let old = open(&args.old, Some(new.projector)).map_err(open_failure)?;
    progress.next("comparing");
    let diff = Diff::between(&old.loaded.map, &new.loaded.map, args.tolerance);
    drop(progress);
    if let Some(file) = &args.report {
        page(file, args, &diff, [&old.loaded.map, &new.loaded.map])?;
    }
    output::print_beside(args.report.as_deref(), |out| match args.format {
        DiffFormat::Text => out.write_all(visible_lines(&diff.text()).as_bytes()),
        DiffFormat::Json => {
            writeln!(HarmlessJson::new(out), "{}", serde_json::to_string_pretty(&diff).map_err(Error::other)?)
        }
    })?;
    Ok(if diff.is_empty() { CLEAN } else { DIFFERENT })
}

/// Writes the page that shows what changed.
fn page(file: &Path, args: &DiffArgs, diff: &Diff, maps: [&LaneletMap; 2]) -> Result<(), Failure> {
    let names = [&args.old, &args.new].map(|map| report_page::title(map));
    // Two versions of one file are told apart by their directories.
    let names = match names[0] == names[1] {
        true => [&args.old, &args.new].map(|map| map.display().to_string()),
        false => names,
    };
    let text = changes_page(diff, maps, [&names[0], &names[1]])
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", file.display())))?;
    files::write(file, text.as_bytes())
}
