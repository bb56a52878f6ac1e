//! What the tests that run the program share.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]
#![allow(dead_code, missing_docs)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A run of the program.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

impl Run {
    /// Holds the exit code, and shows everything if it is another.
    #[track_caller]
    pub fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, code, "exit code; stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }

    /// Holds that a failure says each of these on standard error, and nothing on standard output.
    #[track_caller]
    pub fn fails_saying(self, words: &[&str]) -> Self {
        let run = self.exits(2);
        assert_eq!(run.stdout, "", "a failed run has no result");
        // Long lines are wrapped; the words are looked for across the breaks.
        let flat = run.stderr.replace(['│', '╰', '▶', '×'], " ");
        let flat = flat.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in words {
            assert!(flat.contains(word), "`{word}` is not said:\n{}", run.stderr);
        }
        run
    }
}

/// The program, run from `dir`.
pub fn lanewright(dir: &Path, arguments: &[&str]) -> Run {
    command(dir, arguments).output().unwrap().into()
}

pub fn command(dir: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lanewright"));
    // Help is wrapped to the width of the terminal.
    command.current_dir(dir).args(arguments).env_remove("COLUMNS");
    command
}

/// The sample maps, sorted.
pub fn samples() -> Vec<PathBuf> {
    osm_files(&root().join("sample_maps"))
}

/// The `.osm` files of a directory, sorted.
pub fn osm_files(dir: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(dir)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "osm"))
        .collect();
    files.sort();
    files
}

/// Where the corpus and the acceptance tools lie; says so if they are not here.
pub fn shared() -> Option<PathBuf> {
    let shared = std::env::var_os("LANEWRIGHT_SHARED").map_or_else(|| root().join("../shared"), PathBuf::from);
    if shared.is_dir() {
        return Some(shared);
    }
    eprintln!("skipped: ../shared is not here");
    None
}

/// A Python that has the real Lanelet2 library; `None`, and says so, where there is none.
pub fn python() -> Option<Command> {
    let python = std::env::var("LANEWRIGHT_ORACLE").ok().filter(|p| !p.is_empty()).map(PathBuf::from);
    let python = python.or_else(|| Some(root().join("target/oracle/bin/python")).filter(|p| p.exists()));
    if python.is_none() {
        eprintln!("skipped: no Python with the Lanelet2 library (scripts/oracle.sh makes one)");
    }
    python.map(Command::new)
}

/// Runs the acceptance check of the real Lanelet2 library; `None`, and says so, where it is not here.
pub fn accept(map: &Path, strict: bool) -> Option<Run> {
    let shared = shared()?;
    let mut command = python()?;
    command.arg(shared.join("tools/accept_lanelet2.py")).arg(map);
    if strict {
        command.arg("--strict");
    }
    Some(command.output().unwrap().into())
}
