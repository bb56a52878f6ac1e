//! Reads OpenStreetMap XML, plain or gzip, with the byte position of every element: small files in one pass over a
//! slice, large ones in parts that all threads read at the same time.

use crate::projection::Extent;

use super::load::load;
use super::{OsmData, ReadError, Source, pbf};
use std::io::Read;
use std::path::{Path, PathBuf};

mod blocks;
mod data_blocks;
mod parser;
mod parts;

pub use blocks::{Block, Blocks};
pub use data_blocks::DataBlocks;

use parser::{Parser, Place};

/// Largest unpacked size of a gzip file, bytes: the XML of a country. A small file can be packed so that it fills any memory.
const MOST_UNPACKED: u64 = 8 << 30;

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
        let bytes = load(path).map_err(|source| ReadError::Io { path: path.clone(), source })?;
        read_bytes(&mut data, &path.display().to_string(), bytes)?;
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
    data.oddities[oddities..].sort_by_key(|oddity| oddity.span.start);
    read?;
    if data.bounds.len() == bounds {
        data.push_bounds(Extent::EARTH);
    }
    Ok(())
}

fn read_content(data: &mut OsmData, name: &str, bytes: Vec<u8>) -> Result<(), ReadError> {
    if pbf::is_pbf(&bytes) {
        return pbf::read(data, name, &bytes);
    }
    let bytes = if bytes.starts_with(&[0x1f, 0x8b]) { unpack(name, &bytes)? } else { bytes };
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(ReadError::Empty { name: name.to_owned() });
    }
    // Without the byte-order mark, so that offsets are those of the kept text.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").map(<[u8]>::to_vec).unwrap_or(bytes);
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
    data.sources.push(Source { name: name.to_owned(), text });
    Ok(())
}

fn unpack(name: &str, packed: &[u8]) -> Result<Vec<u8>, ReadError> {
    let failed = |message: String| ReadError::Packed { name: name.to_owned(), message };
    let mut bytes = Vec::new();
    let mut unpacked = flate2::read::MultiGzDecoder::new(packed).take(MOST_UNPACKED);
    unpacked.read_to_end(&mut bytes).map_err(|error| failed(error.to_string()))?;
    if unpacked.limit() == 0 {
        return Err(failed(too_large()));
    }
    Ok(bytes)
}

fn too_large() -> String {
    format!("it holds more than {} GB", MOST_UNPACKED >> 30)
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
