//! Holds tiles against each other: what stands in two is the same in both. Finds ids that two elements have.

use std::collections::BTreeMap;
use std::collections::hash_map::Entry;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use crate::cells::{Cell, Divided, Element, Shared};

/// Files over which ids are spread: one of them is in memory at a time.
const FILES: usize = 256;

/// In what tiles do not agree.
#[derive(Debug, thiserror::Error)]
pub enum Disagreement {
    /// Two have built an element otherwise, or only one of them has it.
    #[error("tiles that meet disagree on {} {} of the map", .0.0, .0.1)]
    Element(Element),
    /// Two elements have this id, whatever is done about it.
    #[error("two elements of the map have the id {0}")]
    Id(i64),
    /// What is known of the tiles so far cannot be kept.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// What must be remembered of the tiles that are built.
#[derive(Debug)]
pub struct Agreement {
    /// What tiles that are built share with tiles to come, by the last of them.
    open: BTreeMap<Cell, FxHashMap<Element, Open>>,
    /// The ids of all elements, by their last digits.
    ids: Vec<PathBuf>,
}

/// An element that stands in several tiles, some of which are still to be built.
#[derive(Debug)]
struct Open {
    shared: Shared,
    seen: usize,
}

impl Agreement {
    /// Before the first tile. Ids are kept in files in a folder that is there, of which an earlier run may have left some.
    pub fn new(folder: &Path) -> Self {
        let ids: Vec<PathBuf> = (0..FILES).map(|file| folder.join(format!("ids_{file}"))).collect();
        ids.iter().for_each(|path| drop(fs::remove_file(path)));
        Self { open: BTreeMap::new(), ids }
    }

    /// Adds a tile, behind those in the rows before and before it in its row.
    ///
    /// # Errors
    ///
    /// It disagrees with one of them.
    pub fn add(&mut self, tile: Cell, divided: &mut Divided) -> Result<(), Disagreement> {
        let shared = std::mem::take(&mut divided.shared);
        shared.into_iter().try_for_each(|shared| self.compare(tile, shared))?;
        self.keep_ids(&divided.own)?;
        // From here on nobody is to have these.
        let mut closed = self.open.remove(&tile).into_iter().flatten();
        let missing = closed.find(|(_, Open { shared, seen })| *seen != shared.tiles.len());
        missing.map_or(Ok(()), |(element, _)| Err(Disagreement::Element(element)))
    }

    fn compare(&mut self, tile: Cell, shared: Shared) -> Result<(), Disagreement> {
        let element = shared.element;
        let last = shared.tiles.last().copied().unwrap_or(tile);
        let same = match self.open.entry(last).or_default().entry(element) {
            Entry::Vacant(place) => {
                let is_first = shared.tiles.first() == Some(&tile);
                place.insert(Open { shared, seen: 1 });
                is_first
            }
            Entry::Occupied(mut known) => {
                known.get_mut().seen += 1;
                known.get().shared == shared
            }
        };
        if same { Ok(()) } else { Err(Disagreement::Element(element)) }
    }

    fn keep_ids(&self, own: &[i64]) -> io::Result<()> {
        let mut bytes = vec![Vec::new(); FILES];
        for id in own {
            let of_file = bytes.get_mut(id.rem_euclid(FILES as i64) as usize);
            of_file.into_iter().for_each(|bytes| bytes.extend_from_slice(&id.to_le_bytes()));
        }
        let append = |(path, bytes): (&PathBuf, &Vec<u8>)| {
            OpenOptions::new().create(true).append(true).open(path)?.write_all(bytes)
        };
        self.ids.iter().zip(&bytes).try_for_each(append)
    }

    /// After the last tile: the ids that two elements have, which are far from each other.
    ///
    /// # Errors
    ///
    /// A tile that was never built was to have an element.
    pub fn finish(self) -> Result<Vec<i64>, Disagreement> {
        if let Some(element) = self.open.into_values().flat_map(FxHashMap::into_keys).min() {
            return Err(Disagreement::Element(element));
        }
        let mut twice = Vec::new();
        for path in self.ids.iter().filter(|path| path.exists()) {
            let bytes = fs::read(path)?;
            let ids = bytes.chunks_exact(8).filter_map(|bytes| bytes.try_into().ok().map(i64::from_le_bytes));
            // Sorted, because a set takes three times the memory.
            let mut ids: Vec<i64> = ids.collect();
            ids.sort_unstable();
            twice.extend(ids.iter().zip(ids.iter().skip(1)).filter_map(|(id, next)| (id == next).then_some(*id)));
            fs::remove_file(path)?;
        }
        Ok(twice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Grid;
    use crate::osm::ElementKind;

    const TILES: [Cell; 2] = [Cell { row: 0, column: 0 }, Cell { row: 0, column: 1 }];

    /// A tile with an element of this text in both tiles, and one of its own.
    fn tile(text: u64, own: i64) -> Divided {
        let mut divided = Divided::empty(Grid::new(100).unwrap());
        divided.shared.push(Shared { element: (ElementKind::Way, 7), text, tiles: TILES.into() });
        divided.own.push(own);
        divided
    }

    fn said(tiles: [Option<Divided>; 2]) -> Result<Vec<i64>, String> {
        let dir = tempfile::tempdir().unwrap();
        let mut agreement = Agreement::new(dir.path());
        let empty = || Divided::empty(Grid::new(100).unwrap());
        let mut add = |(at, tile): (Cell, Option<Divided>)| agreement.add(at, &mut tile.unwrap_or_else(empty));
        let added = TILES.into_iter().zip(tiles).try_for_each(&mut add);
        added.and_then(|()| agreement.finish()).map_err(|error| error.to_string())
    }

    #[test]
    fn tiles_agree_or_say_in_what_they_do_not() {
        assert_eq!(said([Some(tile(1, 2)), Some(tile(1, 3))]), Ok(vec![]));
        let disagree = Err("tiles that meet disagree on way 7 of the map".to_owned());
        assert_eq!(said([Some(tile(1, 2)), Some(tile(4, 3))]), disagree);
        assert_eq!(said([Some(tile(1, 2)), None]), disagree);
        assert_eq!(said([None, Some(tile(1, 2))]), disagree);
        assert_eq!(said([Some(tile(1, 66)), Some(tile(1, 66))]), Ok(vec![66]));
    }
}
