//! `split` and `merge` as their users run them, and divided maps that are damaged.

use std::fs;
use std::path::Path;

use crate::common::program::lanewright;
use crate::common::{names, root};

/// A directory with a map of one lanelet in `whole`, and its cells of 25 m in `cells`.
fn place() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("whole")).unwrap();
    fs::copy(root().join("tests/rules/vm-03-02/bad-turn-missing.osm"), dir.path().join("whole/lanelet2_map.osm"))
        .unwrap();
    fs::write(dir.path().join("whole/lanewright.toml"), "driving_side = \"left\"\n").unwrap();
    let run = lanewright(dir.path(), &["split", "whole", "-o", "cells", "--size", "25"]).exits(0);
    assert!(run.stdout.starts_with("cells\n") && run.stdout.contains(" cells\n"), "{}", run.stdout);
    dir
}

/// The first cells of the map.
fn two_cells(dir: &Path) -> [String; 2] {
    let cells = names(&dir.join("cells/lanelet2_map.osm"));
    [cells[0].clone(), cells[1].clone()].map(|name| format!("cells/lanelet2_map.osm/{name}"))
}

#[test]
fn a_divided_map_is_taken_as_a_single_one() {
    let dir = place();
    assert_eq!(names(&dir.path().join("cells")), ["lanelet2_map.osm", "lanelet2_map_metadata.yaml", "lanewright.toml"]);
    let run = |arguments: &[&str]| lanewright(dir.path(), arguments);
    let finding = |name: &str| {
        let told = run(&["check", name, "--format", "concise"]);
        let lines = told.stdout.lines().filter_map(|line| line.split_once(": ")).map(|(_, what)| what.to_owned());
        (told.code, lines.collect::<Vec<String>>())
    };
    assert_eq!(finding("cells"), finding("whole"));
    assert_eq!(finding("cells/lanelet2_map.osm"), finding("whole"));
    run(&["diff", "whole", "cells"]).exits(0);
    assert_eq!(run(&["stats", "cells"]).exits(0).stdout, run(&["stats", "whole"]).exits(0).stdout);
    for name in ["cells", "whole"] {
        run(&["draw", name, "-o", &format!("{name}.svg")]).exits(0);
    }
    let picture = |name: &str| fs::read_to_string(dir.path().join(name)).unwrap();
    assert_eq!(picture("cells.svg"), picture("whole.svg").replace("whole", "cells"));
    run(&["merge", "cells", "-o", "back"]).exits(0);
    run(&["diff", "back", "whole"]).exits(0);
    assert_eq!(names(&dir.path().join("back")), ["lanelet2_map.osm", "lanewright.toml"]);
}

#[test]
fn cells_are_not_edited() {
    let dir = place();
    let before = fs::read(dir.path().join(&two_cells(dir.path())[0])).unwrap();
    let words = ["divided into cells", "lanewright merge"];
    lanewright(dir.path(), &["fix", "cells"]).fails_saying(&words);
    lanewright(dir.path(), &["project", "convert", "cells", "--to", "MGRS", "-o", "out"]).fails_saying(&words);
    assert_eq!(fs::read(dir.path().join(&two_cells(dir.path())[0])).unwrap(), before);
}

#[test]
fn cells_that_contradict_each_other_are_no_map() {
    let dir = place();
    let [_, second] = two_cells(dir.path());
    let text = fs::read_to_string(dir.path().join(&second)).unwrap();
    let changed = text.replacen("lat=\"", "lat=\"-", 1);
    assert_ne!(text, changed);
    fs::write(dir.path().join(&second), changed).unwrap();
    for verb in [&["check", "cells"][..], &["stats", "cells"], &["merge", "cells", "-o", "out"]] {
        lanewright(dir.path(), verb).fails_saying(&["contradict each other: node", ".osm:4", "lanewright split"]);
    }
    lanewright(dir.path(), &["split", "cells", "-o", "out"]).fails_saying(&["contradict each other: node"]);
    let cells = names(&dir.path().join("cells/lanelet2_map.osm"));
    let cells: Vec<String> = cells.iter().map(|name| format!("cells/lanelet2_map.osm/{name}")).collect();
    let all: Vec<&str> = ["merge", "-o", "out"].into_iter().chain(cells.iter().map(String::as_str)).collect();
    lanewright(dir.path(), &all).fails_saying(&["other elements with ids", "--renumber"]);
    assert!(!dir.path().join("out").exists());
    lanewright(dir.path(), &[&all[..], &["--renumber"]].concat()).exits(0);
}

#[test]
fn cells_and_their_list_must_go_together() {
    let dir = place();
    let [first, _] = two_cells(dir.path());
    let check = || lanewright(dir.path(), &["check", "cells"]);
    let kept = fs::read(dir.path().join(&first)).unwrap();
    fs::remove_file(dir.path().join(&first)).unwrap();
    check().fails_saying(&["there is no such file", &first.replace("cells/", ""), "bring the missing cells back"]);
    fs::write(dir.path().join(&first), &kept).unwrap();
    fs::write(dir.path().join("cells/lanelet2_map.osm/old.osm"), &kept).unwrap();
    check().fails_saying(&["old.osm is a cell that lanelet2_map_metadata.yaml does not name"]);
    fs::remove_file(dir.path().join("cells/lanelet2_map.osm/old.osm")).unwrap();
    let list = dir.path().join("cells/lanelet2_map_metadata.yaml");
    let text = fs::read_to_string(&list).unwrap();
    for (damage, words) in [
        (text.replace("x_resolution: 25.0\n", ""), "line 1: `x_resolution` is missing"),
        (text.replace("[", "{"), "this is not YAML"),
        (format!("{text}9_9.osm: [9.0, 9.0]\n"), "names 9_9.osm, and there is no such file"),
    ] {
        fs::write(&list, damage).unwrap();
        check().fails_saying(&["lanelet2_map_metadata.yaml", words]);
    }
    // Autoware serves the map as a whole without the list.
    fs::remove_file(&list).unwrap();
    assert_eq!(check().code, 1);
}

