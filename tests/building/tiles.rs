//! Maps that are built in tiles are those that are built in one piece, to the byte.
//!
//! `make test` takes small extracts and some regions of random towns, `make soak` (LANEWRIGHT_SOAK=1) whole cities and more regions.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use lanewright::api::{
    Cut, DESCRIPTION, Joining, LayoutOptions, MARGIN, TILES, TileBuilder, TileOptions, TileSizes, build_tiles, cut,
    join,
};
use lanewright::build;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::cells::Cell;
use lanewright::osm::{DataBlocks, read_file};
use lanewright::projection::Extent;
use lanewright::tiles::{Record, TileFile};

use crate::common::drawing::Drawing;
use crate::common::needs::shared;
use crate::common::soak;
use crate::random_towns::region;

const CELL: u32 = 100;

/// All files below a directory, by name.
fn files(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let (mut open, mut files) = (vec![dir.to_path_buf()], BTreeMap::new());
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(next).unwrap().map(Result::unwrap) {
            match entry.file_type().unwrap().is_dir() {
                true => open.push(entry.path()),
                false => drop(
                    files
                        .insert(entry.path().strip_prefix(dir).unwrap().to_path_buf(), fs::read(entry.path()).unwrap()),
                ),
            }
        }
    }
    files
}

fn in_one_piece(input: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let dir = tempfile::tempdir().unwrap();
    build(input, &LayoutOptions::default()).unwrap().write_cells(&dir.path().join("map"), CELL).unwrap();
    files(&dir.path().join("map"))
}

fn in_tiles(input: &Path, size: u32) -> BTreeMap<PathBuf, Vec<u8>> {
    let dir = tempfile::tempdir().unwrap();
    let map = dir.path().join("map");
    let tiles = TileOptions { sizes: TileSizes { tile: size, cell: CELL, margin: MARGIN }, resume: false };
    let tiled = build_tiles(input, &map, tiles, &LayoutOptions::default(), &|_| ()).unwrap();
    println!("{}: {} tiles of {size} m", input.display(), tiled.tiles);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "something is left beside the map");
    files(&map)
}

#[track_caller]
fn is_same(whole: &BTreeMap<PathBuf, Vec<u8>>, tiles: &BTreeMap<PathBuf, Vec<u8>>, what: &str) {
    assert!(whole.keys().eq(tiles.keys()), "{what}: {} files in one piece, {} in tiles", whole.len(), tiles.len());
    let differ: Vec<&PathBuf> =
        whole.iter().filter(|(name, bytes)| tiles[*name] != **bytes).map(|(name, _)| name).collect();
    assert!(differ.is_empty(), "{what}: {} of {} files differ: {:?}", differ.len(), whole.len(), differ.first());
}

fn holds_for(extract: &str, sizes: &[u32]) {
    let Some(input) = shared(extract) else { return };
    let whole = in_one_piece(&input);
    for size in sizes {
        is_same(&whole, &in_tiles(&input, *size), &format!("{extract} in tiles of {size} m"));
    }
}

#[test]
fn an_extract_in_tiles_is_the_extract_in_one_piece() {
    holds_for("corpus/osm/neukolln.osm", &[800, 1100]);
    holds_for("corpus/osm/tempe_split.osm", &[900]);
    holds_for("corpus/osm/borough_sausage_links.osm", &[800]);
    if soak() {
        holds_for("corpus/osm/neukolln.osm", &[600]);
        holds_for("corpus/osm/monaco.osm", &[600, 900, 2000]);
        holds_for("corpus/osm/harrisburg.osm", &[1000, 2000, 4000]);
        holds_for("corpus/osm/harrisburg.osm.pbf", &[1000, 2000, 4000]);
        holds_for("corpus/osm_more/campo_grande.osm", &[1000, 2000, 4000, 8000]);
        holds_for("corpus/osm_more/krems.osm", &[2000]);
        holds_for("corpus/osm_more/leeds_cycleway.osm", &[1000]);
    }
}

