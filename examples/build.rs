//! Builds a map from OpenStreetMap data: `cargo run --example build`.

use std::path::Path;

use lanewright::api::{Error, LayoutOptions};

fn main() -> Result<(), Error> {
    let map = lanewright::build("sample_maps/crossing_right.osm", &LayoutOptions::default())?;
    for note in &map.built.notes {
        println!("{}: {}", note.subject, note.message);
    }
    map.write(Path::new("out/crossing"), false)?;
    println!("{} lanelets", map.built.summary.lanelets);
    Ok(())
}
