//! `build --keep`: a town is built from newer data and keeps what people have changed in it.

use std::fs;
use std::path::Path;
use std::process::Command;

use lanewright::osm::{ElementKind, OsmData, Relation, read_file};

use crate::common::program::{Run, lanewright};
use crate::common::{names, root};

/// A directory with the extract of a town, a newer one, and the map of the old one in `town`.
fn place() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let old = fs::read_to_string(root().join("sample_maps/staggered_left.osm")).unwrap();
    // One road is slower now, another one longer.
    let changes = [("v=\"30 mph\"", "v=\"20 mph\""), ("lat=\"52.3048509\"", "lat=\"52.3047509\"")];
    let new = changes.iter().fold(old.clone(), |text, (old, new)| text.replacen(old, new, 1));
    assert!(changes.iter().all(|(one, _)| old.contains(one)));
    fs::write(dir.path().join("old.osm"), &old).unwrap();
    fs::write(dir.path().join("new.osm"), &new).unwrap();
    lanewright(dir.path(), &["build", "old.osm", "-o", "town", "-q"]).exits(0);
    dir
}

fn map(dir: &Path, name: &str) -> OsmData {
    read_file(&dir.join(name).join("lanelet2_map.osm")).unwrap()
}

/// What a person changes in a map: a lanelet may be crossed by nobody, a regulatory element is taken out.
fn change(dir: &Path, name: &str) {
    let map = map(dir, name);
    let kind = |one: &&Relation, kind: &str| one.tags.is("type", kind);
    let lanelet = map.relations.iter().find(|one| kind(one, "lanelet")).unwrap();
    let element = map.relations.iter().rfind(|one| kind(one, "regulatory_element")).unwrap();
    let mut text = map.sources[0].text.clone();
    let place = |one: &Relation| one.span.start as usize..one.span.end as usize;
    // From the end, so that what is before keeps its place.
    let mut edits = [
        (place(element), String::new()),
        (
            place(lanelet),
            text[place(lanelet)].replace("</relation>", "  <tag k=\"note\" v=\"by hand\"/>\n  </relation>"),
        ),
    ];
    edits.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
    for (place, new) in edits {
        text.replace_range(place, &new);
    }
    let reference = format!("    <member type=\"relation\" ref=\"{}\" role=\"regulatory_element\"/>\n", element.id);
    assert!(text.contains(&reference), "{reference}");
    fs::write(dir.join(name).join("lanelet2_map.osm"), text.replace(&reference, "")).unwrap();
    let settings = dir.join(name).join("lanewright.toml");
    let text = fs::read_to_string(&settings).unwrap();
    fs::write(&settings, text.replacen("driving_side", "ignore = [\"vm-01-02\"]\ndriving_side", 1)).unwrap();
}

/// Holds that a map is the newer build with what the person changed.
#[track_caller]
fn is_new_with_changes(dir: &Path, name: &str) {
    let reference = tempfile::tempdir_in(dir).unwrap();
    let wanted = reference.path().to_str().unwrap().to_owned();
    lanewright(dir, &["build", "new.osm", "-o", &wanted, "-q"]).exits(0);
    change(dir, &wanted);
    let told = lanewright(dir, &["diff", name, &wanted]);
    assert_eq!(told.code, 0, "{}", told.stdout);
    let settings = fs::read_to_string(dir.join(name).join("lanewright.toml")).unwrap();
    assert!(settings.contains("ignore = [\"vm-01-02\"]"), "{settings}");
    assert!(settings.starts_with("# What OpenStreetMap told"), "{settings}");
}

#[test]
fn without_the_old_build_it_says_what_to_give_and_with_it_both_are_there() {
    let dir = place();
    change(dir.path(), "town");
    let run = |arguments: &[&str]| {
        lanewright(dir.path(), &[&["build", "new.osm", "--keep", "town", "-o"], arguments].concat())
    };
    let before = fs::read(dir.path().join("town/lanelet2_map.osm")).unwrap();
    run(&["town"]).fails_saying(&["the build that town was made from is not found", "--base"]);
    run(&["town", "--base", "new.osm"]).fails_saying(&["new.osm is not the build that town was made from"]);
    assert_eq!(fs::read(dir.path().join("town/lanelet2_map.osm")).unwrap(), before);
    // What it was built from is as good as the build.
    let told = run(&["other", "--base", "old.osm"]).exits(0).stdout;
    assert!(told.contains("kept from town; the old build: old.osm\n") && !told.contains("conflict"), "{told}");
    is_new_with_changes(dir.path(), "other");
    lanewright(dir.path(), &["build", "old.osm", "-o", "build", "-q"]).exits(0);
    run(&["town", "--base", "build"]).exits(0);
    is_new_with_changes(dir.path(), "town");
    let all = ["lanelet2_map.built.gz", "lanelet2_map.osm", "lanewright.toml", "map_projector_info.yaml"];
    assert_eq!(names(&dir.path().join("town")), all);
    // Another build would write over what people have changed.
    lanewright(dir.path(), &["build", "new.osm", "-o", "town"])
        .fails_saying(&["hand-made, or was changed since", "--keep"]);
    // The next one knows what it was built from; nothing has changed since.
    let kept = fs::read(dir.path().join("town/lanelet2_map.osm")).unwrap();
    let told = run(&["town"]).exits(0).stdout;
    assert!(
        told.contains("the old build: town/lanelet2_map.built.gz\n") && told.contains("nothing to merge"),
        "{told}"
    );
    assert_eq!(fs::read(dir.path().join("town/lanelet2_map.osm")).unwrap(), kept);
    // Back to what it was.
    lanewright(dir.path(), &["build", "old.osm", "--keep", "town", "-o", "town"]).exits(0);
    assert_eq!(fs::read(dir.path().join("town/lanelet2_map.osm")).unwrap(), before);
}

