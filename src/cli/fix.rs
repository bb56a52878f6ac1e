//! `fix`: a map in, the map mended in place, or what would be changed.

use std::path::Path;

use crate::diagnostic::{Diagnostic, Severity};
use crate::fix::{FixError, Mended, mend};
use crate::lanelet::index::{MapIndex, Thresholds};
use crate::lanelet::{files_of, from_osm};
use crate::osm::{OsmData, Source};
use crate::report::failure::Failure;
use crate::report::visible;
use crate::rules::Config;
use crate::{rules, triage};

use super::check_args::ConfigArgs;
use super::load::{Loaded, open_failure};
use super::screen::Progress;
use super::{CLEAN, FixArgs, files, screen};

use similar::TextDiff;

/// Exit code where an error is left, or `--diff` has something to show.
const LEFT: u8 = 1;

/// Mends the map and says what was done.
pub fn run(args: &FixArgs) -> Result<u8, Failure> {
    let (before, mended) = mended(&args.map, &args.config, args.r#unsafe)?;
    if args.diff {
        let diff = diff(&before, &mended.osm.sources);
        screen::print(&diff)?;
        return Ok(if diff.is_empty() { CLEAN } else { LEFT });
    }
    publish(&args.map, &before, &mended.osm.sources)?;
    screen::print(&told(&mended))?;
    Ok(if mended.left.iter().any(|one| one.severity == Severity::Error) { LEFT } else { CLEAN })
}

/// Mends the map in place and says what was done on standard error.
pub fn in_place(map: &Path, config: &ConfigArgs, unsafe_too: bool) -> Result<(), Failure> {
    let (before, mended) = mended(map, config, unsafe_too)?;
    publish(map, &before, &mended.osm.sources)?;
    screen::complain(&told(&mended));
    Ok(())
}

/// The files as they were, and the map mended.
fn mended(map: &Path, config: &ConfigArgs, unsafe_too: bool) -> Result<(Vec<Source>, Mended), Failure> {
    let progress = Progress::start("reading");
    let loaded = Loaded::read(map, config)?;
    progress.next("mending");
    Ok((loaded.osm.sources.clone(), mended_map(&loaded, unsafe_too)?))
}

/// What a map says, mended.
pub fn mended_map(map: &Loaded, unsafe_too: bool) -> Result<Mended, Failure> {
    let Loaded { projector, info, settings, .. } = map;
    let judge = |osm: &OsmData| -> Result<Vec<Diagnostic>, Failure> {
        let mut loaded = from_osm(osm, projector);
        info.judge(osm, projector, &mut loaded.faults);
        let index = MapIndex::new(&loaded.map, &loaded.faults, settings, Thresholds::default());
        let found = rules::run(&index, &Config::from(settings)).map_err(|error| Failure::new(error.to_string()))?;
        // What somebody has answered for is not mended.
        Ok(triage::sort(found, settings, osm, &loaded.map, None).left)
    };
    mend(map.osm.clone(), unsafe_too, judge).map_err(|error| match error {
        FixError::Judge(failure) => failure,
        FixError::Read(error) => Failure::new(format!("the mended map cannot be read: {error}"))
            .help("nothing was changed; please report this"),
    })
}

/// Writes the files that changed, all or none.
fn publish(map: &Path, before: &[Source], after: &[Source]) -> Result<(), Failure> {
    let paths = files_of(map).map_err(open_failure)?;
    let mut changed: Vec<(&Path, &[u8])> = Vec::new();
    for ((path, old), new) in paths.iter().zip(before).zip(after) {
        if old.text == new.text {
            continue;
        }
        if path.extension().is_some_and(|extension| extension != "osm") {
            return Err(Failure::new(format!("{} is packed", path.display()))
                .help("unpack it first; only plain .osm files are edited, and nothing was changed"));
        }
        changed.push((path, new.text.as_bytes()));
    }
    files::write_all(&changed)
}

/// A unified diff of every file that changed.
fn diff(before: &[Source], after: &[Source]) -> String {
    let changed = before.iter().zip(after).filter(|(old, new)| old.text != new.text);
    changed
        .map(|(old, new)| {
            let lines = TextDiff::from_lines(&old.text, &new.text);
            lines.unified_diff().context_radius(3).header(&old.name, &new.name).to_string()
        })
        .collect()
}

fn told(mended: &Mended) -> String {
    let mut text = String::new();
    for (word, mends) in [("fixed", &mended.done), ("not kept", &mended.refused)] {
        for mend in mends {
            text += &format!("{word}[{}] {}: {}\n", mend.code, mend.subject, visible(&mend.title));
        }
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
    text + "\n"
}
