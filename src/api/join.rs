//! Tiles that are built are held against each other and put together: either some must be built again, or the map is complete.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::Path;

use crate::cells::{Cell, Divided, Grid};
use crate::lanelet::INFO;
use crate::lanelet::cell_metadata::METADATA;
use crate::report::failure::Failure;
use crate::settings::Settings;
use crate::tiles::{Agreement, Disagreement, Record};

use super::built::settings_text;
use super::config::NAME;
use super::cut::{Cut, TileSizes, unwritten};
use super::error::{Error, ErrorKind};
use super::files::Draft;

/// What comes of all tiles.
#[derive(Clone, Debug, PartialEq)]
pub enum Joining {
    /// Ids were found that two elements want, so that neither may have them.
    Again {
        /// The tiles that must be built again, row by row.
        tiles: Vec<Cell>,
        /// With these ids, and those that were known before.
        contested: BTreeSet<i64>,
    },
    /// The map is complete.
    Whole(Box<Whole>),
}

/// What stands beside the cells of all tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Whole {
    /// The cells, and what stands in them.
    pub divided: Divided,
    /// The texts of the files beside them but for the list of the cells, by their names.
    files: [(&'static str, String); 2],
}

impl Whole {
    /// The texts of all files beside the cells, by their names.
    pub fn texts(&self) -> Vec<(&'static str, String)> {
        let mut metadata = Vec::new();
        // Writing to memory cannot fail.
        let _ = self.divided.write_metadata(&mut metadata);
        let metadata = String::from_utf8_lossy(&metadata).into_owned();
        std::iter::once((METADATA, metadata)).chain(self.files.clone()).collect()
    }

    /// Adds the files to a draft.
    pub(super) fn write(&self, draft: &mut Draft) -> Result<(), Failure> {
        draft.write(METADATA, |file| self.divided.write_metadata(file))?;
        self.files.iter().try_for_each(|(name, text)| draft.write(name, |file| file.write_all(text.as_bytes())))
    }
}

/// Holds the tiles of cut data against each other and puts together what is known of them: their records lie in a folder, under the
/// names that [`Record::name`] gives them, and were all made with the `contested` ids. Files are made there meanwhile.
///
/// # Errors
///
/// Where a record is missing or no record, and where two tiles disagree on what stands in both: then the margin is too small.
pub fn join(cut: &Cut, records: &Path, contested: &BTreeSet<i64>) -> Result<Joining, Error> {
    let (grid, _) = cut.sizes.grids()?;
    let tiles: Vec<Cell> = cut.tiles.iter().map(|tile| Cell { row: tile.row, column: tile.column }).collect();
    joined(cut, &tiles, grid, records, contested).map_err(|error| match error {
        Unmade::Said(error) => error,
        Unmade::Disagreement(Disagreement::Io(error)) => unwritten(records, &error),
        Unmade::Disagreement(found) => disagreement_error(&cut.input, cut.sizes, &found),
    })
}

/// Why tiles do not make a map.
enum Unmade {
    Said(Error),
    /// What is known of them cannot be read or kept, or two disagree.
    Disagreement(Disagreement),
}

impl<E: Into<Disagreement>> From<E> for Unmade {
    fn from(error: E) -> Self {
        Self::Disagreement(error.into())
    }
}

fn joined(cut: &Cut, tiles: &[Cell], grid: Grid, records: &Path, contested: &BTreeSet<i64>) -> Result<Joining, Unmade> {
    let record = |tile: &Cell| {
        let file = records.join(Record::name(*tile));
        Record::load(&file, grid).map_err(|error| Unmade::Said(unread(&file, &error)))
    };
    let mut found = BTreeSet::new();
    let mut parts = Parts { divided: Divided::empty(grid), settings: None };
    let mut agreement = Agreement::new(records);
    for tile in tiles {
        let Record { divided, settings, contested: wanted_twice, .. } = record(tile)?;
        found.extend(wanted_twice.into_iter().filter(|id| !contested.contains(id)));
        // What is built anew is compared when that is done.
        if found.is_empty() {
            agreement.add(*tile, &divided)?;
            let settings = settings.map(|text| toml::from_str(&text).map_err(io::Error::other)).transpose()?;
            parts.add(divided, settings);
        }
    }
    if found.is_empty() {
        found.extend(agreement.finish()?);
        if found.is_empty() {
            return parts.finish(cut).map(|whole| Joining::Whole(Box::new(whole))).map_err(Unmade::Said);
        }
        // Nobody was to have it, and two have it all the same.
        if let Some(id) = found.iter().find(|id| contested.contains(id)) {
            return Err(Disagreement::Id(*id).into());
        }
    }
    let mut again = Vec::new();
    for tile in tiles {
        again.extend(record(tile)?.has_any(&found).then_some(*tile));
    }
    found.extend(contested);
    Ok(Joining::Again { tiles: again, contested: found })
}

/// Why a record cannot be read, and the way out.
fn unread(file: &Path, error: &io::Error) -> Error {
    let failure = Failure::new(format!("cannot read what is remembered of a tile, {}: {error}", file.display()));
    ErrorKind::Read.error(failure.about(file.display().to_string()).help("build this tile again"))
}

/// In what tiles disagree, and the way out.
fn disagreement_error(input: &str, TileSizes { margin, .. }: TileSizes, found: &Disagreement) -> Error {
    let failure = Failure::new(format!("{input}: {found}")).about(input);
    let margin = format!("it depends on what lies more than {margin} m away: give --margin {}", 2 * margin);
    let why = if matches!(found, Disagreement::Id(_)) { "ids are hashes; this is a bug" } else { &margin };
    ErrorKind::Build.error(failure.help(format!("nothing was changed; {why}")))
}

/// What is known of all tiles so far.
struct Parts {
    divided: Divided,
    settings: Option<Settings>,
}

impl Parts {
    fn add(&mut self, divided: Divided, settings: Option<Settings>) {
        self.divided.cells.extend(divided.cells);
        self.divided.elements += divided.elements;
        self.divided.written += divided.written;
        match (&mut self.settings, settings) {
            (Some(all), Some(mut settings)) => {
                all.intersection.append(&mut settings.intersection);
                all.bicycle_lanes.append(&mut settings.bicycle_lanes);
                all.loose_ends.extend(settings.loose_ends);
            }
            (None, settings) => self.settings = settings,
            (Some(_), None) => {}
        }
    }

    fn finish(mut self, cut: &Cut) -> Result<Whole, Error> {
        self.divided.cells.sort_unstable();
        let mut settings = self.settings.unwrap_or_default();
        settings.sort();
        let files = [(INFO, cut.projector_info.clone()), (NAME, settings_text(&settings)?)];
        Ok(Whole { divided: self.divided, files })
    }
}
