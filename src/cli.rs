//! The verbs and their arguments, as clap reads them.

mod build;
mod check;
mod check_args;
mod compare;
mod diff;
mod draw;
mod explain;
mod fix;
mod fmt;
mod gallery;
mod geometry;
mod input;
mod memory;
mod output;
mod packaging;
mod project;
mod report_page;
mod stage;
mod stats;
mod tier4;
mod view;
mod watch;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use crate::builder::tags::driving_side;
use crate::projection;
use crate::report::failure::Failure;
use crate::settings::ProjectorType;
use check_args::{CheckArgs, ProfileArg};
use clap::{Args, Parser, Subcommand, ValueEnum};

/// Exit code of a run that found nothing bad enough.
const CLEAN: u8 = 0;
/// Exit code of a run that could not do its work; clap's own, too.
const FAILED: u8 = 2;

/// Builds Autoware-ready Lanelet2 maps from OpenStreetMap and checks any Lanelet2 map.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100, arg_required_else_help = true)]
#[command(after_help = "Exit code: 0 clean, 1 findings of severity error (see check --fail-on), 2 the run failed.")]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Build(BuildArgs),
    Geometry(GeometryArgs),
    Check(CheckArgs),
    Draw(DrawArgs),
    Fix(FixArgs),
    Fmt(FmtArgs),
    Diff(DiffArgs),
    /// Say which projection a map was made with, or put it into another
    #[command(subcommand)]
    Project(ProjectVerb),
    Stats(StatsArgs),
    View(ViewArgs),
    /// Say what a rule requires, why, and how to mend what breaks it
    Explain {
        /// Number of the rule, or a code that a finding shows: vm-03-08, vm-03-08/lane-node-missing
        rule: String,
    },
    /// List the rules
    Rules {
        /// With tier4: the validators of TIER IV's existing tool, each with its requirement
        #[arg(long, value_enum)]
        profile: Option<ProfileArg>,
    },
    /// Print the completions of a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages
    Man {
        /// Directory for lanewright.1 and a page for each verb; made if it is not there
        dir: PathBuf,
    },
}

/// Build a Lanelet2 map from OpenStreetMap data, or from streets as `geometry` writes them
#[derive(Debug, Args)]
struct BuildArgs {
    /// OpenStreetMap data (.osm, .osm.gz or .osm.pbf), or streets as GeoJSON (docs/geometry.md)
    input: PathBuf,
    /// Directory for lanelet2_map.osm, map_projector_info.yaml and lanewright.toml; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    streets: StreetArgs,
}

/// Write roads, lanes and intersections as GeoJSON: the geometry alone, before it becomes a map
#[derive(Debug, Args)]
struct GeometryArgs {
    /// OpenStreetMap data (.osm, .osm.gz or .osm.pbf), or streets as GeoJSON (docs/geometry.md)
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// The GeoJSON file; for several inputs, or if it is one, a directory
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    streets: StreetArgs,
}

/// How streets are laid out, and what is told of it.
#[derive(Debug, Default, Args)]
struct StreetArgs {
    /// Side of the road on which people drive; auto: by the country the data lies in
    #[arg(long, value_enum, default_value_t = SideArg::Auto)]
    driving_side: SideArg,
    /// Projection of the map; without it MGRS, or TransverseMercator where the data does not fit one 100 km square
    #[arg(long, value_enum)]
    projector: Option<ProjectorArg>,
    /// A terrain model to lay the roads on: GeoTIFF in degrees or UTM, heights in metres
    #[arg(long, value_name = "FILE")]
    dem: Option<PathBuf>,
    /// List every guess that was made
    #[arg(long)]
    guesses: bool,
    /// Say of each road that may lie inside an intersection whether it was merged, and what decided
    #[arg(long)]
    explain_merges: bool,
    /// A file to read instead of lanewright.toml, or one key of it: 'merge=[{nodes=[1,2]}]'
    #[arg(long, value_name = "FILE|KEY=VALUE")]
    config: Vec<String>,
    /// Read no lanewright.toml
    #[arg(long)]
    isolated: bool,
}

