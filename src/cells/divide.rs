//! Divides a map: the text of each element is copied into the files of its cells.

use std::fs::OpenOptions;
use std::hash::BuildHasher;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

use crate::lanelet::cell_metadata::CellMetadata;
use crate::lanelet::projector_for;
use crate::osm::{Blocks, ElementKind, OsmData, OsmText};
use crate::projection::Projector;

use super::DivideError;
use super::grid::{Cell, Grid};
use super::ids::Ids;
use super::placement::Placement;
use super::sets::{CellSets, SetId};
use super::survey::{Hints, Shelf, Survey};

/// Blocks in which the files are read for what must be known of them. What is known takes the most memory, not the blocks.
const BLOCKS_READ: u64 = 256;
/// Blocks in which the elements are copied. Each is written to nearly all cells, and to open a file takes longer than to write it.
const BLOCKS_COPIED: u64 = 48;

/// A map is not divided if more of its cells than this, and than it has nodes, have no node of their own: a file for each square metre
/// of an area would fill the disk.
const MOST_EMPTY: usize = 10_000;

/// An element by its kind and id.
pub type Element = (ElementKind, i64);

/// What came of dividing a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Divided {
    /// The grid of the cells.
    pub grid: Grid,
    /// The cells that were written, row by row.
    pub cells: Vec<Cell>,
    /// Elements of the map; of a tile, those that stand in no tile before it.
    pub elements: usize,
    /// Elements of all cells: what stands in two cells counts twice.
    pub written: usize,
    /// Of a tile, the ids of the elements that stand in no tile before it.
    pub own: Vec<i64>,
    /// Of a tile, the elements that also stand in cells of other tiles.
    pub shared: Vec<Shared>,
}

/// An element that stands in cells of several tiles, as one of them has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shared {
    /// Which.
    pub element: Element,
    /// A hash of its text.
    pub text: u64,
    /// All tiles in which it stands, row by row.
    pub tiles: Arc<[Cell]>,
}

impl Divided {
    /// Of nothing.
    pub fn empty(grid: Grid) -> Self {
        Self { grid, cells: Vec::new(), elements: 0, written: 0, own: Vec::new(), shared: Vec::new() }
    }

    /// Writes the list of the cells.
    ///
    /// # Errors
    ///
    /// Where `file` cannot be written.
    pub fn write_metadata(&self, file: impl Write) -> io::Result<()> {
        let listed = self.cells.iter().map(|cell| (self.grid.name(*cell), self.grid.corner(*cell)));
        CellMetadata::write(file, [self.grid.size(); 2], listed)
    }
}

/// A square of whole cells, of which alone the cells are written.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// The tile, in the grid of the tiles.
    pub at: Cell,
    /// Cells along each of its sides.
    pub cells: i32,
}

impl Tile {
    /// The tile of this size in which a cell lies.
    fn around(self, cell: Cell) -> Cell {
        Cell { row: cell.row.div_euclid(self.cells), column: cell.column.div_euclid(self.cells) }
    }
}

