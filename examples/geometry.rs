//! Writes the geometry of OpenStreetMap extracts as GeoJSON in metres: `geometry OUT_DIR INPUT.osm...`

use std::path::{Path, PathBuf};
use std::time::Instant;

use lanewright::builder::geojson::geometry_geojson;
use lanewright::builder::road_network::{NetworkOptions, road_network};
use lanewright::builder::streets::{StreetOptions, Streets, streets};
use lanewright::geometry::Point;
use lanewright::osm::read_file;
use lanewright::projection::LonLat;

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
    let start = Instant::now();
    let network = road_network(&data, &plane, &NetworkOptions::default())?.network;
    let mut options = StreetOptions::default();
    if !merge {
        options.consolidate.rounds = 0;
    }
    let Streets { network, outlines, findings, .. } = streets(network, &options);
    let text = geometry_geojson(&network, &outlines, None)?;
    let stem = input.file_stem().ok_or("no file name")?;
    eprintln!(
        "{}: {} roads, {} findings, {:.0?}",
        input.display(),
        network.roads.len(),
        findings.len(),
        start.elapsed()
    );
    std::fs::write(out.join(stem).with_extension("geojson"), text)?;
    Ok(())
}

/// Metres around the first place, good enough to measure shapes.
fn plane(places: &[LonLat]) -> Vec<Point> {
    const METRES_PER_DEGREE: f64 = 111_195.0;
    let Some(origin) = places.first() else { return Vec::new() };
    let squeeze = origin.lat.to_radians().cos();
    places.iter().map(|p| Point::new((p.lon - origin.lon) * squeeze, p.lat - origin.lat) * METRES_PER_DEGREE).collect()
}
