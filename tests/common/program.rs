//! Runs of the program.

use std::path::Path;
use std::process::{Command, Output};

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
