//! What the program does with files that are somebody's: owners, rights, links, marks and concurrent edits stay what they are.
#![cfg(unix)]

use std::fs::{self, File, Permissions};
use std::io::{Read, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use tempfile::TempDir;

use crate::common::program::{Run, command, lanewright};
use crate::common::{names, root};

/// Nobody, on every system that tests run on.
const NOBODY: u32 = 65534;

/// A directory with a map that `fix` and `fmt` change.
struct Place {
    dir: TempDir,
    bad: String,
    /// Who runs the program: the user of the tests, or, where that is root, somebody else.
    user: Option<u32>,
}

/// A map with one tag that `fix` sets right, built once.
fn bad_map() -> String {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_right.osm");
    lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", "map"]).exits(0);
    let good = fs::read_to_string(dir.path().join("map/lanelet2_map.osm")).unwrap();
    let bad = good.replacen("v=\"left\"", "v=\"right\"", 1).replace("\n    ", "\n\t");
    assert_ne!(good, bad);
    bad
}

/// As the user of the tests, and as a plain one.
fn as_each_user(test: impl Fn(&Place)) {
    let bad = bad_map();
    let is_root = fs::metadata("/proc/self").map_or_else(|_| false, |about| about.uid() == 0);
    for user in [None].into_iter().chain(is_root.then_some(Some(NOBODY))) {
        let dir = tempfile::tempdir().unwrap();
        fs::set_permissions(dir.path(), Permissions::from_mode(0o755)).unwrap();
        let place = Place { dir, bad: bad.clone(), user };
        place.owned(place.dir.path());
        fs::write(place.map(), &place.bad).unwrap();
        place.owned(&place.map());
        test(&place);
    }
}

impl Place {
    fn map(&self) -> PathBuf {
        self.dir.path().join("a.osm")
    }

    fn owned(&self, path: &Path) {
        if let Some(user) = self.user {
            chown(path, Some(user), Some(user)).unwrap();
        }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = command(self.dir.path(), arguments);
        if let Some(user) = self.user {
            command.uid(user).gid(user);
        }
        command
    }

    fn run(&self, arguments: &[&str]) -> Run {
        self.command(arguments).output().unwrap().into()
    }

    /// Holds that the map was mended, or formatted.
    fn is_changed(&self, file: &Path) {
        assert_ne!(fs::read_to_string(file).unwrap(), self.bad, "{} is as it was", file.display());
    }

    fn is_as_it_was(&self, file: &Path) {
        assert!(fs::read_to_string(file).unwrap() == self.bad, "{} was changed", file.display());
    }
}

const CHANGING: [&[&str]; 2] = [&["fix", "a.osm", "--unsafe"], &["fmt", "a.osm"]];

#[test]
fn rights_and_owners_are_kept() {
    as_each_user(|place| {
        for (mode, arguments) in [0o600, 0o640, 0o664].into_iter().flat_map(|mode| CHANGING.map(|verb| (mode, verb))) {
            fs::write(place.map(), &place.bad).unwrap();
            fs::set_permissions(place.map(), Permissions::from_mode(mode)).unwrap();
            let before = fs::metadata(place.map()).unwrap();
            place.run(arguments);
            place.is_changed(&place.map());
            let after = fs::metadata(place.map()).unwrap();
            assert_eq!(after.mode() & 0o7777, mode, "{arguments:?}");
            assert_eq!((after.uid(), after.gid()), (before.uid(), before.gid()), "{arguments:?}");
            assert_eq!(names(place.dir.path()), ["a.osm"]);
        }
        // Root mends somebody's file.
        if place.user.is_none() && chown(place.map(), Some(NOBODY), Some(NOBODY)).is_ok() {
            fs::write(place.map(), &place.bad).unwrap();
            place.run(CHANGING[0]);
            place.is_changed(&place.map());
            assert_eq!(fs::metadata(place.map()).unwrap().uid(), NOBODY);
        }
    });
}

#[test]
fn somebody_else_s_file_that_may_be_written_stays_theirs() {
    as_each_user(|place| {
        let Some(user) = place.user else { return };
        // In a directory where nothing can be made.
        chown(place.dir.path(), Some(0), Some(0)).unwrap();
        chown(place.map(), Some(0), Some(user)).unwrap();
        fs::set_permissions(place.map(), Permissions::from_mode(0o664)).unwrap();
        for arguments in CHANGING {
            fs::write(place.map(), &place.bad).unwrap();
            place.run(arguments);
            place.is_changed(&place.map());
            let after = fs::metadata(place.map()).unwrap();
            assert_eq!((after.uid(), after.gid(), after.mode() & 0o777), (0, user, 0o664));
        }
        // And what cannot be made there is told.
        place.run(&["check", "a.osm", "--report", "page.html"]).exits(2);
    });
}

#[test]
fn links_are_kept() {
    as_each_user(|place| {
        let at = |name: &str| place.dir.path().join(name);
        fs::create_dir(at("deep")).unwrap();
        place.owned(&at("deep"));
        fs::rename(place.map(), at("deep/real.osm")).unwrap();
        symlink("deep/real.osm", at("link.osm")).unwrap();
        symlink("link.osm", place.map()).unwrap();
        for arguments in CHANGING {
            fs::write(at("deep/real.osm"), &place.bad).unwrap();
            place.run(arguments);
            assert!(fs::symlink_metadata(place.map()).unwrap().is_symlink(), "{arguments:?}");
            place.is_changed(&at("deep/real.osm"));
            assert_eq!(names(&at("deep")), ["real.osm"]);
        }
        // Other names of the same file.
        fs::remove_file(place.map()).unwrap();
        fs::hard_link(at("deep/real.osm"), place.map()).unwrap();
        for arguments in CHANGING {
            fs::write(place.map(), &place.bad).unwrap();
            place.run(arguments);
            place.is_changed(&at("deep/real.osm"));
            assert_eq!(fs::metadata(place.map()).unwrap().nlink(), 2, "{arguments:?}");
            assert_eq!(names(place.dir.path()), ["a.osm", "deep", "link.osm"]);
        }
    });
}

#[test]
fn a_write_protected_file_is_refused_with_a_way_out() {
    as_each_user(|place| {
        fs::set_permissions(place.map(), Permissions::from_mode(0o444)).unwrap();
        for arguments in CHANGING {
            place.run(arguments).fails_saying(&["a.osm is write-protected", "chmod u+w"]);
            place.is_as_it_was(&place.map());
            assert_eq!(names(place.dir.path()), ["a.osm"]);
        }
    });
}

#[test]
#[cfg(target_os = "linux")]
fn extended_attributes_are_kept() {
    let place = Place { dir: tempfile::tempdir().unwrap(), bad: bad_map(), user: None };
    fs::write(place.map(), &place.bad).unwrap();
    if rustix::fs::setxattr(place.map(), "user.note", b"surveyed", rustix::fs::XattrFlags::empty()).is_err() {
        // This file system has none.
        return;
    }
    place.run(CHANGING[0]);
    place.is_changed(&place.map());
    let mut value = [0; 8];
    assert_eq!(rustix::fs::getxattr(place.map(), "user.note", &mut value[..]), Ok(8));
    assert_eq!(&value, b"surveyed");
}

#[test]
fn a_byte_order_mark_is_kept_and_shown() {
    as_each_user(|place| {
        for arguments in CHANGING {
            fs::write(place.map(), format!("\u{feff}{}", place.bad)).unwrap();
            place.run(arguments);
            let now = fs::read_to_string(place.map()).unwrap();
            assert!(now.starts_with("\u{feff}<?xml"), "{arguments:?}");
            assert!(!now.trim_start_matches('\u{feff}').starts_with(&place.bad));
        }
        place.run(&["fmt", "a.osm", "--check"]).exits(0);
    });
    // A patch of the first lines has it, so that it fits the file.
    let dir = tempfile::tempdir().unwrap();
    let good = fs::read_to_string(root().join("tests/rules/vm-03-02/good.osm")).unwrap();
    let bad = good.lines().filter(|line| !line.contains("<MetaInfo")).collect::<Vec<_>>().join("\n");
    fs::write(dir.path().join("a.osm"), format!("\u{feff}{bad}\n")).unwrap();
    let diff = lanewright(dir.path(), &["fix", "a.osm", "--unsafe", "--diff"]).stdout;
    if diff.contains("@@ -1,") {
        assert!(diff.contains(" \u{feff}<?xml") || diff.contains(" \\u{feff}<?xml"), "{diff}");
    }
}

#[test]
fn a_save_while_the_program_runs_is_not_written_over() {
    as_each_user(|place| {
        for arguments in CHANGING {
            let saved = place.bad.replacen("generator=", "upload=\"never\" generator=", 1);
            assert_ne!(saved, place.bad);
            let mut seen = [false; 2];
            for milliseconds in [1, 2, 5, 10, 20, 40, 80, 160, 320] {
                fs::write(place.map(), &place.bad).unwrap();
                let mut running =
                    place.command(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
                std::thread::sleep(Duration::from_millis(milliseconds));
                // As editors do: under another name first.
                fs::write(place.dir.path().join("saved"), &saved).unwrap();
                place.owned(&place.dir.path().join("saved"));
                fs::rename(place.dir.path().join("saved"), place.map()).unwrap();
                let mut said = String::new();
                running.stderr.take().unwrap().read_to_string(&mut said).unwrap();
                let code = running.wait().unwrap().code();
                let now = fs::read_to_string(place.map()).unwrap();
                // Read before the save and told; or read after it, or done before it.
                let refused = said.contains("was changed by somebody else");
                assert_eq!(refused, code == Some(2), "{said}");
                assert!(now.contains("upload=\"never\""), "{arguments:?}: the save after {milliseconds} ms is lost");
                seen[usize::from(refused)] = true;
            }
            assert!(seen[1], "{arguments:?}: no save came between reading and writing");
        }
    });
}

#[test]
fn two_runs_at_once_lose_nothing() {
    as_each_user(|place| {
        for _ in 0..4 {
            fs::write(place.map(), &place.bad).unwrap();
            let runs = CHANGING.map(|arguments| {
                place.command(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
            });
            let [fix, fmt] = runs.map(|run| Run::from(run.wait_with_output().unwrap()));
            let now = fs::read_to_string(place.map()).unwrap();
            let lost = |run: &Run| run.code == 2 && run.stderr.contains("was changed by somebody else");
            let (mended, formatted) = (!lost(&fix), !lost(&fmt));
            assert!(mended || formatted, "{}{}", fix.stderr, fmt.stderr);
            // What a run says that it did is there.
            assert!(!formatted || !now.contains("\n\t<nd") || mended, "formatted, and is not");
            if mended {
                assert_eq!(place.run(&["fix", "a.osm", "--unsafe", "--diff"]).stdout, "", "mended, and is not");
            }
            if formatted && !mended {
                place.run(&["fmt", "a.osm", "--check"]).exits(0);
            }
            assert_eq!(names(place.dir.path()), ["a.osm"]);
        }
    });
}

#[test]
fn what_is_no_file_is_written_into() {
    as_each_user(|place| {
        let report = |to: &str| place.run(&["check", "a.osm", "--report", to]);
        report("/dev/null").exits(1);
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        symlink("/dev/null", place.dir.path().join("nothing")).unwrap();
        report("nothing").exits(1);
        assert!(fs::symlink_metadata(place.dir.path().join("nothing")).unwrap().is_symlink());
        let pipe = place.dir.path().join("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        place.owned(&pipe);
        for arguments in [
            &["check", "a.osm", "--report", "pipe"][..],
            &["check", "a.osm", "--write-baseline", "pipe"],
            &["draw", "a.osm", "-o", "pipe"],
        ] {
            let from = pipe.clone();
            let reader = std::thread::spawn(move || fs::read(from).unwrap());
            let run = place.run(arguments);
            if arguments[0] == "draw" {
                // A name without an ending says no format; whoever waits must not wait for ever.
                run.exits(2);
                File::options().write(true).open(&pipe).unwrap().write_all(b"end").unwrap();
            }
            assert!(!reader.join().unwrap().is_empty(), "{arguments:?}");
            assert!(!fs::metadata(&pipe).unwrap().is_file(), "{arguments:?}: the fifo is gone");
        }
    });
}

#[test]
fn an_output_goes_to_standard_output() {
    as_each_user(|place| {
        fs::copy(root().join("sample_maps/tjunction_left.osm"), place.dir.path().join("t.osm")).unwrap();
        for out in ["-", "/dev/stdout", "/dev/fd/1"] {
            let streets = place.run(&["geometry", "t.osm", "-o", out]).exits(0);
            serde_json::from_str::<serde_json::Value>(&streets.stdout).unwrap();
            assert!(streets.stderr.contains("roads"), "{}", streets.stderr);
            let page = place.run(&["check", "a.osm", "--report", out]).exits(1);
            assert!(page.stdout.starts_with("<!") && page.stdout.trim_end().ends_with("</html>"), "{}", page.stdout);
            let picture = place.run(&["draw", "a.osm", "-o", out]).exits(0);
            assert!(picture.stdout.starts_with("<svg") && picture.stdout.trim_end().ends_with("</svg>"));
            let known = place.run(&["check", "a.osm", "--write-baseline", out]).exits(0);
            serde_json::from_str::<serde_json::Value>(&known.stdout).unwrap();
        }
        // Also where a shell has put a file there.
        let file = File::create(place.dir.path().join("out")).unwrap();
        place.owned(&place.dir.path().join("out"));
        let code = place.command(&["geometry", "t.osm", "-o", "/dev/stdout"]).stdout(file).status().unwrap();
        assert!(code.success());
        let text = fs::read_to_string(place.dir.path().join("out")).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap();
    });
}

#[test]
fn a_hand_made_map_is_not_built_over() {
    let dir = tempfile::tempdir().unwrap();
    let sample = root().join("sample_maps/crossing_left.osm");
    let build =
        |more: &[&str]| lanewright(dir.path(), &[&["build", sample.to_str().unwrap(), "-o", "map"], more].concat());
    let convert = |more: &[&str]| {
        lanewright(dir.path(), &[&["project", "convert", "map", "--to", "MGRS", "-o", "out"], more].concat())
    };
    let map = dir.path().join("map/lanelet2_map.osm");
    fs::create_dir(dir.path().join("map")).unwrap();
    fs::write(&map, "by hand").unwrap();
    build(&[]).fails_saying(&["map/lanelet2_map.osm was not written so by lanewright", "--force"]);
    assert_eq!(fs::read_to_string(&map).unwrap(), "by hand");
    build(&["--force"]).exits(0);
    let built = fs::read_to_string(&map).unwrap();
    // Its own is built anew.
    build(&[]).exits(0);
    fs::write(&map, built.replace("<MetaInfo", "<!-- mine --><MetaInfo")).unwrap();
    build(&[]).fails_saying(&["changed since", "--force"]);
    convert(&[]).exits(0);
    convert(&[]).exits(0);
    let out = dir.path().join("out/lanelet2_map.osm");
    fs::write(&out, &built).unwrap();
    convert(&[]).fails_saying(&["out/lanelet2_map.osm", "--force"]);
    assert_eq!(fs::read_to_string(&out).unwrap(), built);
    convert(&["--force"]).exits(0);
    lanewright(dir.path(), &["check", "out"]).exits(0);
    // What is read is not written over by itself either, and settings stay.
    lanewright(dir.path(), &["project", "convert", "map", "--to", "MGRS", "-o", "map"]).fails_saying(&["--force"]);
    assert!(fs::read_to_string(dir.path().join("out/lanewright.toml")).unwrap().contains("# Written with it: "));
}

#[test]
fn a_killed_build_is_completed_or_has_not_begun() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let samples = ["crossing_right", "tjunction_left"].map(|name| root().join(format!("sample_maps/{name}.osm")));
    let mut whole = Vec::new();
    for (i, sample) in samples.iter().enumerate() {
        let name = format!("whole{i}");
        lanewright(dir.path(), &["build", sample.to_str().unwrap(), "-o", &name]).exits(0);
        whole.push(contents(&at(&name)));
    }
    for microseconds in (0..30).map(|round| 7_000 + round * 3_400) {
        lanewright(dir.path(), &["build", samples[0].to_str().unwrap(), "-o", "map", "--force"]).exits(0);
        let mut run = command(dir.path(), &["build", samples[1].to_str().unwrap(), "-o", "map"]);
        let mut running = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_micros(microseconds));
        running.kill().unwrap();
        running.wait().unwrap();
        lanewright(dir.path(), &["check", "map"]).exits(0);
        let now = contents(&at("map"));
        assert!(whole.contains(&now), "after {microseconds} µs: {:?}", now.iter().map(|(n, _)| n).collect::<Vec<_>>());
        // A draft that was left goes with the next run.
        lanewright(dir.path(), &["build", samples[0].to_str().unwrap(), "-o", "map", "--force"]).exits(0);
        assert_eq!(names(&at("map")), ["lanelet2_map.osm", "lanewright.toml", "map_projector_info.yaml"]);
    }
}

/// The files of a directory but for drafts.
fn contents(dir: &Path) -> Vec<(String, Vec<u8>)> {
    let names = names(dir).into_iter().filter(|name| !name.starts_with(".lanewright-draft-"));
    names.map(|name| (name.clone(), fs::read(dir.join(name)).unwrap())).collect()
}

#[test]
fn a_mark_from_elsewhere_moves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let mark = dir.path().join(".lanewright-writing");
    fs::create_dir(&mark).unwrap();
    fs::write(dir.path().join("a.osm"), "mine").unwrap();
    fs::write(mark.join("a.osm"), "theirs").unwrap();
    for (name, new) in [("a.osm", 7), ("../a.osm", 7), ("a.osm", fs::metadata(mark.join("a.osm")).unwrap().ino())] {
        let plan = serde_json::json!([{ "name": name, "copy": false, "new": new, "old": [1, 2, 3] }]);
        fs::write(mark.join(".plan.json"), plan.to_string()).unwrap();
        lanewright(dir.path(), &["check", "a.osm"]).fails_saying(&[".lanewright-writing", "remove the folder"]);
        assert_eq!(fs::read_to_string(dir.path().join("a.osm")).unwrap(), "mine");
    }
}

#[test]
fn what_fmt_cannot_keep_it_refuses_with_the_line() {
    let dir = tempfile::tempdir().unwrap();
    let good = fs::read_to_string(root().join("tests/rules/vm-03-02/good.osm")).unwrap();
    let head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    let changed = |old: &str, new: &str| {
        let text = good.replacen(old, new, 1);
        assert_ne!(text, good, "{old}");
        text
    };
    for (text, words) in [
        (changed(head, &format!("{head}<!DOCTYPE osm>\n")), &["<!DOCTYPE", "a.osm:2:1"][..]),
        (changed(head, &format!("{head}<!DOCTYPE osm [<!ENTITY lane \"road\">]>\n")), &["<!DOCTYPE", "a.osm:2:1"]),
        (changed("v=\"10\"/>", "v=\"10\">ten</tag>"), &["text between elements", "a.osm:4:"]),
    ] {
        fs::write(dir.path().join("a.osm"), &text).unwrap();
        for arguments in [&["fmt", "a.osm"][..], &["fmt", "a.osm", "--check"]] {
            lanewright(dir.path(), arguments).fails_saying(words);
            assert_eq!(fs::read_to_string(dir.path().join("a.osm")).unwrap(), text);
        }
    }
    // An entity that nobody defines: told with its line, by whoever reads it first.
    fs::write(dir.path().join("a.osm"), changed("v=\"10\"", "v=\"&ten;\"")).unwrap();
    lanewright(dir.path(), &["fmt", "a.osm"]).fails_saying(&["a.osm:4:"]);
}