#[test]
fn nothing_is_half_written() {
    let dir = place();
    let split = |arguments: &[&str]| lanewright(dir.path(), &[&["split"], arguments].concat());
    split(&["whole", "-o", "cells"]).fails_saying(&["lanelet2_map.osm is there already", "give another output"]);
    split(&["whole", "-o", "whole"]).fails_saying(&["lanelet2_map.osm is there already"]);
    split(&["none", "-o", "out"]).fails_saying(&["cannot read none"]);
    split(&["whole", "-o", "out", "--size", "0"]).fails_saying(&["0 is not in 1"]);
    lanewright(dir.path(), &["merge", "cells", "-o", "whole"]).fails_saying(&["lanelet2_map.osm is there already"]);
    let text = fs::read_to_string(dir.path().join("whole/lanelet2_map.osm")).unwrap();
    fs::write(dir.path().join("cut.osm"), &text[..text.len() / 2]).unwrap();
    split(&["cut.osm", "-o", "out"]).fails_saying(&["cut.osm:"]);
    fs::write(dir.path().join("roads.osm"), "<osm><way id='1'><tag k='highway' v='service'/></way></osm>").unwrap();
    split(&["roads.osm", "-o", "out"]).fails_saying(&["1 roads and no lanelet", "lanewright build"]);
    let node = |id: i64, metres: &str| {
        format!(
            r#"<node id="{id}" lat="" lon=""><tag k="local_x" v="{metres}"/><tag k="local_y" v="{metres}"/></node>"#
        )
    };
    let far = format!(
        r#"<osm>{}{}<way id="3"><nd ref="1"/><nd ref="2"/></way><relation id="2"><tag k="type" v="lanelet"/></relation></osm>"#,
        node(1, "0"),
        node(2, "3e8"),
    );
    fs::write(dir.path().join("far.osm"), far).unwrap();
    split(&["far.osm", "-o", "out"]).fails_saying(&["way 3 reaches over more than a million cells", "--size"]);
    assert_eq!(names(dir.path()), ["cells", "cut.osm", "far.osm", "roads.osm", "whole"]);
}

#[test]
#[cfg(unix)]
fn a_disk_that_is_full_leaves_nothing() {
    let dir = place();
    let program = env!("CARGO_BIN_EXE_lanewright");
    for command in ["split whole -o out", "build SAMPLE -o out --cells 50", "build SAMPLE -o out --tiles 1000"] {
        let sample = root().join("sample_maps/crossing_right.osm");
        let command = command.replace("SAMPLE", sample.to_str().unwrap());
        // No file may grow beyond a few blocks: to write on fails as on a full disk.
        let script = format!("trap '' XFSZ; ulimit -f 2; exec {program} {command}");
        let run = std::process::Command::new("sh").args(["-c", &script]).current_dir(dir.path()).output().unwrap();
        let told = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(2), "{told}");
        assert!(told.contains("cannot write") && told.contains("free space"), "{told}");
        assert_eq!(names(dir.path()), ["cells", "whole"]);
    }
}

#[test]
fn maps_of_different_makes_do_not_become_one_by_mistake() {
    let dir = place();
    fs::create_dir(dir.path().join("other")).unwrap();
    let text = fs::read_to_string(dir.path().join("whole/lanelet2_map.osm")).unwrap();
    fs::write(dir.path().join("other/lanelet2_map.osm"), &text).unwrap();
    fs::write(dir.path().join("other/map_projector_info.yaml"), "projector_type: Local\n").unwrap();
    let merge =
        |arguments: &[&str]| lanewright(dir.path(), &[&["merge", "whole", "other", "-o", "out"], arguments].concat());
    merge(&[]).fails_saying(&["different projections", "project convert"]);
    fs::remove_file(dir.path().join("other/map_projector_info.yaml")).unwrap();
    // The same map twice is that map.
    merge(&[]).exits(0);
    lanewright(dir.path(), &["diff", "whole", "out"]).exits(0);
    fs::remove_dir_all(dir.path().join("out")).unwrap();
    // Another map with the same ids stands beside it.
    fs::write(dir.path().join("other/lanelet2_map.osm"), text.replace("lat=\"35", "lat=\"36")).unwrap();
    merge(&[]).fails_saying(&["other has other elements with ids that a map before it has: node", "--renumber"]);
    merge(&["--renumber"]).exits(0);
    let count = |name: &str| {
        fs::read_to_string(dir.path().join(name).join("lanelet2_map.osm")).unwrap().matches("<relation ").count()
    };
    assert_eq!(count("out"), 2 * count("whole"));
}
