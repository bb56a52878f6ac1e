//! `project`: which projection a map was made with, and the same map in another.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Edit, Fix, Subject};
use crate::fix::edited;
use crate::lanelet::{Evidence, INFO, Inferred, Opened, ProjectorFrom, inferred_projector, open, twice};
use crate::osm::fixed;
use crate::projection::{Extent, LonLat, MgrsGrid, Projector, Twice, VerticalDatum, infer, residual, write_info};
use crate::report::failure::Failure;

use super::args::{CLEAN, ProjectorArg, place};
use super::output::{self, Progress};
use crate::api::load::open_failure;
use crate::api::{Converted, undivided};
use clap::{Args, Subcommand};

impl ProjectVerb {
    /// The map that is read.
    pub fn map(&self) -> &Path {
        match self {
            Self::Infer { map } | Self::Convert(ConvertArgs { map, .. }) => map,
        }
    }
}

/// What `project` does.
#[derive(Debug, Subcommand)]
pub enum ProjectVerb {
    /// Say which of Autoware's projections takes the map's lat/lon to its local_x/local_y, and how well
    Infer {
        /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
        map: PathBuf,
    },
    Convert(ConvertArgs),
}

/// Write a map with the local_x and local_y of another projection
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml
    pub map: PathBuf,
    /// The projection
    #[arg(long, value_enum)]
    pub to: ProjectorArg,
    /// Where east and north are 0; without it, the middle of the map
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    pub origin: Option<(f64, f64)>,
    /// Directory for the map's files and map_projector_info.yaml; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Write over a map that lanewright has not written there, or that was changed since
    #[arg(long)]
    pub force: bool,
}

/// Exit code where what stands beside the map does not explain it.
const UNEXPLAINED: u8 = 1;
/// A map is explained up to this distance, metres: ten times the last digit that maps write.
const EXPLAINED: f64 = 0.001;

/// Runs one of the two.
pub fn run(verb: &ProjectVerb) -> Result<u8, Failure> {
    match verb {
        ProjectVerb::Infer { map } => infer_map(map),
        ProjectVerb::Convert(args) => convert(args),
    }
}

/// Says which projection the map was made with, as `check` and `fix` take it where no file names it, and whether the one that the
/// map names is that.
fn infer_map(map: &Path) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let opened = open(map, None).map_err(open_failure)?;
    progress.next("measuring");
    let points = twice(&opened.osm);
    let inferred = inferred_projector(&opened.osm);
    let mut text = if points.is_empty() { told_by_degrees(&opened, &inferred)? } else { told_by_metres(&points) };
    drop(progress);
    let unexplained = !points.is_empty() && inferred.evidence != Evidence::LocalCoordinates;
    // Writing to a string cannot fail.
    let _ = match unexplained {
        true => writeln!(text, "\nnone of Autoware's projections explains this map"),
        false => write!(text, "\n{INFO}:\n{}", write_info(&inferred.projector, VerticalDatum::default())),
    };
    let code = match opened.projector_from {
        ProjectorFrom::Info(file) => {
            let _ = write!(text, "\n{} says {}", output::shown(&file), opened.projector);
            let far = residual(&points, &opened.projector);
            let _ = if points.is_empty() { writeln!(text) } else { writeln!(text, ": {}", millimetres(far)) };
            if far <= EXPLAINED && opened.info.is_sound() { CLEAN } else { UNEXPLAINED }
        }
        _ if !unexplained && opened.info.is_sound() => CLEAN,
        _ => UNEXPLAINED,
    };
    output::print(&text)?;
    Ok(code)
}

/// How well each projection explains the metres of nodes by their degrees.
fn told_by_metres(points: &[Twice]) -> String {
    let mut text = format!("{} nodes have degrees and metres\n", points.len());
    for one in infer(points) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:>12}  {}", millimetres(one.residual), one.projector);
    }
    text
}

