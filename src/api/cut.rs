//! Data that are cut into tiles: a folder with the data of each tile and one description, from which any tile can be built alone.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::builder::geojson;
use crate::builder::network::{NetworkError, is_driven, is_highway};
use crate::builder::streets::heights::{elevation, road_heights};
use crate::builder::tags::driving_side::{Country, of_place};
use crate::builder::tags::road_class::DrivingSide;
use crate::builder::{BuildError, BuildOptions};
use crate::cells::{Cell, Grid};
use crate::osm::{ReadError, Way};
use crate::projection::{Extent, Projector, VerticalDatum, read_info, write_info};
use crate::report::VERSION;
use crate::report::failure::Failure;
use crate::settings::{Settings, Side};
use crate::tiles::{Meaning, Survey, SurveyError, TileFile, TileSize, WayUse};

use super::divided::grid;
use super::error::{Error, ErrorKind};
use super::files::{Draft, there_already};
use super::layout::{LayoutOptions, build_failure, build_options, settings, unread, wanted};
use super::{InMemory, Input};

/// How far around a tile and its roads data are read, metres, unless more is asked for.
pub const MARGIN: u32 = 600;

/// The description in a folder of cut data.
pub const DESCRIPTION: &str = "cut.json";
/// The folder in it with the data of the tiles.
pub const TILES: &str = "tiles";
/// The terrain model in it, where there is one.
pub const TERRAIN: &str = "terrain.tif";

/// How large tiles and cells are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TileSizes {
    /// Width and height of a tile, whole metres: a multiple of that of a cell, and no less than the margin.
    pub tile: u32,
    /// Width and height of a cell, whole metres.
    pub cell: u32,
    /// How far around a tile and its roads data are read, metres.
    pub margin: u32,
}

impl TileSizes {
    /// The grid of the cells, and the size of the tiles.
    pub(super) fn grids(self) -> Result<(Grid, TileSize), Error> {
        let Self { tile, cell, margin } = self;
        let wrong = |message: String, help: String| Err(ErrorKind::Config.error(Failure::new(message).help(help)));
        let cells = grid(cell)?;
        if tile % cell != 0 {
            let fits = tile.div_ceil(cell) * cell;
            let message = format!("a tile of {tile} m does not consist of whole cells of {cell} m");
            return wrong(message, format!("--tiles {fits} does"));
        }
        if tile < margin {
            let message =
                format!("a tile of {tile} m is smaller than the margin of {margin} m that is built around it");
            return wrong(
                message,
                format!("--tiles {} or more; thousands of metres are usual", margin.next_multiple_of(cell)),
            );
        }
        Ok((cells, TileSize { tiles: grid(tile)?, margin: f64::from(margin) }))
    }
}

/// All that is the same for all tiles of some data, and which tiles there are: what `cut.json` says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// Version of the program that cut the data. Another one builds another map.
    pub lanewright: String,
    /// What messages call the data.
    pub input: String,
    /// How large tiles and cells are.
    #[serde(flatten)]
    pub sizes: TileSizes,
    /// The text of `map_projector_info.yaml`.
    pub projector_info: String,
    /// ISO 3166-1 code of the country in which the middle of all roads for cars lies; `None` at sea.
    pub country: Option<String>,
    /// Side of the road on which people drive there. The settings may say otherwise.
    pub driving_side: Side,
    /// What the data hold of the Earth.
    pub bounds: Vec<Extent>,
    /// The settings that count, whatever file or argument they came from.
    pub settings: Settings,
    /// Whether the roads are laid on a terrain model, which lies in the folder, too.
    pub terrain: bool,
    /// The tiles that have a road or lie near one, row by row.
    #[serde(default)]
    pub tiles: Vec<CutTile>,
}

/// A tile of cut data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CutTile {
    /// Its column in the grid of the tiles, from west to east.
    pub column: i32,
    /// Its row, from south to north.
    pub row: i32,
    /// Bytes of its data.
    pub bytes: u64,
}

