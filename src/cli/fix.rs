//! `fix`: a map in, the map mended in place, or what would be changed.

use std::path::{Path, PathBuf};

use crate::api::{Fixed, Loaded};
use crate::diagnostic::Severity;
use crate::fix::Mended;
use crate::report::failure::Failure;
use crate::report::visible;

use super::args::CLEAN;
use super::check_args::ConfigArgs;
use super::fix_pictures;
use super::output::{self, Progress};
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
    /// Make fixes that need a look afterwards, too
    #[arg(long)]
    pub r#unsafe: bool,
    #[command(flatten)]
    pub config: ConfigArgs,
}

/// Exit code where an error is left, or `--diff` has something to show.
const LEFT: u8 = 1;

/// Mends the map and says what was done.
pub fn run(args: &FixArgs) -> Result<u8, Failure> {
    let fixed = fixed(&args.map, &args.config, args.r#unsafe)?;
    if let Some(dir) = &args.pictures {
        let count = fix_pictures::write(dir, &fixed)?;
        output::complain(&format!("{}: {count} places\n", dir.join("index.html").display()));
    }
    if args.diff {
        let diff = fixed.diff();
        output::print(&diff)?;
        return Ok(if diff.is_empty() { CLEAN } else { LEFT });
    }
    fixed.write()?;
    output::print(&told(&fixed.mended))?;
    Ok(if fixed.mended.left.iter().any(|one| one.severity == Severity::Error) { LEFT } else { CLEAN })
}

/// Mends the map in place and says what was done on standard error.
pub fn in_place(map: &Path, config: &ConfigArgs, unsafe_too: bool) -> Result<(), Failure> {
    let fixed = fixed(map, config, unsafe_too)?;
    fixed.write()?;
    output::complain(&told(&fixed.mended));
    Ok(())
}

fn fixed(map: &Path, config: &ConfigArgs, unsafe_too: bool) -> Result<Fixed, Failure> {
    let progress = Progress::start("reading");
    let loaded = Loaded::read(map, &config.configuration())?;
    progress.next("mending");
    let tell = |made, open| progress.next(&format!("mending: {made} fixes made, {open} open"));
    Ok(Fixed::telling(loaded, unsafe_too, &tell)?)
}

fn told(mended: &Mended) -> String {
    let mut text = String::new();
    for mend in &mended.done {
        text += &format!("fixed[{}] {}: {}\n", mend.code, mend.subject, visible(&mend.title));
    }
    for (mend, reason) in &mended.refused {
        let reason = visible(reason.trim_end_matches('.'));
        text += &format!("not kept[{}] {}: {} ({reason})\n", mend.code, mend.subject, visible(&mend.title));
    }
    let count = |severity| mended.left.iter().filter(|one| one.severity == severity).count();
    text += &format!("{} fixed", mended.done.len());
    if !mended.refused.is_empty() {
        text += &format!(", {} not kept because they mend nothing or bring an error", mended.refused.len());
    }
    text += &format!("; left: {} errors, {} warnings", count(Severity::Error), count(Severity::Warning));
    if mended.unsafe_left > 0 {
        text += &format!(", {} of them with a fix that needs a look (--unsafe)", mended.unsafe_left);
    }
    text += "\n";
    if mended.revealed > 0 {
        text += &format!(
            "{} of the errors left were not told before: rules now look at the intersections that were marked\n",
            mended.revealed
        );
    }
    text
}
