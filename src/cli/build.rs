//! `build`: streets in, a map directory out.

use std::path::{Path, PathBuf};

use crate::api::{
    self, BuiltMap, Input, KeepOptions, Layout, LayoutOptions, MARGIN, TileOptions, TileSizes, build_tiles, spare,
};
use crate::builder::{Built, Summary};
use crate::lanelet::MAP;
use crate::report::failure::Failure;
use crate::report::visible;

use super::args::{CLEAN, StreetArgs, output_directory, place};
use super::check_args::ProfileArg;
use super::output::{self, Progress};
use super::split::CELL;
use super::{input, memory, merge, split};
use clap::Args;

/// Build a Lanelet2 map from OpenStreetMap data, from streets as `geometry` writes them, or from OpenDRIVE
#[derive(Debug, Args)]
pub struct BuildArgs {
    /// OpenStreetMap data (.osm, .osm.gz or .osm.pbf), streets as GeoJSON (docs/geometry.md), or OpenDRIVE (docs/opendrive.md)
    pub input: PathBuf,
    /// Directory for lanelet2_map.osm, map_projector_info.yaml and lanewright.toml; made if it is not there
    #[arg(short, long, value_name = "DIR", value_parser = output_directory)]
    pub output: PathBuf,
    /// Whose reading of the requirements the map follows where readings differ: docs/tier4.md
    #[arg(long, value_enum)]
    pub profile: Option<ProfileArg>,
    /// Divide the map into cells of this width and height, whole metres, as `split` does
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(1..))]
    pub cells: Option<u32>,
    /// Build tiles of this width and height, one a thread, so that memory depends on the largest tile, and write the map in
    /// cells: docs/divided_maps.md
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(1..))]
    pub tiles: Option<u32>,
    /// How far around a tile data are read with it
    #[arg(long, value_name = "M", requires = "tiles", default_value_t = MARGIN, value_parser = clap::value_parser!(u32).range(1..100_000))]
    pub margin: u32,
    /// Keep the tiles that are built if the run ends early, and do not build those again that an earlier run has kept
    #[arg(long, requires = "tiles")]
    pub resume: bool,
    /// Write over a map that was not built here, or was changed since
    #[arg(long, conflicts_with_all = ["cells", "tiles"])]
    pub force: bool,
    /// Keep what people have changed in this map since it was built: it may be the output itself. docs/merge.md
    #[arg(long, value_name = "MAP", conflicts_with_all = ["cells", "tiles"])]
    pub keep: Option<PathBuf>,
    /// The build that the kept map was made from, or what it was built from, where neither git nor the map's directory has it
    #[arg(long, value_name = "MAP", requires = "keep")]
    pub base: Option<PathBuf>,
    /// Do not look for findings that neither the kept map nor the new build has
    #[arg(long, requires = "keep")]
    pub no_check: bool,
    /// Where the origin of an OpenDRIVE file lies that does not say it
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    pub origin: Option<(f64, f64)>,
    #[command(flatten)]
    pub streets: StreetArgs,
}

/// Builds the map and writes its three files, all or none.
pub fn run(args: &BuildArgs) -> Result<u8, Failure> {
    // Cells and tiles are refused where any map is.
    spare(&args.output, args.force || args.cells.or(args.tiles).is_some() || args.keep.is_some())?;
    let progress = Progress::start("reading");
    let mut options = args.streets.layout.options();
    options.configuration.profile = args.profile.map(Into::into);
    options.origin = args.origin.map(|(lat, lon)| [lat, lon]);
    let input = Input::from(args.input.as_path());
    if input.is_opendrive() {
        return run_opendrive(args, input, &options, progress);
    }
    if let Some(size) = args.tiles {
        return run_tiles(args, size, &options, progress);
    }
    let mut merges = String::new();
    let map = BuiltMap::uncontested(&options, |options| -> Result<Layout, Failure> {
        let layout = Layout::read(args.input.as_path(), options, &|doing| progress.next(doing))?;
        memory::keep(memory::KEPT_BRIEFLY_MS);
        progress.next("building");
        let streets = &layout.plan.streets;
        merges = input::merges(&streets.merges, &streets.findings, &args.streets);
        Ok(layout)
    })?;
    let undrawn = input::undrawn(&map.built.notes);
    if let Some(kept) = &args.keep {
        let code = run_keep(args, kept, &map, &options, progress)?;
        output::print(&format!("{merges}{undrawn}"))?;
        return Ok(code);
    }
    progress.next("writing");
    let divided = match args.cells {
        Some(size) => split::counts(&map.write_cells(&args.output, size)?),
        None => map.write(&args.output, args.force).map(|()| String::new())?,
    };
    drop(progress);
    output::tell(&args.output, &format!("{}{divided}", summary(args, &map.built)))?;
    output::print(&format!("{merges}{undrawn}"))?;
    // The process ends: the memory of a map need not be given back piece by piece.
    std::mem::forget(map);
    Ok(CLEAN)
}

