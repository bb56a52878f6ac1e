//! What several verbs take from the command line, and the exit codes of all.

use std::convert::Infallible;
use std::path::PathBuf;

use crate::settings::ProjectorType;
use clap::{Args, ValueEnum};

/// Exit code of a run that found nothing bad enough.
pub const CLEAN: u8 = 0;
/// Exit code of a run that could not do its work; clap's own, too.
pub const FAILED: u8 = 2;

/// How streets are laid out.
#[derive(Debug, Default, Args)]
pub struct LayoutArgs {
    /// Side of the road on which people drive; auto: by the country the data lies in
    #[arg(long, value_enum, default_value_t = SideArg::Auto)]
    pub driving_side: SideArg,
    /// Projection of the map; without it MGRS, or TransverseMercator where the data does not fit one 100 km square
    #[arg(long, value_enum)]
    pub projector: Option<ProjectorArg>,
    /// A terrain model to lay the roads on: GeoTIFF in degrees or UTM, heights in metres
    #[arg(long, value_name = "FILE")]
    pub dem: Option<PathBuf>,
    /// A file to read instead of lanewright.toml, or one key of it: 'merge=[{nodes=[1,2]}]'
    #[arg(long, value_name = "FILE|KEY=VALUE")]
    pub config: Vec<String>,
    /// Read no lanewright.toml
    #[arg(long)]
    pub isolated: bool,
}

/// How streets are laid out, and what is told of it.
#[derive(Debug, Default, Args)]
pub struct StreetArgs {
    #[command(flatten)]
    pub layout: LayoutArgs,
    /// List every guess that was made
    #[arg(long)]
    pub guesses: bool,
    /// Show for each road that may lie inside an intersection whether it was merged, and why
    #[arg(long)]
    pub explain_merges: bool,
}

/// The side of the road as the command line names it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SideArg {
    Left,
    Right,
    #[default]
    Auto,
}

/// A projection as `map_projector_info.yaml` names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProjectorArg {
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

/// A number of bytes: `20GB`, `500 MB`, `1048576`.
pub fn size(text: &str) -> Result<u64, String> {
    let wrong = || format!("`{text}` is no number of bytes, such as 500MB or 20GB");
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let factor = match unit.trim().to_ascii_uppercase().as_str() {
        "" | "B" => 1.0,
        "K" | "KB" => 1e3,
        "M" | "MB" => 1e6,
        "G" | "GB" => 1e9,
        "T" | "TB" => 1e12,
        _ => return Err(wrong()),
    };
    // More than there are in the world is held to the largest number.
    number.parse::<f64>().map(|number| (number * factor) as u64).map_err(|_| wrong())
}

/// A file to write, or `-` for standard output.
pub fn output_file(text: &str) -> Result<PathBuf, Infallible> {
    Ok(if text == "-" { "/dev/stdout".into() } else { text.into() })
}

/// A directory to write a map into.
pub fn output_directory(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let names_a_file =
        path.extension().is_some_and(|one| ["osm", "pbf", "gz", "xml"].iter().any(|known| one == *known));
    if names_a_file && !path.is_dir() {
        return Err(format!(
            "that names a file, and a map is a directory with lanelet2_map.osm in it: give `{}`",
            path.with_extension("").display()
        ));
    }
    Ok(path)
}

/// A length: 0 or more metres.
pub fn metres(text: &str) -> Result<f64, String> {
    let length = text.parse().ok().filter(|metres: &f64| metres.is_finite() && *metres >= 0.0);
    length.ok_or_else(|| format!("`{text}` is no length in metres, 0 or more"))
}

/// `LAT,LON` in degrees.
pub fn place(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("`{text}` is not LAT,LON in degrees, such as 48.137,11.575");
    let (lat, lon) = text.split_once(',').ok_or_else(wrong)?;
    let number = |part: &str| part.trim().parse::<f64>().map_err(|_| wrong());
    let (lat, lon) = (number(lat)?, number(lon)?);
    if !(-90.0..=90.0).contains(&lat) || !(-180.0..=180.0).contains(&lon) {
        return Err(format!("`{text}` is not on Earth: latitude -90 to 90 first, then longitude -180 to 180"));
    }
    Ok((lat, lon))
}
