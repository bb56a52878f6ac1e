//! `fix`: a map in, the map mended in place, or what would be changed.

use std::path::{Path, PathBuf};

use crate::api::review::ReviewOptions;
use crate::api::{Fixed, Loaded, read_baseline};
use crate::diagnostic::Severity;
use crate::fix::Scope;
use crate::report::failure::Failure;
use crate::triage::Baseline;

use super::args::CLEAN;
use super::check_args::{ConfigArgs, SeverityArg};
use super::output::{self, Progress};
use super::{fix_pictures, fix_summary, interactive};
use clap::Args;

/// Mend a Lanelet2 map in place, changing no more lines than necessary; a fix that causes a new error is not kept
#[derive(Debug, Args)]
pub struct FixArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    pub map: PathBuf,
    /// Show what would be changed and change nothing; exit code 1 if there is anything
    #[arg(long)]
    pub diff: bool,
    /// Write pictures of the places that are mended, before and after side by side, and a page to look through
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// Make fixes that need review afterwards, too
    #[arg(long)]
    pub r#unsafe: bool,
    /// Show the fixes that need review one after another at the terminal, and ask about each; nothing is written before you say so
    #[arg(long, conflicts_with_all = ["diff", "pictures", "unsafe", "allow_warnings", "show"])]
    pub interactive: bool,
    /// Mend nothing that this file lists; --interactive writes rejected fixes into it, with reasons [default there: baseline.json
    /// beside the map]
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// Make fixes, too, that bring more warnings than they mend errors; else these are listed as not kept
    #[arg(long)]
    pub allow_warnings: bool,
    /// Least severity of findings that are mended [default: warning, or info with --select]
    #[arg(long, value_enum, value_name = "SEVERITY")]
    pub show: Option<SeverityArg>,
    #[command(flatten)]
    pub config: ConfigArgs,
}

/// Exit code where an error is left, or `--diff` has something to show.
const LEFT: u8 = 1;

/// Mends the map and says what was done.
pub fn run(args: &FixArgs) -> Result<u8, Failure> {
    if args.interactive {
        let options = ReviewOptions {
            map: args.map.clone(),
            configuration: args.config.configuration(),
            baseline: args.baseline.clone(),
        };
        return interactive::run(options);
    }
    let scope = Scope {
        unsafe_too: args.r#unsafe,
        warnings_too: args.allow_warnings,
        least: args.show.map_or(Severity::Warning, Severity::from),
        ..Scope::default()
    };
    let baseline = args.baseline.as_deref().map(|file| read_baseline(&file.into())).transpose()?;
    let fixed = fixed(&args.map, &args.config, scope, baseline.as_ref())?;
    if let Some(dir) = &args.pictures {
        let count = fix_pictures::write(dir, &fixed)?;
        output::complain(&format!("{}: {count} places\n", output::shown(&dir.join("index.html"))));
    }
    if args.diff {
        let diff = fixed.diff();
        output::print_patch(&diff)?;
        output::complain(&format!("{}\n", fix_summary::change(&fixed.mended)));
        return Ok(if diff.is_empty() { CLEAN } else { LEFT });
    }
    fixed.write()?;
    output::tell(&args.map, &fix_summary::summary(&fixed.mended))?;
    Ok(if fixed.mended.left.iter().any(|one| one.severity == Severity::Error) { LEFT } else { CLEAN })
}

/// Mends the map in place and says what was done on standard error.
pub fn in_place(map: &Path, config: &ConfigArgs, unsafe_too: bool, least: Severity) -> Result<(), Failure> {
    let fixed = fixed(map, config, Scope { unsafe_too, least, ..Scope::default() }, None)?;
    fixed.write()?;
    output::complain(&fix_summary::summary(&fixed.mended));
    Ok(())
}

fn fixed(map: &Path, config: &ConfigArgs, scope: Scope, baseline: Option<&Baseline>) -> Result<Fixed, Failure> {
    let progress = Progress::start("reading");
    let loaded = Loaded::read(map, &config.configuration())?;
    progress.next("mending");
    let tell = |made, open| progress.next(&format!("mending: {made} fixes made, {open} open"));
    Ok(Fixed::telling(loaded, scope.naming(&config.select), baseline, &tell)?)
}
