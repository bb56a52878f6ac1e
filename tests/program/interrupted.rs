//! Somebody presses Ctrl-C.

use std::fs;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::program::{command, lanewright};
use crate::common::root;

/// After these milliseconds.
const AFTER: [u64; 6] = [0, 10, 20, 40, 80, 160];

#[test]
fn an_interrupted_fix_leaves_the_file_whole() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_right.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "map"]).exits(0);
    let path = dir.path().join("map/lanelet2_map.osm");
    let good = fs::read_to_string(&path).unwrap();
    let bad = good.replace("v=\"left\"", "v=\"right\"");
    fs::write(&path, &bad).unwrap();
    lanewright(dir.path(), &["fix", "map", "--unsafe"]);
    let mended = fs::read_to_string(&path).unwrap();
    assert_ne!(mended, bad);
    for milliseconds in AFTER {
        fs::write(&path, &bad).unwrap();
        let mut command = command(dir.path(), &["fix", "map", "--unsafe"]);
        let mut running = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(milliseconds));
        Command::new("kill").args(["-INT", &running.id().to_string()]).stderr(Stdio::null()).status().unwrap();
        running.wait().unwrap();
        let left = fs::read_to_string(&path).unwrap();
        assert!(left == bad || left == mended, "after {milliseconds} ms the file is neither as it was nor mended");
    }
}
