//! `cut`: OpenStreetMap data in, the data of each tile out.

use std::path::PathBuf;

use crate::api::{CutTile, MARGIN, TileSizes, cut};
use crate::report::failure::Failure;

use super::args::{CLEAN, LayoutArgs};
use super::check_args::ProfileArg;
use super::output::{self, Progress};
use super::split::CELL;
use super::{input, memory};
use clap::Args;

/// Cut OpenStreetMap data into tiles from which a map is built on many machines: docs/scale.md
#[derive(Debug, Args)]
pub struct CutArgs {
    /// OpenStreetMap data (.osm, .osm.gz or .osm.pbf)
    pub input: PathBuf,
    /// Directory for the data of each tile and cut.json, which says what all have in common; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Width and height of a tile, whole metres, a multiple of that of a cell
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(1..))]
    pub tiles: u32,
    /// Width and height of a cell of the map, whole metres
    #[arg(long, value_name = "M", default_value_t = CELL, value_parser = clap::value_parser!(u32).range(1..))]
    pub cells: u32,
    /// How far around a tile data are read with it
    #[arg(long, value_name = "M", default_value_t = MARGIN, value_parser = clap::value_parser!(u32).range(1..100_000))]
    pub margin: u32,
    /// Whose reading of the requirements the map follows where readings differ: docs/tier4.md
    #[arg(long, value_enum)]
    pub profile: Option<ProfileArg>,
    #[command(flatten)]
    pub layout: LayoutArgs,
}

/// Cuts the data and says what came of it.
pub fn run(args: &CutArgs) -> Result<u8, Failure> {
    memory::keep(memory::KEPT_BRIEFLY_MS);
    let progress = Progress::start("reading");
    let mut options = args.layout.options();
    options.configuration.profile = args.profile.map(Into::into);
    let sizes = TileSizes { tile: args.tiles, cell: args.cells, margin: args.margin };
    let cut = cut(&args.input, &args.output, sizes, &options, &|doing| progress.next(doing))?;
    drop(progress);
    let megabytes = |bytes: u64| bytes as f64 / 1e6;
    let of_tiles = |tiles: &[CutTile]| tiles.iter().map(|tile| tile.bytes).sum::<u64>();
    let largest = cut.tiles.iter().map(|tile| tile.bytes).max().unwrap_or_default();
    output::print(&format!(
        "{}\n{}  {:>7.1} MB, {:.1} MB in the largest tile\n",
        output::shown(&args.output),
        input::counts(&[(cut.tiles.len(), "tile", "tiles")]),
        megabytes(of_tiles(&cut.tiles)),
        megabytes(largest),
    ))?;
    Ok(CLEAN)
}
