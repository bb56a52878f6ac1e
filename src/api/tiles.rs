//! A map that is built in tiles, and written in cells.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rustc_hash::FxHashSet;

use crate::builder::geojson;
use crate::builder::network::{NetworkError, is_driven};
use crate::builder::tags::driving_side::of_place;
use crate::builder::{BuildError, BuildOptions, Built, build_plan, plan};
use crate::cells::{self, Cell, Divided, Grid, Tile, excerpt};
use crate::lanelet::cell_metadata::METADATA;
use crate::lanelet::{self, INFO, MAP};
use crate::osm::{self, ReadError, Way};
use crate::projection::{Extent, Projector, VerticalDatum, write_info};
use crate::report::failure::Failure;
use crate::settings::Settings;
use crate::tiles::{Agreement, CutError, Disagreement, Record, Survey, TileFile, TileSize, WayUse, cut};

use super::built::settings_text;
use super::config::NAME;
use super::divided::{grid, undivided};
use super::error::{Error, ErrorKind};
use super::files::{Draft, spare, there_already};
use super::layout::{LayoutOptions, build_failure, decided, unread, wanted};
use super::workplace::{Begun, Pace, Workplace};

/// How far around a tile and its roads data are read, metres, unless more is asked for.
pub const MARGIN: u32 = 400;

/// How a map is built in tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileOptions {
    /// Width and height of a tile, whole metres: a multiple of that of a cell, and no less than the margin.
    pub size: u32,
    /// Width and height of a cell, whole metres.
    pub cell: u32,
    /// How far around a tile and its roads data are read, metres.
    pub margin: u32,
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
/// threads: memory depends on the largest tile, but for some 50 bytes for each node of the input. `tell` hears what is done next.
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
    let (cells, size) = sizes(tiles)?;
    spare(output)?;
    for name in [MAP, METADATA] {
        let place = output.join(name);
        if place.exists() {
            return Err(write_error(there_already(&place)));
        }
    }
    tell(&format!("reading {}", input.display()));
    let (survey, inputs) = Inputs::new(input, said)?;
    let unwritten = |error: &std::io::Error| unwritten(output, error);
    let words = format!("{:?} {said:?}", TileOptions { resume: false, ..tiles });
    let begun = Begun::new(input, words).map_err(|error| unwritten(&error))?;
    let (place, files) = Workplace::begin(output, tiles.resume, &begun).map_err(|error| unwritten(&error))?;
    let files = match files {
        Some(files) => files,
        None => {
            tell(&format!("cutting {} into tiles", input.display()));
            let files = cut(input, survey, &inputs.projector, size, &place.data()).map_err(|error| match error {
                CutError::Read(error) => unread(error),
                CutError::Write(error) => unwritten(&error),
            })?;
            place.keep(&begun, &files).map_err(|error| unwritten(&error))?;
            files
        }
    };
    let contested = place.known_contested().map_err(|error| unwritten(&error))?;
    let mut run = TileRun { inputs, output, place, files, grid: cells, options: tiles, contested };
    let whole = run.whole(tell).map_err(|error| told(input, output, tiles, error))?;
    let TileRun { inputs: Inputs { projector, .. }, place, files, .. } = run;
    let (divided, settings) = whole.finish();
    let (info, settings) = (write_info(&projector, VerticalDatum::default()), settings_text(&settings)?);
    let publish = || -> Result<(), Failure> {
        let mut draft = Draft::new(output)?;
        for (name, text) in [(METADATA, divided.metadata().text()), (INFO, info), (NAME, settings)] {
            draft.write(name, |file| file.write_all(text.as_bytes()))?;
        }
        // Last, because a tile is lost whose cells were moved away.
        draft.adopt(MAP, &place.cells())?;
        draft.publish()
    };
    publish().map_err(write_error)?;
    place.clear();
    Ok(Tiled { projector, tiles: files.len(), divided })
}

/// The grid of the cells, and the size of the tiles.
fn sizes(TileOptions { size, cell, margin, .. }: TileOptions) -> Result<(Grid, TileSize), Error> {
    let wrong = |message: String, help: String| Err(ErrorKind::Config.error(Failure::new(message).help(help)));
    let cells = grid(cell)?;
    if size % cell != 0 {
        let fits = size.div_ceil(cell) * cell;
        let message = format!("a tile of {size} m does not consist of whole cells of {cell} m");
        return wrong(message, format!("--tiles {fits} does"));
    }
    if size < margin {
        let message = format!("a tile of {size} m is smaller than the margin of {margin} m that is built around it");
        return wrong(
            message,
            format!("--tiles {} or more; thousands of metres are usual", margin.next_multiple_of(cell)),
        );
    }
    Ok((cells, TileSize { tiles: grid(size)?, margin: f64::from(margin) }))
}

fn write_error(failure: Failure) -> Error {
    ErrorKind::Write.error(failure)
}

fn unwritten(output: &Path, error: &std::io::Error) -> Error {
    let failure = Failure::new(format!("cannot write beside {}: {error}", output.display()));
    write_error(failure.help("nothing was changed; check the place's permissions and free space"))
}

