//! What `build` and `geometry` start from: OpenStreetMap data, or streets as GeoJSON, laid out.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::builder::geojson::{self, WriteError};
use crate::builder::options::Inside;
use crate::builder::tags::road_class::DrivingSide;
use crate::builder::{BuildError, BuildOptions, Plan, plan};
use crate::osm::{self, OsmData, ReadError};
use crate::projection::{Extent, LonLat, MgrsGrid, Projector};
use crate::report::failure::Failure;
use crate::settings::{ProjectorType, Settings, Side};
use crate::terrain::Terrain;
use crate::xodr;

use super::config::{self, Configuration};
use super::error::{Error, ErrorKind};
use super::load::{home, read_failure};
use super::own_output;
use super::{InMemory, Input, files};

/// How streets are laid out, for `build` and `geometry`.
#[derive(Clone, Debug, Default)]
pub struct LayoutOptions {
    /// Side of the road on which people drive; by the settings, then by the country where absent.
    pub driving_side: Option<DrivingSide>,
    /// Projection of the map, its origin in the middle of the data; without it MGRS, or TransverseMercator where the data does
    /// not fit one square of 100 km. `Local` is none to build with.
    pub projector: Option<ProjectorType>,
    /// A terrain model to lay the roads on: GeoTIFF in degrees or UTM, heights in metres.
    pub dem: Option<Input>,
    /// Latitude and longitude, degrees, of the origin of an OpenDRIVE file that does not say where it lies.
    pub origin: Option<[f64; 2]>,
    /// Which settings count. Of its fields, `select` and `ignore` mean nothing here.
    pub configuration: Configuration,
    /// Ids that two elements want, so that neither gets them; [`build`](crate::build()) finds out.
    pub contested: BTreeSet<i64>,
}

/// Streets that are laid out: roads, lanes and intersections, before they become a map.
#[derive(Clone, Debug)]
pub struct Layout {
    /// What a map is built from.
    pub plan: Plan,
    /// What messages call the input.
    pub name: String,
}

impl Layout {
    /// Reads an input and lays out its streets; tells what is done next.
    ///
    /// # Errors
    ///
    /// Where the input, the terrain model or settings cannot be read, and where there is nothing to build from.
    pub fn read(input: impl Into<Input>, options: &LayoutOptions, tell: &dyn Fn(&str)) -> Result<Self, Error> {
        let input = input.into();
        let name = input.name();
        tell(&format!("reading {name}"));
        let (bytes, build) = asked(input, options)?;
        if xodr::is_opendrive(&bytes) {
            let failure = Failure::new(format!("{name} is OpenDRIVE, whose lanes need no laying out")).about(&name);
            return Err(
                ErrorKind::Build.error(failure.help(format!("make a map of it: lanewright build {name} -o DIR")))
            );
        }
        let plan = if geojson::is_json(&bytes) {
            if options.dem.is_some() {
                return Err(ErrorKind::Build.error(
                    Failure::new(format!("{name} holds streets that lie at their height already"))
                        .about(&name)
                        .help("give --dem to `geometry`, which writes the heights with the streets"),
                ));
            }
            of_geojson(&name, bytes, build, options)?
        } else {
            of_osm(&name, bytes, build, options, tell)?
        };
        Ok(Self { plan, name })
    }

    /// Writes the streets as GeoJSON (`docs/geometry.md`).
    ///
    /// # Errors
    ///
    /// Where streets have no place on Earth, or `out` fails.
    pub fn write(&self, out: impl Write + Send) -> Result<(), Error> {
        self.put(out).map_err(|error| self.unwritten(&error))
    }

    /// Writes the streets into a file, whole or not at all.
    ///
    /// # Errors
    ///
    /// Where streets have no place on Earth, or the file cannot be written.
    pub fn write_to(&self, file: &Path) -> Result<(), Error> {
        let mut unwritten = None;
        let done = files::write_by(file, |out| match self.put(out) {
            Err(WriteError::Output(error)) => Err(error),
            Err(error) => {
                let told = io::Error::other(error.to_string());
                unwritten = Some(error);
                Err(told)
            }
            Ok(()) => Ok(()),
        });
        match unwritten {
            Some(error) => Err(self.unwritten(&error)),
            None => done.map_err(ErrorKind::Write.of()),
        }
    }

    fn put(&self, out: impl Write + Send) -> Result<(), WriteError> {
        let Plan { streets, projector, .. } = &self.plan;
        geojson::write(&streets.network, &streets.outlines, projector, out)
    }

    fn unwritten(&self, error: &WriteError) -> Error {
        ErrorKind::Write.error(Failure::new(format!("{}: {error}", self.name)).about(&self.name))
    }
}

