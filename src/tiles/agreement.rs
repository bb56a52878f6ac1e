//! Holds tiles against each other: what stands in two is the same in both. Finds ids that two elements have.

use std::fs::{self, OpenOptions};
use std::hash::{Hash, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rustc_hash::FxHasher;

use crate::cells::{Cell, Divided, Element, Shared};

use super::record::KINDS;

/// Files over which elements are spread by their ids: of few of them at a time all is in memory.
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

/// What must be remembered of the tiles that are built. It lies in files, so that memory does not grow with the map.
#[derive(Debug)]
pub struct Agreement {
    /// What stands in several tiles, as each of them has it.
    shared: Spread<5>,
    /// The ids of all elements.
    ids: Spread<1>,
}

impl Agreement {
    /// Before the first tile. Files are kept in a folder that is there, of which an earlier run may have left some.
    pub fn new(folder: &Path) -> Self {
        Self { shared: Spread::new(folder, "shared"), ids: Spread::new(folder, "ids") }
    }

    /// Adds a tile; each once, in any order.
    ///
    /// # Errors
    ///
    /// It cannot be kept, or has an element that is not to stand there.
    pub fn add(&mut self, tile: Cell, divided: &Divided) -> Result<(), Disagreement> {
        if let Some(shared) = divided.shared.iter().find(|shared| !shared.tiles.contains(&tile)) {
            return Err(Disagreement::Element(shared.element));
        }
        self.shared.append(divided.shared.iter().map(sighting))?;
        self.ids.append(divided.own.iter().map(|id| [id.cast_unsigned()]))?;
        Ok(())
    }

    /// After the last tile: the ids that two elements have, which are far from each other.
    ///
    /// # Errors
    ///
    /// Tiles have built an element otherwise, or not all of them have it that should.
    pub fn finish(self) -> Result<Vec<i64>, Disagreement> {
        if let Some(element) = self.shared.of_each_file(first_disagreement)?.into_iter().flatten().min() {
            return Err(Disagreement::Element(element));
        }
        let twice = |ids: Vec<[u64; 1]>| -> Vec<i64> {
            let pairs = ids.iter().zip(ids.iter().skip(1)).filter(|(id, next)| id == next);
            pairs.map(|([id], _)| id.cast_signed()).collect()
        };
        Ok(self.ids.of_each_file(twice)?.concat())
    }
}

/// An element as one of the tiles has it in which it stands: its id, kind and text, the number of these tiles, and which they are.
fn sighting(Shared { element: (kind, id), text, tiles }: &Shared) -> [u64; 5] {
    let mut which = FxHasher::default();
    tiles.hash(&mut which);
    [id.cast_unsigned(), *kind as u64, *text, tiles.len() as u64, which.finish()]
}

/// The first element, by ids, of which some sightings differ, or of which there are not as many as tiles in which it stands.
fn first_disagreement(sorted: Vec<[u64; 5]>) -> Option<Element> {
    let agree = |of_element: &[[u64; 5]]| match of_element {
        [first @ [.., tiles, _], others @ ..] => {
            *tiles == of_element.len() as u64 && others.iter().all(|other| other == first)
        }
        [] => true,
    };
    let [id, kind, ..] =
        *sorted.chunk_by(|[a, of_a, ..], [b, of_b, ..]| (a, of_a) == (b, of_b)).find(|one| !agree(one))?.first()?;
    Some((*KINDS.get(usize::try_from(kind).ok()?)?, id.cast_signed()))
}

/// Rows of numbers in files, by the first number of each row.
#[derive(Debug)]
struct Spread<const N: usize>(Vec<PathBuf>);

impl<const N: usize> Spread<N> {
    fn new(folder: &Path, name: &str) -> Self {
        let files: Vec<PathBuf> = (0..FILES).map(|file| folder.join(format!("{name}_{file}"))).collect();
        files.iter().for_each(|path| drop(fs::remove_file(path)));
        Self(files)
    }

    fn append(&self, rows: impl Iterator<Item = [u64; N]>) -> io::Result<()> {
        let mut bytes = vec![Vec::new(); FILES];
        for row in rows {
            let of_file = row.first().and_then(|first| bytes.get_mut(*first as usize % FILES));
            of_file.into_iter().for_each(|bytes| bytes.extend(row.iter().flat_map(|number| number.to_le_bytes())));
        }
        let append = |(path, bytes): (&PathBuf, &Vec<u8>)| {
            OpenOptions::new().create(true).append(true).open(path)?.write_all(bytes)
        };
        self.0.iter().zip(&bytes).filter(|(_, bytes)| !bytes.is_empty()).try_for_each(append)
    }

    /// What comes of the sorted rows of each file; the files are removed.
    fn of_each_file<T: Send>(self, result: impl Fn(Vec<[u64; N]>) -> T + Sync) -> io::Result<Vec<T>> {
        let files: Vec<PathBuf> = self.0.into_iter().filter(|path| path.exists()).collect();
        let of_file = |path: PathBuf| -> io::Result<T> {
            let bytes = fs::read(&path)?;
            fs::remove_file(path)?;
            let (numbers, _) = bytes.as_chunks::<8>();
            let mut rows: Vec<[u64; N]> = numbers
                .chunks_exact(N)
                .filter_map(|row| <&[[u8; 8]; N]>::try_from(row).ok())
                .map(|row| row.map(u64::from_le_bytes))
                .collect();
            // Sorted, because a set takes three times the memory.
            rows.sort_unstable();
            Ok(result(rows))
        };
        files.into_par_iter().map(of_file).collect()
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
        let mut add = |(at, tile): (Cell, Option<Divided>)| agreement.add(at, &tile.unwrap_or_else(empty));
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