/// Cut once, each tile built alone from what was written, in no order, twice, and then put together.
#[test]
fn the_stages_apart_give_the_same_map() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("region.osm");
    fs::write(&input, region(1)).unwrap();
    let options = LayoutOptions { driving_side: Some(DrivingSide::Left), ..LayoutOptions::default() };
    let whole = build(input.as_path(), &options).unwrap();
    whole.write_cells(&dir.path().join("whole"), CELL).unwrap();
    let [folder, records, map] = ["cut", "records", "map"].map(|name| dir.path().join(name));
    cut(&input, &folder, TileSizes { tile: 900, cell: CELL, margin: MARGIN }, &options, &|_| ()).unwrap();
    fs::create_dir(&records).unwrap();
    fs::create_dir_all(map.join("lanelet2_map.osm")).unwrap();

    let said = Cut::parse(&fs::read_to_string(folder.join(DESCRIPTION)).unwrap()).unwrap();
    assert!(said.tiles.len() > 3);
    let builder = TileBuilder::new(&said, None, dir.path()).unwrap();
    let cells: Vec<Cell> = said.tiles.iter().map(|tile| Cell { row: tile.row, column: tile.column }).collect();
    for tile in cells.iter().rev() {
        let data = TileFile::path_in(&folder.join(TILES), *tile);
        let built = [1, 2].map(|_| {
            let made = tempfile::tempdir().unwrap();
            let record = builder.build(*tile, &data.as_path().into(), &BTreeSet::new(), made.path()).unwrap();
            (files(made.path()), record)
        });
        assert_eq!(built[0], built[1]);
        let [(files, record), _] = built;
        files.iter().for_each(|(name, text)| fs::write(map.join("lanelet2_map.osm").join(name), text).unwrap());
        record.save(&records.join(Record::name(*tile))).unwrap();
    }
    let Joining::Whole(joined) = join(&said, &records, &BTreeSet::new()).unwrap() else {
        panic!("some are built again")
    };
    joined.texts().iter().for_each(|(name, text)| fs::write(map.join(name), text).unwrap());
    is_same(&files(&dir.path().join("whole")), &files(&map), "the stages apart");

    // An id that two elements want: the tiles in which it stands are built again without it.
    let place = |tile: &Cell| records.join(Record::name(*tile));
    let load = |tile: &Cell| Record::load(&place(tile), joined.divided.grid).unwrap();
    let with_elements = |tile: &&Cell| !load(tile).divided.own.is_empty();
    let [first, last] = [cells.iter().find(with_elements).unwrap(), cells.iter().rfind(with_elements).unwrap()];
    let id = load(first).divided.own[0];
    let mut record = load(last);
    record.divided.own.push(id);
    record.save(&place(last)).unwrap();
    let again = join(&said, &records, &BTreeSet::new()).unwrap();
    let Joining::Again { tiles, contested } = again else { panic!("two elements have the id {id}") };
    assert!(tiles.contains(first) && tiles.contains(last) && tiles.len() < cells.len(), "{tiles:?}");
    assert_eq!(contested, BTreeSet::from([id]));
    let unheard = join(&said, &records, &contested).unwrap_err();
    assert!(unheard.message().contains(&format!("have the id {id}")), "{unheard}");
    fs::remove_file(place(first)).unwrap();
    assert!(join(&said, &records, &contested).is_err(), "a record is missing");
}

/// Three roads of kilometres that meet at a place, in a file of a folder that is there; nodes have these tags.
fn long_roads(folder: &Path, tags: impl Fn(i64) -> &'static str) -> PathBuf {
    let mut drawing = Drawing::default();
    let mut node = |id: i64, [x, y]: [f64; 2]| {
        drawing.node(id, [format!("{:.7}", 48.0 + y / 111_195.0), format!("{:.7}", 11.0 + x / 74_400.0)], tags(id));
    };
    node(1, [0.0, 0.0]);
    for (k, at) in (1..9).map(|k| (k, k as f64)) {
        node(10 + k, [380.0 * at, 40.0 * at.sin()]);
        node(20 + k, [20.0 - 300.0 * at, -260.0 * at]);
    }
    node(30, [-500.0, 1250.0]);
    node(31, [-900.0, 1400.0]);
    node(32, [-1500.0, 1450.0]);
    node(40, [-800.0, 1150.0]);
    node(41, [-200.0, 1370.0]);
    drawing.way(1, [1].into_iter().chain(11..19), "highway=tertiary");
    drawing.way(2, [1].into_iter().chain(21..29), "highway=tertiary");
    drawing.way(3, [1, 30, 31, 32], "highway=tertiary");
    drawing.way(4, [40, 30, 41], "highway=residential");
    let input = folder.join("roads.osm");
    fs::write(&input, drawing.xml()).unwrap();
    input
}

/// A tile between needs the place where the roads meet for one of them only. The direction in which the others leave depends on the
/// crossing to which one of them leads without a bend, which lies farther away than the margin.
#[test]
fn an_intersection_depends_on_its_roads_however_far_they_run_straight() {
    let dir = tempfile::tempdir().unwrap();
    let input = long_roads(dir.path(), |_| "");
    let whole = in_one_piece(&input);
    for size in [800, 900, 1000, 1100] {
        is_same(&whole, &in_tiles(&input, size), &format!("tiles of {size} m"));
    }
}

