//! Where tiles are built beside the output: the data of each, the cells that are done, and what is remembered of them.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Instant, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::cells::{Cell, Divided};
use crate::tiles::{Record, TileFile};

use super::files::{Aside, parent};

/// What tiles are built from: tiles of other data, or built otherwise, are not theirs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Begun {
    /// The data, and a terrain model: where they lie, how long they are, and when they were changed, nanoseconds since 1970.
    files: Vec<(PathBuf, u64, u64)>,
    /// The description of what is the same for all tiles, with the program's version and all settings.
    description: String,
}

impl Begun {
    /// Of files as they are now, and the description of the cut data before their tiles are listed.
    pub(super) fn new(files: &[&Path], description: String) -> io::Result<Self> {
        let state = |file: &&Path| -> io::Result<(PathBuf, u64, u64)> {
            let about = fs::metadata(file)?;
            let changed = about.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos() as u64;
            Ok((file.canonicalize()?, about.len(), changed))
        };
        Ok(Self { files: files.iter().map(state).collect::<io::Result<_>>()?, description })
    }
}

/// A folder beside the output. Without `--resume` it has a name that nobody else has, and is gone when the run ends.
pub(super) struct Workplace {
    folder: PathBuf,
    /// Removes the folder when it is dropped.
    _guard: Option<Aside>,
}

impl Workplace {
    /// Makes the folder, or goes on in that of an earlier run, with the files of its tiles.
    pub(super) fn begin(output: &Path, resume: bool, begun: &Begun) -> io::Result<(Self, Option<Vec<TileFile>>)> {
        fs::create_dir_all(parent(output))?;
        let place = if resume {
            let name = output.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            Self { folder: parent(output).join(format!(".{name}.tiles")), _guard: None }
        } else {
            let guard = Aside::new(parent(output), false)?;
            Self { folder: guard.path().to_path_buf(), _guard: Some(guard) }
        };
        let known = place.known(begun);
        if known.is_none() && resume && place.folder.exists() {
            fs::remove_dir_all(&place.folder)?;
        }
        // The cells are moved away when all is done: where they are missing, nothing is.
        if !place.cells().exists() {
            let _ = fs::remove_dir_all(place.records());
        }
        let _ = fs::remove_dir_all(place.open());
        for folder in [place.data(), place.cells(), place.records(), place.open()] {
            fs::create_dir_all(folder)?;
        }
        Ok((place, known))
    }

    fn known(&self, begun: &Begun) -> Option<Vec<TileFile>> {
        let text = fs::read(self.folder.join("begun.json")).ok()?;
        let (of, tiles): (Begun, Vec<[i32; 2]>) = serde_json::from_slice(&text).ok()?;
        let file = |[row, column]: [i32; 2]| {
            let tile = Cell { row, column };
            TileFile { tile, path: TileFile::path_in(&self.data(), tile) }
        };
        (of == *begun).then(|| tiles.into_iter().map(file).collect())
    }

    /// Notes that the data of all tiles are there.
    pub(super) fn keep(&self, begun: &Begun, files: &[TileFile]) -> io::Result<()> {
        let tiles: Vec<[i32; 2]> = files.iter().map(|file| [file.tile.row, file.tile.column]).collect();
        let draft = self.folder.join("begun.draft");
        fs::write(&draft, serde_json::to_vec(&(begun, tiles))?)?;
        fs::rename(draft, self.folder.join("begun.json"))
    }

    /// The data of each tile.
    pub(super) fn data(&self) -> PathBuf {
        self.folder.join("data")
    }

    /// The cells that are done.
    pub(super) fn cells(&self) -> PathBuf {
        self.folder.join("cells")
    }

    /// What is remembered of the tiles that are built.
    pub(super) fn records(&self) -> PathBuf {
        self.folder.join("records")
    }

    /// Tiles that are being built.
    fn open(&self) -> PathBuf {
        self.folder.join("open")
    }

    fn record_file(&self, tile: Cell) -> PathBuf {
        self.records().join(Record::name(tile))
    }

    /// Whether a tile is built.
    pub(super) fn has(&self, tile: Cell) -> bool {
        self.record_file(tile).exists()
    }

    /// Ids that two elements of the map want, as far as an earlier run has found out.
    pub(super) fn known_contested(&self) -> io::Result<BTreeSet<i64>> {
        match fs::read(self.contested_file()) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(BTreeSet::new()),
            text => Ok(serde_json::from_slice(&text?)?),
        }
    }

    /// Notes the ids that two elements of the map want, before a tile is built again without them.
    pub(super) fn keep_contested(&self, contested: &BTreeSet<i64>) -> io::Result<()> {
        let draft = self.folder.join("contested.draft");
        fs::write(&draft, serde_json::to_vec(contested)?)?;
        fs::rename(draft, self.contested_file())
    }

    fn contested_file(&self) -> PathBuf {
        self.records().join("all.contested")
    }

    /// The tile is to be built again.
    pub(super) fn forget(&self, tile: Cell) -> io::Result<()> {
        fs::remove_file(self.record_file(tile))
    }

    /// An empty folder for the cells of a tile.
    pub(super) fn begin_tile(&self, tile: Cell) -> io::Result<PathBuf> {
        let folder = self.begun_tile(tile);
        fs::create_dir_all(&folder)?;
        Ok(folder)
    }

    fn begun_tile(&self, tile: Cell) -> PathBuf {
        self.open().join(format!("{}_{}", tile.column, tile.row))
    }

    /// Moves the cells of a tile to the others, and records it.
    pub(super) fn put(&self, tile: Cell, record: &Record) -> io::Result<()> {
        let (from, to) = (self.begun_tile(tile), self.cells());
        let Divided { grid, cells, .. } = &record.divided;
        let mut names = cells.iter().map(|cell| grid.name(*cell));
        names.try_for_each(|name| fs::rename(from.join(&name), to.join(&name)))?;
        fs::remove_dir_all(from)?;
        record.save(&self.record_file(tile))
    }

    /// Removes the folder.
    pub(super) fn clear(self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// How many tiles are built, and how long the others will take.
pub(super) struct Pace {
    all: usize,
    before: usize,
    done: AtomicUsize,
    begun: Instant,
}

impl Pace {
    pub(super) fn new(all: usize, missing: usize) -> Self {
        Self { all, before: all - missing, done: AtomicUsize::new(0), begun: Instant::now() }
    }

    /// Counts another tile.
    pub(super) fn another(&self) -> String {
        self.done.fetch_add(1, Ordering::Relaxed);
        self.said()
    }

    pub(super) fn said(&self) -> String {
        let done = self.done.load(Ordering::Relaxed);
        let (all, built) = (self.all, self.before + done);
        let mut said = format!("building tiles: {built} of {all}");
        if done > 0 {
            let each = self.begun.elapsed().as_secs_f64() / done as f64;
            let left = (each * (all - built) as f64).ceil() as u64;
            said.push_str(&format!(", {:.0} a minute, {}:{:02} left", 60.0 / each.max(1e-3), left / 60, left % 60));
        }
        said
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pace_is_that_of_this_run() {
        let pace = Pace::new(4, 2);
        assert_eq!(pace.said(), "building tiles: 2 of 4");
        assert!(pace.another().starts_with("building tiles: 3 of 4, "));
        assert!(pace.another().ends_with(" 0:00 left"));
    }
}
