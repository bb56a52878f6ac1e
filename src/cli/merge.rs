//! `merge`: cells or several maps in, one map out.

use std::path::PathBuf;

use crate::api::{Joined, merge};
use crate::report::failure::Failure;

use super::args::CLEAN;
use super::input;
use super::output::{self, Progress};
use clap::Args;

/// Put the cells of a divided map together again, or several maps into one
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Maps: .osm files, single cells, directories of .osm files, or map directories, divided or not
    #[arg(required = true)]
    pub maps: Vec<PathBuf>,
    /// Directory for lanelet2_map.osm and copies of map_projector_info.yaml and lanewright.toml; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Give elements other ids that share theirs with another element of a map before
    #[arg(long)]
    pub renumber: bool,
}

/// Puts the maps together and says what came of it.
pub fn run(args: &MergeArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let joined = merge(&args.maps, &args.output, args.renumber, &|doing| progress.next(doing))?;
    drop(progress);
    let Joined { elements: [nodes, ways, relations], renumbered, settings_left_out } = joined;
    let mut counts = vec![(nodes, "node", "nodes"), (ways, "way", "ways"), (relations, "relation", "relations")];
    counts.extend((renumbered > 0).then_some((renumbered, "element has another id", "elements have other ids")));
    let mut text = format!("{}\n{}", output::shown(&args.output), input::counts(&counts));
    if settings_left_out {
        text += "warning: the maps have different settings; no lanewright.toml was written\n";
    }
    output::tell(&args.output, &text)?;
    Ok(CLEAN)
}
