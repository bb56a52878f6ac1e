//! What is remembered of a tile that is built: with it and its cells the tile need not be built again.

use std::collections::BTreeSet;
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
    /// Ids that two elements of it want, but for those that were known before it was built.
    pub contested: Vec<i64>,
    /// What was guessed, left out or could not be built as it should, its surroundings included.
    pub notes: usize,
    /// Errors, warnings and infos that have their place in it, where it was held against the rules.
    pub findings: Option<[usize; 3]>,
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
    contested: Vec<i64>,
    notes: usize,
    findings: Option<[usize; 3]>,
}

/// All kinds, by their numbers.
pub(super) const KINDS: [ElementKind; 3] = [ElementKind::Node, ElementKind::Way, ElementKind::Relation];

impl Record {
    /// Of a tile in which nothing is to be built.
    pub fn empty(grid: Grid) -> Self {
        Self { divided: Divided::empty(grid), settings: None, contested: Vec::new(), notes: 0, findings: None }
    }

    /// The name of the file in which it is kept.
    pub fn name(tile: Cell) -> String {
        format!("{}_{}.json", tile.column, tile.row)
    }

    /// Whether one of these ids stands in the tile, or was wanted there.
    pub fn has_any(&self, ids: &BTreeSet<i64>) -> bool {
        let shared = self.divided.shared.iter().map(|shared| &shared.element.1);
        self.divided.own.iter().chain(&self.contested).chain(shared).any(|id| ids.contains(id))
    }

    /// As it is kept in a file.
    ///
    /// # Errors
    ///
    /// None that is known: JSON can say all of it.
    pub fn to_bytes(&self) -> io::Result<Vec<u8>> {
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
            contested: self.contested.clone(),
            notes: self.notes,
            findings: self.findings,
        };
        for Shared { element: (kind, id), text, tiles } in shared {
            let set: Vec<[i32; 2]> = tiles.iter().map(pair).collect();
            let at = stored.tiles.iter().position(|known| *known == set).unwrap_or_else(|| {
                stored.tiles.push(set);
                stored.tiles.len() - 1
            });
            stored.shared.push((*kind as u8, *id, *text, at));
        }
        Ok(serde_json::to_vec(&stored)?)
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn save(&self, file: &Path) -> io::Result<()> {
        let begun = file.with_extension("begun");
        fs::write(&begun, self.to_bytes()?)?;
        fs::rename(begun, file)
    }

    /// Reads it again.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or is no record.
    pub fn load(file: &Path, grid: Grid) -> io::Result<Self> {
        let stored: Stored = serde_json::from_slice(&fs::read(file)?)?;
        let Stored { cells, elements, written, own, tiles, shared, settings, contested, notes, findings } = stored;
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
        let divided = Divided { grid, cells, elements, written, own, shared };
        Ok(Self { divided, settings, contested, notes, findings })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_read_as_it_was_written() {
        let grid = Grid::new(100).unwrap();
        let settings = Some("x = 1\n".to_owned());
        let mut record =
            Record { settings, contested: vec![i64::MAX], notes: 3, findings: Some([0, 1, 2]), ..Record::empty(grid) };
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
        assert!(record.has_any(&[7].into()) && record.has_any(&[i64::MAX].into()) && !record.has_any(&[8].into()));
        fs::write(&file, "{").unwrap();
        assert!(Record::load(&file, grid).is_err());
    }
}
