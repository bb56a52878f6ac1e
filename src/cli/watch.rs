//! Waits until a file that a run reads changes.

use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, SystemTime};

use crate::api::{above, load};
use crate::lanelet;

/// How often the files are looked at. Asking costs little, and every file system can answer.
const PAUSE: Duration = Duration::from_millis(250);

/// A file with its time and length; `None` where it is not there.
pub type Stamp = (PathBuf, Option<(SystemTime, u64)>);

/// A map and the other files that a run reads.
#[derive(Clone, Debug)]
pub struct Watched {
    map: PathBuf,
    more: Vec<PathBuf>,
}

impl Watched {
    /// The map's files, what stands beside it and above it, and the given files.
    pub fn new(map: &Path, more: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { map: map.to_path_buf(), more: more.into_iter().collect() }
    }

    /// How the files are now.
    pub fn stamps(&self) -> Vec<Stamp> {
        let home = load::home(&self.map);
        let mut files = lanelet::files_of(&self.map).unwrap_or_default();
        files.push(home.join(lanelet::INFO));
        files.extend(above(home));
        files.extend(self.more.iter().cloned());
        let stamp = |file: &PathBuf| {
            let about = std::fs::metadata(file).ok()?;
            Some((about.modified().ok()?, about.len()))
        };
        files.into_iter().map(|file| (file.clone(), stamp(&file))).collect()
    }

    /// Waits until the files are not as they were, and nobody writes any more.
    pub fn wait(&self, mut before: Vec<Stamp>) {
        while self.stamps() == before {
            sleep(PAUSE);
        }
        loop {
            before = self.stamps();
            sleep(PAUSE);
            if self.stamps() == before {
                return;
            }
        }
    }
}
