//! `build --tiles` as its users run it: what it says, and what it refuses.

use std::fs;
use std::path::Path;

use crate::common::program::{Run, lanewright};
use crate::common::root;

/// Builds a file in tiles, with these arguments more, into `out`.
fn build(dir: &Path, input: &str, more: &[&str]) -> Run {
    lanewright(dir, &[&["build", input, "-o", "out"], more].concat())
}

fn sample() -> String {
    root().join("sample_maps/crossing_right.osm").display().to_string()
}

#[test]
fn a_map_in_tiles_is_a_map_in_cells() {
    let dir = tempfile::tempdir().unwrap();
    let told = build(dir.path(), &sample(), &["--tiles", "800", "--cells", "50"]).exits(0).stdout;
    assert!(told.contains(" tile") && told.contains(" cells\n"), "{told}");
    lanewright(dir.path(), &["build", &sample(), "-o", "whole", "--cells", "50"]).exits(0);
    lanewright(dir.path(), &["diff", "whole", "out"]).exits(0);
    build(dir.path(), &sample(), &["--tiles", "800"]).fails_saying(&["is there already", "nothing was changed"]);
}

#[test]
fn nothing_is_written_where_tiles_cannot_be_built() {
    let dir = tempfile::tempdir().unwrap();
    let refused = |input: &str, more: &[&str], words: &[&str]| {
        build(dir.path(), input, more).fails_saying(words);
        let left =
            fs::read_dir(dir.path()).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
        let written: Vec<String> = left.filter(|name| name == "out" || name.starts_with(".lanewright")).collect();
        assert!(written.is_empty(), "{words:?}: {written:?}");
    };
    refused(&sample(), &["--tiles", "700"], &["smaller than the margin of 800 m", "--tiles 800"]);
    refused(&sample(), &["--tiles", "1050"], &["whole cells of 100 m", "--tiles 1100"]);
    refused("none.osm", &["--tiles", "1000"], &["none.osm"]);
    fs::write(dir.path().join("cut.osm"), "<osm><node id='1' lat='48' lon='11'/><way id='2'>").unwrap();
    refused("cut.osm", &["--tiles", "1000"], &["cut off"]);
    fs::write(dir.path().join("empty.osm"), "<osm><node id='1' lat='48' lon='11'/></osm>").unwrap();
    refused("empty.osm", &["--tiles", "1000"], &["no drivable road"]);
    lanewright(dir.path(), &["geometry", &sample(), "-o", "streets.geojson"]).exits(0);
    refused("streets.geojson", &["--tiles", "1000"], &["holds streets", "OpenStreetMap data"]);
    lanewright(dir.path(), &["build", &sample(), "-o", "map"]).exits(0);
    refused("map/lanelet2_map.osm", &["--tiles", "1000"], &["Lanelet2 map already"]);
}
