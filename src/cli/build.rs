//! `build`: streets in, a map directory out.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::builder::{Built, Summary, build_plan};
use crate::lanelet;
use crate::projection::{VerticalDatum, write_info};
use crate::report::failure::Failure;

use super::screen::{self, Progress};
use super::{BuildArgs, CLEAN, files, input, memory};

/// The settings that go with a map.
const SETTINGS: &str = "lanewright.toml";
/// Says how they came to be and what they are for.
const SETTINGS_HEAD: &str = "# What OpenStreetMap told and the map cannot say; `lanewright check` reads it.\n";

/// Builds the map and writes its three files, all or none.
pub fn run(args: &BuildArgs) -> Result<u8, Failure> {
    spare(&args.output.join(SETTINGS))?;
    let progress = Progress::start("reading");
    let plan = input::streets(&args.input, &args.streets, &progress)?;
    memory::keep(memory::SPARING);
    progress.next("building");
    let merges = input::merges(&plan.streets.merges, &plan.streets.findings, &args.streets);
    let built = build_plan(plan);
    progress.next("writing");
    let info = write_info(&built.projector, VerticalDatum::default());
    let settings = toml::to_string(&built.settings)
        .map_err(|error| Failure::new(format!("the settings cannot be written: {error}")))?;
    let settings = format!("{SETTINGS_HEAD}{settings}");
    let mut draft = files::Draft::new(&args.output)?;
    draft.write("lanelet2_map.osm", |file| lanelet::to_osm(&built.map, &built.projector, file))?;
    draft.write("map_projector_info.yaml", |file| file.write_all(info.as_bytes()))?;
    draft.write(SETTINGS, |file| file.write_all(settings.as_bytes()))?;
    draft.publish()?;
    drop(progress);
    screen::print(&format!("{}{merges}{}", summary(args, &built), input::undrawn(&built.notes)))?;
    // The process ends: the memory of a map need not be given back piece by piece.
    std::mem::forget(built);
    Ok(CLEAN)
}

/// Whether a build has written these settings.
pub fn wrote(settings: &Path) -> bool {
    fs::read(settings).is_ok_and(|written| written.starts_with(SETTINGS_HEAD.as_bytes()))
}

/// Refuses to write over settings that no build has written.
fn spare(settings: &Path) -> Result<(), Failure> {
    if settings.is_file() && !wrote(settings) {
        return Err(Failure::new(format!(
            "{} was not written by `build`, which would write over it",
            settings.display()
        ))
        .help("build into a directory of its own; the settings of directories above it count there, too"));
    }
    Ok(())
}

/// What was built, and what had to be guessed.
fn summary(args: &BuildArgs, built: &Built) -> String {
    let Summary { roads, intersections, lanelets, regulatory_elements, guesses } = built.summary;
    let counts = input::counts(&[
        (roads, "road", "roads"),
        (intersections, "intersection", "intersections"),
        (lanelets, "lanelet", "lanelets"),
        (regulatory_elements, "regulatory element", "regulatory elements"),
        (guesses, "guess", "guesses"),
    ]);
    let map = args.output.join("lanelet2_map.osm");
    let guesses = input::guesses(guesses, &built.notes, &args.streets);
    format!("{}: {}\n{counts}{guesses}", map.display(), built.projector.name())
}
