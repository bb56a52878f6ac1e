//! `project`: which projection a map was made with, and the same map in another.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Edit, Fix, Subject};
use crate::fix::edited;
use crate::lanelet::{INFO, ProjectorFrom, open, twice};
use crate::projection::{Extent, LonLat, MgrsGrid, Projector, VerticalDatum, infer, residual, write_info};
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

/// Says which projections explain the map's metres by its degrees, and whether the one that the map names does.
fn infer_map(map: &Path) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let opened = open(map, None).map_err(open_failure)?;
    let points = twice(&opened.osm);
    if points.is_empty() {
        return Err(Failure::new(format!("no node of {} has both degrees and metres", map.display()))
            .help("lat and lon, local_x and local_y on the same node tell the projection; `lanewright project convert` adds the latter"));
    }
    progress.next("measuring");
    let found = infer(&points);
    drop(progress);
    let mut text = format!("{} nodes have degrees and metres\n", points.len());
    // Writing to a string cannot fail.
    for one in &found {
        let _ = writeln!(text, "{:>12}  {}", millimetres(one.residual), one.projector);
    }
    let best = found.first().filter(|best| best.residual <= EXPLAINED);
    if let Some(best) = best {
        let _ = write!(text, "\n{INFO}:\n{}", write_info(&best.projector, VerticalDatum::default()));
    } else {
        text += "\nnone of Autoware's projections explains this map\n";
    }
    let code = match opened.projector_from {
        ProjectorFrom::Info(file) => {
            let far = residual(&points, &opened.projector);
            let _ = writeln!(text, "\n{} says {}: {}", output::shown(&file), opened.projector, millimetres(far));
            if far <= EXPLAINED && opened.info.is_sound() { CLEAN } else { UNEXPLAINED }
        }
        _ if best.is_some() && opened.info.is_sound() => CLEAN,
        _ => UNEXPLAINED,
    };
    output::print(&text)?;
    Ok(code)
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