/// Divides the map in these files into cells, one file each in a folder that is there; of a `tile` only those that lie in it.
/// Without a projector the map tells it, as it does when it is loaded. `tell` hears what is done next.
///
/// # Errors
///
/// If a file cannot be read or written, or the map cannot be divided; then some of the cells may have been written.
pub fn divide(
    files: &[PathBuf],
    projector: Option<Projector>,
    grid: Grid,
    tile: Option<Tile>,
    folder: &Path,
    tell: &dyn Fn(&str),
) -> Result<Divided, DivideError> {
    let projector = match projector {
        Some(projector) => projector,
        None => projector_for(&hints(files)?),
    };
    let survey = survey(files, &projector)?;
    if !survey.lanelet2 {
        return Err(match survey.roads {
            0 => DivideError::NotLanelet2,
            roads => DivideError::Navigation { roads },
        });
    }
    let placement = Placement::of(&survey, grid)?;
    let cells = placement.sets.cells().len();
    let occupied: FxHashSet<Cell> = survey.places.iter().filter_map(|place| grid.around(*place)).collect();
    let empty = cells.saturating_sub(occupied.len());
    if empty > MOST_EMPTY.max(survey.places.len()) {
        return Err(DivideError::TooSmall { cells, empty });
    }
    let Survey { nodes, ways, relations, meta, generator, .. } = survey;
    let shelves = [(nodes, placement.nodes), (ways, placement.ways), (relations, placement.relations)];
    // Ids and places have done their work, but for what tiles share.
    let shelves = shelves.map(|(Shelf { copies, ids, .. }, sets)| {
        let ids = if tile.is_some() { ids } else { Ids::default() };
        Placed { copies, ids, sets, seen: 0, placed: 0 }
    });
    let head = OsmText::head_by(generator.as_deref().unwrap_or("lanewright"), &meta);
    tell("writing the cells");
    let mut cells = CellFiles::new(grid, folder, head, &placement.sets, tile);
    copy(files, shelves, &mut cells)?;
    cells.finish()
}

/// As much of a map as tells its projector.
fn hints(files: &[PathBuf]) -> Result<OsmData, DivideError> {
    let mut hints = Hints::default();
    for file in files {
        let mut blocks = Blocks::open(file, BLOCKS_READ)?;
        while let Some(block) = blocks.next_block()? {
            if hints.look(&block.data) {
                return Ok(hints.data());
            }
        }
    }
    Ok(hints.data())
}

fn survey(files: &[PathBuf], projector: &Projector) -> Result<Survey, DivideError> {
    let mut survey = Survey::default();
    for file in files {
        let mut blocks = Blocks::open(file, BLOCKS_READ)?;
        survey.begin_file(blocks.name(), blocks.size());
        while let Some(block) = blocks.next_block()? {
            survey.add(&block.data, projector, files.len() > 1)?;
        }
    }
    survey.end();
    Ok(survey)
}

/// The sets of all elements of one kind, handed out in the order of the files.
struct Placed {
    copies: FxHashSet<u32>,
    ids: Ids,
    sets: Vec<SetId>,
    /// Elements that were passed, with and without copies.
    seen: u32,
    placed: usize,
}

impl Placed {
    /// The id and the set of the next element; `None` for a copy.
    fn next(&mut self) -> Option<(i64, SetId)> {
        self.seen += 1;
        if self.copies.contains(&(self.seen - 1)) {
            return None;
        }
        self.placed += 1;
        self.sets.get(self.placed - 1).map(|set| (self.ids.at(self.placed - 1), *set))
    }
}

/// An element in one of its cells.
struct Entry<'t> {
    cell: u32,
    text: &'t str,
}

/// Copies all elements into their cells.
fn copy(
    files: &[PathBuf],
    [mut nodes, mut ways, mut relations]: [Placed; 3],
    cells: &mut CellFiles<'_>,
) -> Result<(), DivideError> {
    for file in files {
        let mut blocks = Blocks::open(file, BLOCKS_COPIED)?;
        while let Some(block) = blocks.next_block()? {
            let mut entries = Vec::new();
            for (kind, text) in block.elements() {
                let next = match kind {
                    ElementKind::Node => nodes.next(),
                    ElementKind::Way => ways.next(),
                    ElementKind::Relation => relations.next(),
                };
                if let Some((id, set)) = next {
                    cells.note((kind, id), text, set);
                    let within = cells.sets.get(set).iter().filter(|cell| cells.within[**cell as usize]);
                    entries.extend(within.map(|cell| Entry { cell: *cell, text }));
                }
            }
            cells.append(entries)?;
        }
    }
    Ok(())
}

