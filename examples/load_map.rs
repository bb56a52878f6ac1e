//! Opens a map and says how long each step took and how much memory it needed: `load_map MAP`.

use std::path::PathBuf;
use std::time::Instant;

use lanewright::lanelet::{from_osm, projector_for};
use lanewright::osm::read_file;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: load_map MAP")?);
    let start = Instant::now();
    let osm = read_file(&path)?;
    let read = start.elapsed();
    let loaded = from_osm(&osm, &projector_for(&osm));
    let load = start.elapsed() - read;
    println!("{} nodes, {} lanelets, {} faults", osm.nodes.len(), loaded.map.lanelets.len(), loaded.faults.len());
    println!("read {:.2} s, load {:.2} s", read.as_secs_f64(), load.as_secs_f64());
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let peak = status.lines().find(|line| line.starts_with("VmHWM"));
        println!("{}", peak.unwrap_or_default());
    }
    Ok(())
}
