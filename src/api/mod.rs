//! The verbs as functions: what the command line and the Python module are made of.
//!
//! Each takes an [`Input`], a path or bytes, and options of which the default is what the command line does without any.
//! What comes of it stays in memory until it is written.

mod built;
mod checked;
pub(crate) mod config;
mod conflicts;
#[cfg(feature = "cli")]
mod converted;
mod cut;
mod divided;
mod error;
pub(crate) mod files;
mod fixed;
mod forecasts;
#[cfg(feature = "cli")]
mod git;
mod join;
mod judge;
#[cfg(feature = "cli")]
mod kept;
pub(crate) mod layout;
pub(crate) mod load;
mod merged;
pub(crate) mod opendrive;
mod own_output;
#[cfg(feature = "cli")]
pub(crate) mod review;
mod tile;
mod tiles;
mod workplace;

use std::path::{Path, PathBuf};

pub use built::BuiltMap;
#[cfg(feature = "cli")]
pub(crate) use checked::judged;
pub(crate) use checked::read_baseline;
pub use checked::{CheckOptions, Checked, write_baseline};
pub use config::{ConfigSource, Configuration};
#[cfg(feature = "cli")]
pub(crate) use config::{above, requirements};
pub use conflicts::conflict_requirement;
#[cfg(feature = "cli")]
pub(crate) use converted::Converted;
pub use cut::{Cut, CutTile, DESCRIPTION, MARGIN, TERRAIN, TILES, TileSizes, cut};
pub use divided::{Joined, merge, split};
pub use error::{Error, ErrorKind};
pub use fixed::{EditedFile, Edits, FixOptions, Fixed};
#[cfg(feature = "cli")]
pub(crate) use fixed::{mended, undivided};
pub(crate) use forecasts::forecasts;
pub use forecasts::{Along, forecast};
#[cfg(feature = "cli")]
pub(crate) use git::{GitSetup, MAPS, SetupKind, conflict_page, settings_of_theirs};
pub use join::{Joining, Whole, join};
#[cfg(feature = "cli")]
pub use kept::{KEPT, KeepOptions, KeptMap, keep};
pub use layout::{Layout, LayoutOptions};
pub use load::Loaded;
pub use merged::{MergeOptions, MergedMap, merge_settings_files, merge_versions};
pub use own_output::spare;
pub use tile::TileBuilder;
pub use tiles::{TileOptions, Tiled, build_tiles};

/// What a verb reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A file, or for a Lanelet2 map a directory; the files beside it are read, too.
    Path(PathBuf),
    /// The content of a file. No other file is read, unless settings are named.
    Bytes(InMemory),
}

/// The content of a file, and of the files that belong beside it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InMemory {
    /// What messages call it.
    pub name: String,
    /// OpenStreetMap XML, plain or gzip, or PBF; streets as GeoJSON; OpenDRIVE; what it is, its content says.
    pub bytes: Vec<u8>,
    /// The text of `map_projector_info.yaml`.
    pub projector_info: Option<String>,
    /// The text of `lanewright.toml`.
    pub settings: Option<String>,
}

impl Input {
    /// The content of a file that messages call by `name`.
    pub fn bytes(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self::Bytes(InMemory { name: name.into(), bytes: bytes.into(), ..InMemory::default() })
    }

    /// What messages call it.
    pub fn name(&self) -> String {
        match self {
            Self::Path(path) => path.display().to_string(),
            Self::Bytes(InMemory { name, .. }) => name.clone(),
        }
    }
}

impl From<PathBuf> for Input {
    fn from(path: PathBuf) -> Self {
        Self::Path(path)
    }
}

impl From<&Path> for Input {
    fn from(path: &Path) -> Self {
        Self::Path(path.to_path_buf())
    }
}

impl From<&str> for Input {
    fn from(path: &str) -> Self {
        Self::Path(path.into())
    }
}

/// Writes a file, whole or not at all.
///
/// # Errors
///
/// Where it cannot be written; what was there before is unchanged.
pub fn write_file(file: &Path, bytes: &[u8]) -> Result<(), Error> {
    files::write(file, bytes).map_err(ErrorKind::Write.of())
}

/// Builds a Lanelet2 map from OpenStreetMap data (XML, gzip, PBF), from streets as [`geometry`] writes them, or from OpenDRIVE.
///
/// # Errors
///
/// Where the input or settings cannot be read, or have no road that a map could be built from.
pub fn build(input: impl Into<Input>, options: &LayoutOptions) -> Result<BuiltMap, Error> {
    let input = input.into();
    if input.is_opendrive() {
        return BuiltMap::of_opendrive(input, options, &|_| ());
    }
    BuiltMap::uncontested(options, |options| geometry(input.clone(), options))
}

/// Lays out the streets of OpenStreetMap data: roads, lanes and intersections, before they become a map.
///
/// # Errors
///
/// See [`build`].
pub fn geometry(input: impl Into<Input>, options: &LayoutOptions) -> Result<Layout, Error> {
    Layout::read(input, options, &|_| ())
}

/// Holds a Lanelet2 map against Autoware's requirements: a file, a directory of files, a map directory, or bytes.
///
/// # Errors
///
/// Where the map, the baseline or settings cannot be read. What is wrong with the map is no error but a finding.
pub fn check(map: impl Into<Input>, options: CheckOptions) -> Result<Checked, Error> {
    Checked::of(Loaded::read(map, &options.configuration)?, options)
}

/// Mends a Lanelet2 map by the smallest change to its text; nothing is written until [`Fixed::write`].
///
/// # Errors
///
/// Where the map, the baseline or settings cannot be read.
pub fn fix(map: impl Into<Input>, options: &FixOptions) -> Result<Fixed, Error> {
    let baseline = options.baseline.as_ref().map(read_baseline).transpose()?;
    Fixed::telling(Loaded::read(map, &options.configuration)?, options.scope, baseline.as_ref(), &|_, _| {})
}