/// Draw a Lanelet2 map as SVG or PNG, with its findings, or its lines as GeoJSON; or how a map comes to be
#[derive(Debug, Args)]
struct DrawArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml; with --stage what
    /// `build` reads
    #[arg(required_unless_present = "compare")]
    map: Option<PathBuf>,
    /// The picture: .svg or .png; or .geojson: each line as it is painted, and the outlines of the lanelets
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Draw a stage of `build` instead of a map, with the points that decided
    #[arg(long, value_enum, value_delimiter = ',')]
    stage: Vec<StageArg>,
    /// Draw every intersection by itself, all stages that are given, into a directory with a page to look through
    #[arg(long, requires = "stage", conflicts_with_all = ["compare", "around", "at"])]
    each: bool,
    /// Draw two versions side by side and list the intersections that changed: two maps, or two files of streets
    #[arg(long, num_args = 2, value_names = ["OLD", "NEW"], conflicts_with = "map")]
    compare: Option<Vec<PathBuf>>,
    /// Draw what lies around this place
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true, conflicts_with = "around")]
    at: Option<(f64, f64)>,
    /// How far around the place, metres
    #[arg(long, value_name = "M", requires = "at", default_value_t = 60.0)]
    radius: f64,
    /// Draw what lies around the primitive with this id; of a stage, around an OpenStreetMap node or way
    #[arg(long, value_name = "ID", allow_hyphen_values = true)]
    around: Option<i64>,
    /// Pixels per metre; without it, whatever fits a screen
    #[arg(long, value_name = "PX")]
    scale: Option<f64>,
    /// Write the ids of lanelets, intersection areas and regulatory elements
    #[arg(long)]
    ids: bool,
    /// Leave out the findings of `check`
    #[arg(long)]
    no_findings: bool,
}

/// Mend a Lanelet2 map in place, changing only the lines it must; what makes a new error is not kept
#[derive(Debug, Args)]
struct FixArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    map: PathBuf,
    /// Show what would be changed and change nothing; exit code 1 if there is anything
    #[arg(long)]
    diff: bool,
    /// Make fixes that need a look afterwards, too
    #[arg(long)]
    r#unsafe: bool,
    #[command(flatten)]
    config: check_args::ConfigArgs,
}

/// Write a Lanelet2 map in canonical form, in place: the same elements give the same bytes
#[derive(Debug, Args)]
struct FmtArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    map: PathBuf,
    /// Change nothing; exit code 1 if a file is not formatted
    #[arg(long)]
    check: bool,
}

#[derive(Debug, Subcommand)]
enum ProjectVerb {
    /// Say which of Autoware's projections takes the map's lat/lon to its local_x/local_y, and how well
    Infer {
        /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
        map: PathBuf,
    },
    Convert(ConvertArgs),
}

/// Write a map with the local_x and local_y of another projection
#[derive(Debug, Args)]
struct ConvertArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    map: PathBuf,
    /// The projection
    #[arg(long, value_enum)]
    to: ProjectorArg,
    /// Where east and north are 0; without it, the middle of the map
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    origin: Option<(f64, f64)>,
    /// Directory for the map's files and map_projector_info.yaml; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Say what changed between two Lanelet2 maps, by element and meaning; exit code 1 if anything did
#[derive(Debug, Args)]
struct DiffArgs {
    /// The map as it was: a .osm file, a directory of them, or a map directory
    old: PathBuf,
    /// The map as it is
    new: PathBuf,
    /// For people or for programs
    #[arg(long, value_enum, default_value_t = DiffFormat::Text)]
    format: DiffFormat,
    /// What lies this close to where it was, metres, has not moved
    #[arg(long, value_name = "M", default_value_t = 0.001)]
    tolerance: f64,
    /// Write the changes on the new map, too: one HTML page to look at
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DiffFormat {
    Text,
    Json,
}

/// Say what a Lanelet2 map contains: counts, lengths, widths, curvature, what hangs together, what it lacks
#[derive(Debug, Args)]
struct StatsArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    map: PathBuf,
    /// For people or for programs
    #[arg(long, value_enum, default_value_t = StatsFormat::Text)]
    format: StatsFormat,
}

/// Show the report of a map in a browser, fresh whenever the map's files change, with what fixes would change
#[derive(Debug, Args)]
struct ViewArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml; with --build
    /// OpenStreetMap data
    map: PathBuf,
    /// Show how `build` makes a map of OpenStreetMap data, stage by stage, and anew after every change: drag nodes,
    /// change lanes and widths, merge roads or keep them apart. The file is not written to
    #[arg(long)]
    build: bool,
    /// With --build: side of the road on which people drive; auto: by the country the data lies in
    #[arg(long, value_enum, default_value_t = SideArg::Auto, requires = "build")]
    driving_side: SideArg,
    /// With --build, where the data is large: what to show first
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true, requires = "build")]
    at: Option<(f64, f64)>,
    /// Port on 127.0.0.1; 0 lets the system choose
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
    /// Show fixes that need a look afterwards, too
    #[arg(long, conflicts_with = "build")]
    r#unsafe: bool,
    #[command(flatten)]
    config: check_args::ConfigArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StatsFormat {
    Text,
    Json,
}