/// Builds the map of an OpenDRIVE file and writes its files, all or none.
fn run_opendrive(args: &BuildArgs, input: Input, options: &LayoutOptions, progress: Progress) -> Result<u8, Failure> {
    if args.tiles.is_some() {
        let failure = Failure::new(format!("{} is OpenDRIVE, which is not built in tiles", args.input.display()));
        return Err(failure.help("leave --tiles out; --cells divides the map"));
    }
    let map = BuiltMap::of_opendrive(input, options, &|doing| progress.next(doing))?;
    if let Some(kept) = &args.keep {
        return run_keep(args, kept, &map, options, progress);
    }
    progress.next("writing");
    let divided = match args.cells {
        Some(size) => split::counts(&map.write_cells(&args.output, size)?),
        None => map.write(&args.output, args.force).map(|()| String::new())?,
    };
    drop(progress);
    let oddities = input::oddities(&map.built.notes, args.streets.guesses);
    let undrawn = input::undrawn(&map.built.notes);
    output::tell(&args.output, &format!("{}{divided}", summary(args, &map.built)))?;
    output::print(&format!("{oddities}{undrawn}"))?;
    Ok(CLEAN)
}

/// Merges the map with what people have changed in the one that was built before, and writes its files, all or none.
fn run_keep(
    args: &BuildArgs,
    kept: &Path,
    map: &BuiltMap,
    options: &LayoutOptions,
    progress: Progress,
) -> Result<u8, Failure> {
    let keep = KeepOptions { map: kept.to_path_buf(), base: args.base.clone(), unchecked: args.no_check };
    let merged = api::keep(map, &keep, options, &|doing| progress.next(doing))?;
    progress.next("writing");
    merged.write(&args.output, kept, args.force)?;
    drop(progress);
    let from = format!("kept from {}; the old build: {}\n", output::shown(kept), visible(&merged.base_from));
    output::tell(&args.output, &format!("{}{from}", summary(args, &map.built)))?;
    output::print(&merge::text(kept, &merged.merged))?;
    Ok(if merged.merged.needs_a_look() { merge::CONFLICTS } else { CLEAN })
}

/// Builds the map in tiles and writes its cells, all or none.
fn run_tiles(args: &BuildArgs, size: u32, options: &LayoutOptions, progress: Progress) -> Result<u8, Failure> {
    memory::keep(memory::KEPT_BRIEFLY_MS);
    let sizes = TileSizes { tile: size, cell: args.cells.unwrap_or(CELL), margin: args.margin };
    let tiles = TileOptions { sizes, resume: args.resume };
    let tell = |doing: &str| {
        // A tile is done. What it took must not add to what the next one takes.
        memory::give_back();
        progress.next(doing);
    };
    let tiled = build_tiles(&args.input, &args.output, tiles, options, &tell)?;
    drop(progress);
    let map = args.output.join(MAP);
    let counts = input::counts(&[(tiled.tiles, "tile", "tiles")]);
    let cells = split::counts(&tiled.divided);
    output::tell(&map, &format!("{}: {}\n{counts}{cells}", output::shown(&map), tiled.projector.name()))?;
    Ok(CLEAN)
}

/// What was built, and what had to be guessed.
fn summary(args: &BuildArgs, built: &Built) -> String {
    let Summary { roads, intersections, lanelets, regulatory_elements, guesses } = built.summary;
    let counts = input::counts(&[
        (roads, "road", "roads"),
        (intersections, "intersection", "intersections"),
        (lanelets, "lanelet", "lanelets"),
        (regulatory_elements, "regulatory element", "regulatory elements"),
        (guesses, "guess", "guesses"),
    ]);
    let map = args.output.join(MAP);
    let guesses = input::guesses(guesses, &built.notes, &args.streets);
    format!("{}: {}\n{counts}{guesses}", output::shown(&map), built.projector.name())
}