/// Why tiles do not make a map.
enum Unmade {
    /// One of them cannot be built.
    Tile(Error),
    /// What is known of them cannot be kept, or two disagree.
    Disagreement(Disagreement),
}

impl<E: Into<Disagreement>> From<E> for Unmade {
    fn from(error: E) -> Self {
        Self::Disagreement(error.into())
    }
}

/// Why tiles do not make a map, and the way out.
fn told(input: &Path, output: &Path, TileOptions { margin, .. }: TileOptions, error: Unmade) -> Error {
    match error {
        Unmade::Tile(error) => error,
        Unmade::Disagreement(Disagreement::Io(error)) => unwritten(output, &error),
        Unmade::Disagreement(found) => {
            let failure = Failure::new(format!("{}: {found}", input.display())).about(input.display().to_string());
            let margin = format!("it depends on what lies more than {margin} m away: give --margin {}", 2 * margin);
            let why = if matches!(found, Disagreement::Id(_)) { "ids are hashes; this is a bug" } else { &margin };
            ErrorKind::Build.error(failure.help(format!("nothing was changed; {why}")))
        }
    }
}

/// What all tiles are built with.
struct Inputs {
    name: String,
    options: BuildOptions,
    projector: Projector,
    /// What the input holds of the Earth.
    bounds: Vec<Extent>,
}

impl Inputs {
    /// Reads what must be known of all data, and decides what must be the same in all tiles.
    fn new(input: &Path, said: &LayoutOptions) -> Result<(Survey, Self), Error> {
        let name = input.display().to_string();
        refuse_streets(input, &name)?;
        let mut options = decided(input, said)?;
        let use_of = |way: &Way| match () {
            () if is_driven(way, &options.roads) => WayUse::Driven,
            () if way.tags.has("highway") => WayUse::Highway,
            () => WayUse::Other,
        };
        let survey = Survey::read(input, &use_of).map_err(unread)?;
        let failed = |error: BuildError| ErrorKind::Build.error(build_failure(error, &name));
        if survey.lanelets > 0 {
            return Err(failed(BuildError::Lanelet2Map { lanelets: survey.lanelets }));
        }
        let (ways, roads) = (survey.count(WayUse::Other), survey.count(WayUse::Highway));
        let no_road = |left_out| failed(NetworkError::NoRoad { ways, left_out }.into());
        let extent = match survey.around(WayUse::Highway) {
            Some(extent) => extent,
            None if roads > 0 => return Err(failed(BuildError::NoPlace)),
            None => return Err(no_road(0)),
        };
        let driven = survey.around(WayUse::Driven).ok_or_else(|| no_road(roads))?;
        let projector = match said.projector {
            Some(kind) => wanted(kind, survey.around_all(), &name)?,
            None => Projector::for_extent(&extent),
        };
        options.projector = Some(projector);
        options.country = Some(of_place(driven.center()));
        let bounds = survey.bounds.clone();
        Ok((survey, Self { name, options, projector, bounds }))
    }
}

/// Tiles that are being built.
struct TileRun<'a> {
    inputs: Inputs,
    output: &'a Path,
    place: Workplace,
    files: Vec<TileFile>,
    grid: Grid,
    options: TileOptions,
    /// Ids that two elements of the map want, so that neither gets them.
    contested: BTreeSet<i64>,
}