/// The stages of `build` that can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StageArg {
    /// Each road with its edges
    Thicken,
    /// Where the edges collide
    Collide,
    /// How far each road is cut back
    Trim,
    /// The outlines of the intersections
    Outline,
    /// Which roads lie inside an intersection, and why
    Consolidate,
    /// The cross-section of each road
    Lanes,
    /// Who drives where: the lanelets of the map
    Movements,
}

impl StageArg {
    /// The word on the command line.
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum SideArg {
    Left,
    Right,
    #[default]
    Auto,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ProjectorArg {
    #[value(name = "MGRS", alias = "mgrs")]
    Mgrs,
    #[value(name = "TransverseMercator", alias = "transverse-mercator")]
    TransverseMercator,
    #[value(name = "LocalCartesianUTM", alias = "local-cartesian-utm")]
    LocalCartesianUtm,
    #[value(name = "LocalCartesian", alias = "local-cartesian")]
    LocalCartesian,
}

impl From<ProjectorArg> for ProjectorType {
    fn from(projector: ProjectorArg) -> Self {
        match projector {
            ProjectorArg::Mgrs => Self::Mgrs,
            ProjectorArg::TransverseMercator => Self::TransverseMercator,
            ProjectorArg::LocalCartesianUtm => Self::LocalCartesianUtm,
            ProjectorArg::LocalCartesian => Self::LocalCartesian,
        }
    }
}

/// `LAT,LON` in degrees.
fn place(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("`{text}` is not LAT,LON in degrees, such as 48.137,11.575");
    let (lat, lon) = text.split_once(',').ok_or_else(wrong)?;
    let number = |part: &str| part.trim().parse::<f64>().map_err(|_| wrong());
    let (lat, lon) = (number(lat)?, number(lon)?);
    if !(-90.0..=90.0).contains(&lat) || !(-180.0..=180.0).contains(&lon) {
        return Err(format!("`{text}` is not on Earth: latitude -90 to 90 first, then longitude -180 to 180"));
    }
    Ok((lat, lon))
}

/// Runs on one of the threads that share the work: no other is waited for where there is none to share. This thread, which would
/// only wait, meanwhile unpacks what every layout of streets asks for first.
fn shared(run: impl FnOnce() -> Result<u8, Failure> + Send) -> Result<u8, Failure> {
    memory::keep(memory::QUICK);
    let mut result = Ok(CLEAN);
    rayon::in_place_scope(|threads| {
        threads.spawn(|_| result = run());
        projection::warm_up();
        driving_side::warm_up();
    });
    result
}

/// Runs the program with the arguments of the process.
pub fn run() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os()))
}

/// Runs the program with these arguments, the first of which is its own name, and gives its exit code.
pub fn run_with(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let verb = match Cli::try_parse_from(arguments) {
        Ok(Cli { verb }) => verb,
        Err(asked) => {
            // Help and version are asked for; there is nobody to tell that they could not be printed.
            let _ = asked.print();
            return if asked.use_stderr() { FAILED } else { CLEAN };
        }
    };
    let result: Result<u8, Failure> = match verb {
        Verb::Build(args) => shared(|| build::run(&args)),
        Verb::Geometry(args) => shared(|| geometry::run(&args)),
        Verb::Check(args) => check::run(&args),
        Verb::Draw(args) => draw::run(&args),
        Verb::Fix(args) => fix::run(&args),
        Verb::Fmt(args) => fmt::run(&args),
        Verb::Project(ProjectVerb::Infer { map }) => project::infer_map(&map),
        Verb::Project(ProjectVerb::Convert(args)) => project::convert(&args),
        Verb::Diff(args) => diff::run(&args),
        Verb::Stats(args) => stats::run(&args),
        Verb::View(args) => view::run(args),
        Verb::Explain { rule } => explain::explain(&rule),
        Verb::Rules { profile } => explain::rules(profile),
        Verb::Completions { shell } => packaging::completions(shell),
        Verb::Man { dir } => packaging::man(&dir),
    };
    result.unwrap_or_else(|failure| {
        output::complain(&failure.render(output::stderr_style()));
        FAILED
    })
}
