//! A map that was mended, in memory until it is written.

#[cfg(feature = "cli")]
use std::path::Path;
use std::path::PathBuf;

use crate::diagnostic::{Diagnostic, Subject};
use crate::fix::{FixError, Mend, Mended, Scope, mend};
use crate::lanelet::{Condition, INFO, InfoFault, Loaded as FromOsm, ProjectorInfo, from_osm};
use crate::osm::{OsmData, ReadError, Source};
use crate::projection::{Projector, VerticalDatum, write_info};
use crate::report::failure::Failure;
use crate::text::unified_diff;
use crate::triage::{Baseline, Sorted};

use super::Input;
use super::checked::Checked;
use super::config::Configuration;
use super::error::{Error, ErrorKind};
use super::files::{self, Rewritten, Was};
use super::judge::{MapJudge, found_of_projector};
use super::load::{Loaded, is_packed};

/// What is mended.
#[derive(Clone, Debug, Default)]
pub struct FixOptions {
    /// Which settings count, which rules are asked: what they do not find is not mended.
    pub configuration: Configuration,
    /// Which fixes are made: those of errors and warnings that need no look, if nothing else is said.
    pub scope: Scope,
    /// Findings that are known: they are not mended.
    pub baseline: Option<Input>,
}

/// A map as it was and as it is, with what was done.
#[derive(Debug)]
pub struct Fixed {
    /// The map as it was.
    pub loaded: Loaded,
    /// The map as it is, what was done to it, what is left.
    pub mended: Mended,
    /// The projector's file that was missing beside the map.
    projector_file: Option<ProjectorFile>,
}

/// A `map_projector_info.yaml` to be written beside a map.
#[derive(Clone, Debug)]
pub(super) struct ProjectorFile {
    path: PathBuf,
    source: Source,
    /// What it names.
    pub(super) projector: Projector,
}

impl ProjectorFile {
    /// The one that a map lacks: with the projector that its coordinates tell, or with the MGRS square to which Autoware falls back. Heights
    /// are taken to be from the ellipsoid, as Autoware does: that is why it needs review.
    pub(super) fn missing(map: &Loaded) -> Option<Self> {
        let needed = map.faults.iter().find_map(|fault| match fault.condition {
            Condition::ProjectorInfo(InfoFault::Missing { needed, .. }) => Some(needed.unwrap_or(map.projector)),
            _ => None,
        })?;
        let path = map.files.first()?.with_file_name(INFO);
        let text = write_info(&needed, VerticalDatum::default());
        let source = Source { name: path.display().to_string(), text, marked: false };
        Some(Self { path, source, projector: needed })
    }

    pub(super) fn info(&self) -> ProjectorInfo {
        ProjectorInfo::of(&self.path, &self.source.text)
    }

    /// What writing it does, in one line.
    pub(super) fn title(&self) -> String {
        format!("write {INFO}: {}", self.projector)
    }

    pub(super) fn edited(&self) -> EditedFile {
        EditedFile { path: Some(self.path.clone()), source: self.source.clone(), was: None }
    }

    pub(super) fn diff(&self) -> String {
        let name = &self.source.name;
        unified_diff([name, name], ["", &self.source.as_written()])
    }
}

/// The finding that the file mends.
pub(super) const PROJECTOR_MISSING: &str = "projector/missing";

impl Fixed {
    /// Mends a map.
    ///
    /// # Errors
    ///
    /// Where a parameter has a value of the wrong type, or the map is divided into cells.
    pub fn of(loaded: Loaded, scope: impl Into<Scope>) -> Result<Self, Error> {
        Self::telling(loaded, scope.into(), None, &|_, _| {})
    }

    /// The same but for what a baseline knows, and says now and then how many fixes were made and how many are open.
    ///
    /// # Errors
    ///
    /// See [`Fixed::of`].
    pub fn telling(
        loaded: Loaded,
        scope: Scope,
        baseline: Option<&Baseline>,
        tell: &dyn Fn(usize, usize),
    ) -> Result<Self, Error> {
        if loaded.divided {
            return Err(ErrorKind::Write.error(undivided("mends")));
        }
        let needed = ProjectorFile::missing(&loaded).filter(|_| scope.unsafe_too);
        let is_asked_for = |one: &Diagnostic| one.code == PROJECTOR_MISSING && scope.wants(one);
        let projector_file = match needed {
            Some(file) => {
                let found = found_of_projector(&loaded)?.into_iter().find(is_asked_for);
                found.map(|found| (file, found.severity))
            }
            None => None,
        };
        let Some((file, severity)) = projector_file else {
            let judge = MapJudge::telling(&loaded, &loaded.projector, &loaded.info, tell).knowing(baseline);
            let mended = mended_by(&loaded, scope, judge)?;
            return Ok(Self { loaded, mended, projector_file: None });
        };
        let info = file.info();
        let judge = MapJudge::telling(&loaded, &file.projector, &info, tell).knowing(baseline);
        let mut mended = mended_by(&loaded, scope, judge)?;
        let (code, title) = (PROJECTOR_MISSING.to_owned(), file.title());
        mended.made_first(Mend { code, subject: Subject::Map, title }, severity);
        Ok(Self { loaded, mended, projector_file: Some(file) })
    }

    /// The files that changed, each as it was and as it is. The texts are unpacked.
    pub fn changed(&self) -> impl Iterator<Item = (&Source, &Source)> {
        let (before, after) = (&self.loaded.osm.sources, &self.mended.osm.sources);
        before.iter().zip(after).filter(|(old, new)| old.text != new.text)
    }