/// Streets across another one, 12 m apart: without room between them they are merged, and tiles of this size disagreed where that went
/// on from one to the next.
#[test]
fn a_long_row_of_intersections_without_room_between_them_is_no_chain() {
    /// So many disagreed; fewer take less time.
    const MANY: i64 = 133;
    let streets = if soak() { MANY } else { 20 };
    let mut drawing = Drawing::default();
    let mut node = |id: i64, [x, y]: [f64; 2]| {
        drawing.node(id, [format!("{:.7}", 49.0 + y / 111_132.0), format!("{:.7}", 8.4 + x / 73_033.0)], "");
    };
    let place = |street: i64| 12.0 * (street - 1) as f64;
    for street in 1..=streets {
        [0.0, 60.0, -60.0].into_iter().zip(0..).for_each(|(y, k)| node(1000 * k + street, [place(street), y]));
    }
    node(9001, [-150.0, 0.0]);
    node(9002, [place(streets) + 150.0, 0.0]);
    drawing.way(1, [9001].into_iter().chain(1..=streets).chain([9002]), "highway=tertiary");
    for street in 1..=streets {
        drawing.way(1000 + street, [1000 + street, street, 2000 + street], "highway=residential");
    }
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("row.osm");
    fs::write(&input, drawing.xml()).unwrap();
    is_same(&in_one_piece(&input), &in_tiles(&input, 600), "tiles of 600 m");
}

/// Between known heights the ground rises evenly, however many tiles lie between; a road apart is as high as they are on average.
#[test]
fn the_ground_lies_between_heights_that_no_tile_sees_together() {
    let dir = tempfile::tempdir().unwrap();
    let tags = |id: i64| match id {
        18 => "ele=300",
        28 => "ele=420.5 m",
        _ => "",
    };
    let input = long_roads(dir.path(), tags);
    let whole = in_one_piece(&input);
    for size in [800, 1100] {
        is_same(&whole, &in_tiles(&input, size), &format!("tiles of {size} m"));
    }
    let text: String = whole.values().map(|bytes| String::from_utf8_lossy(bytes)).collect();
    let heights =
        text.split("k=\"ele\" v=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse::<f64>().unwrap());
    let [low, high] = heights.fold([f64::MAX, f64::MIN], |[low, high], z| [low.min(z), high.max(z)]);
    assert!((low - 300.0).abs() < 0.5 && (high - 420.5).abs() < 0.5, "{low} {high}");
}

/// Towns that hang together, some of them kilometres apart: what one of them decides must not reach the other.
#[test]
fn random_towns_in_tiles_are_those_in_one_piece() {
    let dir = tempfile::tempdir().unwrap();
    let input = dir.path().join("region.osm");
    for seed in 0..if soak() { 40 } else { 2 } {
        fs::write(&input, region(seed)).unwrap();
        let size = [1300, 900, 600][seed as usize % 3];
        is_same(&in_one_piece(&input), &in_tiles(&input, size), &format!("region {seed} in tiles of {size} m"));
    }
}

#[test]
fn a_file_says_the_same_block_by_block() {
    for name in ["corpus/osm/harrisburg.osm.pbf", "corpus/osm/monaco.osm"] {
        let Some(input) = shared(name) else { continue };
        let whole = read_file(&input).unwrap();
        let mut blocks = DataBlocks::open(&input).unwrap();
        let (mut nodes, mut ways, mut relations, mut bounds) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        while let Some(block) = blocks.next_block().unwrap() {
            nodes.extend(block.nodes.into_iter().map(|node| (node.id, node.position, node.tags)));
            ways.extend(block.ways.into_iter().map(|way| (way.id, way.nodes, way.tags)));
            relations.extend(block.relations.into_iter().map(|one| (one.id, one.members, one.tags)));
            bounds.extend(block.bounds);
        }
        assert!(
            nodes.into_iter().eq(whole.nodes.into_iter().map(|node| (node.id, node.position, node.tags))),
            "{name}"
        );
        assert!(ways.into_iter().eq(whole.ways.into_iter().map(|way| (way.id, way.nodes, way.tags))), "{name}");
        assert!(
            relations.into_iter().eq(whole.relations.into_iter().map(|one| (one.id, one.members, one.tags))),
            "{name}"
        );
        let named = if bounds.is_empty() { vec![Extent::EARTH] } else { bounds };
        assert_eq!(named, whole.bounds, "{name}");
    }
}
