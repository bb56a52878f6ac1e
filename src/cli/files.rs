//! Writes results so that a failure leaves nothing half-written and what was good before stays good.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use lanewright::report::failure::Failure;

/// Writes files into `dir`, made if it is not there: first all of them beside their places, then each moved there.
pub fn publish(dir: &Path, files: &[(&str, &[u8])]) -> Result<(), Failure> {
    let failed = |what: &str, path: &Path, error: io::Error| {
        Failure::new(format!("cannot {what} {}: {error}", path.display()))
            .help("nothing was changed; check the place's permissions and free space")
    };
    fs::create_dir_all(dir).map_err(|e| failed("make the directory", dir, e))?;
    // Within `dir`, because a move is atomic only on one file system.
    let draft =
        tempfile::Builder::new().prefix(".lanewright-").tempdir_in(dir).map_err(|e| failed("write into", dir, e))?;
    for (name, bytes) in files {
        let path = draft.path().join(name);
        write(&path, bytes).map_err(|e| failed("write", &dir.join(name), e))?;
        if dir.join(name).is_dir() {
            return Err(Failure::new(format!("{} is a directory", dir.join(name).display()))
                .help("nothing was changed; move it away or give another output"));
        }
    }
    for (name, _) in files {
        fs::rename(draft.path().join(name), dir.join(name)).map_err(|e| failed("write", &dir.join(name), e))?;
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
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