/// Where a map lies of which no node has both degrees and metres, and which projections are possible.
fn told_by_degrees(opened: &Opened, inferred: &Inferred) -> Result<String, Failure> {
    let places = opened.osm.nodes.iter().filter_map(|node| node.position);
    let places: Vec<LonLat> = places.filter(|place| *place != LonLat::default()).collect();
    let extent = match &inferred.evidence {
        Evidence::Metres => return Ok("lat and lon are metres, not degrees: only Local is possible\n".to_owned()),
        Evidence::NoDegrees => return Ok("no node has degrees, only metres: only Local is possible\n".to_owned()),
        _ => Extent::of(places.iter().copied()),
    };
    let Some(extent) = extent else {
        return Err(Failure::new("no node of the map has degrees or metres")
            .help("lat and lon, or local_x and local_y, say where a node lies"));
    };
    let center = extent.center();
    let [lat, lon] = [center.lat, center.lon].map(|degrees| fixed(degrees, 6));
    let squares = match (&inferred.evidence, inferred.projector) {
        (Evidence::Squares(squares), _) => {
            let names: Vec<String> = squares.iter().map(ToString::to_string).collect();
            format!("crosses the MGRS squares {}", names.join(", "))
        }
        (_, Projector::Mgrs(grid)) => format!("lies in UTM zone {}, MGRS square {grid}", grid.zone()),
        _ => "lies in no MGRS square".to_owned(),
    };
    let possible = match &inferred.evidence {
        Evidence::Squares(_) => {
            "MGRS is not possible: Autoware folds the squares into one. Possible are TransverseMercator and LocalCartesian, and LocalCartesianUTM within one zone, each with an origin in the map"
        }
        _ => {
            "MGRS is possible, to which Autoware falls back; so are TransverseMercator, LocalCartesianUTM and LocalCartesian, each with an origin in the map"
        }
    };
    Ok(format!(
        "{} nodes have degrees, none has local_x and local_y\nthe map {squares}, around latitude {lat}, longitude {lon}\n{possible}\n",
        places.len()
    ))
}

/// Writes the map with the metres of another projection.
fn convert(args: &ConvertArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let opened = open(&args.map, None).map_err(open_failure)?;
    if opened.divided {
        return Err(undivided("converts"));
    }
    let mut places: Vec<LonLat> = Vec::new();
    for node in &opened.osm.nodes {
        let metres =
            || Some(crate::geometry::Point::new(number(node.tags.get("local_x"))?, number(node.tags.get("local_y"))?));
        let given = node.position.filter(|place| *place != LonLat::default());
        let place = given.or_else(|| opened.projector.inverse(metres()?));
        places.push(place.ok_or_else(|| {
            Failure::new(format!("node {} has no degrees, and nothing tells how to get them from its metres", node.id))
                .help(format!("write the map's projection into {INFO} beside it"))
        })?);
    }
    let names: Vec<String> = opened
        .files
        .iter()
        .map(|file| {
            file.file_name().map_or_else(String::new, |name| name.to_string_lossy().trim_end_matches(".gz").to_owned())
        })
        .collect();
    let converted = Converted { directory: &args.output, force: args.force, names: &names };
    converted.spare()?;
    let to = target(args, &places)?;
    progress.next("converting");
    let ele = |i: usize| number(opened.osm.nodes[i].tags.get("ele")).unwrap_or(0.0);
    let metres = to.forward_each(&places, ele);
    let mut edits = Vec::new();
    for (node, at) in opened.osm.nodes.iter().zip(metres) {
        let at = at.ok_or_else(|| {
            Failure::new(format!("{} does not reach node {}", to.name(), node.id))
                .help("choose another projection or origin")
        })?;
        for (key, value) in [("local_x", at.x), ("local_y", at.y)] {
            let value = format!("{:.4}", value + 0.0);
            if node.tags.get(key) != Some(&value) {
                edits.push(Edit::SetTag { on: Subject::Point(node.id), key: key.into(), value: value.into() });
            }
        }
    }
    let fix = Fix { title: String::new(), safe: true, edits };
    let texts = edited(&opened.osm, &fix).ok_or_else(|| Failure::new("the map cannot be edited"))?;
    drop(progress);
    converted.write(&args.map, &texts, &write_info(&to, opened.info.datum()))?;
    output::print(&format!("{}: {} nodes in {}\n", output::shown(&args.output), places.len(), to))?;
    Ok(CLEAN)
}

fn target(args: &ConvertArgs, places: &[LonLat]) -> Result<Projector, Failure> {
    let extent = Extent::of(places.iter().copied()).ok_or_else(|| Failure::new("the map has no node"))?;
    let origin = args.origin.map_or_else(|| extent.center(), |(lat, lon)| LonLat { lon, lat });
    Ok(match args.to {
        ProjectorArg::Mgrs => MgrsGrid::of(extent.center())
            .map(Projector::Mgrs)
            .ok_or_else(|| Failure::new("there is no MGRS square here").help("choose another projection"))?,
        ProjectorArg::TransverseMercator => Projector::transverse_mercator(origin),
        ProjectorArg::LocalCartesianUtm => Projector::LocalCartesianUtm { origin },
        ProjectorArg::LocalCartesian => Projector::LocalCartesian { origin },
    })
}

fn number(text: Option<&str>) -> Option<f64> {
    text?.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

fn millimetres(metres: f64) -> String {
    if metres < 1.0 { format!("{:.3} mm", metres * 1e3) } else { format!("{metres:.1} m") }
}
