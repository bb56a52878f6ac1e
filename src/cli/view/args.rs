//! The arguments of `view`.

use std::path::PathBuf;

use crate::cli::args::{SideArg, place};
use crate::cli::check_args::ConfigArgs;
use crate::cli::planner::ParameterArgs;
use clap::Args;

/// Show the report of a map in a browser, fresh whenever the map's files change, with what fixes would change
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml; with --build
    /// OpenStreetMap data
    pub map: PathBuf,
    /// Show the fixes that need review, one after another: accept or reject them, edit the map, and save. Nothing is written before
    /// that
    #[arg(long, conflicts_with = "build")]
    pub review: bool,
    /// With --review: the file that remembers rejected fixes with their reasons, for `check --baseline` [default: baseline.json
    /// beside the map]
    #[arg(long, value_name = "FILE", requires = "review")]
    pub baseline: Option<PathBuf>,
    /// Show how `build` makes a map of OpenStreetMap data, stage by stage, and anew after every change: drag nodes,
    /// change lanes and widths, merge roads or keep them apart. The file is not written to
    #[arg(long)]
    pub build: bool,
    /// With --build: side of the road on which people drive; auto: by the country the data lies in
    #[arg(long, value_enum, default_value_t = SideArg::Auto, requires = "build")]
    pub driving_side: SideArg,
    /// With --build, where the data is large: what to show first
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true, requires = "build")]
    pub at: Option<(f64, f64)>,
    /// Port on 127.0.0.1; 0 lets the system choose
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Open the page in the browser
    #[arg(long)]
    pub open: bool,
    /// Show fixes that need review afterwards, too
    #[arg(long, conflicts_with_all = ["build", "review"])]
    pub r#unsafe: bool,
    #[command(flatten)]
    pub parameters: ParameterArgs,
    #[command(flatten)]
    pub config: ConfigArgs,
}
