//! `fmt`: a map in, the same map in canonical form out, in place.

use std::path::{Path, PathBuf};

use crate::fix::canonical;
use crate::lanelet::open;
use crate::report::failure::Failure;

use super::args::CLEAN;
use super::output;
use crate::api::files;
use crate::api::load::open_failure;
use clap::Args;

/// Write a Lanelet2 map in canonical form, in place: the same elements give the same bytes
#[derive(Debug, Args)]
pub struct FmtArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    pub map: PathBuf,
    /// Change nothing; exit code 1 if a file is not formatted
    #[arg(long)]
    pub check: bool,
}

/// Exit code of `--check` where a file would change.
const WOULD_CHANGE: u8 = 1;

/// Formats the files of a map, or says which are not formatted.
pub fn run(args: &FmtArgs) -> Result<u8, Failure> {
    let opened = open(&args.map, None).map_err(open_failure)?;
    let mut changed: Vec<(&Path, String)> = Vec::new();
    for (path, source) in opened.files.iter().zip(&opened.osm.sources) {
        let text = canonical(&source.text).ok_or_else(|| {
            Failure::new(format!("{} cannot be formatted", path.display())).help("nothing was changed")
        })?;
        if text != source.text {
            changed.push((path, text));
        }
    }
    let told: String = changed
        .iter()
        .map(|(path, _)| format!("{}: {}\n", path.display(), if args.check { "not formatted" } else { "formatted" }))
        .collect();
    if args.check {
        output::print(&told)?;
        return Ok(if changed.is_empty() { CLEAN } else { WOULD_CHANGE });
    }
    if let Some((packed, _)) = changed.iter().find(|(path, _)| path.extension().is_some_and(|one| one != "osm")) {
        return Err(Failure::new(format!("{} is packed", packed.display()))
            .help("unpack it first; only plain .osm files are formatted, and nothing was changed"));
    }
    let texts: Vec<(&Path, &[u8])> = changed.iter().map(|(path, text)| (*path, text.as_bytes())).collect();
    files::write_all(&texts)?;
    output::print(&told)?;
    Ok(CLEAN)
}
