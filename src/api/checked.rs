//! A map that was held against the rules.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Diagnostic, Severity};
use crate::lanelet::LaneletMap;
use crate::lanelet::index::MapIndex;
use crate::osm::OsmData;
use crate::projection::{LonLat, Projector};
use crate::report::failure::Failure;
use crate::report::{Report, Sources};
use crate::rules::{self, Config};
use crate::settings::Settings;
use crate::triage::{self, Baseline, Sorted, Suppressions};

use super::config::Configuration;
use super::error::{Error, ErrorKind};
use super::load::Loaded;
use super::{InMemory, Input, files};

/// What counts in a check.
#[derive(Clone, Debug, Default)]
pub struct CheckOptions {
    /// Which settings count, which rules are asked, whose reading of them.
    pub configuration: Configuration,
    /// Findings of an earlier run, which are known and left out.
    pub baseline: Option<Input>,
    /// Parameters of the existing validator in place of its own, by validator; for its profile only.
    pub peer_parameters: Option<BTreeMap<String, toml::Table>>,
}

/// A map and what there is to say of it.
#[derive(Debug)]
pub struct Checked {
    /// The map.
    pub loaded: Loaded,
    /// The findings that count, and how many were left out.
    pub sorted: Sorted,
}

impl Checked {
    /// Holds a map against the rules.
    ///
    /// # Errors
    ///
    /// Where the baseline cannot be read, or a parameter has a value of the wrong type.
    pub fn of(loaded: Loaded, options: CheckOptions) -> Result<Self, Error> {
        let baseline = options.baseline.as_ref().map(read_baseline).transpose()?;
        let suppressions = Suppressions::of(&loaded.settings, &loaded.osm);
        Self::judge(loaded, suppressions, options.peer_parameters, baseline.as_ref())
    }

    /// Asks for no element of the files.
    pub(crate) fn judge(
        loaded: Loaded,
        suppressions: Suppressions,
        peer_parameters: Option<BTreeMap<String, toml::Table>>,
        baseline: Option<&Baseline>,
    ) -> Result<Self, Error> {
        let found = judged(&loaded, &Config { peer_parameters, ..Config::from(&loaded.settings) })?;
        let sorted = triage::sort(found, &loaded.settings, suppressions, &loaded.map, baseline);
        Ok(Self { loaded, sorted })
    }

    /// All that shows what was found: for the functions of [`crate::report`].
    pub fn with_report<T>(&self, show: impl FnOnce(&Report<'_>) -> T) -> T {
        let Self { loaded: Loaded { osm, map, projector, settings, .. }, sorted } = self;
        with_report((osm, map), (projector, settings), sorted, show)
    }

    /// All findings as a baseline: `CheckOptions::baseline` of a later run leaves them out.
    pub fn baseline(&self) -> Baseline {
        // What triage says is about suppressions; they are mended, not remembered.
        let found = self.sorted.left.iter().filter(|one| !one.code.starts_with("triage/"));
        Baseline::of(&found.cloned().collect::<Vec<Diagnostic>>())
    }

    /// Writes all findings into a baseline, whole or not at all.
    ///
    /// # Errors
    ///
    /// Where the file cannot be written.
    pub fn write_baseline(&self, file: &Path) -> Result<(), Error> {
        write_baseline(&self.baseline(), file)
    }
}

/// All that shows what was found in a map.
pub(super) fn with_report<T>(
    (osm, map): (&OsmData, &LaneletMap),
    (projector, settings): (&Projector, &Settings),
    sorted: &Sorted,
    show: impl FnOnce(&Report<'_>) -> T,
) -> T {
    let sources = Sources::new(osm.sources.iter().map(|s| (s.name.as_str(), s.text.as_str())));
    let mut requirements = rules::selected(&Config::from(settings));
    if sorted.suppressed + sorted.known > 0 || sorted.left.iter().any(|one| one.code.starts_with("triage/")) {
        requirements.extend(triage::requirement().ok());
    }
    let to_globe =
        |points: &[_]| -> Option<Vec<LonLat>> { projector.inverse_each(points, |_| 0.0).into_iter().collect() };
    let root = repository();
    show(&Report {
        requirements: &requirements,
        show: Severity::Warning,
        suppressed: sorted.suppressed,
        known: sorted.known,
        accepted: &sorted.reasons,
        unproject: Some(&to_globe),
        root: root.as_deref(),
        ..Report::new(&sorted.left, &sources, map)
    })
}

/// Writes a baseline, whole or not at all.
///
/// # Errors
///
/// Where the file cannot be written.
pub fn write_baseline(baseline: &Baseline, file: &Path) -> Result<(), Error> {
    let mut text = Vec::new();
    let failed = |what: std::io::Error| {
        ErrorKind::Write.error(Failure::new(format!("cannot write the baseline {}: {what}", file.display())))
    };
    baseline.write(&mut text).map_err(failed)?;
    files::write(file, &text).map_err(ErrorKind::Write.of())
}

/// What the loader and the rules say about a map.
pub(crate) fn judged(loaded: &Loaded, config: &Config) -> Result<Vec<Diagnostic>, Error> {
    let index = MapIndex::new(&loaded.map, &loaded.faults, &loaded.settings);
    rules::run(&index, config).map_err(|error| ErrorKind::Config.error(Failure::new(error.to_string())))
}

/// The root of the repository that we run in; without one, the directory itself.
fn repository() -> Option<PathBuf> {
    let here = std::env::current_dir().ok()?;
    let root = here.ancestors().find(|directory| directory.join(".git").exists());
    Some(root.unwrap_or(&here).to_path_buf())
}

/// Reads a baseline.
pub(crate) fn read_baseline(input: &Input) -> Result<Baseline, Error> {
    let name = input.name();
    let failed = |message: String, help: &str| ErrorKind::Read.error(Failure::new(message).about(&name).help(help));
    let text = match input {
        Input::Path(path) => std::fs::read_to_string(path),
        Input::Bytes(InMemory { bytes, .. }) => String::from_utf8(bytes.clone()).map_err(std::io::Error::other),
    };
    let text = text.map_err(|error| {
        failed(format!("cannot read the baseline {name}: {error}"), "--write-baseline FILE makes one")
    })?;
    Baseline::parse(&text).map_err(|error| failed(format!("{name}: {error}"), "--write-baseline FILE writes it anew"))
}
