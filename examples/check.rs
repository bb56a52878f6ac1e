//! Builds a map in memory and holds it against Autoware's requirements: `cargo run --example check`.

use lanewright::api::{CheckOptions, Error, LayoutOptions};

fn main() -> Result<(), Error> {
    let map = lanewright::build("sample_maps/crossing_right.osm", &LayoutOptions::default())?;
    let checked = lanewright::check(map.to_input("crossing")?, CheckOptions::default())?;
    for found in &checked.sorted.left {
        println!("{} [{}] {}: {}", found.severity, found.code, found.finding.subject, found.finding.message);
    }
    println!("{} findings", checked.sorted.left.len());
    Ok(())
}