/// Reads OpenStreetMap data, and what a user decides about building it.
#[cfg(feature = "cli")]
pub(crate) fn osm_data(input: &Path, options: &LayoutOptions) -> Result<(OsmData, BuildOptions), Error> {
    let (bytes, build) = asked(input.into(), options)?;
    if geojson::is_json(&bytes) {
        return Err(ErrorKind::Read.error(
            Failure::new(format!("{} is GeoJSON", input.display()))
                .help("give OpenStreetMap data; `build` and `draw --stage` take files of streets, too"),
        ));
    }
    let mut data = OsmData::default();
    osm::read_bytes(&mut data, &input.display().to_string(), bytes).map_err(unread)?;
    osm::refuse_off_earth(&data).map_err(unread)?;
    Ok((data, build))
}

pub(super) fn unread(error: ReadError) -> Error {
    ErrorKind::Read.error(read_failure(error))
}

/// The bytes of an input.
pub(super) fn loaded(path: PathBuf) -> Result<Vec<u8>, Error> {
    osm::load(&path).map_err(unread)
}

/// The bytes of an input, and what a user decides about building it.
pub(super) fn asked(input: Input, said: &LayoutOptions) -> Result<(Vec<u8>, BuildOptions), Error> {
    match input {
        Input::Path(path) => Ok((loaded(path.clone())?, decided(&path, said)?)),
        Input::Bytes(InMemory { bytes, settings, .. }) => {
            let settings = config::settings_of(settings.as_deref(), &said.configuration);
            Ok((bytes, build_options(settings.map_err(ErrorKind::Config.of())?, said)?))
        }
    }
}

/// What a user decides about building a file.
fn decided(input: &Path, said: &LayoutOptions) -> Result<BuildOptions, Error> {
    build_options(settings(input, &said.configuration).map_err(ErrorKind::Config.of())?, said)
}

pub(super) fn build_options(settings: Settings, said: &LayoutOptions) -> Result<BuildOptions, Error> {
    let driving_side = said.driving_side.or(match settings.driving_side {
        Some(Side::Left) => Some(DrivingSide::Left),
        Some(Side::Right) => Some(DrivingSide::Right),
        Some(Side::Auto) | None => None,
    });
    let wanted = settings.merge.into_iter().map(|said| (said, true));
    let merges = wanted.chain(settings.keep_apart.into_iter().map(|said| (said, false))).collect();
    let mut options =
        BuildOptions { driving_side, merges, contested: said.contested.clone(), ..BuildOptions::default() };
    options.terrain = said.dem.as_ref().map(terrain).transpose()?.map(Arc::new);
    options.beside = settings.beside.unwrap_or_default();
    let lights = settings.lights.unwrap_or_default();
    options.inside = Inside { everywhere: settings.inside, lights, intersections: settings.intersection };
    options.markings = settings.markings.unwrap_or_default();
    options.assume = settings.assume;
    options.roads = settings.road;
    options.profile = settings.profile.unwrap_or_default();
    let high = settings.heights.unwrap_or_default();
    let heights = &mut options.streets.heights;
    heights.ground = high.ground.unwrap_or(heights.ground);
    heights.storey = high.layer.unwrap_or(heights.storey);
    heights.grade = high.grade;
    heights.steepest = high.steepest;
    Ok(options)
}

/// Reads a terrain model.
pub(super) fn terrain(input: &Input) -> Result<Terrain, Error> {
    let name = input.name();
    let failed = |path: &Path, source| unread(ReadError::Io { path: path.to_path_buf(), source });
    let read = match input {
        Input::Path(path) => Terrain::read(&fs::read(path).map_err(|source| failed(path, source))?),
        Input::Bytes(InMemory { bytes, .. }) => Terrain::read(bytes),
    };
    read.map_err(|error| {
        ErrorKind::Read.error(
            Failure::new(format!("{name} is no terrain model to build on: {error}"))
                .about(&name)
                .help("write one with GDAL: gdalwarp -t_srs EPSG:4326 -ot Float32 IN.tif OUT.tif"),
        )
    })
}

/// What `lanewright.toml` beside the input or above it says. One that a build has written is what that build made of these.
pub(super) fn settings(input: &Path, said: &Configuration) -> Result<Settings, Failure> {
    let told = |file: &PathBuf| file.is_file() && !own_output::wrote(file);
    config::settings_from(config::above(home(input)).into_iter().filter(told).collect(), said)
}

fn of_osm(
    name: &str,
    bytes: Vec<u8>,
    mut build: BuildOptions,
    said: &LayoutOptions,
    tell: &dyn Fn(&str),
) -> Result<Plan, Error> {
    let mut data = OsmData::default();
    osm::read_bytes(&mut data, name, bytes).map_err(unread)?;
    osm::refuse_off_earth(&data).map_err(unread)?;
    tell(&format!("laying out the streets of {name}"));
    if let Some(kind) = said.projector {
        let extent = Extent::of(data.nodes.iter().filter_map(|node| node.position));
        build.projector = Some(wanted(kind, extent, name)?);
    }
    plan(data, &build).map_err(|error| ErrorKind::Build.error(build_failure(error, name)))
}

