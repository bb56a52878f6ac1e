//! `build --tiles` as its users run it: what it says, and what it refuses.

use std::fs;
use std::io::Write;
use std::path::Path;

use lanewright::osm::read_file;

use crate::common::needs::shared;
use crate::common::program::{Run, lanewright};
use crate::common::{names, root, soak};
use crate::pbf_fields as pbf;

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
fn the_format_of_the_data_changes_nothing() {
    format_changes_nothing("corpus/osm/neukolln.osm", &["900"]);
    if soak() {
        format_changes_nothing("corpus/osm/neukolln.osm", &["600", "2000"]);
        format_changes_nothing("corpus/osm/monaco.osm", &["600", "900", "2000"]);
        format_changes_nothing("corpus/osm_more/campo_grande.osm", &["2000", "4000", "8000"]);
    }
}

/// An extract, packed and as PBF, in tiles of these sizes is the extract in one piece.
fn format_changes_nothing(extract: &str, sizes: &[&str]) {
    let Some(xml) = shared(extract) else { return };
    let dir = tempfile::tempdir().unwrap();
    let text = fs::read(&xml).unwrap();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&text).unwrap();
    fs::write(dir.path().join("town.osm.gz"), packed.finish().unwrap()).unwrap();
    fs::write(dir.path().join("town.osm.pbf"), pbf::of(&read_file(&xml).unwrap())).unwrap();
    lanewright(dir.path(), &["build", xml.to_str().unwrap(), "-o", "out_xml", "--cells", "100"]).exits(0);
    for (input, size) in
        ["town.osm.gz", "town.osm.pbf"].into_iter().flat_map(|input| sizes.iter().map(move |s| (input, *s)))
    {
        let out = format!("{input}_{size}");
        lanewright(dir.path(), &["build", input, "-o", &out, "--tiles", size]).exits(0);
        let [xml, other] = ["out_xml", &out].map(|name| dir.path().join(name));
        for place in ["", "lanelet2_map.osm"] {
            let [one, two] = [&xml, &other].map(|dir| dir.join(place));
            assert_eq!(names(&one), names(&two), "{input} in tiles of {size} m");
            for name in names(&one).iter().filter(|name| one.join(name).is_file()) {
                let same = fs::read(one.join(name)).unwrap() == fs::read(two.join(name)).unwrap();
                assert!(same, "{input} in tiles of {size} m: {name}");
            }
        }
    }
}

/// Tiles that are built stay until the map is complete, and are not built again.
#[test]
#[cfg(unix)]
fn a_run_that_ends_early_is_gone_on_with() {
    let Some(input) = shared("corpus/osm/neukolln.osm") else { return };
    let dir = tempfile::tempdir().unwrap();
    let input = input.to_str().unwrap();
    let arguments = ["build", input, "-o", "out", "--tiles", "600", "--resume", "--isolated"];
    // The list of the cells cannot be written: it has a directory's name.
    fs::create_dir_all(dir.path().join("out/lanewright.toml")).unwrap();
    lanewright(dir.path(), &arguments).fails_saying(&["lanewright.toml is a directory"]);
    let records = dir.path().join(".out.tiles/records");
    let known = names(&records);
    assert!(known.len() > 3 && known.iter().all(|name| name.ends_with(".json")), "{known:?}");
    fs::remove_dir_all(dir.path().join("out")).unwrap();
    // A tile that was being built leaves no record: it is built again, and only it.
    let changed = |name: &String| fs::metadata(records.join(name)).unwrap().modified().unwrap();
    let before: Vec<_> = known.iter().skip(1).map(changed).collect();
    fs::remove_file(records.join(&known[0])).unwrap();
    fs::create_dir_all(dir.path().join("out/lanewright.toml")).unwrap();
    lanewright(dir.path(), &arguments).fails_saying(&["lanewright.toml is a directory"]);
    assert_eq!((names(&records), known.iter().skip(1).map(changed).collect::<Vec<_>>()), (known.clone(), before));
    fs::remove_dir_all(dir.path().join("out")).unwrap();
    lanewright(dir.path(), &arguments).exits(0);
    assert_eq!(names(dir.path()), ["out"]);
    lanewright(dir.path(), &["build", input, "-o", "whole", "--cells", "100", "--isolated"]).exits(0);
    lanewright(dir.path(), &["diff", "whole", "out"]).exits(0);
    // What was built otherwise is not taken, be it that a settings file was changed.
    fs::remove_dir_all(dir.path().join("out")).unwrap();
    fs::create_dir_all(dir.path().join("out/lanewright.toml")).unwrap();
    lanewright(dir.path(), &arguments).fails_saying(&["lanewright.toml is a directory"]);
    let with_settings = |text: &str| {
        fs::write(dir.path().join("settings.toml"), text).unwrap();
        let arguments = ["build", input, "-o", "out", "--tiles", "600", "--resume", "--config", "settings.toml"];
        lanewright(dir.path(), &arguments).fails_saying(&["lanewright.toml is a directory"]);
        known.iter().map(changed).collect::<Vec<_>>()
    };
    let [first, same, other] = ["left", "left", "right"].map(|side| with_settings(&format!("driving_side = '{side}'")));
    assert!(first == same && first.iter().zip(&other).all(|(first, other)| first != other));
    let other = ["build", input, "-o", "out", "--tiles", "700", "--resume", "--isolated"];
    lanewright(dir.path(), &other).fails_saying(&["lanewright.toml is a directory"]);
    assert_ne!(names(&records), known);
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
    refused(&sample(), &["--tiles", "300"], &["smaller than the margin of 600 m", "--tiles 600"]);
    refused(&sample(), &["--tiles", "800", "--margin", "900"], &["smaller than the margin of 900 m", "--tiles 900"]);
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

#[test]
fn data_are_cut_once_into_a_folder() {
    let dir = tempfile::tempdir().unwrap();
    let cut = |input: &str, more: &[&str]| lanewright(dir.path(), &[&["cut", input, "-o", "data"], more].concat());
    for (arguments, words) in [
        (["--tiles", "300"], ["smaller than the margin of 600 m", "--tiles 600"]),
        (["--tiles", "1050"], ["whole cells of 100 m", "--tiles 1100"]),
    ] {
        cut(&sample(), &arguments).fails_saying(&words);
    }
    cut("none.osm", &["--tiles", "800"]).fails_saying(&["none.osm"]);
    assert_eq!(names(dir.path()), [""; 0]);
    let told = cut(&sample(), &["--tiles", "800", "--projector", "TransverseMercator"]).exits(0).stdout;
    assert!(told.contains(" tile") && told.contains("MB in the largest tile"), "{told}");
    assert_eq!(names(&dir.path().join("data")), ["cut.json", "tiles"]);
    let said = fs::read_to_string(dir.path().join("data/cut.json")).unwrap();
    let said: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!((&said["tile"], &said["cell"], &said["country"]), (&800.into(), &100.into(), &"DE".into()));
    assert!(said["projector_info"].as_str().unwrap().contains("TransverseMercator"), "{said}");
    let listed = said["tiles"].as_array().unwrap();
    let name = |tile: &serde_json::Value| format!("{}_{}.osm", tile["column"], tile["row"]);
    let mut listed: Vec<String> = listed.iter().map(name).collect();
    listed.sort_unstable();
    assert_eq!(names(&dir.path().join("data/tiles")), listed);
    cut(&sample(), &["--tiles", "800"]).fails_saying(&["is there already", "nothing was changed"]);
}
