//! Streets as GeoJSON: roads, lanes and intersections, for other tools to draw and measure, and for `build` to read
//! back. `docs/geometry.md` describes the file.
//!
//! What is read back is what was written, to the bit: places lie on a grid ([`super::streets::snap_grid`]) that nine decimals of a
//! degree can tell apart. Files from elsewhere may leave out almost everything; what is assumed then is noted.

mod error;
mod header;
mod id;
mod number_format;
mod parse;
mod read_intersections;
mod read_network;
mod read_outlines;
mod read_road;
mod schema;
mod split_features;
mod values;
mod write;

pub use error::ReadError;

use crate::diagnostic::{Finding, Severity, Subject};

use super::options::{BuildOptions, Plan};
use super::streets::Streets;

pub use write::{WriteError, write};

/// Whether a file's content is JSON and not OpenStreetMap's XML or PBF.
pub fn is_json(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    text.iter().find(|b| !b.is_ascii_whitespace()).is_some_and(|b| matches!(b, b'{' | b'['))
}

/// Reads streets. What the options say of the driving side and the projector goes before what the file says.
pub fn read(text: &str, options: &BuildOptions) -> Result<Plan, ReadError> {
    let parsed = parse::parse(text, options.projector)?;
    let mut notes = Vec::new();
    if parsed.others > 0 {
        let message = format!("{} features are neither road, lane nor intersection", parsed.others);
        notes.push(Finding::new("feature-skipped", Subject::Map, message).graded(Severity::Info));
    }
    let read_network::FileNetwork { mut network, rings } = read_network::network(&parsed, options, &mut notes)?;
    network.beside = options.beside;
    network.markings = options.markings;
    network.fan_out = options.inside.everywhere.fan_out.unwrap_or_default();
    let guesses = notes.len();
    let mut findings = Vec::new();
    let outlines = read_outlines::outlines(&network, &rings, &options.streets.outline, &mut findings);
    let streets = Streets { network, outlines, merges: Vec::new(), findings };
    let (inside, heights) = (options.inside.clone(), options.streets.heights.clone());
    Ok(Plan { streets, projector: parsed.projector, notes, guesses, inside, heights })
}
