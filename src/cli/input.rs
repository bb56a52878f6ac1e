//! What `build` and `geometry` start from: OpenStreetMap data, or streets as GeoJSON.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::builder::network::UNMET_ROAD;
use crate::builder::options::Inside;
use crate::builder::postprocess::inside::UNDRAWN;
use crate::builder::streets::consolidate::MergeNote;
use crate::builder::tags::road_class::DrivingSide;
use crate::builder::{BuildError, BuildOptions, Plan, UNMET_WISH, geojson, plan};
use crate::diagnostic::Finding;
use crate::osm;
use crate::osm::{OsmData, ReadError};
use crate::projection::{Extent, LonLat, MgrsGrid, Projector};
use crate::report::failure::Failure;
use crate::settings::{Settings, Side};
use crate::terrain::Terrain;

use super::check_args::ConfigArgs;
use super::load::{home, read_failure};
use super::screen::Progress;
use super::{ProjectorArg, SideArg, StreetArgs, build, config};

/// Reads an input and lays out its streets.
pub fn streets(input: &Path, args: &StreetArgs, progress: &Progress) -> Result<Plan, Failure> {
    let name = input.display().to_string();
    progress.next(&format!("reading {name}"));
    let (bytes, options) = asked(input, args)?;
    if geojson::is_json(&bytes) {
        if args.dem.is_some() {
            return Err(Failure::new(format!("{name} holds streets that lie at their height already"))
                .help("give --dem to `geometry`, which writes the heights with the streets"));
        }
        of_geojson(&name, bytes, options, args)
    } else {
        of_osm(&name, bytes, options, args, progress)
    }
}

/// Reads OpenStreetMap data, and what a user decides about building it.
pub fn osm(input: &Path, args: &StreetArgs) -> Result<(OsmData, BuildOptions), Failure> {
    let (bytes, options) = asked(input, args)?;
    if geojson::is_json(&bytes) {
        return Err(Failure::new(format!("{} is GeoJSON", input.display()))
            .help("give OpenStreetMap data; `build` and `draw --stage` take files of streets, too"));
    }
    let mut data = OsmData::default();
    osm::read_bytes(&mut data, &input.display().to_string(), bytes).map_err(read_failure)?;
    Ok((data, options))
}

/// The bytes of an input, and what a user decides about building it.
fn asked(input: &Path, args: &StreetArgs) -> Result<(Vec<u8>, BuildOptions), Failure> {
    let bytes = osm::load(input).map_err(|source| read_failure(ReadError::Io { path: input.to_path_buf(), source }))?;
    let settings = settings(input, args)?;
    let driving_side = match (args.driving_side, settings.driving_side) {
        (SideArg::Left, _) | (SideArg::Auto, Some(Side::Left)) => Some(DrivingSide::Left),
        (SideArg::Right, _) | (SideArg::Auto, Some(Side::Right)) => Some(DrivingSide::Right),
        (SideArg::Auto, Some(Side::Auto) | None) => None,
    };
    let wanted = settings.merge.into_iter().map(|said| (said, true));
    let merges = wanted.chain(settings.keep_apart.into_iter().map(|said| (said, false))).collect();
    let mut options = BuildOptions { driving_side, merges, ..BuildOptions::default() };
    options.terrain = args.dem.as_deref().map(terrain).transpose()?.map(Arc::new);
    options.beside = settings.beside.unwrap_or_default();
    let lights = settings.lights.unwrap_or_default();
    options.inside = Inside { everywhere: settings.inside, lights, intersections: settings.intersection };
    options.markings = settings.markings.unwrap_or_default();
    options.assume = settings.assume;
    options.roads = settings.road;
    let said = settings.heights.unwrap_or_default();
    let heights = &mut options.streets.heights;
    heights.ground = said.ground.unwrap_or(heights.ground);
    heights.storey = said.layer.unwrap_or(heights.storey);
    heights.grade = said.grade;
    heights.steepest = said.steepest;
    Ok((bytes, options))
}

/// Reads a terrain model.
fn terrain(path: &Path) -> Result<Terrain, Failure> {
    let bytes = fs::read(path).map_err(|source| read_failure(ReadError::Io { path: path.to_path_buf(), source }))?;
    Terrain::read(&bytes).map_err(|error| {
        Failure::new(format!("{} is no terrain model to build on: {error}", path.display()))
            .help("write one with GDAL: gdalwarp -t_srs EPSG:4326 -ot Float32 IN.tif OUT.tif")
    })
}

/// What `lanewright.toml` beside the input or above it says. One that a build has written is what that build made of these.
fn settings(input: &Path, args: &StreetArgs) -> Result<Settings, Failure> {
    let config = ConfigArgs { config: args.config.clone(), isolated: args.isolated, ..ConfigArgs::default() };
    let told = |file: &PathBuf| file.is_file() && !build::wrote(file);
    config::settings_from(config::above(home(input)).into_iter().filter(told).collect(), &config)
}

