//! Opens a map with the settings that apply to it.

use std::path::{Path, PathBuf};

use crate::lanelet::{
    INFO, LaneletMap, LoadFault, Loaded as FromOsm, OpenError, Opened, ProjectorInfo, from_osm, open, open_bytes,
    projector_for,
};
use crate::osm::{OsmData, ReadError};
use crate::projection::{LonLat, Projector};
use crate::report::failure::Failure;
use crate::settings::{ProjectorType, Settings};

use super::config::{self, Configuration};
use super::error::{Error, ErrorKind};
use super::{InMemory, Input, files};

/// A map as Autoware would load it, and what is known beyond it.
#[derive(Debug)]
pub struct Loaded {
    /// What the files say.
    pub osm: OsmData,
    /// The files, in reading order; none where the map was read from bytes.
    pub files: Vec<PathBuf>,
    /// What they mean.
    pub map: LaneletMap,
    /// What the loader stumbles over.
    pub faults: Vec<LoadFault>,
    /// How degrees become metres.
    pub projector: Projector,
    /// The projector file beside the map.
    pub info: ProjectorInfo,
    /// What is known beyond the map.
    pub settings: Settings,
    /// Whether the map is divided into cells, so that an element may stand in several files.
    pub divided: bool,
}

impl Loaded {
    /// Reads a `.osm` file, a directory of them, a map directory, or bytes.
    ///
    /// # Errors
    ///
    /// Where settings or the map cannot be read, and where what is read is no Lanelet2 map.
    pub fn read(input: impl Into<Input>, said: &Configuration) -> Result<Self, Error> {
        let (settings, opened) = match input.into() {
            Input::Path(path) => {
                files::complete(home(&path)).map_err(ErrorKind::Read.of())?;
                let settings = config::settings(home(&path), said).map_err(ErrorKind::Config.of())?;
                let opened = open(&path, projector(&settings));
                (settings, opened)
            }
            Input::Bytes(InMemory { name, bytes, projector_info, settings }) => {
                let settings = config::settings_of(settings.as_deref(), said).map_err(ErrorKind::Config.of())?;
                let info = projector_info.as_deref().map(|text| ProjectorInfo::of(Path::new(INFO), text));
                let opened = open_bytes(&name, bytes, info.unwrap_or_default(), projector(&settings));
                (settings, opened)
            }
        };
        opened.map_err(|error| ErrorKind::Read.error(open_failure(error))).map(|opened| Self::of(opened, settings))
    }

    /// A map of one file from its text, with what stands beside it.
    pub(super) fn of_text(name: &str, text: String, info: ProjectorInfo, settings: Settings) -> Result<Self, Error> {
        let opened = open_bytes(name, text.into_bytes(), info, projector(&settings));
        opened.map_err(|error| ErrorKind::Read.error(open_failure(error))).map(|opened| Self::of(opened, settings))
    }

    fn of(opened: Opened, settings: Settings) -> Self {
        let opened = in_squares(opened, &settings);
        let Opened { osm, files, projector, info, divided, loaded: FromOsm { map, faults }, .. } = opened;
        Self { osm, files, map, faults, projector, info, settings, divided }
    }

    /// Whether the files can be mended where they are: cells and packed files are not edited.
    pub fn is_editable(&self) -> bool {
        !self.divided && !self.files.iter().any(|file| is_packed(file))
    }
}

/// Whether a file is something else than plain XML.
pub(super) fn is_packed(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension != "osm")
}

/// The projector that the settings name, if it needs nothing of the map.
pub(super) fn projector(settings: &Settings) -> Option<Projector> {
    let origin = settings.origin.map(|[lat, lon]| LonLat { lon, lat });
    Some(match (settings.projector?, origin) {
        (ProjectorType::Local, _) => Projector::Local,
        (ProjectorType::LocalCartesianUtm, Some(origin)) => Projector::LocalCartesianUtm { origin },
        (ProjectorType::TransverseMercator, Some(origin)) => Projector::transverse_mercator(origin),
        (ProjectorType::LocalCartesian, Some(origin)) => Projector::LocalCartesian { origin },
        _ => return None,
    })
}

/// The map in MGRS, where the settings ask for it and the file beside the map does not name the square.
fn in_squares(mut opened: Opened, settings: &Settings) -> Opened {
    if settings.projector == Some(ProjectorType::Mgrs) && !matches!(opened.projector, Projector::Mgrs(_)) {
        opened.projector = projector_for(&opened.osm);
        opened.loaded = from_osm(&opened.osm, &opened.projector);
        opened.info = ProjectorInfo::overruled();
    }
    opened
}

/// The directory of a map, where `map_projector_info.yaml` and `lanewright.toml` are looked for.
pub(crate) fn home(path: &Path) -> &Path {
    if path.is_dir() {
        return path;
    }
    // The parent of a bare file name is empty, which is no directory to look up from.
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Why a map could not be opened, and the way out.
pub(crate) fn open_failure(error: OpenError) -> Failure {
    let message = error.to_string();
    match error {
        OpenError::Read(error) => read_failure(error),
        OpenError::Navigation { ref path, .. } => Failure::new(message)
            .about(path.display().to_string())
            .help(format!("make a Lanelet2 map of it first: lanewright build {} -o DIR", path.display())),
        OpenError::Contradiction { .. } => Failure::new(message).help(error.help()),
        OpenError::EmptyDirectory { ref path }
        | OpenError::NotLanelet2 { ref path }
        | OpenError::Metadata { ref path, .. }
        | OpenError::MissingCell { ref path, .. }
        | OpenError::UnlistedCell { ref path } => {
            Failure::new(message).about(path.display().to_string()).help(error.help())
        }
    }
}

/// Whether a text begins as OpenStreetMap XML does.
fn begins_as_osm(text: &str) -> bool {
    let text = text.trim_start();
    let text = text.strip_prefix("<?xml").and_then(|rest| Some(rest.split_once("?>")?.1.trim_start())).unwrap_or(text);
    text.starts_with("<osm")
}

/// Why a file could not be read, with the place where it broke.
pub(crate) fn read_failure(error: ReadError) -> Failure {
    let help = error.help();
    let message = error.to_string();
    match error {
        // Who reads a file block by block has no text to show.
        // Nor is the text of a stranger's choice shown, to which a link leads.
        ReadError::Broken { name, text, .. }
            if text.is_empty() || (files::is_link(Path::new(&name)) && !begins_as_osm(&text)) =>
        {
            Failure::new(message).help(help).about(name)
        }
        ReadError::Broken { name, offset, text, message, .. } => {
            Failure::new(message).help(help).at(&name, text, offset)
        }
        ReadError::Io { path, .. } => Failure::new(message).help(help).about(path.display().to_string()),
        ReadError::Empty { name }
        | ReadError::TooLarge { name, .. }
        | ReadError::LongElement { name, .. }
        | ReadError::Packed { name, .. }
        | ReadError::NotText { name, .. }
        | ReadError::Pbf { name, .. }
        | ReadError::PbfFeature { name, .. } => Failure::new(message).help(help).about(name),
    }
}