impl TileRun<'_> {
    /// Builds all tiles, and those anew in which an id stands that two elements want.
    fn whole(&mut self, tell: &(dyn Fn(&str) + Sync)) -> Result<Whole, Unmade> {
        /// As often as a map in one piece is built for that.
        const ROUNDS: usize = 4;
        for _ in 0..ROUNDS {
            self.build(tell).map_err(Unmade::Tile)?;
            let mut found = BTreeSet::new();
            for file in &self.files {
                found.append(&mut self.place.contested(file.tile)?);
            }
            if found.is_subset(&self.contested) {
                tell("comparing tiles");
                let (whole, twice) = self.agreed()?;
                if twice.is_empty() {
                    return Ok(whole);
                }
                found.extend(twice);
            }
            found.retain(|id| !self.contested.contains(id));
            self.forget(&found)?;
            self.contested.append(&mut found);
            // Not before the tiles are forgotten that know nothing of it.
            self.place.keep_contested(&self.contested)?;
        }
        let last = self.contested.last().copied().unwrap_or_default();
        Err(Disagreement::Id(last).into())
    }

    /// Lets the tiles be built again in which one of these ids stands, or was wanted.
    fn forget(&self, ids: &BTreeSet<i64>) -> std::io::Result<()> {
        for file in &self.files {
            let Record { divided, .. } = self.place.record(file.tile, self.grid)?;
            let shared = divided.shared.iter().map(|shared| shared.element.1);
            let mut of_tile = divided.own.into_iter().chain(self.place.contested(file.tile)?).chain(shared);
            if of_tile.any(|id| ids.contains(&id)) {
                self.place.forget(file.tile)?;
            }
        }
        Ok(())
    }

    /// Holds the tiles against each other and puts together what is known of them; also the ids that two elements have.
    fn agreed(&self) -> Result<(Whole, Vec<i64>), Disagreement> {
        let mut whole = Whole { divided: Divided::empty(self.grid), settings: None };
        let mut agreement = Agreement::new(self.place.folder());
        for file in &self.files {
            let Record { mut divided, settings, .. } = self.place.record(file.tile, self.grid)?;
            agreement.add(file.tile, &mut divided)?;
            let settings = settings.map(|text| toml::from_str(&text).map_err(std::io::Error::other)).transpose()?;
            whole.add(divided, settings);
        }
        Ok((whole, agreement.finish()?))
    }

    /// Builds the tiles that are not built yet, as many at a time as there are threads.
    fn build(&self, tell: &(dyn Fn(&str) + Sync)) -> Result<(), Error> {
        let missing: Vec<&TileFile> = self.files.iter().filter(|file| !self.place.has(file.tile)).collect();
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
        let Inputs { name, options, projector, bounds } = &self.inputs;
        let mut data = osm::read_file(path).map_err(unread)?;
        data.bounds.clone_from(bounds);
        let options = BuildOptions { contested: self.contested.clone(), ..options.clone() };
        let (record, contested) = match plan(data, &options) {
            Err(BuildError::Network(_) | BuildError::NoPlace) => (Record::empty(self.grid), Vec::new()),
            Err(error) => return Err(ErrorKind::Build.error(build_failure(error, name))),
            Ok(plan) => {
                let mut built = build_plan(plan);
                let contested = std::mem::take(&mut built.contested);
                (self.divide(*tile, built, projector)?, contested)
            }
        };
        self.place.put(*tile, self.grid, &record, &contested).map_err(|error| unwritten(self.output, &error))
    }

    /// Writes the cells of a tile into a folder of its own.
    fn divide(&self, tile: Cell, mut built: Built, projector: &Projector) -> Result<Record, Error> {
        let unwritten = |error: std::io::Error| unwritten(self.output, &error);
        let size = f64::from(self.options.size);
        let corner = [tile.column, tile.row].map(|at| f64::from(at) * size);
        excerpt(&mut built.map, [corner, corner.map(|low| low + size)]);
        let folder = self.place.begin_tile(tile).map_err(unwritten)?;
        if built.map.points.is_empty() {
            return Ok(Record::empty(self.grid));
        }
        let map = folder.with_extension("osm");
        File::create(&map).and_then(|file| lanelet::to_osm(&built.map, projector, file)).map_err(unwritten)?;
        drop(built.map);
        let within = Tile { at: tile, cells: (self.options.size / self.options.cell) as i32 };
        let files = [map.clone()];
        let divided = cells::divide(&files, Some(*projector), self.grid, Some(within), &folder, &|_| ());
        let divided = divided.map_err(|error| undivided(self.output, error))?;
        fs::remove_file(map).map_err(unwritten)?;
        let mut settings = built.settings;
        let own: FxHashSet<i64> = divided.own.iter().copied().collect();
        settings.intersection.retain(|entry| entry.ia.is_some_and(|area| own.contains(&area)));
        settings.bicycle_lanes.retain(|lanelet| own.contains(lanelet));
        let settings = toml::to_string(&settings).map_err(|error| unwritten(std::io::Error::other(error)))?;
        Ok(Record { divided, settings: Some(settings) })
    }
}

/// Refuses streets as GeoJSON, which are laid out already.
fn refuse_streets(input: &Path, name: &str) -> Result<(), Error> {
    let mut head = Vec::new();
    let read = File::open(input).and_then(|file| file.take(4096).read_to_end(&mut head));
    read.map_err(|source| unread(ReadError::Io { path: input.to_path_buf(), source }))?;
    if geojson::is_json(&head) {
        let failure = Failure::new(format!("{name} holds streets, which are not built in tiles")).about(name);
        return Err(ErrorKind::Build.error(failure.help("give the OpenStreetMap data that they were made of")));
    }
    Ok(())
}

/// What came of all tiles.
struct Whole {
    divided: Divided,
    settings: Option<Settings>,
}

impl Whole {
    fn add(&mut self, divided: Divided, settings: Option<Settings>) {
        self.divided.cells.extend(divided.cells);
        self.divided.elements += divided.elements;
        self.divided.written += divided.written;
        match (&mut self.settings, settings) {
            (Some(all), Some(mut settings)) => {
                all.intersection.append(&mut settings.intersection);
                all.bicycle_lanes.append(&mut settings.bicycle_lanes);
            }
            (None, settings) => self.settings = settings,
            (Some(_), None) => {}
        }
    }

    fn finish(mut self) -> (Divided, Settings) {
        self.divided.cells.sort_unstable();
        let mut settings = self.settings.unwrap_or_default();
        settings.sort();
        (self.divided, settings)
    }
}
