//! The bytes of a file, read by all threads at once: most of the time goes into the memory that they come to lie in.

use std::io;
use std::path::Path;

/// The bytes of a file.
///
/// # Errors
///
/// If the file cannot be read.
#[cfg(unix)]
pub fn load(path: &Path) -> io::Result<Vec<u8>> {
    use std::os::unix::fs::FileExt;

    use crate::parallel::Finely;
    use rayon::prelude::*;

    /// Bytes that one thread reads at a time.
    const PART: usize = 1 << 20;

    let file = std::fs::File::open(path)?;
    let about = file.metadata()?;
    // Pipes and the like have no length.
    if !about.is_file() || about.len() <= PART as u64 {
        return std::fs::read(path);
    }
    let mut bytes = vec![0; about.len() as usize];
    let parts = bytes.par_chunks_mut(PART).finely().enumerate();
    parts.try_for_each(|(i, part)| file.read_exact_at(part, (i * PART) as u64))?;
    Ok(bytes)
}

/// The bytes of a file.
///
/// # Errors
///
/// If the file cannot be read.
#[cfg(not(unix))]
pub fn load(path: &Path) -> io::Result<Vec<u8>> {
    std::fs::read(path)
}
