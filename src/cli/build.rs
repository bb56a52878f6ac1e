//! `build`: OpenStreetMap in, a map directory out.

use std::fmt::Write as _;
use std::io::Write;

use lanewright::builder::road_network::DrivingSide;
use lanewright::builder::{BuildError, BuildOptions, Built, Summary, build};
use lanewright::diagnostic::Finding;
use lanewright::lanelet;
use lanewright::osm::{self, OsmData};
use lanewright::projection::{Extent, LonLat, MgrsGrid, Projector, VerticalDatum, write_info};
use lanewright::report::failure::Failure;

use super::load::read_failure;
use super::screen::{self, Progress};
use super::{BuildArgs, CLEAN, ProjectorArg, SideArg, files};

/// Says how the files came to be and what they are for.
const SETTINGS_HEAD: &str = "# What OpenStreetMap told and the map cannot say; `lanewright check` reads it.\n";

/// Builds the map and writes its three files, all or none.
pub fn run(args: &BuildArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let osm = osm::read_file(&args.input).map_err(read_failure)?;
    progress.next("building");
    let options = BuildOptions {
        driving_side: match args.driving_side {
            SideArg::Left => Some(DrivingSide::Left),
            SideArg::Right => Some(DrivingSide::Right),
            SideArg::Auto => None,
        },
        projector: args.projector.map(|kind| projector(kind, &osm)).transpose()?,
        ..BuildOptions::default()
    };
    let built = build(&osm, &options).map_err(|error| build_failure(error, args))?;
    progress.next("writing");
    let info = write_info(&built.projector, VerticalDatum::default());
    let settings = toml::to_string(&built.settings)
        .map_err(|error| Failure::new(format!("the settings cannot be written: {error}")))?;
    let settings = format!("{SETTINGS_HEAD}{settings}");
    let mut draft = files::Draft::new(&args.output)?;
    draft.write("lanelet2_map.osm", |file| lanelet::to_osm(&built.map, &built.projector, file))?;
    draft.write("map_projector_info.yaml", |file| file.write_all(info.as_bytes()))?;
    draft.write("lanewright.toml", |file| file.write_all(settings.as_bytes()))?;
    draft.publish()?;
    drop(progress);
    screen::print(&summary(args, &built))?;
    Ok(CLEAN)
}

/// The projector that the user wants, with its origin in the middle of the data.
fn projector(kind: ProjectorArg, osm: &OsmData) -> Result<Projector, Failure> {
    let nowhere = || Failure::new("the data has no node with a latitude and longitude");
    let extent = Extent::of(osm.nodes.iter().filter_map(|node| node.position)).ok_or_else(nowhere)?;
    let origin: LonLat = extent.center();
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

fn build_failure(error: BuildError, args: &BuildArgs) -> Failure {
    let input = args.input.display();
    match error {
        BuildError::Lanelet2Map { .. } => Failure::new(format!("{input} is a Lanelet2 map already"))
            .help(format!("`build` starts from OpenStreetMap data; to judge this map: lanewright check {input}")),
        BuildError::Network(_) => Failure::new(format!("{input}: {error}"))
            .help("are highway=* ways in the extract, and not only footways and private paths?"),
        BuildError::NoPlace => Failure::new(format!("{input}: {error}")),
    }
}

/// What was built, and what had to be guessed.
fn summary(args: &BuildArgs, built: &Built) -> String {
    let Summary { roads, intersections, lanelets, regulatory_elements, guesses } = built.summary;
    let mut text = String::new();
    let _ = writeln!(text, "{}: {}", args.output.join("lanelet2_map.osm").display(), built.projector.name());
    for (count, one, many) in [
        (roads, "road", "roads"),
        (intersections, "intersection", "intersections"),
        (lanelets, "lanelet", "lanelets"),
        (regulatory_elements, "regulatory element", "regulatory elements"),
        (guesses, "guess", "guesses"),
    ] {
        let _ = writeln!(text, "  {count:>7} {}", if count == 1 { one } else { many });
    }
    if guesses > 0 && !args.guesses {
        let _ = writeln!(text, "--guesses lists what the input did not say");
    }
    if args.guesses {
        for note in &built.notes {
            let Finding { fault, subject, message, .. } = note;
            let _ = writeln!(text, "{subject}: {message} [{fault}]");
        }
    }
    text
}
