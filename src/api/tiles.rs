//! A map that is built in tiles on this machine, and written in cells.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::cells::Divided;
use crate::lanelet::MAP;
use crate::lanelet::cell_metadata::METADATA;
use crate::projection::Projector;
use crate::report::failure::Failure;
use crate::tiles::TileFile;

use super::Input;
use super::cut::{Cut, Surveyed, TileSizes, unwritten};
use super::error::{Error, ErrorKind};
use super::files::{Draft, there_already};
use super::join::{Joining, Whole, join};
use super::layout::LayoutOptions;
use super::own_output::spare_settings;
use super::tile::TileBuilder;
use super::workplace::{Begun, Pace, Workplace};

/// How a map is built in tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileOptions {
    /// How large tiles and cells are.
    pub sizes: TileSizes,
    /// Whether tiles that are built stay beside the output if the run ends early, and those of such a run are not built again.
    pub resume: bool,
}

/// A map that was built in tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Tiled {
    /// How its metres relate to degrees.
    pub projector: Projector,
    /// Tiles that have a road, or lie near one.
    pub tiles: usize,
    /// The cells, and what stands in them.
    pub divided: Divided,
}

/// Builds a map from OpenStreetMap data in tiles and writes it in cells, all or none: the cells that
/// [`write_cells`](super::BuiltMap::write_cells) writes of the map in one piece. As many tiles are built at a time as there are
/// threads: memory depends on the largest tile, but for some 120 bytes for each node of a road. `tell` hears what is done next.
///
/// # Errors
///
/// Where the input or settings cannot be read, nothing can be built, `output` holds a map already, the sizes do not suit each
/// other, or two tiles disagree on what stands in both: then the margin is too small.
pub fn build_tiles(
    input: &Path,
    output: &Path,
    tiles: TileOptions,
    said: &LayoutOptions,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Tiled, Error> {
    tiles.sizes.grids()?;
    spare_settings(output)?;
    for name in [MAP, METADATA] {
        let place = output.join(name);
        if place.exists() {
            return Err(ErrorKind::Write.error(there_already(&place)));
        }
    }
    tell(&format!("reading {}", input.display()));
    let Surveyed { survey, mut cut, options } = Surveyed::new(input, output, tiles.sizes, said)?;
    let builder = TileBuilder::with(&cut, options, output)?;
    let unwritten = |error: &std::io::Error| unwritten(output, error);
    let files = match &said.dem {
        Some(Input::Path(terrain)) => vec![input, terrain.as_path()],
        _ => vec![input],
    };
    let begun = Begun::new(&files, cut.text()?).map_err(|error| unwritten(&error))?;
    let (place, files) = Workplace::begin(output, tiles.resume, &begun).map_err(|error| unwritten(&error))?;
    let files = match files {
        Some(files) => files,
        None => {
            tell(&format!("cutting {} into tiles", input.display()));
            let files = cut.write_tiles(survey, &place.data(), output)?;
            place.keep(&begun, &files).map_err(|error| unwritten(&error))?;
            files
        }
    };
    cut.list(&files).map_err(|error| unwritten(&error))?;
    let contested = place.known_contested().map_err(|error| unwritten(&error))?;
    let mut run = TileRun { builder, cut, output, place, files, contested };
    let whole = run.whole(tell)?;
    let TileRun { cut, place, files, .. } = run;
    let publish = || -> Result<(), Failure> {
        let mut draft = Draft::new(output)?;
        whole.write(&mut draft)?;
        // Last, because a tile is lost whose cells were moved away.
        draft.adopt(MAP, &place.cells())?;
        draft.publish()
    };
    publish().map_err(|failure| ErrorKind::Write.error(failure))?;
    place.clear();
    Ok(Tiled { projector: cut.projector()?, tiles: files.len(), divided: whole.divided })
}

/// Tiles that are being built.
struct TileRun<'a> {
    builder: TileBuilder,
    cut: Cut,
    output: &'a Path,
    place: Workplace,
    files: Vec<TileFile>,
    /// Ids that two elements of the map want, so that neither gets them.
    contested: BTreeSet<i64>,
}

impl TileRun<'_> {
    /// Builds all tiles, and those anew in which an id stands that two elements want.
    fn whole(&mut self, tell: &(dyn Fn(&str) + Sync)) -> Result<Whole, Error> {
        loop {
            self.build(tell)?;
            tell("comparing tiles");
            let (tiles, contested) = match join(&self.cut, &self.place.records(), &self.contested)? {
                Joining::Whole(whole) => return Ok(*whole),
                Joining::Again { tiles, contested } => (tiles, contested),
            };
            let mut forgotten = tiles.into_iter().map(|tile| self.place.forget(tile));
            // Not before the tiles are forgotten that know nothing of it.
            let noted = forgotten.try_for_each(|done| done).and_then(|()| self.place.keep_contested(&contested));
            noted.map_err(|error| unwritten(self.output, &error))?;
            self.contested = contested;
        }
    }

    /// The tiles that are not built yet, the largest first: whether memory suffices shows at once, and no thread is left with a large
    /// one in the end.
    fn missing(&self) -> Vec<&TileFile> {
        let tiles = self.files.iter().zip(&self.cut.tiles).filter(|(file, _)| !self.place.has(file.tile));
        let mut missing: Vec<(&TileFile, u64)> = tiles.map(|(file, cut)| (file, cut.bytes)).collect();
        missing.sort_by_key(|(_, bytes)| Reverse(*bytes));
        missing.into_iter().map(|(file, _)| file).collect()
    }

    /// Builds the tiles that are not built yet, as many at a time as there are threads.
    fn build(&self, tell: &(dyn Fn(&str) + Sync)) -> Result<(), Error> {
        let missing = self.missing();
        let threads = rayon::current_num_threads();
        let workers = threads.min(missing.len()).max(1);
        let (next, failed) = (AtomicUsize::new(0), Mutex::new(None));
        let pace = Pace::new(self.files.len(), missing.len());
        tell(&pace.said());
        let work = || {
            while let Some(file) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
                match self.build_tile(file) {
                    Ok(()) => tell(&pace.another()),
                    Err(error) => {
                        next.store(missing.len(), Ordering::Relaxed);
                        failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    }
                }
            }
        };
        // A thread that waits for others of its pool would begin another tile: so each has a pool of its own.
        let pool = || rayon::ThreadPoolBuilder::new().num_threads(threads.div_ceil(workers)).build();
        let pools: Result<Vec<_>, _> = (0..workers).map(|_| pool()).collect();
        let pools = pools.map_err(|error| unwritten(self.output, &std::io::Error::other(error)))?;
        std::thread::scope(|scope| pools.iter().for_each(|pool| drop(scope.spawn(|| pool.install(work)))));
        failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }

    /// Builds a tile. Its cells are moved into their place when all are written; then they are recorded.
    fn build_tile(&self, TileFile { tile, path }: &TileFile) -> Result<(), Error> {
        let failed = |error: std::io::Error| unwritten(self.output, &error);
        let folder = self.place.begin_tile(*tile).map_err(failed)?;
        let record = self.builder.build(*tile, &Input::from(path.as_path()), &self.contested, &folder)?;
        self.place.put(*tile, &record).map_err(failed)
    }
}