#[test]
fn the_old_build_is_found_in_the_history_of_the_repository() {
    let dir = place();
    let git = |arguments: &[&str]| {
        let mut command = Command::new("git");
        command.arg("-C").arg(dir.path()).args(["-c", "user.name=A", "-c", "user.email=a@example.org"]).args(arguments);
        command.env("GIT_CONFIG_GLOBAL", "/dev/null").env("GIT_CONFIG_NOSYSTEM", "1");
        Run::from(command.output().unwrap()).exits(0).stdout
    };
    git(&["init", "-q"]);
    git(&["add", "."]);
    git(&["commit", "-qm", "Built"]);
    let commit = git(&["log", "--format=%h"]);
    change(dir.path(), "town");
    git(&["commit", "-qam", "By hand"]);
    let told = lanewright(dir.path(), &["build", "new.osm", "--keep", "town", "-o", "town"]).exits(0).stdout;
    assert!(told.contains(&format!("the old build: commit {commit}")), "{told}");
    is_new_with_changes(dir.path(), "town");
}

#[test]
fn what_a_person_changed_and_took_out_stays_so_and_is_told() {
    let dir = place();
    let before = map(dir.path(), "town");
    lanewright(dir.path(), &["build", "new.osm", "-o", "new", "-q"]).exits(0);
    let after = map(dir.path(), "new");
    let speed = |map: &OsmData, id: i64| Some(map.relation(id)?.tags.get("speed_limit")?.to_owned());
    let is_referred_to = |id: i64| before.relations.iter().any(|one| one.members.iter().any(|member| member.id == id));
    let slower: Vec<&Relation> =
        before.relations.iter().filter(|one| speed(&before, one.id) != speed(&after, one.id)).collect();
    let gone = slower.iter().find(|one| !is_referred_to(one.id)).unwrap();
    let faster = slower.iter().find(|one| one.id != gone.id).unwrap();
    let [old, new] = [&before, &after].map(|map| speed(map, faster.id).unwrap());
    let text = &before.sources[0].text;
    let part = |one: &Relation| &text[one.span.start as usize..one.span.end as usize];
    let value = |speed: &str| format!("k=\"speed_limit\" v=\"{speed}\"");
    let edited = text.replace(part(gone), "").replace(part(faster), &part(faster).replace(&value(&old), &value("60")));
    fs::write(dir.path().join("town/lanelet2_map.osm"), edited).unwrap();
    let arguments = ["build", "new.osm", "--keep", "town", "-o", "town", "--base", "old.osm"];
    let told = lanewright(dir.path(), &arguments).exits(1).stdout;
    for words in [
        format!("conflict: lanelet {}: tag speed_limit (at ", faster.id),
        format!("ours    60  <- in the result\n  theirs  {new}\n"),
        format!("conflict: lanelet {}: deletion (at ", gone.id),
        "ours    (not there)  <- in the result\n  theirs  changed\n".to_owned(),
        "2 conflicts; ".to_owned(),
    ] {
        assert!(told.contains(&words), "{words}:\n{told}");
    }
    let town = map(dir.path(), "town");
    assert_eq!(speed(&town, faster.id).as_deref(), Some("60"));
    assert!(!town.contains(ElementKind::Relation, gone.id));
}

#[test]
fn a_map_that_was_not_built_is_not_kept() {
    let dir = place();
    fs::create_dir(dir.path().join("hand")).unwrap();
    fs::copy(dir.path().join("town/lanelet2_map.osm"), dir.path().join("hand/lanelet2_map.osm")).unwrap();
    lanewright(dir.path(), &["build", "new.osm", "--keep", "hand", "-o", "out"])
        .fails_saying(&["was not written by `build`", "--base"]);
    lanewright(dir.path(), &["build", "new.osm", "--keep", "town", "-o", "out", "--cells", "100"]).exits(2);
    assert!(!dir.path().join("out").exists());
}