fn of_geojson(name: &str, bytes: Vec<u8>, mut build: BuildOptions, said: &LayoutOptions) -> Result<Plan, Error> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").map(<[u8]>::to_vec).unwrap_or(bytes);
    let text = String::from_utf8(bytes).map_err(|_| {
        let failure = Failure::new(format!("{name} is not UTF-8")).about(name);
        ErrorKind::Read.error(failure.help("GeoJSON is UTF-8 text; export it again"))
    })?;
    let read = |options: &BuildOptions| {
        geojson::read(&text, options).map_err(|error| {
            let failure = Failure::new(format!("{name}: {error}")).help(error.help);
            ErrorKind::Read.error(failure.at(name, &text, error.offset))
        })
    };
    let plan = read(&build)?;
    match said.projector {
        Some(kind) if !is_of(&plan.projector, kind) => {
            build.projector = Some(projector(kind, centre(&plan))?);
            read(&build)
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

fn is_of(projector: &Projector, kind: ProjectorType) -> bool {
    matches!(
        (projector, kind),
        (Projector::Mgrs(_), ProjectorType::Mgrs)
            | (Projector::TransverseMercator { .. }, ProjectorType::TransverseMercator)
            | (Projector::LocalCartesianUtm { .. }, ProjectorType::LocalCartesianUtm)
            | (Projector::LocalCartesian { .. }, ProjectorType::LocalCartesian)
            | (Projector::Local, ProjectorType::Local)
    )
}

/// The projector that the user wants, with its origin in the middle of the box around all nodes.
pub(super) fn wanted(kind: ProjectorType, extent: Option<Extent>, name: &str) -> Result<Projector, Error> {
    let nowhere =
        || ErrorKind::Build.error(Failure::new("the data has no node with a latitude and longitude").about(name));
    let extent = extent.ok_or_else(nowhere)?;
    if kind == ProjectorType::Mgrs {
        let (min, max) = (extent.min, extent.max);
        let corners = [min, max, LonLat { lon: min.lon, lat: max.lat }, LonLat { lon: max.lon, lat: min.lat }];
        let mut squares: Vec<String> = Projector::squares(&corners).iter().flatten().map(MgrsGrid::to_string).collect();
        squares.sort_unstable();
        squares.dedup();
        if squares.len() > 1 {
            let message =
                format!("the data crosses the border of the MGRS squares {}, and a map has one", squares.join(" and "));
            let help = "use --projector TransverseMercator, or cut the data at the border";
            return Err(ErrorKind::Build.error(Failure::new(message).about(name).help(help)));
        }
    }
    projector(kind, extent.center())
}

/// The projector that the user wants, with its origin there.
pub(super) fn projector(kind: ProjectorType, origin: LonLat) -> Result<Projector, Error> {
    let failed = |message: &str, help: &str| ErrorKind::Build.error(Failure::new(message).help(help));
    Ok(match kind {
        ProjectorType::Mgrs => Projector::mgrs(MgrsGrid::of(origin).ok_or_else(|| {
            failed(
                "MGRS does not reach beyond 80 degrees south and 84 degrees north",
                "use --projector TransverseMercator",
            )
        })?),
        ProjectorType::TransverseMercator => Projector::transverse_mercator(origin),
        ProjectorType::LocalCartesianUtm => Projector::LocalCartesianUtm { origin },
        ProjectorType::LocalCartesian => Projector::LocalCartesian { origin },
        ProjectorType::Local => {
            return Err(failed("Local is no projection", "a map that is built has longitudes and latitudes"));
        }
    })
}

/// Why there is no map, and the way out.
pub(crate) fn build_failure(error: BuildError, input: &str) -> Failure {
    let failure = match error {
        BuildError::Lanelet2Map { .. } => Failure::new(format!("{input} is a Lanelet2 map already"))
            .help(format!("`build` starts from OpenStreetMap data; to judge this map: lanewright check {input}")),
        BuildError::Network(_) => Failure::new(format!("{input}: {error}"))
            .help("are highway=* ways in the extract, and not only footways and private paths?"),
        BuildError::NoPlace => Failure::new(format!("{input}: {error}")),
        BuildError::NoLane { .. } => Failure::new(format!("{input}: {error}"))
            .help("lanes of type driving and its kin, bus and taxi become lanelets: has the file others only, or numbers that cannot be?"),
    };
    failure.about(input)
}
