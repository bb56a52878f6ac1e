//! The program while it serves a page.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// `lanewright view`, ended when dropped.
pub struct Program {
    child: Child,
    pub url: String,
}

impl Program {
    /// Starts it and waits for its address.
    pub fn view(arguments: &[&str], map: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_lanewright"))
            .arg("view")
            .args(arguments)
            .arg("--isolated")
            .arg(map)
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let url = line.split_whitespace().next().unwrap_or_else(|| panic!("no address")).to_owned();
        Self { child, url }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
