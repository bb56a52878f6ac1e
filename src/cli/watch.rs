//! `check --watch`: checks again whenever a file that matters changes.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, SystemTime};

use crate::api::{above, load};
use crate::lanelet;
use crate::report::failure::Failure;

use super::check_args::CheckArgs;
use super::{check, output};

/// How often the files are looked at. Asking costs little, and every file system can answer.
const PAUSE: Duration = Duration::from_millis(250);

/// A file with its time and length; `None` where it is not there.
type Stamp = (PathBuf, Option<(SystemTime, u64)>);

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

/// Checks until somebody ends it. A map that cannot be read is told and waited for: it may be half saved.
pub fn run(args: &CheckArgs) -> Result<u8, Failure> {
    let more = args.config.config.iter().map(PathBuf::from).chain(args.baseline.clone());
    let watched = Watched::new(&args.map, more);
    loop {
        // Taken before the run, so that a change during it is seen.
        let before = watched.stamps();
        if let Err(failure) = check::once(args) {
            output::complain(&failure.render(output::stderr_style()));
        }
        output::complain(&format!("watching {}; Ctrl-C ends\n", args.map.display()));
        watched.wait(before);
        if std::io::stdout().is_terminal() {
            const CLEAR: &str = "\u{1b}[2J\u{1b}[H";
            output::print(CLEAR)?;
        }
    }
}
