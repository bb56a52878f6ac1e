//! `git-setup`: git merges and shows maps by element and meaning. `git-text`: what git shows of a map.

use std::path::{Path, PathBuf};

use crate::api::{GitSetup, MAPS, SetupKind, load};
use crate::osm::read_file;
use crate::report::failure::Failure;
use crate::three_way::plain_text;

use super::args::CLEAN;
use super::output;
use clap::Args;

/// Tell a git repository to merge and show maps by element and meaning
#[derive(Debug, Args)]
#[command(after_help = "Everybody who merges runs it once in the own clone; docs/merge.md")]
pub struct GitSetupArgs {
    /// A directory of the repository
    #[arg(default_value = ".")]
    pub dir: PathBuf,
    /// Which files are maps, as .gitattributes names them
    #[arg(long, value_name = "PATTERN", default_value = MAPS)]
    pub maps: String,
    /// Let git merge without a look for findings that neither version has: for maps that take minutes to check
    #[arg(long)]
    pub no_check: bool,
    /// Change nothing; show what would be done
    #[arg(long)]
    pub dry_run: bool,
}

/// Print a map as text by element and meaning, in an order that does not depend on the file: what git compares for `git diff`
#[derive(Debug, Args)]
pub struct GitTextArgs {
    /// A .osm file
    pub map: PathBuf,
}

/// Sets a repository up and says what was done.
pub fn setup(args: &GitSetupArgs) -> Result<u8, Failure> {
    let setup = GitSetup::plan(&args.dir, &args.maps, args.no_check)?;
    if !args.dry_run {
        setup.apply()?;
    }
    let mut text = String::new();
    for step in &setup.steps {
        let (place, what) = match &step.what {
            SetupKind::Config(key, value) => ("git config", format!("{key} = {value}")),
            SetupKind::Attribute(line) => (".gitattributes", line.clone()),
        };
        let done = match (step.is_done, args.dry_run) {
            (true, _) => "known",
            (false, true) => "to add",
            (false, false) => "added",
        };
        text += &format!("{done:<7} {place:<15} {what}\n");
    }
    if !args.dry_run {
        text += "commit .gitattributes; each clone that merges runs `lanewright git-setup` once\n";
    }
    output::tell(Path::new(""), &text)?;
    Ok(CLEAN)
}

/// Prints a map as text.
pub fn text(args: &GitTextArgs) -> Result<u8, Failure> {
    // A file that is new, or gone, is compared with an empty one.
    if std::fs::metadata(&args.map).is_ok_and(|file| file.len() == 0) {
        return Ok(CLEAN);
    }
    let osm = read_file(&args.map).map_err(load::read_failure)?;
    output::print(&plain_text(&osm))?;
    Ok(CLEAN)
}