    /// A unified diff of every file that changed; empty where none did.
    pub fn diff(&self) -> String {
        let of_map = self.changed().map(|(old, new)| {
            let texts = [old, new].map(Source::as_written);
            unified_diff([&old.name, &new.name], [&texts[0], &texts[1]])
        });
        of_map.chain(self.projector_file.iter().map(ProjectorFile::diff)).collect()
    }

    /// The changes to the files, to be written now or later.
    pub fn edits(&self) -> Edits {
        let mut edits = Edits::between(&self.loaded, &self.mended.osm);
        edits.files.extend(self.projector_file.iter().map(ProjectorFile::edited));
        edits
    }

    /// Writes the files that changed in place, all or none.
    ///
    /// # Errors
    ///
    /// See [`Edits::write`].
    pub fn write(&self) -> Result<(), Error> {
        self.edits().write()
    }

    /// The mended map with what is left to find in it.
    pub fn into_left(self) -> Checked {
        let Self { loaded, mended: Mended { osm, left, .. }, projector_file } = self;
        let Loaded { files, mut projector, mut info, settings, divided, .. } = loaded;
        if let Some(file) = projector_file {
            (projector, info) = (file.projector, file.info());
        }
        let FromOsm { map, mut faults } = from_osm(&osm, &projector);
        info.judge(&osm, &projector, &mut faults);
        let loaded = Loaded { osm, files, map, faults, projector, info, settings, divided };
        Checked { loaded, sorted: Sorted { left, ..Sorted::default() } }
    }
}

/// A file that mending changes.
#[derive(Clone, Debug)]
pub struct EditedFile {
    /// Where it is; none where the map was given as bytes.
    pub path: Option<PathBuf>,
    /// Its name and its new text, unpacked.
    pub source: Source,
    /// What it held when it was read; nothing where it was not there.
    was: Option<Was>,
}

impl EditedFile {
    fn new(old: &Source, source: Source) -> Self {
        Self { path: None, source, was: Some(Was::of(old.as_written().as_bytes())) }
    }

    /// A file that was read and is to have another text.
    #[cfg(feature = "cli")]
    pub(crate) fn of(path: &Path, old: &Source, text: String) -> Self {
        Self { path: Some(path.to_path_buf()), ..Self::new(old, Source { text, ..old.clone() }) }
    }
}

/// What mending changes in the files of a map.
#[derive(Clone, Debug, Default)]
pub struct Edits {
    /// Each file that changes.
    pub files: Vec<EditedFile>,
}

impl Edits {
    /// What makes another map of the files of a map.
    pub(super) fn between(loaded: &Loaded, now: &OsmData) -> Self {
        let paths = loaded.files.iter().map(Some).chain(std::iter::repeat(None));
        let sources = loaded.osm.sources.iter().zip(&now.sources);
        let changed = paths.zip(sources).filter(|(_, (old, new))| old.text != new.text);
        let file = |(path, (old, new)): (Option<&PathBuf>, (&Source, &Source))| EditedFile {
            path: path.cloned(),
            ..EditedFile::new(old, new.clone())
        };
        Self { files: changed.map(file).collect() }
    }

    /// Writes the files that changed in place, all or none. Owners, rights, links and extended attributes stay what they are.
    ///
    /// # Errors
    ///
    /// Where they cannot be written, or were changed by somebody else after they were read; where a packed file would have to be
    /// changed, or the map was given as bytes.
    pub fn write(&self) -> Result<(), Error> {
        self.publish().map_err(ErrorKind::Write.of())
    }

    fn publish(&self) -> Result<(), Failure> {
        let texts: Vec<String> = self.files.iter().map(|file| file.source.as_written()).collect();
        let mut changed: Vec<Rewritten<'_>> = Vec::new();
        for (EditedFile { path, source, was }, text) in self.files.iter().zip(&texts) {
            let Some(path) = path else {
                return Err(Failure::new(format!("{} was given as bytes: there is no file to change", source.name))
                    .about(&source.name)
                    .help("take the changed text from the result"));
            };
            if is_packed(path) && !path.ends_with(INFO) {
                return Err(Failure::new(format!("{} is packed", path.display()))
                    .about(path.display().to_string())
                    .help("unpack it first; only plain .osm files are edited, and nothing was changed"));
            }
            changed.push(Rewritten { file: path, was: was.clone(), bytes: text.as_bytes() });
        }
        files::rewrite(&changed)
    }
}

/// Why cells are not edited one by one, and the way out.
pub(crate) fn undivided(verb: &str) -> Failure {
    Failure::new(format!("the map is divided into cells, and lanewright {verb} whole maps only"))
        .help("lanewright merge MAP -o WHOLE first, and lanewright split WHOLE -o CELLS afterwards")
}

/// What a map says, mended.
pub(crate) fn mended(map: &Loaded, scope: impl Into<Scope>) -> Result<Mended, Error> {
    mended_by(map, scope.into(), MapJudge::telling(map, &map.projector, &map.info, &|_, _| {}))
}

fn mended_by(map: &Loaded, scope: Scope, judge: MapJudge<'_>) -> Result<Mended, Error> {
    mend(map.osm.clone(), scope, judge).map_err(fix_failure)
}

/// Why a map was not mended.
pub(super) fn fix_failure(error: FixError<Error>) -> Error {
    match error {
        FixError::Judge(error) => error,
        FixError::Read(error) => unreadable(&error),
    }
}

/// An edited map that cannot be read: a fault of ours.
pub(super) fn unreadable(error: &ReadError) -> Error {
    ErrorKind::Internal.error(
        Failure::new(format!("the mended map cannot be read: {error}")).help("nothing was changed; please report this"),
    )
}
