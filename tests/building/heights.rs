//! Heights end to end: a terrain model with a cliff, given by `--dem`, and the map that comes of it.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use lanewright::lanelet::{LaneletMap, open};
use tiff::encoder::{TiffEncoder, colortype::Gray32Float};
use tiff::tags::Tag;

use crate::common::program::lanewright;

/// Degrees of one square of the model, some 3 m of latitude.
const SQUARE: f64 = 3e-5;
/// Squares along each side of it.
const SIDE: u32 = 240;
/// Its north-western corner: longitude, latitude.
const CORNER: [f64; 2] = [8.4964, 49.0036];
/// Height of the ground in the west, and of the cliff down to the east, metres.
const GROUND: f32 = 120.0;
const CLIFF: f32 = 9.0;

/// What a street may climb on steep ground. The lanes of an intersection climb up to half as much again: the roads that meet
/// there are level from kerb to kerb, each in its own direction.
const MOST: f64 = 0.3 * TILTED;
const TILTED: f64 = 1.55;

/// A model of ground that is level but for a cliff from north to south at 8.5 degrees.
fn terrain() -> Vec<u8> {
    let east = |i: u32| CORNER[0] + SQUARE * (f64::from(i % SIDE) + 0.5) > 8.5;
    let heights: Vec<f32> = (0..SIDE * SIDE).map(|i| if east(i) { GROUND - CLIFF } else { GROUND }).collect();
    let mut file = Cursor::new(Vec::new());
    let mut tiff = TiffEncoder::new(&mut file).unwrap();
    let mut image = tiff.new_image::<Gray32Float>(SIDE, SIDE).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[SQUARE, SQUARE, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, CORNER[0], CORNER[1], 0.0][..]).unwrap();
    let keys = [1_u16, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326];
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
    image.write_data(&heights).unwrap();
    file.into_inner()
}

/// Streets over the cliff: one straight across with a side street at its foot, and one from which a bridge leads over it.
const STREETS: &str = "<osm version='0.6'>\
    <node id='1' lat='49.0' lon='8.4970'/><node id='2' lat='49.0' lon='8.50004'/><node id='3' lat='49.0' lon='8.5030'/>\
    <node id='4' lat='48.9985' lon='8.50004'/>\
    <node id='5' lat='49.0010' lon='8.4970'/><node id='6' lat='49.0010' lon='8.4990'/>\
    <node id='7' lat='49.0010' lon='8.5010'/><node id='8' lat='49.0010' lon='8.5030'/>\
    <node id='9' lat='49.0020' lon='8.5005'/><node id='10' lat='49.0002' lon='8.5005'/>\
    <way id='20'><nd ref='1'/><nd ref='2'/><nd ref='3'/><tag k='highway' v='residential'/></way>\
    <way id='21'><nd ref='2'/><nd ref='4'/><tag k='highway' v='residential'/></way>\
    <way id='22'><nd ref='5'/><nd ref='6'/><tag k='highway' v='secondary'/></way>\
    <way id='23'><nd ref='6'/><nd ref='7'/><tag k='highway' v='secondary'/><tag k='bridge' v='yes'/></way>\
    <way id='24'><nd ref='7'/><nd ref='8'/><tag k='highway' v='secondary'/></way>\
    <way id='25'><nd ref='9'/><nd ref='10'/><tag k='highway' v='residential'/></way>\
    </osm>";

/// Builds the streets over the terrain and reads the map.
fn built(dir: &Path, settings: &str) -> LaneletMap {
    fs::write(dir.join("streets.osm"), STREETS).unwrap();
    fs::write(dir.join("cliff.tif"), terrain()).unwrap();
    fs::write(dir.join("lanewright.toml"), settings).unwrap();
    lanewright(dir, &["build", "streets.osm", "--dem", "cliff.tif", "-o", "map"]).exits(0);
    open(&dir.join("map"), None).unwrap().loaded.map
}

/// How long a lane's border is and by how much it rises, piece by piece.
fn climbs(map: &LaneletMap) -> Vec<(f64, f64)> {
    let bounds = map.lanelets.iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]);
    let mut climbs = Vec::new();
    for line in bounds.filter_map(|id| map.linestrings.get(id)) {
        let points: Vec<_> = line.points.iter().filter_map(|id| map.points.get(*id)).collect();
        for pair in points.windows(2) {
            let run = (pair[1].position - pair[0].position).norm();
            climbs.push((run, (pair[1].ele().unwrap() - pair[0].ele().unwrap()).abs()));
        }
    }
    climbs
}

fn steepest(map: &LaneletMap) -> f64 {
    climbs(map).into_iter().filter(|(run, _)| *run > 1.0).map(|(run, rise)| rise / run).fold(0.0, f64::max)
}

fn range(map: &LaneletMap) -> [f64; 2] {
    let heights = || map.points.iter().filter_map(|point| point.ele());
    [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)]
}

#[test]
fn a_cliff_in_the_terrain_becomes_a_climb() {
    let dir = tempfile::tempdir().unwrap();
    let map = built(dir.path(), "");
    let [low, high] = range(&map);
    assert!((low - f64::from(GROUND - CLIFF)).abs() < 0.5, "the street dips a little under the bridge: {low}");
    assert!((high - f64::from(GROUND)).abs() < 6.0, "{high}");
    assert!(steepest(&map) < MOST, "{}", steepest(&map));
    let told = lanewright(dir.path(), &["check", "map", "--select", "node"]).exits(0);
    assert!(!told.stdout.contains("ele-step"), "{}", told.stdout);
}

#[test]
fn the_settings_say_how_steep_it_may_be() {
    let dir = tempfile::tempdir().unwrap();
    let map = built(dir.path(), "[heights]\nsteepest = 0.1\ngrade = 0.1\n");
    assert!(steepest(&map) < 0.1 * TILTED, "{}", steepest(&map));
    let [low, high] = range(&map);
    assert!(high - low > 8.0, "far from the cliff the ground is as the model says: {low} {high}");
}
