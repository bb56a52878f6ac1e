//! What an output is: a file, where its links lead, or something that is written into as it is, such as a device or a fifo.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::failures::parent;

/// As the command line names standard output, whatever the system; `-` becomes the first.
const STDOUT: [&str; 3] = ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// More links than this in a row lead nowhere: the system's own bound.
const MOST_LINKS: usize = 40;

/// Where an output goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Standard output of this process.
    Stdout,
    /// Something that is there and no file: it is written into.
    Stream(PathBuf),
    /// A file, or a directory; all links of its name are resolved. It need not be there.
    File(PathBuf),
}

impl Place {
    /// What a path leads to.
    pub(super) fn of(named: &Path) -> io::Result<Self> {
        let mut path = named.to_path_buf();
        for _ in 0..MOST_LINKS {
            if is_stdout(&path) {
                return Ok(Self::Stdout);
            }
            // A link in here stands for something open, whatever it seems to lead to.
            if parent(&path).canonicalize().is_ok_and(|home| home.starts_with("/proc")) {
                return Ok(Self::Stream(path));
            }
            match fs::symlink_metadata(&path) {
                Ok(about) if about.is_symlink() => path = parent(&path).join(fs::read_link(&path)?),
                Ok(about) if !about.is_file() && !about.is_dir() => return Ok(Self::Stream(path)),
                Ok(_) => return Ok(Self::File(path)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::File(path)),
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::other("its links lead in a circle"))
    }
}

/// Whether a path names standard output.
pub fn is_stdout(path: &Path) -> bool {
    STDOUT.iter().any(|name| path == Path::new(name))
}

/// Whether a file is a link, which may lead to a file that is nobody's business.
pub fn is_link(file: &Path) -> bool {
    fs::symlink_metadata(file).is_ok_and(|about| about.is_symlink())
}
