//! Why a file could not be read, with the place and a way out.

use std::path::PathBuf;

/// Why a file could not be read at all.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system says no.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// Nothing in it.
    #[error("{name} is empty")]
    Empty {
        /// The file.
        name: String,
    },
    /// More than may be read.
    #[error("{name} takes more than {} in memory", size(*most))]
    TooLarge {
        /// The file.
        name: String,
        /// How many bytes may be read.
        most: u64,
    },
    /// An element, or what stands between two, that is too long.
    #[error("{name}: no node, way or relation begins within {} MB behind byte {offset}", most >> 20)]
    LongElement {
        /// The file.
        name: String,
        /// Offset of the last element that begins before.
        offset: usize,
        /// How many bytes one may take.
        most: usize,
    },
    /// gzip that cannot be unpacked.
    #[error("{name} cannot be unpacked: {message}")]
    Packed {
        /// The file.
        name: String,
        /// What is wrong.
        message: String,
    },
    /// Not text.
    #[error("{name} is neither OpenStreetMap PBF nor UTF-8 text (first bad byte at offset {offset})")]
    NotText {
        /// The file.
        name: String,
        /// Offset of the first byte that is not UTF-8.
        offset: usize,
    },
    /// PBF that cannot be decoded.
    #[error("{name} is not a usable PBF file: {message}")]
    Pbf {
        /// The file.
        name: String,
        /// What is wrong.
        message: String,
    },
    /// PBF that demands a reader with a feature that this one has not.
    #[error("{name} needs a reader that knows `{feature}`")]
    PbfFeature {
        /// The file.
        name: String,
        /// A required feature of its header.
        feature: String,
    },
    /// XML, or something else, that is broken at a place.
    #[error("{name}:{line}:{column}: {message}")]
    Broken {
        /// The file.
        name: String,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// Byte offset.
        offset: usize,
        /// The whole text, so that the place can be shown.
        text: String,
        /// What is wrong.
        message: String,
        /// A way out.
        help: &'static str,
    },
}

/// Bytes as people say them.
fn size(bytes: u64) -> String {
    let (divisor, unit) = match bytes {
        ..10_000_000 => (1000, "kB"),
        10_000_000..10_000_000_000 => (1_000_000, "MB"),
        10_000_000_000.. => (1_000_000_000, "GB"),
    };
    format!("{} {unit}", bytes / divisor)
}

impl ReadError {
    /// A way out, in one line.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Io { .. } => "give the path of a readable file",
            Self::Empty { .. } => "the file has no content; was its download or export cut off?",
            Self::TooLarge { .. } => {
                "if the memory suffices, --max-input SIZE allows more (a map takes about four times its XML); \
                 `lanewright split` cuts a map of any size into cells"
            }
            Self::LongElement { .. } => "the file is damaged, or made to fill the memory; export or download it again",
            Self::Packed { .. } => "the .gz file is damaged or cut off; download or pack it again",
            Self::NotText { .. } => "give OpenStreetMap XML in UTF-8 (.osm, .osm.gz) or OpenStreetMap PBF (.osm.pbf)",
            Self::Pbf { .. } => "the file is damaged or cut off; download it again, or convert it to .osm",
            Self::PbfFeature { feature, .. } if feature == "HistoricalInformation" => {
                "it holds what was deleted, too: write one state of it with `osmium time-filter`"
            }
            Self::PbfFeature { .. } => "convert it to .osm, or to .osm.pbf without that feature",
            Self::Broken { help, .. } => help,
        }
    }
}
