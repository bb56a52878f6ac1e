//! `check`: a map in, findings and a verdict out.

use lanewright::diagnostic::Diagnostic;
use lanewright::lanelet::index::{MapIndex, Thresholds};
use lanewright::report::failure::Failure;
use lanewright::report::{self, Sources};
use lanewright::rules::{self, Config};

use super::load::Loaded;
use super::screen::{self, Progress};
use super::{CheckArgs, FormatArg};

/// Checks the map and prints what was found.
pub fn run(args: &CheckArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let loaded = Loaded::read(&args.map)?;
    progress.next("checking");
    let found = judge(&loaded, &args.select, &args.ignore)?;
    drop(progress);
    let sources = Sources::new(loaded.osm.sources.iter().map(|s| (s.name.as_str(), s.text.as_str())));
    screen::print_with(|out| match args.format {
        FormatArg::Text => report::text(out, &found, &sources, screen::stdout_style()),
        FormatArg::Concise => {
            report::concise(out, &found, &sources)?;
            writeln!(out, "{}", report::summary(&found))
        }
    })?;
    Ok(report::exit_code(&found, args.fail_on.into()))
}

/// What the loader and the rules say about a map.
pub fn judge(loaded: &Loaded, select: &[String], ignore: &[String]) -> Result<Vec<Diagnostic>, Failure> {
    let index = MapIndex::new(&loaded.map, &loaded.faults, &loaded.settings, Thresholds::default());
    let config = Config { select: select.to_vec(), ignore: ignore.to_vec(), ..Config::default() };
    rules::run(&index, &config).map_err(|error| Failure::new(error.to_string()))
}
