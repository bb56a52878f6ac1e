//! Reads OpenStreetMap XML, plain or gzip, with the byte position of every element: small files in one pass over a
//! slice, large ones in parts that all threads read at the same time.

use crate::projection::Extent;

use super::limits::{hold, most_input, most_unpacked, read_within};
use super::load::load;
use super::{OsmData, ReadError, Source, pbf};
use std::path::{Path, PathBuf};

mod blocks;
mod data_blocks;
mod parser;
mod parts;

pub use blocks::{Block, Blocks};
pub use data_blocks::DataBlocks;

use parser::{Parser, Place, broken};

/// Reads one file.
///
/// # Errors
///
/// If the file cannot be read, or is no OpenStreetMap data.
pub fn read_file(path: &Path) -> Result<OsmData, ReadError> {
    read_files(&[path.to_path_buf()])
}

/// Reads several files into one map, in the given order.
///
/// # Errors
///
/// As [`read_file`], of the first file that fails.
pub fn read_files(paths: &[PathBuf]) -> Result<OsmData, ReadError> {
    let mut data = OsmData::default();
    for path in paths {
        read_bytes(&mut data, &path.display().to_string(), load(path)?)?;
    }
    Ok(data)
}

/// Adds the content of one file, XML (unpacked where it is gzip) or PBF, to `data`.
///
/// # Errors
///
/// If the content is no OpenStreetMap data. `data` then holds what was read before the fault.
pub fn read_bytes(data: &mut OsmData, name: &str, bytes: Vec<u8>) -> Result<(), ReadError> {
    let (known, bounds, oddities) = (data.counts(), data.bounds.len(), data.oddities.len());
    let read = read_content(data, name, bytes);
    data.index(known);
    if let Some(new) = data.oddities.get_mut(oddities..) {
        new.sort_by_key(|oddity| oddity.span.start);
    }
    read?;
    if data.bounds.len() == bounds {
        data.push_bounds(Extent::EARTH);
    }
    Ok(())
}

/// Refuses data with a node that lies nowhere on Earth, for those who need to know where everything is.
///
/// # Errors
///
/// If there is such a node: the first.
pub fn refuse_off_earth(data: &OsmData) -> Result<(), ReadError> {
    let Some(odd) = data.oddities.iter().find(|odd| odd.off_earth.is_some()) else { return Ok(()) };
    let Some(source) = data.sources.get(odd.span.file as usize) else { return Ok(()) };
    let help = "latitudes run from -90 to 90, longitudes from -180 to 180; are the two swapped?";
    let mut error = broken(&source.name, &source.text, odd.span.start as usize, odd.message.clone(), help);
    if let ReadError::Broken { text, .. } = &mut error {
        text.clone_from(&source.text);
    }
    Err(error)
}

fn read_content(data: &mut OsmData, name: &str, bytes: Vec<u8>) -> Result<(), ReadError> {
    // All files of a map lie in memory together.
    let most = most_input().saturating_sub(data.sources.iter().map(|source| source.text.len() as u64).sum());
    if pbf::is_pbf(&bytes) {
        return pbf::read(data, name, &bytes, most);
    }
    let packed = bytes.starts_with(&[0x1f, 0x8b]);
    let most = if packed { most.min(most_unpacked(bytes.len())) } else { most };
    let mut bytes = if packed { unpack(name, &bytes, most)? } else { bytes };
    if bytes.len() as u64 > most {
        return Err(ReadError::TooLarge { name: name.to_owned(), most });
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(ReadError::Empty { name: name.to_owned() });
    }
    hold(&bytes, name)?;
    // Without the byte-order mark, so that offsets are those of the kept text.
    let marked = bytes.starts_with(b"\xef\xbb\xbf");
    if marked {
        bytes.drain(..3);
    }
    let text = String::from_utf8(bytes)
        .map_err(|error| ReadError::NotText { name: name.to_owned(), offset: error.utf8_error().valid_up_to() })?;
    let file = data.sources.len() as u32;
    if let Err(mut error) = parse(data, file, name, &text) {
        // The error shows the place in the text, so it takes the text along; a copy could be large.
        if let ReadError::Broken { text: shown, .. } = &mut error {
            *shown = text;
        }
        return Err(error);
    }
    data.sources.push(Source { name: name.to_owned(), text, marked });
    Ok(())
}

fn unpack(name: &str, packed: &[u8], most: u64) -> Result<Vec<u8>, ReadError> {
    let failed = |error: std::io::Error| ReadError::Packed { name: name.to_owned(), message: error.to_string() };
    read_within(flate2::read::MultiGzDecoder::new(packed), name, most, |_| true, failed)
}

fn parse(data: &mut OsmData, file: u32, name: &str, text: &str) -> Result<(), ReadError> {
    if let Some(parts) = parts::parse(file, name, text, parts::DOCUMENT) {
        data.nodes.reserve(parts.iter().map(|part| part.nodes.len()).sum());
        parts.into_iter().for_each(|part| data.append(part));
        return Ok(());
    }
    let mut parser = Parser { data, file, name, text };
    let reached = parser.run(0..text.len(), Place::default())?;
    ended(&parser, reached)
}

/// Whether a text may end at this place.
fn ended(parser: &Parser<'_>, reached: Place) -> Result<(), ReadError> {
    match reached {
        Place { depth: 1.., .. } => Err(parser.broken(
            parser.text.len(),
            "the file ends in the middle of an element".to_owned(),
            "the file is cut off; export or download it again",
        )),
        Place { seen_root: false, .. } => Err(parser.broken(
            0,
            "there is no <osm> element".to_owned(),
            "expected OpenStreetMap XML, which begins with <?xml or <osm",
        )),
        Place { .. } => Ok(()),
    }
}

#[cfg(test)]
mod tests;
