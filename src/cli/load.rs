//! Opens a map with the settings that apply to it.

use std::path::Path;

use crate::lanelet::{
    LaneletMap, LoadFault, Loaded as FromOsm, OpenError, Opened, ProjectorInfo, from_osm, open, projector_for,
};
use crate::osm::{OsmData, ReadError};
use crate::projection::{LonLat, Projector};
use crate::report::failure::Failure;
use crate::settings::{ProjectorType, Settings};

use super::check_args::ConfigArgs;
use super::config;

/// A map as Autoware would load it, and what is known beyond it.
pub struct Loaded {
    /// What the files say.
    pub osm: OsmData,
    /// What they mean.
    pub map: LaneletMap,
    /// What the loader stumbles over.
    pub faults: Vec<LoadFault>,
    /// How degrees become metres.
    pub projector: Projector,
    /// What stands beside the map about that.
    pub info: ProjectorInfo,
    /// What is known beyond the map.
    pub settings: Settings,
}

impl Loaded {
    /// Reads a `.osm` file, a directory of them, or a map directory.
    pub fn read(path: &Path, config: &ConfigArgs) -> Result<Self, Failure> {
        let settings = config::settings(home(path), config)?;
        let opened = open(path, projector(&settings)).map_err(open_failure)?;
        let Opened { osm, projector, info, loaded: FromOsm { map, faults }, .. } = in_squares(opened, &settings);
        Ok(Self { osm, map, faults, projector, info, settings })
    }
}

/// The projector that the settings name, if it needs nothing of the map.
fn projector(settings: &Settings) -> Option<Projector> {
    let origin = settings.origin.map(|[lat, lon]| LonLat { lon, lat });
    Some(match (settings.projector?, origin) {
        (ProjectorType::Local, _) => Projector::Local,
        (ProjectorType::LocalCartesianUtm, Some(origin)) => Projector::LocalCartesianUtm { origin },
        (ProjectorType::TransverseMercator, Some(origin)) => Projector::transverse_mercator(origin),
        (ProjectorType::LocalCartesian, Some(origin)) => Projector::LocalCartesian { origin },
        _ => return None,
    })
}

/// The map in MGRS where the settings ask for it and what stands beside the map does not: the square is the map's own.
fn in_squares(mut opened: Opened, settings: &Settings) -> Opened {
    if settings.projector == Some(ProjectorType::Mgrs) && !matches!(opened.projector, Projector::Mgrs(_)) {
        opened.projector = projector_for(&opened.osm);
        opened.loaded = from_osm(&opened.osm, &opened.projector);
        opened.info = ProjectorInfo::overruled();
    }
    opened
}

/// The directory of a map, beside whose files the projector's and ours stand.
pub fn home(path: &Path) -> &Path {
    if path.is_dir() {
        return path;
    }
    // The parent of a bare file name is empty, which is no directory to look up from.
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Why a map could not be opened, and the way out.
pub fn open_failure(error: OpenError) -> Failure {
    match error {
        OpenError::Read(error) => read_failure(error),
        OpenError::Navigation { ref path, .. } => Failure::new(error.to_string())
            .help(format!("make a Lanelet2 map of it first: lanewright build {} -o DIR", path.display())),
        _ => Failure::new(error.to_string()).help(error.help()),
    }
}

/// Why a file could not be read, with the place where it broke.
pub fn read_failure(error: ReadError) -> Failure {
    let help = error.help();
    match &error {
        ReadError::Broken { name, offset, text, message, .. } => {
            Failure::new(message.clone()).help(help).at(name, text, *offset)
        }
        _ => Failure::new(error.to_string()).help(help),
    }
}
