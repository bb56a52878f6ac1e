//! Small inputs that are hard work: each kind in two sizes. Twice the input may take two and a half times the time and memory at most.
//!
//! `make test` takes the verbs that read a kind first, `make soak` (LANEWRIGHT_SOAK=1) all verbs and the steepest kinds, too.
#![cfg(target_os = "linux")]

mod maps;
mod sketch;
mod streets;

use std::fs;
use std::path::Path;
use std::process::Stdio;

use serde_json::Value;

use crate::common::program::{command, lanewright};
use crate::common::soak;
use sketch::Sketch;

/// A kind of small input.
pub struct Kind {
    /// What it is.
    pub name: &'static str,
    /// How many of its parts it has in its smaller size.
    pub size: usize,
    /// Draws it in a size.
    pub draw: fn(&mut Sketch, usize),
}

/// Twice the input may take this many times the time and memory.
const GROWTH: f64 = 2.5;
/// What every run takes, however small its input: seconds of a processor, and bytes. Only what is beyond is compared.
const START: (f64, f64) = (0.3, 40e6);

/// A run that takes more seconds of a processor than this is stopped; it keeps no bound.
const LONGEST: f64 = 120.0;

/// What a run took: seconds of all processors, and bytes at most at one time.
#[derive(Clone, Copy, Debug)]
struct Cost {
    seconds: f64,
    bytes: f64,
}

