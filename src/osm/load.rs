//! The bytes of a file, read by all threads at once: most of the time goes into the memory that they come to lie in.

use std::fs::File;
use std::io;
use std::path::Path;

use super::limits::{most_input, read_within};
use super::{ReadError, pbf};

/// The bytes of a file, as many as [`most_input`] allows.
///
/// # Errors
///
/// If the file cannot be read, or takes more.
pub fn load(path: &Path) -> Result<Vec<u8>, ReadError> {
    let (name, most) = (|| path.display().to_string(), most_input());
    let failed = |source| ReadError::Io { path: path.to_path_buf(), source };
    let file = File::open(path).map_err(failed)?;
    let about = file.metadata().map_err(failed)?;
    // Pipes and the like have no length, and may have no end.
    if !about.is_file() {
        return read_within(file, &name(), most, is_xml, failed);
    }
    if about.len() > most {
        return Err(ReadError::TooLarge { name: name(), most });
    }
    read(path, &file, about.len()).map_err(failed)
}

/// Whether a file that begins so can be nothing else than XML: not packed, not GeoJSON.
fn is_xml(bytes: &[u8]) -> bool {
    let first = bytes.iter().find(|b| !b.is_ascii_whitespace());
    !bytes.starts_with(&[0x1f, 0x8b]) && !pbf::is_pbf(bytes) && first.is_none_or(|b| !b"{[".contains(b))
}

/// The bytes of a file of this length.
#[cfg(unix)]
fn read(path: &Path, file: &File, length: u64) -> io::Result<Vec<u8>> {
    use std::os::unix::fs::FileExt;

    use crate::parallel::InSmallParts;
    use rayon::prelude::*;

    /// Bytes that one thread reads at a time.
    const PART: usize = 1 << 20;

    if length <= PART as u64 {
        return std::fs::read(path);
    }
    let mut bytes = vec![0; length as usize];
    let parts = bytes.par_chunks_mut(PART).in_small_parts().enumerate();
    parts.try_for_each(|(i, part)| file.read_exact_at(part, (i * PART) as u64))?;
    Ok(bytes)
}

/// The bytes of a file of this length.
#[cfg(not(unix))]
fn read(path: &Path, _file: &File, _length: u64) -> io::Result<Vec<u8>> {
    std::fs::read(path)
}
