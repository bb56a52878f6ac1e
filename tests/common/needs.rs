//! What tests need from outside the project, and the one way to skip a test where it is missing.
//!
//! `scripts/test.sh` prints which tests were skipped. Where `../shared` is, as on the machine that tests every change, nothing
//! may be skipped: there a test fails instead.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::program::Run;
use super::root;

/// Where the corpus and the acceptance tools lie.
fn material() -> PathBuf {
    std::env::var_os("LANEWRIGHT_SHARED").map_or_else(|| root().join("../shared"), PathBuf::from)
}

/// A file or folder of `../shared`; `None`, noted as skipped, without `../shared`.
pub fn shared(path: &str) -> Option<PathBuf> {
    if !material().is_dir() {
        return skip("../shared is not here");
    }
    let path = material().join(path);
    assert!(path.exists(), "{} is missing", path.display());
    Some(path)
}

/// Notes that the running test, or a part of it, is skipped, in the file that LANEWRIGHT_SKIPPED names.
pub fn skip<T>(reason: &str) -> Option<T> {
    assert!(!material().is_dir(), "this test may not be skipped where ../shared is: {reason}");
    eprintln!("skipped: {reason}");
    if let Some(list) = std::env::var_os("LANEWRIGHT_SKIPPED") {
        // Without a thread of its own a test runs on the main one, and only nextest tells its name.
        let name = std::env::var("NEXTEST_TEST_NAME").ok();
        let name = name.or_else(|| std::thread::current().name().map(str::to_owned)).unwrap_or_default();
        let mut list = OpenOptions::new().append(true).create(true).open(list).unwrap();
        // One write, so that lines of tests that run at the same time stay whole.
        list.write_all(format!("{}::{name}\t{reason}\n", env!("CARGO_CRATE_NAME")).as_bytes()).unwrap();
    }
    None
}

/// A Python that has the real Lanelet2 library; `None`, noted as skipped, where there is none.
pub fn python() -> Option<Command> {
    let python = std::env::var("LANEWRIGHT_ORACLE").ok().filter(|path| !path.is_empty()).map(PathBuf::from);
    let installed = root().join("target/oracle");
    match python.or_else(|| installed.join("ready").exists().then(|| installed.join("bin/python"))) {
        Some(python) => Some(Command::new(python)),
        None => skip("no Python with the Lanelet2 library; scripts/oracle.sh installs one"),
    }
}

/// Runs the acceptance check of the real Lanelet2 library; `None`, noted as skipped, where it is not here.
pub fn accept(map: &Path, strict: bool) -> Option<Run> {
    let script = shared("tools/accept_lanelet2.py")?;
    let mut command = python()?;
    command.arg(script).arg(map);
    if strict {
        command.arg("--strict");
    }
    Some(command.output().unwrap().into())
}