/// Cuts OpenStreetMap data into the tiles from which a map can be built piece by piece, anywhere and in any order: a folder with
/// the data of each tile, OpenStreetMap XML, and a description. All is written or nothing. Some 120 bytes are held in memory for
/// each node of a road. `tell` hears what is done next.
///
/// # Errors
///
/// Where the input or settings cannot be read, nothing can be built, `output` holds cut data already, or the sizes do not suit
/// each other.
pub fn cut(
    input: &Path,
    output: &Path,
    sizes: TileSizes,
    said: &LayoutOptions,
    tell: &dyn Fn(&str),
) -> Result<Cut, Error> {
    let write = |failure| ErrorKind::Write.error(failure);
    for name in [DESCRIPTION, TILES] {
        let place = output.join(name);
        if place.exists() {
            return Err(write(there_already(&place)));
        }
    }
    tell(&format!("reading {}", input.display()));
    let Surveyed { survey, mut cut, .. } = Surveyed::new(input, output, sizes, said)?;
    let mut draft = Draft::new(output).map_err(write)?;
    let folder = draft.folder(TILES).map_err(write)?;
    tell(&format!("cutting {} into tiles", input.display()));
    let files = cut.write_tiles(survey, &folder, output)?;
    cut.list(&files).map_err(|error| unwritten(output, &error))?;
    let text = cut.text()?;
    let rest = || -> Result<(), Failure> {
        match &said.dem {
            Some(Input::Path(path)) => draft.write(TERRAIN, |file| io::copy(&mut File::open(path)?, file).map(drop))?,
            Some(Input::Bytes(InMemory { bytes, .. })) => draft.write(TERRAIN, |file| file.write_all(bytes))?,
            None => {}
        }
        draft.write(DESCRIPTION, |file| file.write_all(text.as_bytes()))?;
        draft.publish()
    };
    rest().map_err(write)?;
    Ok(cut)
}

/// Why nothing is written beside an output.
pub(super) fn unwritten(output: &Path, error: &io::Error) -> Error {
    let failure = Failure::new(format!("cannot write beside {}: {error}", output.display()));
    ErrorKind::Write.error(failure.help("nothing was changed; check the place's permissions and free space"))
}

/// The nearest folder to an output that is there.
fn beside(output: &Path) -> &Path {
    output.ancestors().skip(1).find(|folder| folder.is_dir()).unwrap_or(Path::new("."))
}

impl Cut {
    /// Reads a description.
    ///
    /// # Errors
    ///
    /// If it is none, or of another version of the program.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let wrong = |message: String| {
            let failure = Failure::new(message).about(DESCRIPTION);
            ErrorKind::Read.error(failure.help("cut the data again: lanewright cut INPUT --tiles 8000 -o DIR"))
        };
        let cut: Self = serde_json::from_str(text)
            .map_err(|error| wrong(format!("{DESCRIPTION} describes no data that are cut into tiles: {error}")))?;
        match cut.lanewright == VERSION {
            true => Ok(cut),
            false => Err(wrong(format!("the data were cut by lanewright {}, and this is {VERSION}", cut.lanewright))),
        }
    }

    /// As [`DESCRIPTION`] has it.
    ///
    /// # Errors
    ///
    /// Where JSON cannot say what the settings say, which would be a fault of ours.
    pub fn text(&self) -> Result<String, Error> {
        serde_json::to_string(self).map_err(|error| Error::internal(format!("cut data cannot be described: {error}")))
    }

    /// How metres relate to degrees.
    ///
    /// # Errors
    ///
    /// Where the description names no projector.
    pub fn projector(&self) -> Result<Projector, Error> {
        read_info(&self.projector_info).projector.ok_or_else(|| {
            ErrorKind::Read.error(Failure::new(format!("{DESCRIPTION} names no projector")).about(DESCRIPTION))
        })
    }

    /// What tiles are built with, but for a terrain model.
    pub(super) fn options(&self) -> Result<BuildOptions, Error> {
        let side = if self.driving_side == Side::Left { DrivingSide::Left } else { DrivingSide::Right };
        let country = Country { country: self.country.as_deref().map(Into::into), side };
        let options = build_options(self.settings.clone(), &LayoutOptions::default())?;
        Ok(BuildOptions { projector: Some(self.projector()?), country: Some(country), ..options })
    }

    /// Writes the data of all tiles into a folder that is there, for an output.
    pub(super) fn write_tiles(&self, survey: Survey, folder: &Path, output: &Path) -> Result<Vec<TileFile>, Error> {
        let (_, size) = self.sizes.grids()?;
        crate::tiles::cut(survey, &self.projector()?, size, folder).map_err(|error| unwritten(output, &error))
    }

    /// Notes which tiles there are.
    pub(super) fn list(&mut self, files: &[TileFile]) -> io::Result<()> {
        for TileFile { tile: Cell { row, column }, path } in files {
            self.tiles.push(CutTile { column: *column, row: *row, bytes: fs::metadata(path)?.len() });
        }
        Ok(())
    }
}

