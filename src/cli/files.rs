//! Writes results so that a failure leaves nothing half-written and what was good before stays good.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use lanewright::report::failure::Failure;
use tempfile::TempDir;

/// Writes files into `dir`, made if it is not there, all or none.
pub fn publish(dir: &Path, files: &[(&str, &[u8])]) -> Result<(), Failure> {
    let mut draft = Draft::new(dir)?;
    for (name, bytes) in files {
        draft.write(name, |file| file.write_all(bytes))?;
    }
    draft.publish()
}

/// Files that stand beside their places until all of them are good.
pub struct Draft<'a> {
    dir: &'a Path,
    beside: TempDir,
    names: Vec<String>,
}

impl<'a> Draft<'a> {
    /// Begins a draft of files in `dir`, which is made if it is not there.
    pub fn new(dir: &'a Path) -> Result<Self, Failure> {
        fs::create_dir_all(dir).map_err(|e| failed("make the directory", dir, e))?;
        // Within `dir`, because a move is atomic only on one file system.
        let beside = tempfile::Builder::new().prefix(".lanewright-").tempdir_in(dir);
        Ok(Self { dir, beside: beside.map_err(|e| failed("write into", dir, e))?, names: Vec::new() })
    }

    /// Writes a file, by a function that need not hold all of it in memory.
    pub fn write(&mut self, name: &str, content: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Failure> {
        let place = self.dir.join(name);
        let written = File::create(self.beside.path().join(name)).and_then(|mut file| {
            content(&mut file)?;
            file.sync_all()
        });
        written.map_err(|e| failed("write", &place, e))?;
        if place.is_dir() {
            return Err(Failure::new(format!("{} is a directory", place.display()))
                .help("nothing was changed; move it away or give another output"));
        }
        self.names.push(name.to_owned());
        Ok(())
    }

    /// Moves all files to their places.
    pub fn publish(self) -> Result<(), Failure> {
        for name in &self.names {
            let place = self.dir.join(name);
            fs::rename(self.beside.path().join(name), &place).map_err(|e| failed("write", &place, e))?;
        }
        Ok(())
    }
}

fn failed(what: &str, path: &Path, error: io::Error) -> Failure {
    Failure::new(format!("cannot {what} {}: {error}", path.display()))
        .help("nothing was changed; check the place's permissions and free space")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_what_was_there() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("a"), "old").unwrap();
        fs::create_dir(dir.path().join("b")).unwrap();
        let result = publish(dir.path(), &[("a", b"new"), ("b", b"new")]);
        assert!(result.unwrap_err().to_string().ends_with("b is a directory"));
        assert_eq!(fs::read_to_string(dir.path().join("a")).unwrap(), "old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2, "the draft is gone");
    }

    #[test]
    fn directories_are_made() {
        let dir = tempfile::tempdir().unwrap();
        let deep = dir.path().join("x/y");
        publish(&deep, &[("a", b"1")]).unwrap();
        assert_eq!(fs::read(deep.join("a")).unwrap(), b"1");
    }
}
