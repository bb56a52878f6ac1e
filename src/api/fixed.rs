//! A map that was mended, in memory until it is written.

use std::path::{Path, PathBuf};

use similar::TextDiff;

use crate::diagnostic::Diagnostic;
use crate::fix::{FixError, Mended, mend};
use crate::lanelet::index::{MapIndex, Thresholds};
use crate::lanelet::{Loaded as FromOsm, from_osm};
use crate::osm::{OsmData, Source};
use crate::report::failure::Failure;
use crate::rules::{self, Config};
use crate::triage::{self, Sorted};

use super::checked::Checked;
use super::config::Configuration;
use super::error::{Error, ErrorKind};
use super::files;
use super::load::{Loaded, is_packed};

/// What is mended.
#[derive(Clone, Debug, Default)]
pub struct FixOptions {
    /// Which settings count, which rules are asked: what they do not find is not mended.
    pub configuration: Configuration,
    /// Whether fixes are made, too, that need a look afterwards.
    pub unsafe_too: bool,
}

/// A map as it was and as it is, with what was done.
#[derive(Debug)]
pub struct Fixed {
    /// The map as it was.
    pub loaded: Loaded,
    /// The map as it is, what was done to it, what is left.
    pub mended: Mended,
}

impl Fixed {
    /// Mends a map.
    ///
    /// # Errors
    ///
    /// Where a parameter has a value of the wrong type, or the map is divided into cells.
    pub fn of(loaded: Loaded, unsafe_too: bool) -> Result<Self, Error> {
        if loaded.divided {
            return Err(ErrorKind::Write.error(undivided("mends")));
        }
        let mended = mended(&loaded, unsafe_too)?;
        Ok(Self { loaded, mended })
    }

    /// The files that changed, each as it was and as it is. The texts are unpacked.
    pub fn changed(&self) -> impl Iterator<Item = (&Source, &Source)> {
        let (before, after) = (&self.loaded.osm.sources, &self.mended.osm.sources);
        before.iter().zip(after).filter(|(old, new)| old.text != new.text)
    }

    /// A unified diff of every file that changed; empty where none did.
    pub fn diff(&self) -> String {
        self.changed()
            .map(|(old, new)| {
                let lines = TextDiff::from_lines(&old.text, &new.text);
                lines.unified_diff().context_radius(3).header(&old.name, &new.name).to_string()
            })
            .collect()
    }

    /// The changes to the files, to be written now or later.
    pub fn edits(&self) -> Edits {
        let paths = self.loaded.files.iter().map(Some).chain(std::iter::repeat(None));
        let sources = self.loaded.osm.sources.iter().zip(&self.mended.osm.sources);
        let changed = paths.zip(sources).filter(|(_, (old, new))| old.text != new.text);
        let files = changed.map(|(path, (_, new))| (path.cloned(), new.clone()));
        Edits { files: files.collect() }
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
        let Self { loaded, mended: Mended { osm, left, .. } } = self;
        let Loaded { files, projector, info, settings, divided, .. } = loaded;
        let FromOsm { map, mut faults } = from_osm(&osm, &projector);
        info.judge(&osm, &projector, &mut faults);
        let loaded = Loaded { osm, files, map, faults, projector, info, settings, divided };
        Checked { loaded, sorted: Sorted { left, ..Sorted::default() } }
    }
}

/// What mending changes in the files of a map.
#[derive(Clone, Debug, Default)]
pub struct Edits {
    /// Each file that changes, where it is one, with its name and its new text, unpacked.
    pub files: Vec<(Option<PathBuf>, Source)>,
}

impl Edits {
    /// Writes the files that changed in place, all or none.
    ///
    /// # Errors
    ///
    /// Where they cannot be written, a packed file would have to be changed, or the map was given as bytes.
    pub fn write(&self) -> Result<(), Error> {
        self.publish().map_err(ErrorKind::Write.of())
    }

    fn publish(&self) -> Result<(), Failure> {
        let mut changed: Vec<(&Path, &[u8])> = Vec::new();
        for (path, source) in &self.files {
            let Some(path) = path else {
                return Err(Failure::new(format!("{} was given as bytes: there is no file to change", source.name))
                    .about(&source.name)
                    .help("take the changed text from the result"));
            };
            if is_packed(path) {
                return Err(Failure::new(format!("{} is packed", path.display()))
                    .about(path.display().to_string())
                    .help("unpack it first; only plain .osm files are edited, and nothing was changed"));
            }
            changed.push((path, source.text.as_bytes()));
        }
        files::write_all(&changed)
    }
}

/// Why cells are not edited one by one, and the way out.
pub(crate) fn undivided(verb: &str) -> Failure {
    Failure::new(format!("the map is divided into cells, and lanewright {verb} whole maps only"))
        .help("lanewright merge MAP -o WHOLE first, and lanewright split WHOLE -o CELLS afterwards")
}

/// What a map says, mended.
pub(crate) fn mended(map: &Loaded, unsafe_too: bool) -> Result<Mended, Error> {
    let Loaded { projector, info, settings, .. } = map;
    let judge = |osm: &OsmData| -> Result<Vec<Diagnostic>, Error> {
        let mut loaded = from_osm(osm, projector);
        info.judge(osm, projector, &mut loaded.faults);
        let index = MapIndex::new(&loaded.map, &loaded.faults, settings, Thresholds::default());
        let found = rules::run(&index, &Config::from(settings))
            .map_err(|error| ErrorKind::Config.error(Failure::new(error.to_string())))?;
        // What somebody has answered for is not mended.
        Ok(triage::sort(found, settings, osm, &loaded.map, None).left)
    };
    mend(map.osm.clone(), unsafe_too, judge).map_err(|error| match error {
        FixError::Judge(error) => error,
        FixError::Read(error) => ErrorKind::Internal.error(
            Failure::new(format!("the mended map cannot be read: {error}"))
                .help("nothing was changed; please report this"),
        ),
    })
}