/// Runs a verb on a file and measures it.
fn cost(dir: &Path, verb: &str, file: &str) -> Cost {
    let copy = dir.join("copy.osm");
    fs::copy(dir.join(file), &copy).unwrap();
    let out = dir.join("out");
    let _ = fs::remove_dir_all(&out);
    let arguments: &[&str] = match verb {
        "build" => &["build", "copy.osm", "-o", "out"],
        "geometry" => &["geometry", "copy.osm", "-o", "streets.geojson"],
        "check" => &["check", "--isolated", "copy.osm", "--report", "report.html"],
        "fix" => &["fix", "--isolated", "copy.osm"],
        "draw" => &["draw", "copy.osm", "-o", "picture.svg"],
        "diff" => &["diff", "copy.osm", "moved.osm"],
        _ => unreachable!("{verb}"),
    };
    if verb == "diff" {
        // Everything a little to the east.
        fs::write(dir.join("moved.osm"), fs::read_to_string(&copy).unwrap().replace("lon=\"8.50", "lon=\"8.51"))
            .unwrap();
    }
    let mut child = command(dir, arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let (status, stat) = (format!("/proc/{}/status", child.id()), format!("/proc/{}/stat", child.id()));
    let mut cost = Cost { seconds: 0.0, bytes: 0.0 };
    let exit = loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let high = text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
        cost.bytes = high.map_or(cost.bytes, |kilobytes: f64| kilobytes * 1024.0);
        cost.seconds = processor_seconds(&stat).unwrap_or(cost.seconds);
        if let Some(exit) = child.try_wait().unwrap() {
            break exit;
        }
        if cost.seconds > LONGEST {
            child.kill().unwrap();
            child.wait().unwrap();
            return cost;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    };
    let code = exit.code();
    assert!(code.is_some_and(|code| (0..=2).contains(&code)), "{verb} of {file} ends with {code:?}");
    cost
}

/// Seconds of a processor that a process has taken, its own and the system's for it.
fn processor_seconds(stat: &str) -> Option<f64> {
    /// The kernel counts in hundredths of a second for programs.
    const TICKS: f64 = 100.0;
    let text = fs::read_to_string(stat).ok()?;
    // The name, in brackets, may hold blanks.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / TICKS)
}

fn write(dir: &Path, kind: &Kind, size: usize, file: &str) {
    let mut sketch = Sketch::default();
    (kind.draw)(&mut sketch, size);
    fs::write(dir.join(file), sketch.text()).unwrap();
}

/// Holds how the cost of a kind grows. Others use the machine, too: what has grown too much is measured again.
fn grows_like_its_input(kinds: &[Kind], verbs: &[&str]) {
    const ROUNDS: usize = 4;
    let dir = tempfile::tempdir().unwrap();
    let mut faults = Vec::new();
    for kind in kinds {
        write(dir.path(), kind, kind.size, "once.osm");
        write(dir.path(), kind, 2 * kind.size, "twice.osm");
        for verb in verbs {
            let (mut once, mut twice) = (cost(dir.path(), verb, "once.osm"), cost(dir.path(), verb, "twice.osm"));
            let fits = |once: Cost, twice: Cost| {
                twice.seconds <= GROWTH * once.seconds.max(START.0) && twice.bytes <= GROWTH * once.bytes.max(START.1)
            };
            for _ in 0..ROUNDS {
                if fits(once, twice) {
                    break;
                }
                let more = [cost(dir.path(), verb, "once.osm"), cost(dir.path(), verb, "twice.osm")];
                // Whatever disturbs a run makes it take longer.
                twice = Cost { seconds: twice.seconds.min(more[1].seconds), bytes: twice.bytes.min(more[1].bytes) };
                once = Cost { seconds: once.seconds.max(more[0].seconds), ..once };
            }
            println!("{:32} {verb:9} {:6}: {once:?}, {twice:?}", kind.name, kind.size);
            if !fits(once, twice) {
                faults.push(format!("{verb} of {} x {}: {once:?}, twice as many: {twice:?}", kind.size, kind.name));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn streets_take_time_and_memory_in_proportion() {
    grows_like_its_input(streets::KINDS, if soak() { &["build", "geometry"] } else { &["build"] });
}

#[test]
fn maps_take_time_and_memory_in_proportion() {
    let verbs: &[&str] = if soak() { &["check", "fix", "draw", "diff"] } else { &["check"] };
    grows_like_its_input(maps::KINDS, verbs);
}

/// Kinds whose cost grows faster than their input have bounds in one size at least, which these tests hold without optimisation.
#[test]
fn steep_kinds_stay_within_bounds() {
    /// Seconds of a processor, and bytes; the program as it is released takes a quarter of the time.
    const MOST: (f64, f64) = (60.0, 1e9);
    let dir = tempfile::tempdir().unwrap();
    // Some of them take half a minute.
    let (streets, mended) = if soak() { (streets::STEEP, maps::STEEP) } else { (&[][..], &[][..]) };
    for (kinds, verb) in [(streets, "build"), (maps::STEEP, "check"), (mended, "fix")] {
        for kind in kinds {
            write(dir.path(), kind, kind.size, "steep.osm");
            let cost = cost(dir.path(), verb, "steep.osm");
            println!("{:32} {verb:9} {:6}: {cost:?}", kind.name, kind.size);
            assert!(cost.seconds < MOST.0 && cost.bytes < MOST.1, "{verb} of {} x {}: {cost:?}", kind.size, kind.name);
        }
    }
}

/// Files of one megabyte, as somebody would send who wants to do harm. `LANEWRIGHT_KINDS=star,comb` takes these kinds alone.
#[test]
fn a_megabyte_of_every_kind_stays_within_bounds() {
    /// Seconds of a processor, and bytes; the program as it is released takes a quarter of the time, and 10 s are promised.
    const MOST: (f64, f64) = (40.0, 1e9);
    const MEGABYTE: u64 = 1_000_000;
    if !soak() {
        return;
    }
    let only = std::env::var("LANEWRIGHT_KINDS").ok();
    let is_asked = |kind: &Kind| only.as_ref().is_none_or(|names| names.split(',').any(|name| name == kind.name));
    let dir = tempfile::tempdir().unwrap();
    let mut faults = Vec::new();
    for (kinds, verbs) in [
        ([streets::KINDS, streets::STEEP], &["build", "geometry"][..]),
        ([maps::KINDS, maps::STEEP], &["check", "fix", "draw", "diff"][..]),
    ] {
        for kind in kinds.into_iter().flatten().filter(|kind| is_asked(kind)) {
            let mut size = kind.size;
            let length = |size: usize| {
                write(dir.path(), kind, size, "megabyte.osm");
                fs::metadata(dir.path().join("megabyte.osm")).unwrap().len()
            };
            let mut bytes = length(size);
            // Some kinds grow with the square of their size, and one, a number in a tag, hardly at all.
            while bytes < MEGABYTE * 9 / 10 && size < MEGABYTE as usize {
                size = (size * 11 / 10).max((size as u64 * MEGABYTE / bytes).isqrt() as usize).max(size + 1);
                bytes = length(size);
            }
            for verb in verbs {
                let cost = cost(dir.path(), verb, "megabyte.osm");
                let is_kept = cost.seconds < MOST.0 && cost.bytes < MOST.1;
                let (seconds, megabytes) = (cost.seconds, cost.bytes / 1e6);
                let mark = if is_kept { "" } else { "  TOO MUCH" };
                println!("{:32} {verb:9} {size:6}: {seconds:6.1} s, {megabytes:5.0} MB{mark}", kind.name);
                if !is_kept {
                    faults.push(format!("{verb} of {size} x {}: {cost:?}", kind.name));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Draws a kind into a file.
fn drawn(kinds: [&[Kind]; 2], name: &str, size: usize) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let kind = kinds.into_iter().flatten().find(|kind| kind.name == name).unwrap();
    write(dir.path(), kind, size, "map.osm");
    dir
}

#[test]
fn shapes_without_area_are_told_one_by_one() {
    let dir = drawn([maps::KINDS, maps::STEEP], "no area", 1);
    let run = lanewright(dir.path(), &["check", "--isolated", "--format", "json", "map.osm"]).exits(1);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    let text = fs::read_to_string(dir.path().join("map.osm")).unwrap();
    let shapes = text.lines().filter(|line| line.contains("v=\"lanelet\"") || line.contains("k=\"area\""));
    let ids: Vec<i64> = shapes.map(|line| line.split('"').nth(1).unwrap().parse().unwrap()).collect();
    assert_eq!(ids.len(), 5, "two lanelets and three areas");
    let told = |id: &i64| {
        let findings = report["findings"].as_array().unwrap();
        findings.iter().any(|one| one["primitive"]["id"] == *id && one["severity"] != "info")
    };
    for id in &ids {
        assert!(told(id), "nothing is said of {id}: {}", run.stdout);
    }
    lanewright(dir.path(), &["draw", "map.osm", "-o", "picture.svg"]).exits(0);
    lanewright(dir.path(), &["fix", "--isolated", "map.osm"]).exits(1);
}

#[test]
fn a_file_for_every_square_metre_is_refused() {
    let dir = drawn([maps::KINDS, maps::STEEP], "areas over lanelets", 1);
    let text = fs::read_to_string(dir.path().join("map.osm")).unwrap();
    // The area is 60 m wide; here it is a hundred times as wide as it is high.
    fs::write(
        dir.path().join("map.osm"),
        text.replace("lon=\"8.500", "lon=\"8.520").replace("lon=\"8.499", "lon=\"8.480"),
    )
    .unwrap();
    let run = lanewright(dir.path(), &["split", "--size", "1", "map.osm", "-o", "cells"]);
    run.fails_saying(&["would hold no node", "give a larger --size"]);
    assert!(!dir.path().join("cells").exists());
    lanewright(dir.path(), &["split", "--size", "100", "map.osm", "-o", "cells"]).exits(0);
}

#[test]
fn what_is_too_many_to_compare_is_said() {
    let dir = drawn([maps::KINDS, maps::STEEP], "one over the other", 50);
    let run = lanewright(dir.path(), &["check", "--isolated", "--format", "concise", "map.osm"]).exits(0);
    let many = run.stdout.lines().filter(|line| line.contains("too many to compare; the first 30 were")).count();
    assert_eq!(many, 19, "the first 19 of 50 lie on more than 30 behind them: {}", run.stdout);
    let dir = drawn([maps::KINDS, maps::STEEP], "nearly joined", 40);
    let run = lanewright(dir.path(), &["check", "--isolated", "--format", "concise", "map.osm"]).exits(1);
    assert!(run.stdout.contains("40 nodes lie so close to each other: too many to compare"), "{}", run.stdout);
    let dir = drawn([maps::KINDS, maps::STEEP], "nodes at one place", 40);
    let same_place = ["check", "--isolated", "--select", "parts/same-place", "--format", "concise", "map.osm"];
    let run = lanewright(dir.path(), &same_place).exits(0);
    assert_eq!(run.stdout.matches("parts/same-place").count(), 1, "one finding tells for all: {}", run.stdout);
    assert!(run.stdout.contains("80 nodes lie so close to each other: too many to compare"), "{}", run.stdout);
    let dir = drawn([streets::KINDS, streets::STEEP], "star", 24);
    let run = lanewright(dir.path(), &["build", "map.osm", "-o", "again"]).exits(0);
    let said = format!("{}{}", run.stdout, run.stderr);
    assert!(said.contains("24 roads meet at node 1: too many"), "{said}");
    for (kind, size, way) in [("tangle", 60, "crosses itself"), ("crossing without nodes", 40, "crosses others")] {
        let dir = drawn([streets::KINDS, streets::STEEP], kind, size);
        let run = lanewright(dir.path(), &["build", "map.osm", "-o", "again"]).exits(0);
        let said = format!("{}{}", run.stdout, run.stderr);
        assert!(said.contains(way) && said.contains("too many for a road; it is not cut there"), "{said}");
    }
    let dir = drawn([streets::KINDS, streets::STEEP], "comb", 60);
    let run = lanewright(dir.path(), &["build", "map.osm", "-o", "again"]).exits(0);
    let said = format!("{}{}", run.stdout, run.stderr);
    assert!(said.contains("too close to each other to be laid out to the end"), "{said}");
    for (kind, size, words) in [
        ("two hubs", 100, "too many ways: on a square of 50 m there are"),
        ("rings in rings", 300, "too much to lay side by side"),
        ("web", 30, "ends of ways that meet others, and 40 are built"),
        ("stars", 20, "too many to draw; the straightest"),
    ] {
        let dir = drawn([streets::KINDS, streets::STEEP], kind, size);
        let run = lanewright(dir.path(), &["build", "map.osm", "-o", "again"]).exits(0);
        let said = format!("{}{}", run.stdout, run.stderr);
        assert!(said.contains(words), "{kind}: {said}");
    }
    let dir = drawn([maps::KINDS, maps::STEEP], "many into many", 40);
    let run = lanewright(dir.path(), &["check", "--isolated", "--format", "concise", "map.osm"]).exits(0);
    assert_eq!(
        run.stdout.matches("80 lines meet at its end or start: too many to compare").count(),
        1,
        "{}",
        run.stdout
    );
    let dir = drawn([maps::KINDS, maps::STEEP], "heap", 250);
    let run = lanewright(dir.path(), &["check", "--isolated", "--format", "concise", "map.osm"]).exits(1);
    assert!(run.stdout.contains("too many for an area that a machine draws"), "{}", run.stdout);
}

/// What would be no number once it is squared is none at all.
#[test]
fn numbers_beyond_the_earth_are_none() {
    let dir = tempfile::tempdir().unwrap();
    let map = |lat: &str, ele: &str| {
        let node =
            |id: i64| format!("<node id=\"{id}\" lat=\"{lat}\" lon=\"1e3{id}\"><tag k=\"ele\" v=\"{ele}\"/></node>");
        let nodes: String = (1..5).map(node).collect();
        let ways = [(10, 1, 2), (11, 3, 4)]
            .map(|(id, a, b)| format!("<way id=\"{id}\"><nd ref=\"{a}\"/><nd ref=\"{b}\"/></way>"));
        let members = "<member type=\"way\" role=\"left\" ref=\"10\"/><member type=\"way\" role=\"right\" ref=\"11\"/>";
        let tags = "<tag k=\"type\" v=\"lanelet\"/><tag k=\"subtype\" v=\"road\"/>";
        format!("<osm version=\"0.6\">{nodes}{}<relation id=\"20\">{members}{tags}</relation></osm>", ways.concat())
    };
    for (at, (lat, ele)) in
        [("1e308", "1e308"), ("-1e300", "-1e308"), ("NaN", "inf"), ("90", "1")].into_iter().enumerate()
    {
        fs::write(dir.path().join("a.osm"), map(lat, ele)).unwrap();
        fs::write(dir.path().join("b.osm"), map("1e200", "0").replace("1e3", "-1e30")).unwrap();
        for arguments in [
            &["check", "--isolated", "a.osm"][..],
            &["diff", "a.osm", "b.osm"],
            &["draw", "a.osm", "-o", "a.svg"],
            &["fix", "--isolated", "a.osm", "--diff"],
            &["stats", "a.osm"],
        ] {
            let run = lanewright(dir.path(), arguments);
            let said = format!("{}{}", run.stdout, run.stderr);
            assert!(!said.contains("broke") && !said.contains("panicked"), "{at}: {arguments:?}: {said}");
        }
        let said = lanewright(dir.path(), &["check", "--isolated", "a.osm", "--format", "concise"]).exits(1).stdout;
        assert!(ele == "1" || said.contains("node/"), "{said}");
    }
}
