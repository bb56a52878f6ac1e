//! Why a map cannot be opened, and what to do about it.

use std::path::PathBuf;

use crate::lanelet::cell_metadata::{METADATA, MetadataError};
use crate::osm::{ElementKind, ReadError};

/// Why a map cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A directory without maps.
    #[error("{path} holds no .osm file")]
    EmptyDirectory {
        /// The directory.
        path: PathBuf,
    },
    /// Roads for navigation, not lanelets.
    #[error("{path} is not a Lanelet2 map but a plain OpenStreetMap extract: it has {roads} roads and no lanelet")]
    Navigation {
        /// The file or directory.
        path: PathBuf,
        /// Ways with `highway`.
        roads: usize,
    },
    /// Cells in which an element is not the same everywhere.
    #[error("{first} and {second} contradict each other: {kind} {id} is not the same in both{}", .more.map_or(String::new(), |more| format!("; so are {more} more elements")))]
    Contradiction {
        /// The file and line where it stands first.
        first: String,
        /// The file and line where it stands otherwise.
        second: String,
        /// Its kind.
        kind: ElementKind,
        /// Its id.
        id: i64,
        /// How many more there are, if any.
        more: Option<usize>,
    },
    /// A list of cells that cannot be read.
    #[error("{path}: {error}")]
    Metadata {
        /// The list.
        path: PathBuf,
        /// What is wrong with it.
        error: MetadataError,
    },
    /// A list of cells and a folder of cells that do not go together.
    #[error("{path} names {name}, and there is no such file{}", .more.map_or(String::new(), |more| format!("; so it does {more} more")))]
    MissingCell {
        /// The list.
        path: PathBuf,
        /// As the list writes it.
        name: String,
        /// How many more are missing, if any.
        more: Option<usize>,
    },
    /// A cell that no client would get.
    #[error("{path} is a cell that {METADATA} does not name")]
    UnlistedCell {
        /// The cell.
        path: PathBuf,
    },
    /// Neither lanelets nor roads.
    #[error("{path} is not a Lanelet2 map: it has no relation with type=lanelet")]
    NotLanelet2 {
        /// The file or directory.
        path: PathBuf,
    },
}

impl OpenError {
    /// A way out, in one line.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Read(error) => error.help(),
            Self::EmptyDirectory { .. } => {
                "give an .osm file, a directory of .osm files, or a map directory with lanelet2_map.osm in it"
            }
            Self::Navigation { .. } => "make a Lanelet2 map of it first: `lanewright build`",
            Self::Contradiction { .. } => {
                "divide the map anew from what the cells were made of: `lanewright split`; cells are never edited one by one"
            }
            Self::Metadata { .. } | Self::UnlistedCell { .. } => {
                "remove what does not belong there, or divide the map anew: `lanewright split` writes cells and their list"
            }
            Self::MissingCell { .. } => {
                "bring the missing cells back, or give the .osm files that are there by themselves, outside a map directory"
            }
            Self::NotLanelet2 { .. } => "give a map with lanelets; `lanewright build` makes one from OpenStreetMap",
        }
    }
}
