//! `planner`: a lanelet in, what Autoware's planner will do there out.

use std::io::{Error, Write};
use std::path::{Path, PathBuf};

use crate::api::{Along, Configuration, Loaded, forecasts};
use crate::geometry::Point;
use crate::planner::Params;
use crate::projection::LonLat;
use crate::report::failure::Failure;
use crate::report::{HarmlessJson, planner};

use super::args::{CLEAN, place};
use super::output::{self, Progress};
use clap::{Args, ValueEnum};

/// Tell what Autoware's planner will do on a lanelet of an intersection: whom it watches, whom it ignores and why, where it stops,
/// from where it blinks. Without a lanelet, a place or a route: a line for every lanelet with turn_direction
#[derive(Debug, Args)]
pub struct PlannerArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    pub map: PathBuf,
    /// The lanelet; several times for several
    #[arg(long, value_name = "ID", allow_hyphen_values = true, conflicts_with_all = ["at", "from"])]
    pub lanelet: Vec<i64>,
    /// The lanelets at this place
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true, conflicts_with = "from")]
    pub at: Option<(f64, f64)>,
    /// The intersections on the shortest way from this lanelet, without changing lanes
    #[arg(long, value_name = "ID", allow_hyphen_values = true, requires = "to")]
    pub from: Option<i64>,
    /// ... to this one
    #[arg(long, value_name = "ID", allow_hyphen_values = true, requires = "from")]
    pub to: Option<i64>,
    #[command(flatten)]
    pub parameters: ParameterArgs,
    /// For people or for programs
    #[arg(long, value_enum, default_value_t = PlannerFormat::Text)]
    pub format: PlannerFormat,
}

/// With which parameters the planner is run.
#[derive(Debug, Default, Args)]
pub struct ParameterArgs {
    /// A parameter file of Autoware, as intersection.param.yaml or vehicle_info.param.yaml; several times for several
    #[arg(long, value_name = "FILE")]
    pub planner_params: Vec<PathBuf>,
}

/// How forecasts are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PlannerFormat {
    Text,
    Json,
}

impl ParameterArgs {
    /// The parameters that the files say, and the usual ones.
    pub fn read(&self) -> Result<Params, Failure> {
        let mut params = Params::default();
        for file in &self.planner_params {
            read(&mut params, file)?;
        }
        Ok(params)
    }
}

fn read(params: &mut Params, file: &Path) -> Result<(), Failure> {
    let name = file.display().to_string();
    let text = std::fs::read_to_string(file).map_err(|error| {
        Failure::new(format!("{name}: {error}"))
            .help("name a parameter file of Autoware, .param.yaml")
            .about(name.clone())
    })?;
    params.read(&text).map_err(|error| {
        let offset = text.split_inclusive('\n').take(error.line.saturating_sub(1)).map(str::len).sum();
        Failure::new(error.message).help("docs/planner.md lists the parameters that are read").at(
            &name,
            text.clone(),
            offset,
        )
    })
}

/// Prints what the planner will do.
pub fn run(args: &PlannerArgs) -> Result<u8, Failure> {
    let params = args.parameters.read()?;
    let along = match (args.at, args.from.zip(args.to)) {
        (Some((lat, lon)), _) => Along::At(LonLat { lon, lat }),
        (_, Some((from, to))) => Along::Route { from, to },
        _ if !args.lanelet.is_empty() => Along::Lanelets(args.lanelet.clone()),
        _ => Along::Intersections,
    };
    let progress = Progress::start("reading");
    let loaded = Loaded::read(args.map.as_path(), &Configuration::default())?;
    progress.next("forecasting");
    let found = forecasts(&loaded, &along, &params)?;
    drop(progress);
    match args.format {
        PlannerFormat::Text if found.is_empty() => output::print(match along {
            Along::Route { .. } => "No lanelet on the way has a turn_direction: the planner drives through.\n",
            _ => "No lanelet has a turn_direction: the planner knows no intersection here.\n",
        })?,
        PlannerFormat::Text => output::print(&planner::text(&found))?,
        PlannerFormat::Json => {
            let to_globe = |points: &[Point]| loaded.projector.inverse_each(points, |_| 0.0).into_iter().collect();
            let json = planner::json(&found, &params, &to_globe).map_err(|error| Failure::new(error.to_string()))?;
            output::print_with(|out| {
                writeln!(HarmlessJson::new(out), "{}", serde_json::to_string_pretty(&json).map_err(Error::other)?)
            })?;
        }
    }
    Ok(CLEAN)
}