fn of_osm(
    name: &str,
    bytes: Vec<u8>,
    mut options: BuildOptions,
    args: &StreetArgs,
    progress: &Progress,
) -> Result<Plan, Failure> {
    let mut data = OsmData::default();
    osm::read_bytes(&mut data, name, bytes).map_err(read_failure)?;
    progress.next(&format!("laying out the streets of {name}"));
    if let Some(kind) = args.projector {
        let extent = Extent::of(data.nodes.iter().filter_map(|node| node.position));
        let nowhere = || Failure::new("the data has no node with a latitude and longitude");
        options.projector = Some(projector(kind, extent.ok_or_else(nowhere)?.center())?);
    }
    plan(data, &options).map_err(|error| build_failure(error, name))
}

fn of_geojson(name: &str, bytes: Vec<u8>, mut options: BuildOptions, args: &StreetArgs) -> Result<Plan, Failure> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").map(<[u8]>::to_vec).unwrap_or(bytes);
    let text = String::from_utf8(bytes)
        .map_err(|_| Failure::new(format!("{name} is not UTF-8")).help("GeoJSON is UTF-8 text; export it again"))?;
    let read = |options: &BuildOptions| {
        geojson::read(&text, options)
            .map_err(|error| Failure::new(format!("{name}: {error}")).help(error.help).at(name, &text, error.offset))
    };
    let plan = read(&options)?;
    match args.projector {
        Some(kind) if !is_of(&plan.projector, kind) => {
            options.projector = Some(projector(kind, centre(&plan))?);
            read(&options)
        }
        _ => Ok(plan),
    }
}

/// The middle of the box around all roads.
fn centre(plan: &Plan) -> LonLat {
    let points: Vec<_> =
        plan.streets.network.roads.iter().flat_map(|road| road.line.points().iter().copied()).collect();
    let places = plan.projector.inverse_each(&points, |_| 0.0);
    Extent::of(places.into_iter().flatten()).map(|extent| extent.center()).unwrap_or_default()
}

fn is_of(projector: &Projector, kind: ProjectorArg) -> bool {
    matches!(
        (projector, kind),
        (Projector::Mgrs(_), ProjectorArg::Mgrs)
            | (Projector::TransverseMercator { .. }, ProjectorArg::TransverseMercator)
            | (Projector::LocalCartesianUtm { .. }, ProjectorArg::LocalCartesianUtm)
            | (Projector::LocalCartesian { .. }, ProjectorArg::LocalCartesian)
    )
}

/// The projector that the user wants, with its origin in the middle of the data.
fn projector(kind: ProjectorArg, origin: LonLat) -> Result<Projector, Failure> {
    Ok(match kind {
        ProjectorArg::Mgrs => {
            let grid = MgrsGrid::of(origin).ok_or_else(|| {
                Failure::new("MGRS does not reach beyond 80 degrees south and 84 degrees north")
                    .help("use --projector TransverseMercator")
            })?;
            Projector::mgrs(grid)
        }
        ProjectorArg::TransverseMercator => Projector::transverse_mercator(origin),
        ProjectorArg::LocalCartesianUtm => Projector::LocalCartesianUtm { origin },
        ProjectorArg::LocalCartesian => Projector::LocalCartesian { origin },
    })
}

pub fn build_failure(error: BuildError, input: &str) -> Failure {
    match error {
        BuildError::Lanelet2Map { .. } => Failure::new(format!("{input} is a Lanelet2 map already"))
            .help(format!("`build` starts from OpenStreetMap data; to judge this map: lanewright check {input}")),
        BuildError::Network(_) => Failure::new(format!("{input}: {error}"))
            .help("are highway=* ways in the extract, and not only footways and private paths?"),
        BuildError::NoPlace => Failure::new(format!("{input}: {error}")),
    }
}

/// Lines that count things, each with its singular and plural.
pub fn counts(of: &[(usize, &str, &str)]) -> String {
    let mut text = String::new();
    for (count, one, many) in of {
        let _ = writeln!(text, "  {count:>7} {}", if *count == 1 { one } else { many });
    }
    text
}

/// What decided about each road that may lie inside an intersection, where that is asked for; and settings that meant
/// no road, always.
pub fn merges(notes: &[MergeNote], findings: &[Finding], args: &StreetArgs) -> String {
    let mut text = String::new();
    for note in notes.iter().filter(|_| args.explain_merges) {
        let _ = writeln!(text, "{note}");
    }
    for unmet in findings.iter().filter(|finding| [UNMET_WISH, UNMET_ROAD].contains(&finding.fault)) {
        let _ = writeln!(text, "warning: {}", unmet.message);
    }
    text
}

/// What the settings want drawn and the map did not get.
pub fn undrawn(notes: &[Finding]) -> String {
    let mut text = String::new();
    for note in notes.iter().filter(|note| note.fault == UNDRAWN) {
        let _ = writeln!(text, "warning: {}", note.message);
    }
    text
}

/// What was guessed: all of it, or how to see it.
pub fn guesses<'a>(count: usize, notes: impl IntoIterator<Item = &'a Finding>, args: &StreetArgs) -> String {
    let mut text = String::new();
    if count > 0 && !args.guesses {
        let _ = writeln!(text, "--guesses lists what the input did not say");
    }
    for Finding { fault, subject, message, .. } in notes.into_iter().filter(|_| args.guesses) {
        let _ = writeln!(text, "{subject}: {message} [{fault}]");
    }
    text
}
