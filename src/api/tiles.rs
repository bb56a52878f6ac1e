//! A map that is built in tiles, one after the other, and written in cells.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;

use rustc_hash::FxHashSet;

use crate::builder::geojson;
use crate::builder::network::{NetworkError, is_driven};
use crate::builder::tags::driving_side::of_place;
use crate::builder::{BuildError, BuildOptions, build_plan, plan};
use crate::cells::{self, Divided, Grid, Tile};
use crate::lanelet::cell_metadata::METADATA;
use crate::lanelet::{self, INFO, MAP};
use crate::osm::{self, ReadError, Way};
use crate::projection::{Extent, Projector, VerticalDatum, write_info};
use crate::report::failure::Failure;
use crate::settings::Settings;
use crate::tiles::{Agreement, CutError, Disagreement, Survey, TileFile, TileSize, WayUse, cut};

use super::built::settings_text;
use super::config::NAME;
use super::divided::{grid, undivided};
use super::error::{Error, ErrorKind};
use super::files::{Draft, spare};
use super::layout::{LayoutOptions, build_failure, decided, unread, wanted};

/// How far around a tile and its roads data are read, metres, unless more is asked for.
pub const MARGIN: u32 = 800;

/// How a map is built in tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileOptions {
    /// Width and height of a tile, whole metres: a multiple of that of a cell, and no less than the margin.
    pub size: u32,
    /// Width and height of a cell, whole metres.
    pub cell: u32,
    /// How far around a tile and its roads data are read, metres.
    pub margin: u32,
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
/// [`write_cells`](super::BuiltMap::write_cells) writes of the map in one piece. Memory depends on the largest tile, but for some
/// 50 bytes for each node of the input. `tell` hears what is done next.
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
    tell: &dyn Fn(&str),
) -> Result<Tiled, Error> {
    let (cells, size) = sizes(tiles)?;
    spare(output)?;
    let mut draft = Draft::new(output).map_err(write_error)?;
    let folder = draft.folder(MAP).map_err(write_error)?;
    let scratch = draft.scratch("tiles").map_err(write_error)?;
    fs::create_dir(&scratch).map_err(|error| unwritten(output, &error))?;
    tell(&format!("reading {}", input.display()));
    let (survey, work) = Work::new(input, output, said)?;
    tell(&format!("cutting {} into tiles", input.display()));
    let files = cut(input, survey, &work.projector, size, &scratch).map_err(|error| match error {
        CutError::Read(error) => unread(error),
        CutError::Write(error) => unwritten(output, &error),
    })?;
    let mut whole = Whole { divided: Divided::empty(cells), settings: None };
    let mut agreement = Agreement::new(&scratch);
    let told = |disagreement| disagreed(input, output, tiles, disagreement);
    for (done, file) in files.iter().enumerate() {
        tell(&format!("building tile {} of {}", done + 1, files.len()));
        let tile = Tile { at: file.tile, cells: (tiles.size / tiles.cell) as i32 };
        let mut built = work.build(file, cells, tile, &folder)?;
        agreement.add(file.tile, built.as_mut().map(|(divided, _)| divided)).map_err(told)?;
        built.into_iter().for_each(|(divided, settings)| whole.add(divided, settings));
    }
    agreement.finish().map_err(told)?;
    let (divided, settings) = whole.finish();
    let (info, settings) = (write_info(&work.projector, VerticalDatum::default()), settings_text(&settings)?);
    let rest = || -> Result<(), Failure> {
        for (name, text) in [(METADATA, divided.metadata().text()), (INFO, info), (NAME, settings)] {
            draft.write(name, |file| file.write_all(text.as_bytes()))?;
        }
        draft.publish()
    };
    rest().map_err(write_error)?;
    Ok(Tiled { projector: work.projector, tiles: files.len(), divided })
}

/// The grid of the cells, and the size of the tiles.
fn sizes(TileOptions { size, cell, margin }: TileOptions) -> Result<(Grid, TileSize), Error> {
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

/// Why tiles do not make a map, and the way out.
fn disagreed(input: &Path, output: &Path, TileOptions { margin, .. }: TileOptions, found: Disagreement) -> Error {
    let failure = Failure::new(format!("{}: {found}", input.display())).about(input.display().to_string());
    ErrorKind::Build.error(failure.help(match found {
        Disagreement::Io(error) => return unwritten(output, &error),
        Disagreement::Element(_) => format!(
            "nothing was changed; it depends on what lies more than {margin} m away: give --margin {}",
            2 * margin
        ),
        Disagreement::Id(_) => {
            "nothing was changed; ids are hashes, and two met by chance: build it in one piece, with --cells".to_owned()
        }
    }))
}

/// What all tiles are built with.
struct Work<'a> {
    name: String,
    output: &'a Path,
    options: BuildOptions,
    projector: Projector,
    /// What the input holds of the Earth.
    bounds: Vec<Extent>,
}

impl<'a> Work<'a> {
    /// Reads what must be known of all data, and decides what must be the same in all tiles.
    fn new(input: &Path, output: &'a Path, said: &LayoutOptions) -> Result<(Survey, Self), Error> {
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
        Ok((survey, Self { name, output, options, projector, bounds }))
    }

    /// Builds a tile and writes its cells; `None` where there is nothing to drive on.
    fn build(
        &self,
        TileFile { path, .. }: &TileFile,
        cells: Grid,
        tile: Tile,
        folder: &Path,
    ) -> Result<Option<(Divided, Settings)>, Error> {
        let mut data = osm::read_file(path).map_err(unread)?;
        data.bounds.clone_from(&self.bounds);
        let plan = match plan(data, &self.options) {
            Err(BuildError::Network(_) | BuildError::NoPlace) => return Ok(None),
            plan => plan.map_err(|error| ErrorKind::Build.error(build_failure(error, &self.name)))?,
        };
        let built = build_plan(plan);
        // The data of the tile have done their work.
        File::create(path)
            .and_then(|file| lanelet::to_osm(&built.map, &built.projector, file))
            .map_err(|error| unwritten(self.output, &error))?;
        let settings = built.settings;
        drop(built.map);
        let files = [path.clone()];
        let divided = cells::divide(&files, Some(self.projector), cells, Some(tile), folder, &|_| ());
        let divided = divided.map_err(|error| undivided(self.output, error))?;
        fs::remove_file(path).map_err(|error| unwritten(self.output, &error))?;
        Ok(Some((divided, settings)))
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

/// What came of the tiles so far.
struct Whole {
    divided: Divided,
    settings: Option<Settings>,
}

impl Whole {
    /// Adds a tile, and what is known of single elements that stand in none before it.
    fn add(&mut self, divided: Divided, mut settings: Settings) {
        self.divided.cells.extend(divided.cells);
        self.divided.elements += divided.elements;
        self.divided.written += divided.written;
        let own: FxHashSet<i64> = divided.own.into_iter().map(|(_, id)| id).collect();
        settings.intersection.retain(|entry| entry.ia.is_some_and(|area| own.contains(&area)));
        settings.bicycle_lanes.retain(|lanelet| own.contains(lanelet));
        match &mut self.settings {
            Some(all) => {
                all.intersection.append(&mut settings.intersection);
                all.bicycle_lanes.append(&mut settings.bicycle_lanes);
            }
            None => self.settings = Some(settings),
        }
    }

    /// Of the whole map.
    fn finish(mut self) -> (Divided, Settings) {
        self.divided.cells.sort_unstable();
        let mut settings = self.settings.unwrap_or_default();
        settings.sort();
        (self.divided, settings)
    }
}
