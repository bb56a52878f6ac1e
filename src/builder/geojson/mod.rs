//! Streets as GeoJSON: roads, lanes and intersections. Other tools draw and measure the file, and `build` reads it back.
//! `docs/geometry.md` describes it.
//!
//! Reading gives back exactly what was written: positions lie on a grid ([`super::streets::snap_grid`]) coarser than nine
//! decimals of a degree. Files of other tools may omit most properties; each assumption becomes a note.

mod encoding;
mod error;
mod header;
mod id;

mod parse;
mod read_intersections;
mod read_network;
mod read_outlines;
mod read_road;
mod schema;
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

/// Reads streets. The driving side and the projector of the options go before those of the file.
///
/// # Errors
///
/// The text is no GeoJSON of streets; the error gives the place in the text.
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
    let outlines = read_outlines::outlines(&network, &rings, &mut findings);
    let streets = Streets { network, outlines, merges: Vec::new(), findings };
    let (inside, heights) = (options.inside.clone(), options.streets.heights.clone());
    Ok(Plan {
        streets,
        projector: parsed.projector,
        notes,
        guesses,
        inside,
        heights,
        profile: options.profile,
        contested: options.contested.clone(),
    })
}