/// What must be known of all data before they are cut.
pub(super) struct Surveyed {
    pub(super) survey: Survey,
    /// Without the tiles.
    pub(super) cut: Cut,
    /// What tiles are built with.
    pub(super) options: BuildOptions,
}

impl Surveyed {
    /// Reads what must be known of all data, and decides what must be the same in all tiles. The elements are kept on the disk of
    /// the output.
    pub(super) fn new(input: &Path, output: &Path, sizes: TileSizes, said: &LayoutOptions) -> Result<Self, Error> {
        let name = input.display().to_string();
        refuse_streets(input, &name)?;
        let mut settings = settings(input, &said.configuration).map_err(ErrorKind::Config.of())?;
        settings.driving_side = said.driving_side.map(side).or(settings.driving_side);
        let options = build_options(settings.clone(), said)?;
        let use_of = |way: &Way| match () {
            () if is_driven(way, &options.roads) => WayUse::Driven,
            () if is_highway(way, &options.roads) => WayUse::Highway,
            () => WayUse::Other,
        };
        let meaning = Meaning { use_of: &use_of, elevation: &elevation };
        let mut survey = Survey::read(input, beside(output), meaning).map_err(|error| match error {
            SurveyError::Read(error) => unread(error),
            SurveyError::Write(error) => unwritten(output, &error),
        })?;
        if said.dem.is_none() {
            find_ground(&mut survey);
        }
        let failed = |error: BuildError| ErrorKind::Build.error(build_failure(error, &name));
        if survey.lanelets > 0 {
            return Err(failed(BuildError::Lanelet2Map { lanelets: survey.lanelets }));
        }
        let (ways, roads) = (survey.count(WayUse::Other), survey.count(WayUse::Highway));
        let no_road = |left_out| failed(NetworkError::NoRoad { ways, left_out, first: None }.into());
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
        let country = of_place(driven.center());
        let cut = Cut {
            lanewright: VERSION.to_owned(),
            input: name,
            sizes,
            projector_info: write_info(&projector, VerticalDatum::default()),
            country: country.country.as_ref().map(ToString::to_string),
            driving_side: side(country.side),
            bounds: survey.bounds.clone(),
            settings,
            terrain: said.dem.is_some(),
            tiles: Vec::new(),
        };
        let options = BuildOptions { terrain: options.terrain, ..cut.options()? };
        Ok(Self { survey, cut, options })
    }
}

/// Finds the ground of all roads between written heights, which may lie any distance away.
fn find_ground(survey: &mut Survey) {
    let written = std::mem::take(&mut survey.elevations);
    if !written.is_empty() {
        let roads = survey.nodes_of(WayUse::Highway).map(|nodes| nodes.iter().copied());
        survey.elevations = road_heights(roads, |node| survey.place(node), |node| written.get(&node).copied());
    }
}

fn side(side: DrivingSide) -> Side {
    match side {
        DrivingSide::Left => Side::Left,
        DrivingSide::Right => Side::Right,
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
