//! `geometry`: streets in, GeoJSON out.

use std::path::{Path, PathBuf};

use crate::builder::Plan;
use crate::report::failure::Failure;

use super::args::{CLEAN, StreetArgs, output_file};
use super::input;
use super::output::{self, Progress};
use clap::Args;

/// Write roads, lanes and intersections as GeoJSON: the geometry alone, before it becomes a map
#[derive(Debug, Args)]
pub struct GeometryArgs {
    /// OpenStreetMap data (.osm, .osm.gz or .osm.pbf), or streets as GeoJSON (docs/geometry.md)
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// The GeoJSON file, - for standard output; for several inputs, or if it is one, a directory
    #[arg(short, long, value_name = "FILE", value_parser = output_file)]
    pub output: PathBuf,
    #[command(flatten)]
    pub streets: StreetArgs,
}

/// Lays out the streets of each input and writes them.
pub fn run(args: &GeometryArgs) -> Result<u8, Failure> {
    let outputs = outputs(args)?;
    for (input, output) in args.inputs.iter().zip(&outputs) {
        let progress = Progress::start("reading");
        let layout = input::streets(input, &args.streets, &progress)?;
        progress.next("writing");
        layout.write_to(output)?;
        drop(progress);
        output::tell(output, &summary(args, output, &layout.plan))?;
        // Its memory is given back beside what follows; where nothing does, the process need not wait for it.
        rayon::spawn(move || drop(layout));
    }
    Ok(CLEAN)
}

/// Where each input goes: the file that the user names, or one of its name in a directory.
fn outputs(args: &GeometryArgs) -> Result<Vec<PathBuf>, Failure> {
    if args.inputs.len() == 1 && !args.output.is_dir() {
        return Ok(vec![args.output.clone()]);
    }
    let mut outputs: Vec<PathBuf> = Vec::new();
    for input in &args.inputs {
        let name = input.file_name().and_then(|n| n.to_str()).unwrap_or("streets");
        let stem = [".osm.pbf", ".osm.gz", ".osm", ".pbf", ".geojson"].iter().find_map(|end| name.strip_suffix(end));
        let output = args.output.join(format!("{}.geojson", stem.unwrap_or(name)));
        if outputs.contains(&output) {
            return Err(Failure::new(format!("two inputs would be written to {}", output.display()))
                .help("give them one by one, each with its own --output"));
        }
        outputs.push(output);
    }
    Ok(outputs)
}

fn summary(args: &GeometryArgs, output: &Path, plan: &Plan) -> String {
    let network = &plan.streets.network;
    let counts = input::counts(&[
        (network.roads.len(), "road", "roads"),
        (network.roads.iter().map(|road| road.section.strips.len()).sum(), "lane", "lanes"),
        (network.intersections.len(), "intersection", "intersections"),
        (network.intersections.iter().filter(|i| i.nodes.len() > 1).count(), "of several nodes", "of several nodes"),
        (plan.guesses, "guess", "guesses"),
    ]);
    let notes = plan.notes.iter().chain(&plan.streets.findings);
    let guesses = input::guesses(plan.guesses, notes, &args.streets);
    let merges = input::merges(&plan.streets.merges, &plan.streets.findings, &args.streets);
    format!("{}: {}\n{counts}{guesses}{merges}", output::shown(output), plan.projector.name())
}
