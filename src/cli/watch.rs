//! `check --watch`: checks again whenever a file that matters changes.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, SystemTime};

use lanewright::lanelet;
use lanewright::report::failure::Failure;

use super::check_args::CheckArgs;
use super::{check, config, load, screen};

/// How often the files are looked at. Asking costs little, and every file system can answer.
const PAUSE: Duration = Duration::from_millis(250);

/// A file with its time and length; `None` where it is not there.
type Stamp = (PathBuf, Option<(SystemTime, u64)>);

/// Checks until somebody ends it. A map that cannot be read is told and waited for: it may be half saved.
pub fn run(args: &CheckArgs) -> Result<u8, Failure> {
    loop {
        // Taken before the run, so that a change during it is seen.
        let before = stamps(args);
        if let Err(failure) = check::once(args) {
            screen::complain(&failure.render(screen::stderr_style()));
        }
        screen::complain(&format!("watching {}; Ctrl-C ends\n", args.map.display()));
        while stamps(args) == before {
            sleep(PAUSE);
        }
        settle(args);
        if std::io::stdout().is_terminal() {
            const CLEAR: &str = "\u{1b}[2J\u{1b}[H";
            screen::print(CLEAR)?;
        }
    }
}

/// Waits until nobody writes any more.
fn settle(args: &CheckArgs) {
    loop {
        let before = stamps(args);
        sleep(PAUSE);
        if stamps(args) == before {
            return;
        }
    }
}

fn stamps(args: &CheckArgs) -> Vec<Stamp> {
    let home = load::home(&args.map);
    let mut files = lanelet::files_of(&args.map).unwrap_or_default();
    files.push(home.join(lanelet::INFO));
    files.extend(config::above(home));
    files.extend(args.config.config.iter().map(PathBuf::from));
    files.extend(args.baseline.clone());
    let stamp = |file: &PathBuf| {
        let about = std::fs::metadata(file).ok()?;
        Some((about.modified().ok()?, about.len()))
    };
    files.into_iter().map(|file| (file.clone(), stamp(&file))).collect()
}
