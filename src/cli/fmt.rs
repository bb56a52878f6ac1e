//! `fmt`: a map in, the same map in canonical form out, in place.

use std::path::{Path, PathBuf};

use crate::fix::canonical;
use crate::lanelet::open;
use crate::osm::Source;
use crate::report::failure::Failure;
use crate::text::unified_diff;

use super::args::CLEAN;
use super::output;
use crate::api::load::open_failure;
use crate::api::{EditedFile, Edits};
use clap::Args;

/// Write a Lanelet2 map in canonical form, in place: the same elements give the same bytes
#[derive(Debug, Args)]
pub struct FmtArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    pub map: PathBuf,
    /// Change nothing; exit code 1 if a file is not formatted
    #[arg(long)]
    pub check: bool,
    /// Change nothing; show the changes as a unified diff; exit code 1 if a file is not formatted
    #[arg(long)]
    pub diff: bool,
}

/// Exit code of `--check` and `--diff` where a file would change.
const WOULD_CHANGE: u8 = 1;

/// Formats the files of a map, or says which are not formatted.
pub fn run(args: &FmtArgs) -> Result<u8, Failure> {
    let opened = open(&args.map, None).map_err(open_failure)?;
    let mut changed: Vec<(&Path, &Source, String)> = Vec::new();
    for (path, source) in opened.files.iter().zip(&opened.osm.sources) {
        let text = canonical(&source.text).map_err(|unkept| {
            Failure::new(format!("{} cannot be formatted: {unkept}", path.display()))
                .help(format!("nothing was changed; {}", unkept.help))
                .at(&source.name, source.text.clone(), unkept.offset)
        })?;
        if text != source.text {
            changed.push((path, source, text));
        }
    }
    let unformatted = if changed.is_empty() { CLEAN } else { WOULD_CHANGE };
    if args.diff {
        let diffs = changed.iter().map(|(_, source, text)| {
            let formatted = Source { text: text.clone(), ..Source::clone(source) };
            unified_diff([&source.name; 2].map(String::as_str), [&source.as_written(), &formatted.as_written()])
        });
        output::print_patch(&diffs.collect::<String>())?;
        return Ok(unformatted);
    }
    let told: String = changed
        .iter()
        .map(|(path, ..)| {
            format!("{}: {}\n", output::shown(path), if args.check { "not formatted" } else { "formatted" })
        })
        .collect();
    if args.check {
        output::print(&told)?;
        return Ok(unformatted);
    }
    if let Some((packed, ..)) = changed.iter().find(|(path, ..)| path.extension().is_some_and(|one| one != "osm")) {
        return Err(Failure::new(format!("{} is packed", packed.display()))
            .help("unpack it first; only plain .osm files are formatted, and nothing was changed"));
    }
    let edits = changed.into_iter().map(|(path, old, text)| EditedFile::of(path, old, text)).collect();
    Edits { files: edits }.write()?;
    output::print(&told)?;
    Ok(CLEAN)
}
