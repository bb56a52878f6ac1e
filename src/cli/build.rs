//! `build`: streets in, a map directory out.

use crate::api::{BuiltMap, MAP, spare};
use crate::builder::{Built, Summary};
use crate::report::failure::Failure;

use super::output::{self, Progress};
use super::{BuildArgs, CLEAN, input, memory};

/// Builds the map and writes its three files, all or none.
pub fn run(args: &BuildArgs) -> Result<u8, Failure> {
    spare(&args.output)?;
    let progress = Progress::start("reading");
    let layout = input::streets(&args.input, &args.streets, &progress)?;
    memory::keep(memory::SPARING);
    progress.next("building");
    let streets = &layout.plan.streets;
    let merges = input::merges(&streets.merges, &streets.findings, &args.streets);
    let map = BuiltMap::of(layout);
    progress.next("writing");
    map.write(&args.output)?;
    drop(progress);
    output::print(&format!("{}{merges}{}", summary(args, &map.built), input::undrawn(&map.built.notes)))?;
    // The process ends: the memory of a map need not be given back piece by piece.
    std::mem::forget(map);
    Ok(CLEAN)
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
    let map = args.output.join(MAP);
    let guesses = input::guesses(guesses, &built.notes, &args.streets);
    format!("{}: {}\n{counts}{guesses}", map.display(), built.projector.name())
}
