//! A team's story: two clones of a git repository with one map, edits of both, and what git makes of them with the merge driver.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lanewright::osm::{ElementKind, OsmData, Relation, read_file};

use crate::common::program::{Run, command, lanewright};
use crate::common::root;

const MAP: &str = "town/lanelet2_map.osm";

/// Runs git in a directory, of nobody's configuration.
fn git(dir: &Path, arguments: &[&str]) -> Run {
    let mut command = Command::new("git");
    for (name, value) in [("NAME", "A. Person"), ("EMAIL", "person@example.org")] {
        command.env(format!("GIT_AUTHOR_{name}"), value).env(format!("GIT_COMMITTER_{name}"), value);
    }
    command.env("GIT_CONFIG_GLOBAL", "/dev/null").env("GIT_CONFIG_NOSYSTEM", "1");
    command.arg("-C").arg(dir).args(["-c", "init.defaultBranch=main", "-c", "core.autocrlf=false"]).args(arguments);
    command.output().unwrap().into()
}

/// A repository with a built town of two intersections, and two clones that are set up.
struct Team {
    dir: tempfile::TempDir,
}

impl Team {
    fn new() -> Self {
        let team = Self { dir: tempfile::tempdir().unwrap() };
        let origin = team.path("origin");
        fs::create_dir(&origin).unwrap();
        git(&origin, &["init", "-q"]).exits(0);
        let sample = root().join("sample_maps/staggered_left.osm");
        lanewright(&origin, &["build", sample.to_str().unwrap(), "-o", "town", "-q"]).exits(0);
        let told = lanewright(&origin, &["git-setup"]).exits(0).stdout;
        assert_eq!(told.lines().filter(|line| line.starts_with("added ")).count(), 6, "{told}");
        git(&origin, &["add", "."]).exits(0);
        git(&origin, &["commit", "-qm", "The town"]).exits(0);
        git(&origin, &["config", "receive.denyCurrentBranch", "updateInstead"]).exits(0);
        for clone in ["anna", "ben"] {
            git(team.dir.path(), &["clone", "-q", "origin", clone]).exits(0);
            lanewright(&team.path(clone), &["git-setup", "-q"]).exits(0);
        }
        team
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn map(&self, clone: &str) -> OsmData {
        read_file(&self.path(clone).join(MAP)).unwrap()
    }

    fn text(&self, clone: &str) -> String {
        fs::read_to_string(self.path(clone).join(MAP)).unwrap()
    }

    /// The lanelets of each intersection, by the id of its area.
    fn intersections(&self) -> Vec<Vec<Relation>> {
        let map = self.map("origin");
        let area = |one: &Relation| one.tags.get("intersection_area").map(str::to_owned);
        let mut areas: Vec<String> = map.relations.iter().filter_map(area).collect();
        areas.sort_unstable();
        areas.dedup();
        let lanelets =
            |id: &String| map.relations.iter().filter(|one| area(one).as_ref() == Some(id)).cloned().collect();
        areas.iter().map(lanelets).collect()
    }

    /// Gives a lanelet another speed.
    fn set_speed(&self, clone: &str, lanelet: i64, speed: &str) {
        self.edit(clone, (ElementKind::Relation, lanelet), |element| {
            let (before, rest) = element.split_once("k=\"speed_limit\" v=\"").unwrap();
            format!("{before}k=\"speed_limit\" v=\"{speed}\"{}", rest.split_once('"').unwrap().1)
        });
    }

    /// Moves the middle vertex of a lanelet's left bound by a centimetre, and inserts one behind it.
    fn redraw(&self, clone: &str, lanelet: &Relation, new_id: i64) {
        let map = self.map(clone);
        let way = map.way(lanelet.members.iter().find(|one| one.role == "left").unwrap().id).unwrap().clone();
        let at = way.nodes.len() / 2;
        let [node, next] = [at - 1, at].map(|at| map.node(way.nodes[at]).unwrap().clone());
        let places = [&node, &next].map(|one| one.position.unwrap());
        let written = |degrees: f64| format!("{degrees:.11}");
        let moved = written(places[0].lat + 1e-7);
        self.edit(clone, (ElementKind::Node, node.id), |text| text.replacen(&written(places[0].lat), &moved, 1));
        let middle = [(places[0].lat + places[1].lat) / 2.0, (places[0].lon + places[1].lon) / 2.0].map(written);
        let [lat, lon] = &middle;
        let new = format!(
            "<node id=\"{new_id}\" version=\"1\" lat=\"{lat}\" lon=\"{lon}\">\n    <tag k=\"ele\" v=\"0.0\"/>\n  </node>\n  "
        );
        let first = map.nodes[0].id;
        self.edit(clone, (ElementKind::Node, first), |text| format!("{new}{text}"));
        let vertex = format!("<nd ref=\"{}\"/>", next.id);
        let with_new = format!("<nd ref=\"{new_id}\"/>\n    {vertex}");
        self.edit(clone, (ElementKind::Way, way.id), |text| text.replacen(&vertex, &with_new, 1));
    }

    fn edit(&self, clone: &str, (kind, id): (ElementKind, i64), change: impl Fn(&str) -> String) {
        let map = self.map(clone);
        let span = match kind {
            ElementKind::Node => &map.node(id).unwrap().span,
            ElementKind::Way => &map.way(id).unwrap().span,
            ElementKind::Relation => &map.relation(id).unwrap().span,
        };
        let mut text = self.text(clone);
        let place = span.start as usize..span.end as usize;
        let changed = change(&text[place.clone()]);
        assert_ne!(changed, text[place.clone()]);
        text.replace_range(place, &changed);
        fs::write(self.path(clone).join(MAP), text).unwrap();
    }

    fn commit(&self, clone: &str, message: &str) {
        git(&self.path(clone), &["commit", "-qam", message]).exits(0);
    }

    /// What is found in the map of a clone, without places.
    fn findings(&self, clone: &str) -> Vec<String> {
        let told = lanewright(&self.path(clone), &["check", "town", "--format", "concise"]).stdout;
        let mut found: Vec<String> =
            told.lines().filter_map(|line| Some(line.split_once(": ")?.1.to_owned())).collect();
        found.sort_unstable();
        found
    }
}

#[test]
fn two_clones_edit_different_intersections_and_one_common_tag() {
    let team = Team::new();
    let before = team.findings("origin");
    let intersections = team.intersections();
    let [first, second] = &intersections[..] else { panic!("{} intersections", intersections.len()) };
    let common = team.map("origin").relations.iter().find(|one| one.tags.is("type", "lanelet")).unwrap().id;
    // Both give their new vertex the same id.
    team.redraw("anna", &first[0], 4_000_000_001);
    team.set_speed("anna", common, "30");
    team.commit("anna", "The first intersection");
    team.redraw("ben", &second[0], 4_000_000_001);
    team.set_speed("ben", second[1].id, "20");
    team.set_speed("ben", common, "25");
    team.commit("ben", "The second intersection");
    git(&team.path("anna"), &["push", "-q"]).exits(0);

    let pulled = git(&team.path("ben"), &["pull", "--no-rebase", "--no-edit"]).exits(1);
    let told = pulled.stdout;
    assert_eq!(told.matches("conflict: ").count(), 1, "{told}");
    let page = told.lines().find_map(|line| line.strip_prefix("to look at: ")).unwrap();
    let page = fs::read_to_string(team.path("ben").join(page)).unwrap();
    assert!(page.contains("rule-merge"));
    for words in [
        format!("conflict: lanelet {common}: tag speed_limit (at "),
        "ours    25  <- in the result".to_owned(),
        "theirs  30\n".to_owned(),
        "point 4000000001 of theirs is 4000000002 now".to_owned(),
    ] {
        assert!(told.contains(&words), "{words}:\n{told}");
    }
    assert_eq!(git(&team.path("ben"), &["status", "--short"]).stdout, format!("UU {MAP}\n"));
    let map = team.map("ben");
    for (id, lanelet) in [(4_000_000_001, &second[0]), (4_000_000_002, &first[0])] {
        let left = lanelet.members.iter().find(|one| one.role == "left").unwrap().id;
        assert!(map.way(left).unwrap().nodes.contains(&id));
    }
    assert_eq!(map.relation(second[1].id).unwrap().tags.get("speed_limit"), Some("20"));
    // They settle it, and the map is as clean as before.
    team.set_speed("ben", common, "30");
    git(&team.path("ben"), &["commit", "-qam", "Together"]).exits(0);
    assert_eq!(team.findings("ben"), before);
    git(&team.path("ben"), &["push", "-q"]).exits(0);
    // Anna has nothing to merge.
    git(&team.path("anna"), &["pull", "-q"]).exits(0);
    assert_eq!(team.text("anna"), team.text("ben"));
}

#[test]
fn edits_that_go_together_are_merged_by_git_alone() {
    let team = Team::new();
    let intersections = team.intersections();
    let [anna, ben] = [0, 1].map(|at| intersections[at][0].id);
    team.set_speed("anna", anna, "30");
    team.commit("anna", "Slower");
    git(&team.path("anna"), &["push", "-q"]).exits(0);
    // Ben has the file formatted anew, with carriage returns: no line is as it was.
    team.set_speed("ben", ben, "20");
    fs::write(team.path("ben").join(MAP), team.text("ben").replace('\n', "\r\n")).unwrap();
    team.commit("ben", "Slower there");
    for arguments in
        [&["pull", "--no-rebase", "--no-edit"][..], &["reset", "-q", "--hard", "HEAD~1"], &["pull", "--rebase"]]
    {
        git(&team.path("ben"), arguments).exits(0);
    }
    let map = team.map("ben");
    let speeds = [anna, ben].map(|id| map.relation(id).unwrap().tags.get("speed_limit").map(str::to_owned));
    assert_eq!(speeds, [Some("30".to_owned()), Some("20".to_owned())]);
}

#[test]
fn git_shows_what_changed_by_meaning() {
    let team = Team::new();
    let lanelet = team.intersections()[0][0].id;
    team.set_speed("anna", lanelet, "30");
    let diff = git(&team.path("anna"), &["diff", "-U0"]).exits(0).stdout;
    let changed: Vec<&str> = diff.lines().filter(|line| line.starts_with(['+', '-', '@'])).skip(2).collect();
    let [place, old, new] = changed[..] else { panic!("{diff}") };
    assert!(place.ends_with(&format!("@@ lanelet {lanelet}")), "{diff}");
    assert!(old.starts_with("-  speed_limit = ") && new == "+  speed_limit = 30", "{diff}");
    // Another order of the file is no change.
    fs::write(team.path("ben").join(MAP), lanewright::fix::canonical(&team.text("ben")).unwrap()).unwrap();
    assert_eq!(
        git(&team.path("ben"), &["diff"]).exits(0).stdout.lines().filter(|line| line.starts_with(['+', '-'])).count(),
        0
    );
}

#[test]
fn setting_up_twice_changes_nothing_and_a_dry_run_nothing_at_all() {
    let dir = tempfile::tempdir().unwrap();
    lanewright(dir.path(), &["git-setup"]).fails_saying(&["git rev-parse --show-toplevel failed", "git init"]);
    git(dir.path(), &["init", "-q"]).exits(0);
    fs::write(dir.path().join(".gitattributes"), "*.png binary").unwrap();
    let told = lanewright(dir.path(), &["git-setup", "--dry-run"]).exits(0).stdout;
    assert_eq!(told.matches("to add ").count(), 6, "{told}");
    let attributes = || fs::read_to_string(dir.path().join(".gitattributes")).unwrap();
    assert_eq!(attributes(), "*.png binary");
    assert_eq!(git(dir.path(), &["config", "merge.lanewright.driver"]).code, 1);
    lanewright(dir.path(), &["git-setup", "--maps", "maps/**/*.osm"]).exits(0);
    let written = "*.png binary\nmaps/**/*.osm merge=lanewright diff=lanewright\nlanewright.toml merge=lanewright\n";
    assert_eq!(attributes(), written);
    fs::create_dir(dir.path().join("maps")).unwrap();
    let again = lanewright(&dir.path().join("maps"), &["git-setup", "--maps", "maps/**/*.osm"]).exits(0).stdout;
    assert_eq!(again.matches("known ").count(), 6, "{again}");
    assert_eq!(attributes(), written);
    lanewright(dir.path(), &["git-setup", "--maps", "a b"]).fails_saying(&["no pattern of .gitattributes"]);
    let told = lanewright(dir.path(), &["git-setup", "--no-check", "--dry-run"]).exits(0).stdout;
    assert!(
        told.contains("to add  git config      merge.lanewright.driver = ") && told.contains(" --no-check\n"),
        "{told}"
    );
    // A program that is not found by its name is called by its path.
    let driver = git(dir.path(), &["config", "merge.lanewright.driver"]).stdout;
    assert!(driver.contains(" merge --base %O %A %B -o %A --path %P"), "{driver}");
    let mut elsewhere = command(dir.path(), &["git-setup"]);
    elsewhere.env("PATH", "");
    let without: Run = elsewhere.output().unwrap().into();
    without.fails_saying(&["git cannot be run", "install git"]);
}
