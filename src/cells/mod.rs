//! Maps that are divided into cells as Autoware loads them, one by one around the vehicle, and put together again.
//!
//! A lanelet, a line string, a polygon or a free point stands in every cell that it touches, and whatever an element refers to
//! stands in each cell of that element: a cell alone is a map that loads. An element has the same text in all its cells, so that
//! cells can be merged by ids.
//!
//! Dividing goes through the files twice: first it notes ids, places and references, and decides on the cells; then it copies
//! the text of each element. The text itself is never in memory as a whole.

mod divide;
mod excerpt;
mod grid;
mod ids;
mod merge;
mod placement;
mod renumber;
mod sets;
mod survey;

use std::path::PathBuf;

use crate::osm::{ElementKind, ReadError};

pub use divide::{Divided, Element, Shared, Tile, divide};
pub use excerpt::excerpt;
pub use grid::{Cell, Grid};
pub use ids::{Ids, Lists};
pub use merge::{Collision, Merge};
pub use sets::{CellSets, NOWHERE, SetId};

/// Why a map cannot be divided.
#[derive(Debug, thiserror::Error)]
pub enum DivideError {
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A file cannot be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// An element reaches over half the Earth, or cells are far too small.
    #[error("{kind} {id} reaches over more than a million cells")]
    TooWide {
        /// Its kind.
        kind: ElementKind,
        /// Its id.
        id: i64,
    },
    /// Cells without a node of their own: far smaller than what is drawn.
    #[error("of {cells} cells, {empty} would hold no node, only what reaches over them")]
    TooSmall {
        /// All cells.
        cells: usize,
        /// Those in which no node lies.
        empty: usize,
    },
    /// Nearly every cell would hold the whole map.
    #[error("elements refer to each other across the whole map, so that nearly every cell would hold all of it")]
    Chained,
    /// Files of one map in which an element is not the same everywhere.
    #[error("{first} and {second} contradict each other: {kind} {id} is not the same in both")]
    Contradiction {
        /// The file where it stands first.
        first: String,
        /// The file where it stands otherwise.
        second: String,
        /// Its kind.
        kind: ElementKind,
        /// Its id.
        id: i64,
    },
    /// More elements than can be numbered.
    #[error("the map has more than four billion elements of one kind")]
    TooMany,
    /// Roads for navigation, not lanelets.
    #[error("it has {roads} roads and no lanelet")]
    Navigation {
        /// Ways with `highway`.
        roads: usize,
    },
    /// Neither lanelets nor roads.
    #[error("it has no relation with type=lanelet")]
    NotLanelet2,
}

impl DivideError {
    /// A way out, in one line.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Read(error) => error.help(),
            Self::Write { .. } => "nothing was changed; check the place's permissions and free space",
            Self::TooWide { .. } => "are its nodes where they should be? otherwise give a larger --size",
            Self::TooSmall { .. } => "give a larger --size: 100 m is usual",
            Self::Chained => "give a larger --size, or do not divide this map",
            Self::Contradiction { .. } => {
                "divide the map from what these files were made of; two maps that only share ids: `lanewright merge --renumber`"
            }
            Self::TooMany => "divide it in parts",
            Self::Navigation { .. } => "make a Lanelet2 map of it first: `lanewright build`",
            Self::NotLanelet2 => "give a map with lanelets; `lanewright build` makes one from OpenStreetMap",
        }
    }
}

/// Tags whose value is the id of a way.
const NAMING: [&str; 2] = ["intersection_area", "traffic_light_id"];
