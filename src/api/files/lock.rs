//! Who writes: drafts that a run keeps, those that a killed run has left, and one run at a time that puts files into a directory.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::TempDir;

use crate::report::failure::Failure;

/// Drafts lie in folders whose names begin so.
const PREFIX: &str = ".lanewright-draft-";
/// So many letters follow.
const LETTERS: usize = 6;

/// A folder for drafts, gone when it is dropped, and locked until then: what nobody holds was left by a run that was killed.
#[derive(Debug)]
pub struct Aside {
    folder: TempDir,
    _lock: Option<File>,
}

impl Aside {
    /// Makes a folder in another; one that is to be the result is made with the rights that any new directory has.
    pub fn new(home: &Path, result: bool) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).rand_bytes(LETTERS);
        #[cfg(unix)]
        if result {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o777));
        }
        #[cfg(not(unix))]
        let _ = result;
        loop {
            let folder = builder.tempdir_in(home)?;
            let lock = File::open(folder.path()).ok().filter(|file| system::lock(file) == system::Lock::Ours);
            // Between the two, another run may have taken it for one that was left.
            if folder.path().is_dir() {
                return Ok(Self { folder, _lock: lock });
            }
        }
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Keeps the folder, which has another name by now.
    pub(super) fn keep(self) {
        let _ = self.folder.keep();
    }
}

/// Directories that this process has swept.
static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes drafts that killed runs have left in a directory, once.
pub(super) fn sweep(home: &Path) {
    if !SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(home.to_path_buf()) {
        return;
    }
    for entry in fs::read_dir(home).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_draft =
            name.to_str().and_then(|name| name.strip_prefix(PREFIX)).is_some_and(|rest| rest.len() == LETTERS);
        if is_draft && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            let lock = File::open(entry.path()).ok().filter(|file| system::lock(file) == system::Lock::Ours);
            if lock.is_some() {
                let _ = fs::remove_dir_all(entry.path());
            }
        }
    }
}

/// A name for a folder that the next sweep removes.
pub(super) fn swept_name(home: &Path) -> PathBuf {
    home.join(format!("{PREFIX}{:06}", std::process::id() % 1_000_000))
}

/// That no other run puts files into a directory meanwhile.
pub(super) struct Alone(#[allow(dead_code, reason = "held until it is dropped")] Option<File>);

impl Alone {
    /// Waits for other runs, which only move files. Where the file system knows no locks, there is nothing to wait for.
    pub(super) fn in_directory(dir: &Path) -> Result<Self, Failure> {
        let Ok(file) = File::open(dir) else { return Ok(Self(None)) };
        for _ in 0..WAITS {
            match system::lock(&file) {
                system::Lock::Ours => return Ok(Self(Some(file))),
                system::Lock::Unknown => return Ok(Self(None)),
                system::Lock::Others => std::thread::sleep(WAIT),
            }
        }
        Err(Failure::new(format!("another program keeps {} locked", dir.display()))
            .about(dir.display().to_string())
            .help("nothing was changed; run again when it has ended"))
    }
}

/// Another run is waited for so often.
const WAITS: u32 = 1500;
/// And so long each time.
const WAIT: std::time::Duration = std::time::Duration::from_millis(20);

#[cfg(unix)]
mod system {
    use std::fs::File;

    use rustix::fs::{FlockOperation, flock};
    use rustix::io::Errno;

    /// Whose a lock is.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(super) enum Lock {
        Ours,
        Others,
        Unknown,
    }

    /// Locks an open file until it is closed, by whatever end of the process.
    pub(super) fn lock(file: &File) -> Lock {
        match flock(file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => Lock::Ours,
            Err(Errno::WOULDBLOCK) => Lock::Others,
            Err(_) => Lock::Unknown,
        }
    }
}

#[cfg(not(unix))]
mod system {
    use std::fs::File;

    /// Whose a lock is.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[allow(dead_code, reason = "directories cannot be locked here")]
    pub(super) enum Lock {
        Ours,
        Others,
        Unknown,
    }

    pub(super) fn lock(_: &File) -> Lock {
        Lock::Unknown
    }
}
