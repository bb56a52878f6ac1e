//! Reads OpenDRIVE 1.1 to 1.8: roads with exact geometry, lanes, junctions, signals and objects, in the file's own metres.
//!
//! It knows nothing of maps. What breaks the standard is an [`Oddity`] with its line, and the rest is read.

mod cubic;
mod damage;
mod document;
mod error;
mod furniture;
mod georeference;
mod junction;
mod placing;
mod plan_view;
mod read;
mod road;
mod surface;
#[cfg(test)]
mod tests;

pub use cubic::{Cubic, Cubics};
pub use error::{Oddity, XodrError};
pub use furniture::{Object, Signal, SignalReference, Validity};
pub use georeference::{Georeference, Plane};
pub use junction::{Connection, Controller, Junction, JunctionKind};
pub use plan_view::{Heading, PlanRecord, PlanView, Shape};
pub use read::read;
pub use road::{Lane, Place, Road, RoadEnd, RoadLink, RoadMark, Section, inner};

/// What stands at the head of a file.
#[derive(Clone, Debug, Default)]
pub struct Header {
    /// The line of its georeference, else its own, from 1.
    pub line: usize,
    /// Where on earth it lies.
    pub plane: Plane,
    /// What is added to its metres, after a turn: x, y, z (metres), and the turn (radians).
    pub offset: [f64; 4],
}

/// A file.
#[derive(Clone, Debug, Default)]
pub struct OpenDrive {
    /// Where it lies.
    pub header: Header,
    /// In order of the file, each id once.
    pub roads: Vec<Road>,
    /// In order of the file.
    pub junctions: Vec<Junction>,
    /// In order of the file.
    pub controllers: Vec<Controller>,
    /// What breaks the standard, in order of reading.
    pub oddities: Vec<Oddity>,
}

/// Whether a content is XML with the root of OpenDRIVE, by its first bytes.
pub fn is_opendrive(bytes: &[u8]) -> bool {
    /// Comments may stand before the root.
    const HEAD: usize = 1 << 16;
    let head = bytes.get(..HEAD.min(bytes.len())).unwrap_or_default();
    let root = b"<OpenDRIVE";
    let first = head.iter().find(|b| !b.is_ascii_whitespace() && !b"\xef\xbb\xbf".contains(b));
    first == Some(&b'<') && head.windows(root.len()).any(|window| window == root)
}
