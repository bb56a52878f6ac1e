//! What is remembered of a tile that is built: with it and its cells the tile need not be built again.

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::cells::{Cell, Divided, Grid, Shared};
use crate::osm::ElementKind;

/// A tile that is built.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Its cells, and what stands in them.
    pub divided: Divided,
    /// The settings that go beside it, as TOML; `None` where there is nothing to drive on.
    pub settings: Option<String>,
}

/// As it is written.
#[derive(Serialize, Deserialize)]
struct Stored {
    cells: Vec<[i32; 2]>,
    elements: usize,
    written: usize,
    own: Vec<i64>,
    /// Sets of tiles.
    tiles: Vec<Vec<[i32; 2]>>,
    /// Shared elements: kind, id, hash of the text, set of tiles.
    shared: Vec<(u8, i64, u64, usize)>,
    settings: Option<String>,
}

const KINDS: [ElementKind; 3] = [ElementKind::Node, ElementKind::Way, ElementKind::Relation];

impl Record {
    /// Of a tile in which nothing is to be built.
    pub fn empty(grid: Grid) -> Self {
        Self { divided: Divided::empty(grid), settings: None }
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn save(&self, file: &Path) -> io::Result<()> {
        let Divided { cells, elements, written, own, shared, .. } = &self.divided;
        let pair = |cell: &Cell| [cell.row, cell.column];
        let mut stored = Stored {
            cells: cells.iter().map(pair).collect(),
            elements: *elements,
            written: *written,
            own: own.clone(),
            tiles: Vec::new(),
            shared: Vec::with_capacity(shared.len()),
            settings: self.settings.clone(),
        };
        for Shared { element: (kind, id), text, tiles } in shared {
            let set: Vec<[i32; 2]> = tiles.iter().map(pair).collect();
            let at = stored.tiles.iter().position(|known| *known == set).unwrap_or_else(|| {
                stored.tiles.push(set);
                stored.tiles.len() - 1
            });
            stored.shared.push((*kind as u8, *id, *text, at));
        }
        let begun = file.with_extension("begun");
        fs::write(&begun, serde_json::to_vec(&stored)?)?;
        fs::rename(begun, file)
    }

    /// Reads it again.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or is no record.
    pub fn load(file: &Path, grid: Grid) -> io::Result<Self> {
        let stored: Stored = serde_json::from_slice(&fs::read(file)?)?;
        let Stored { cells, elements, written, own, tiles, shared, settings } = stored;
        let cell = |[row, column]: [i32; 2]| Cell { row, column };
        let tiles: Vec<std::sync::Arc<[Cell]>> =
            tiles.into_iter().map(|set| set.into_iter().map(cell).collect()).collect();
        let shared = shared.into_iter().map(|(kind, id, text, set)| {
            let (kind, tiles) = KINDS.get(usize::from(kind)).zip(tiles.get(set))?;
            Some(Shared { element: (*kind, id), text, tiles: tiles.clone() })
        });
        let shared: Option<Vec<Shared>> = shared.collect();
        let shared = shared.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "no record of a tile"))?;
        let cells = cells.into_iter().map(cell).collect();
        Ok(Self { divided: Divided { grid, cells, elements, written, own, shared }, settings })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_read_as_it_was_written() {
        let grid = Grid::new(100).unwrap();
        let mut record = Record { settings: Some("x = 1\n".to_owned()), ..Record::empty(grid) };
        let [here, there] = [0, 1].map(|column| Cell { row: -3, column });
        record.divided.cells = vec![here];
        record.divided.own = vec![7, -9_007_199_254_740_991];
        let element = (ElementKind::Relation, 7);
        record.divided.shared = vec![Shared { element, text: u64::MAX, tiles: [here, there].into() }];
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("record");
        record.save(&file).unwrap();
        assert_eq!(Record::load(&file, grid).unwrap(), record);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        fs::write(&file, "{").unwrap();
        assert!(Record::load(&file, grid).is_err());
    }
}