/// The files of the cells. None of them stays open: there may be more than a process may have open.
struct CellFiles<'a> {
    names: Vec<PathBuf>,
    head: OsmText,
    begun: Vec<bool>,
    /// Whether each cell is to be written.
    within: Vec<bool>,
    sets: &'a CellSets,
    tile: Option<Tile>,
    /// The tiles of each set that was asked for.
    tiles: FxHashMap<SetId, Arc<[Cell]>>,
    divided: Divided,
}

impl<'a> CellFiles<'a> {
    fn new(grid: Grid, folder: &Path, head: OsmText, sets: &'a CellSets, tile: Option<Tile>) -> Self {
        let cells = sets.cells();
        let is_within = |cell: &Cell| tile.is_none_or(|tile| tile.around(*cell) == tile.at);
        Self {
            names: cells.iter().map(|cell| folder.join(grid.name(*cell))).collect(),
            head,
            begun: vec![false; cells.len()],
            within: cells.iter().map(is_within).collect(),
            sets,
            tile,
            tiles: FxHashMap::default(),
            divided: Divided::empty(grid),
        }
    }

    /// Counts an element, and notes of a tile what it has of its own and what it shares.
    fn note(&mut self, element: Element, text: &str, set: SetId) {
        let Some(tile) = self.tile else {
            self.divided.elements += 1;
            return;
        };
        let (sets, tiles) = (self.sets, &mut self.tiles);
        let tiles = tiles.entry(set).or_insert_with(|| {
            let mut tiles: Vec<Cell> =
                sets.get(set).iter().map(|cell| tile.around(sets.cells()[*cell as usize])).collect();
            tiles.sort_unstable();
            tiles.dedup();
            tiles.into()
        });
        if tiles.first() == Some(&tile.at) {
            self.divided.elements += 1;
            self.divided.own.push(element.1);
        }
        if tiles.len() > 1 && tiles.contains(&tile.at) {
            let text = FxBuildHasher.hash_one(text);
            self.divided.shared.push(Shared { element, text, tiles: tiles.clone() });
        }
    }

    /// Appends elements to their cells, each in the order of the list.
    fn append(&mut self, mut entries: Vec<Entry<'_>>) -> Result<(), DivideError> {
        self.divided.written += entries.len();
        entries.sort_by_key(|entry| entry.cell);
        let of_cells: Vec<&[Entry<'_>]> = entries.chunk_by(|a, b| a.cell == b.cell).collect();
        of_cells.par_iter().try_for_each(|of_cell| self.append_to(of_cell))?;
        of_cells.iter().filter_map(|of_cell| of_cell.first()).for_each(|entry| self.begun[entry.cell as usize] = true);
        Ok(())
    }

    fn append_to(&self, entries: &[Entry<'_>]) -> Result<(), DivideError> {
        let Some(cell) = entries.first().map(|entry| entry.cell as usize) else { return Ok(()) };
        let head = if self.begun[cell] { &[][..] } else { self.head.as_bytes() };
        let mut text = Vec::with_capacity(head.len() + entries.iter().map(|entry| entry.text.len() + 3).sum::<usize>());
        text.extend_from_slice(head);
        for entry in entries {
            text.extend_from_slice(b"  ");
            text.extend_from_slice(entry.text.as_bytes());
            text.push(b'\n');
        }
        write(&self.names[cell], &text)
    }

    /// Ends all files.
    fn finish(mut self) -> Result<Divided, DivideError> {
        let tail = OsmText::tail();
        let begun = self.names.par_iter().zip(&self.begun).filter(|(_, begun)| **begun);
        begun.try_for_each(|(name, _)| write(name, tail.as_bytes()))?;
        let cells = self.sets.cells().iter().zip(&self.begun).filter(|(_, begun)| **begun);
        self.divided.cells = cells.map(|(cell, _)| *cell).collect();
        self.divided.cells.sort_unstable();
        Ok(self.divided)
    }
}

fn write(path: &Path, text: &[u8]) -> Result<(), DivideError> {
    let file = OpenOptions::new().create(true).append(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text));
    written.map_err(|source| DivideError::Write { path: path.to_path_buf(), source })
}
