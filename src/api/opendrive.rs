//! OpenDRIVE as an input of `build`: the file's own lanes become the map.

use std::fs::File;
use std::io::Read;

use rustc_hash::FxHashSet;

use crate::builder::{Built, FileLane, Placing, build_opendrive, opendrive_note};
use crate::diagnostic::{Finding, Severity, Subject};
use crate::lanelet::LaneletId;
use crate::lanelet::index::MapIndex;
use crate::projection::{LonLat, Projector};
use crate::report::failure::Failure;
use crate::rules::{self, Config};
use crate::xodr::{XodrError, is_opendrive, read};

use super::built::BuiltMap;
use super::error::{Error, ErrorKind};
use super::layout::{LayoutOptions, asked, build_failure, projector};
use super::{InMemory, Input};

/// Notes about lanes whose shape breaks a requirement: they name the lanelets.
const SHAPE_NOTES: [&str; 2] = ["opendrive-shape", "opendrive-overlap"];

/// A map of so many points is always judged, ...
const MOST_POINTS: usize = 50_000;
/// ... a larger one if its lanelets have no more than this on the average: those of towns have 34 to 87, of a motorway 200.
const MOST_OF_LANELET: usize = 1_000;

/// A map is judged if no more than so many pairs of lanelets lie within each other's boxes, ...
const MOST_PAIRS: usize = 400_000;
/// ... a larger one if these are no more than so many for each lanelet.
const MOST_PAIRS_OF_LANELET: usize = 100;

/// Bytes of a file by which its format is told.
const HEAD: u64 = 1 << 16;

impl Input {
    /// Whether it is OpenDRIVE, by its first bytes. One that cannot be read is none: reading it tells why.
    pub fn is_opendrive(&self) -> bool {
        match self {
            Self::Bytes(InMemory { bytes, .. }) => is_opendrive(bytes),
            Self::Path(path) => {
                let mut head = Vec::new();
                // Pipes can be read only once.
                let file = File::open(path).ok().filter(|file| file.metadata().is_ok_and(|about| about.is_file()));
                let read = file.is_some_and(|file| file.take(HEAD).read_to_end(&mut head).is_ok());
                read && is_opendrive(&head)
            }
        }
    }
}

impl BuiltMap {
    /// The map of an OpenDRIVE file.
    ///
    /// # Errors
    ///
    /// Where the file or settings cannot be read, and where it has no lane for vehicles.
    pub fn of_opendrive(input: impl Into<Input>, options: &LayoutOptions, tell: &dyn Fn(&str)) -> Result<Self, Error> {
        let input = input.into();
        let name = input.name();
        tell(&format!("reading {name}"));
        let (bytes, build) = asked(input, options)?;
        if options.dem.is_some() {
            let failure = Failure::new(format!("{name} has heights of its own")).about(&name);
            return Err(ErrorKind::Build.error(failure.help("leave --dem out")));
        }
        let text = String::from_utf8(bytes).map_err(|_| {
            let failure = Failure::new(format!("{name} is not UTF-8")).about(&name);
            ErrorKind::Read.error(failure.help("OpenDRIVE is XML in UTF-8; export it again"))
        })?;
        let file = read(&text).map_err(|error| ErrorKind::Read.error(unread(error, &name, &text)))?;
        drop(text);
        tell(&format!("building {name}"));
        let origin = options.origin.map(|[lat, lon]| LonLat { lon, lat });
        if let Some(kind) = options.projector {
            // What no place can have is told before.
            projector(kind, LonLat::default())?;
            if origin.is_none() && file.header.plane.georeference.is_none() {
                let failure = Failure::new(format!("{name} does not say where on earth it lies")).about(&name);
                return Err(ErrorKind::Build.error(failure.help("say it: --origin LAT,LON of the file's origin")));
            }
        }
        let wanted = |middle: LonLat| {
            let kind = options.projector.and_then(|kind| projector(kind, middle).ok());
            kind.unwrap_or(Projector::transverse_mercator(middle))
        };
        let wanted: &(dyn Fn(LonLat) -> Projector + Sync) = &wanted;
        let placing = Placing { origin, wanted: options.projector.map(|_| wanted) };
        let mut built = build_opendrive(&file, &build, placing)
            .map_err(|error| ErrorKind::Build.error(build_failure(error, &name)))?;
        tell(&format!("judging {name}"));
        let untold = untold_errors(&built)?;
        built.notes.extend(untold);
        Ok(Self { built })
    }
}

/// A note for each error that `check` finds at lanes whose own shapes or links break a requirement, unless another note names them.
fn untold_errors(built: &Built) -> Result<Vec<Finding>, Error> {
    let (points, lanelets) = (built.map.points.len(), built.map.lanelets.len());
    let unjudged = |what: String| {
        let message = format!("{what} are not held against the rules here: `check` does it");
        vec![opendrive_note("opendrive-error", 1, message).graded(Severity::Warning)]
    };
    if points > MOST_POINTS.max(MOST_OF_LANELET * lanelets) {
        return Ok(unjudged(format!("{points} points on {lanelets} lanelets")));
    }
    let index = MapIndex::new(&built.map, &[], &built.settings);
    if crowded(&index) {
        return Ok(unjudged(format!("{lanelets} lanelets, of which each lies over a hundred others,")));
    }
    let found = rules::run(&index, &Config::from(&built.settings))
        .map_err(|error| ErrorKind::Config.error(Failure::new(error.to_string())))?;
    let in_file = |subject: Subject| {
        let Subject::Lanelet(id) = subject else { return None };
        let at = built.file_lanes.binary_search_by_key(&LaneletId(id), |lane| lane.lanelet).ok()?;
        built.file_lanes.get(at)
    };
    let shapes = built.notes.iter().filter(|note| SHAPE_NOTES.contains(&note.fault));
    let named: FxHashSet<Subject> = shapes.flat_map(|note| &note.related).map(|related| related.subject).collect();
    let mut told = Vec::new();
    for error in found.iter().filter(|one| one.severity == Severity::Error) {
        let finding = &error.finding;
        let subjects = std::iter::once(finding.subject).chain(finding.related.iter().map(|related| related.subject));
        let mut lanes: Vec<&FileLane> = subjects.filter_map(in_file).collect();
        lanes.dedup_by_key(|lane| lane.lanelet);
        let Some(first) = lanes.first() else { continue };
        if lanes.iter().any(|lane| named.contains(&Subject::Lanelet(lane.lanelet.0))) {
            continue;
        }
        let name = |lane: &&FileLane| format!("lane {} of road {} (lanelet {})", lane.lane, lane.road, lane.lanelet);
        let names: Vec<String> = lanes.iter().map(name).collect();
        let message = format!(
            "{}: as the file has it, `check` calls it an error: {} [{}]",
            names.join(" and "),
            finding.message,
            error.code
        );
        told.push(opendrive_note("opendrive-error", first.line, message).graded(Severity::Warning));
    }
    Ok(told)
}

/// Whether so many lanelets lie at one place that to hold all of them against each other would take minutes.
fn crowded(index: &MapIndex) -> bool {
    let most = MOST_PAIRS.max(MOST_PAIRS_OF_LANELET * index.lanes.len());
    let mut pairs = 0;
    index.lanes.iter().any(|lane| {
        pairs += index.lanes_near(lane.extent[0], lane.extent[1]).len();
        pairs > most
    })
}

fn unread(error: XodrError, name: &str, text: &str) -> Failure {
    Failure::new(format!("{name}: {error}")).help(error.help()).at(name, text, error.offset())
}
