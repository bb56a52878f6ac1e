//! Times the stages of the geometry: `geometry [--apart] OUT_DIR INPUT.osm...`; with `--apart` nothing is merged.

use std::path::{Path, PathBuf};
use std::time::Instant;

use lanewright::builder::{BuildOptions, geojson, plan};
use lanewright::osm::read_file;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from).peekable();
    let merge = arguments.next_if(|a| a.as_os_str() == "--apart").is_none();
    let out = arguments.next().ok_or("usage: geometry [--apart] OUT_DIR INPUT.osm...")?;
    std::fs::create_dir_all(&out)?;
    for input in arguments {
        write(&input, &out, merge)?;
    }
    Ok(())
}

fn write(input: &Path, out: &Path, merge: bool) -> Result<(), Box<dyn std::error::Error>> {
    let data = read_file(input)?;
    let mut options = BuildOptions::default();
    if !merge {
        options.streets.consolidate.rounds = 0;
    }
    let start = Instant::now();
    let plan = plan(&data, &options)?;
    let laid_out = start.elapsed();
    let stem = input.file_stem().ok_or("no file name")?;
    let file = std::fs::File::create(out.join(stem).with_extension("geojson"))?;
    geojson::write(&plan.streets.network, &plan.streets.outlines, &plan.projector, file)?;
    eprintln!(
        "{}: {} roads, {} findings, laid out in {laid_out:.0?}, written in {:.0?}",
        input.display(),
        plan.streets.network.roads.len(),
        plan.streets.findings.len(),
        start.elapsed() - laid_out
    );
    Ok(())
}
