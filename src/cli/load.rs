//! Finds and reads a map with what stands beside it: the projector's file and the settings.

use std::fs;
use std::path::{Path, PathBuf};

use lanewright::lanelet::{self, LaneletMap, LoadFault, from_osm};
use lanewright::osm::{self, OsmData, ReadError};
use lanewright::projection::{LonLat, MgrsGrid, Projector, read_info};
use lanewright::report::failure::Failure;
use lanewright::settings::Settings;

use super::check_args::ConfigArgs;
use super::config;

/// Autoware's name for the map's file in a map directory, or for a directory of parts.
const MAP: &str = "lanelet2_map.osm";
/// Autoware's name for the file that names the projector.
pub const PROJECTOR: &str = "map_projector_info.yaml";

/// A map as Autoware would load it.
pub struct Loaded {
    /// What the files say.
    pub osm: OsmData,
    /// What they mean.
    pub map: LaneletMap,
    /// What the loader stumbles over.
    pub faults: Vec<LoadFault>,
    /// How degrees become metres.
    pub projector: Projector,
    /// What is known beyond the map.
    pub settings: Settings,
}

impl Loaded {
    /// Reads a `.osm` file, a directory of them, or a map directory.
    pub fn read(path: &Path, config: &ConfigArgs) -> Result<Self, Failure> {
        let files = files(path)?;
        let osm = osm::read_files(&files).map_err(read_failure)?;
        if !osm.relations.iter().any(|r| r.tags.is("type", "lanelet")) {
            return Err(not_a_map(path, &osm));
        }
        let home = home(path);
        let projector = match beside(home, PROJECTOR)? {
            Some((file, text)) => {
                let unusable = |error| {
                    Failure::new(format!("{}: {error}", file.display()))
                        .help("Autoware reads how degrees become metres from this file; mend it or move it away")
                };
                read_info(&text).map_err(unusable)?.0
            }
            None => guessed(&osm),
        };
        let settings = config::settings(home, config)?;
        let lanelet::Loaded { map, faults } = from_osm(&osm, &projector);
        Ok(Self { osm, map, faults, projector, settings })
    }
}

/// The directory of a map, beside whose files the projector's and ours stand.
pub fn home(path: &Path) -> &Path {
    if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) }
}

/// The files of a map, in order of their names.
pub fn files(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_path_buf()]);
    }
    let inside = path.join(MAP);
    if inside.is_dir() {
        return files(&inside);
    }
    if inside.is_file() {
        return Ok(vec![inside]);
    }
    let unreadable = |error| Failure::new(format!("cannot read the directory {}: {error}", path.display()));
    let mut found = Vec::new();
    for entry in fs::read_dir(path).map_err(unreadable)? {
        let file = entry.map_err(unreadable)?.path();
        if file.is_file() && file.extension().is_some_and(|e| e.eq_ignore_ascii_case("osm")) {
            found.push(file);
        }
    }
    found.sort();
    if found.is_empty() {
        return Err(Failure::new(format!("there is no .osm file in the directory {}", path.display()))
            .help("give a .osm file, a directory of .osm files, or a map directory with lanelet2_map.osm"));
    }
    Ok(found)
}

/// A file that may stand beside the map, with its text.
fn beside(home: &Path, name: &str) -> Result<Option<(PathBuf, String)>, Failure> {
    let file = home.join(name);
    if !file.is_file() {
        return Ok(None);
    }
    match fs::read_to_string(&file) {
        Ok(text) => Ok(Some((file, text))),
        Err(error) => Err(Failure::new(format!("cannot read {}: {error}", file.display()))),
    }
}

/// Without a projector's file: `Local` where the nodes have no degrees, else MGRS as most Autoware maps have it.
fn guessed(osm: &OsmData) -> Projector {
    let place = |position: Option<LonLat>| position.filter(|p| p.lat != 0.0 || p.lon != 0.0);
    match osm.nodes.iter().find_map(|node| place(node.position)) {
        None => Projector::Local,
        Some(first) => match MgrsGrid::of(first) {
            Some(grid) => Projector::mgrs(grid),
            None => Projector::transverse_mercator(first),
        },
    }
}

fn not_a_map(path: &Path, osm: &OsmData) -> Failure {
    let name = path.display();
    let failure = Failure::new(format!("{name} is not a Lanelet2 map: it has no lanelet"));
    if osm.ways.iter().any(|way| way.tags.has("highway")) {
        failure.help(format!("it has roads; to make a Lanelet2 map of them: lanewright build {name} -o DIR"))
    } else {
        failure.help("a Lanelet2 map has relations with type=lanelet")
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
