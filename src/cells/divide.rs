//! Divides a map: the text of each element is copied into the files of its cells.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::lanelet::cell_metadata::CellMetadata;
use crate::lanelet::projector_for;
use crate::osm::{Blocks, ElementKind, OsmData, OsmText};
use crate::projection::Projector;

use super::DivideError;
use super::grid::Grid;
use super::placement::Placement;
use super::sets::{CellSets, SetId};
use super::survey::{Hints, Shelf, Survey};

/// Blocks in which the files are read for what must be known of them. What is known takes the most memory, not the blocks.
const BLOCKS_READ: u64 = 256;
/// Blocks in which the elements are copied. Each is written to nearly all cells, and to open a file takes longer than to write it.
const BLOCKS_COPIED: u64 = 48;

/// What came of dividing a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Divided {
    /// The files that were written, with the squares that they cover.
    pub metadata: CellMetadata,
    /// Elements of the map.
    pub elements: usize,
    /// Elements of all cells: what stands in two cells counts twice.
    pub written: usize,
}

/// Divides the map in these files into cells, one file each in a folder that is there. Without a projector the map tells it, as
/// it does when it is loaded. `tell` hears what is done next.
///
/// # Errors
///
/// If a file cannot be read or written, or the map cannot be divided; then some of the cells may have been written.
pub fn divide(
    files: &[PathBuf],
    projector: Option<Projector>,
    grid: Grid,
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
    let Survey { nodes, ways, relations, meta, generator, .. } = survey;
    // Ids and places have done their work.
    let shelves = [(nodes, placement.nodes), (ways, placement.ways), (relations, placement.relations)];
    let shelves = shelves.map(|(Shelf { copies, .. }, sets)| Placed { copies, sets, seen: 0, placed: 0 });
    let names = placement.sets.cells().iter().map(|cell| folder.join(grid.name(*cell))).collect();
    let head = OsmText::head_by(generator.as_deref().unwrap_or("lanewright"), &meta);
    tell("writing the cells");
    let begun = vec![false; placement.sets.cells().len()];
    let mut cells = CellFiles { names, head, begun, written: 0 };
    let elements = shelves.iter().map(|shelf| shelf.sets.len()).sum();
    copy(files, shelves, &placement.sets, &mut cells)?;
    cells.finish()?;
    let mut squares = placement.sets.cells().to_vec();
    squares.sort_unstable();
    let listed = squares.iter().map(|cell| (grid.name(*cell), grid.corner(*cell))).collect();
    let metadata = CellMetadata { resolution: [grid.size(); 2], cells: listed };
    Ok(Divided { metadata, elements, written: cells.written })
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
    sets: Vec<SetId>,
    /// Elements that were passed, with and without copies.
    seen: u32,
    placed: usize,
}

impl Placed {
    /// The set of the next element; `None` for a copy.
    fn next(&mut self) -> Option<SetId> {
        self.seen += 1;
        if self.copies.contains(&(self.seen - 1)) {
            return None;
        }
        self.placed += 1;
        self.sets.get(self.placed - 1).copied()
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
    sets: &CellSets,
    cells: &mut CellFiles,
) -> Result<(), DivideError> {
    for file in files {
        let mut blocks = Blocks::open(file, BLOCKS_COPIED)?;
        while let Some(block) = blocks.next_block()? {
            let mut entries = Vec::new();
            for (kind, text) in block.elements() {
                let set = match kind {
                    ElementKind::Node => nodes.next(),
                    ElementKind::Way => ways.next(),
                    ElementKind::Relation => relations.next(),
                };
                let of_element = set.map_or(&[][..], |set| sets.get(set));
                entries.extend(of_element.iter().map(|cell| Entry { cell: *cell, text }));
            }
            cells.append(entries)?;
        }
    }
    Ok(())
}

/// The files of the cells. None of them stays open: there may be more than a process may have open.
struct CellFiles {
    names: Vec<PathBuf>,
    head: OsmText,
    begun: Vec<bool>,
    written: usize,
}

impl CellFiles {
    /// Appends elements to their cells, each in the order of the list.
    fn append(&mut self, mut entries: Vec<Entry<'_>>) -> Result<(), DivideError> {
        self.written += entries.len();
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

    fn finish(&self) -> Result<(), DivideError> {
        let tail = OsmText::tail();
        self.names.par_iter().try_for_each(|name| write(name, tail.as_bytes()))
    }
}

fn write(path: &Path, text: &[u8]) -> Result<(), DivideError> {
    let file = OpenOptions::new().create(true).append(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text));
    written.map_err(|source| DivideError::Write { path: path.to_path_buf(), source })
}
