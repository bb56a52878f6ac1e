//! Small files that unpack to large ones, and files that never end: refused with a way out before they fill the memory.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

use crate::common::program::command;
use crate::common::root;
use crate::pbf_fields::{field, number};

/// What no refused input may take, bytes.
const MOST: u64 = 500_000_000;
/// Unpacked size of the bombs, bytes.
const BOMB: u64 = 300_000_000;

struct Refused {
    code: i32,
    said: String,
    peak: u64,
}

/// Runs the program and watches how much memory it takes.
fn run(dir: &Path, arguments: &[&str]) -> Refused {
    let mut child = command(dir, arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    let exit = loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let high =
            text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        peak = peak.max(high.unwrap_or(0) << 10);
        if let Some(exit) = child.try_wait().unwrap() {
            break exit;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    Refused { code: exit.code().unwrap(), said, peak }
}

#[track_caller]
fn refuses(dir: &Path, arguments: &[&str], words: &[&str]) {
    let Refused { code, said, peak } = run(dir, arguments);
    println!("{arguments:?}: {} MB, {said}", peak / 1_000_000);
    assert_eq!(code, 2, "{arguments:?}: {said}");
    for word in words {
        assert!(said.contains(word), "{arguments:?}: `{word}` is not said: {said}");
    }
    assert!(peak < MOST, "{arguments:?} took {peak} bytes");
}

/// A packed text: a head, then so many bytes of a filling.
fn bomb(file: &Path, head: &str, filling: &[u8], tail: &str) {
    let mut out = GzEncoder::new(File::create(file).unwrap(), Compression::fast());
    out.write_all(head.as_bytes()).unwrap();
    let many = filling.repeat((1 << 20) / filling.len());
    for _ in 0..BOMB as usize / many.len() {
        out.write_all(&many).unwrap();
    }
    out.write_all(tail.as_bytes()).unwrap();
    out.finish().unwrap();
    assert!(file.metadata().unwrap().len() < 10_000_000);
}

const LONG: &[&str] = &["no node, way or relation begins within 64 MB", "damaged, or made to fill the memory"];

/// What is said of a packed file that is larger unpacked than any map.
const UNPACKED: &[&str] = &["takes more than", "--max-input SIZE allows more"];

#[test]
fn blanks_are_refused_by_every_verb() {
    let dir = tempfile::tempdir().unwrap();
    bomb(&dir.path().join("blanks.osm.gz"), "<osm>\n", b" ", "</osm>\n");
    fs::copy(root().join("tests/rules/vm-03-02/good.osm"), dir.path().join("good.osm")).unwrap();
    for arguments in [
        &["check", "blanks.osm.gz"][..],
        &["fix", "blanks.osm.gz", "--diff"],
        &["build", "blanks.osm.gz", "-o", "out"],
        &["geometry", "blanks.osm.gz", "-o", "out.geojson"],
        &["draw", "blanks.osm.gz", "-o", "out.svg"],
        &["stats", "blanks.osm.gz"],
        &["diff", "good.osm", "blanks.osm.gz"],
        &["project", "infer", "blanks.osm.gz"],
        &["merge", "blanks.osm.gz", "-o", "whole"],
    ] {
        refuses(dir.path(), arguments, UNPACKED);
        refuses(dir.path(), &[&["--max-input", "4GB"], arguments].concat(), LONG);
    }
    // Passed through block by block.
    refuses(dir.path(), &["split", "blanks.osm.gz", "-o", "cells"], &["blanks.osm.gz"]);
    assert!(["out", "out.geojson", "out.svg", "whole", "cells"].iter().all(|name| !dir.path().join(name).exists()));
}

#[test]
fn an_element_that_does_not_end_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("map.osm.gz");
    for (head, filling) in [
        ("", &b" "[..]),
        ("<osm><node id=\"1\" lat=\"", b"1"),
        ("<osm><way id=\"1\"><nd ref=\"1\"/>", b"<nd ref=\"1\"/>"),
        ("<osm><node id=\"1\"><tag k=\"a\" v=\"", b"&amp;"),
        ("<osm><!--", b"-"),
    ] {
        bomb(&file, head, filling, "</osm>\n");
        refuses(dir.path(), &["--max-input", "4GB", "check", "map.osm.gz"], LONG);
        refuses(dir.path(), &["--max-input", "4GB", "build", "map.osm.gz", "-o", "out"], LONG);
    }
    // Not packed: zeros that take no room on the disk.
    File::create(dir.path().join("map.osm")).unwrap().set_len(BOMB).unwrap();
    refuses(dir.path(), &["check", "map.osm"], LONG);
    refuses(dir.path(), &["check", "/dev/zero"], LONG);
}

#[test]
fn more_than_max_input_is_refused_with_a_way_out() {
    let dir = tempfile::tempdir().unwrap();
    bomb(&dir.path().join("map.osm.gz"), "<osm>", b"<node id=\"1\" lat=\"1\" lon=\"1\"/>\n", "</osm>\n");
    let words = &["map.osm.gz takes more than 100 MB in memory", "--max-input SIZE allows more", "lanewright split"];
    refuses(dir.path(), &["check", "map.osm.gz", "--max-input", "100MB"], words);
    refuses(
        dir.path(),
        &["--max-input", "1e8", "check", "map.osm.gz"],
        &["`1e8` is no number of bytes", "500MB or 20GB"],
    );
    // A file that is not packed, and files that are too large only together.
    let good = root().join("tests/rules/vm-03-02/good.osm");
    let size = good.metadata().unwrap().len();
    let (one, two) = ((size + 10).to_string(), (2 * size + 10).to_string());
    fs::create_dir(dir.path().join("maps")).unwrap();
    for name in ["maps/1.osm", "maps/2.osm"] {
        fs::copy(&good, dir.path().join(name)).unwrap();
    }
    refuses(dir.path(), &["check", "maps/1.osm", "--max-input", "1kB"], &["takes more than 1 kB", "--max-input"]);
    refuses(dir.path(), &["check", "maps", "--max-input", &one], &["2.osm takes more", "--max-input"]);
    assert_ne!(run(dir.path(), &["check", "maps", "--max-input", &two]).code, 2);
    assert_eq!(run(dir.path(), &["check", "maps/1.osm", "--max-input", &one]).code, 0);
}

/// A blob that says it has so many bytes, packed, and its header, which says so many.
fn blob(kind: &str, content: impl Read, unpacked: u64, stored: Option<u64>) -> Vec<u8> {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::fast());
    io::copy(&mut { content }, &mut packed).unwrap();
    let body = [number(2, unpacked), field(3, &packed.finish().unwrap())].concat();
    let header = [field(1, kind.as_bytes()), number(3, stored.unwrap_or(body.len() as u64))].concat();
    [&(header.len() as u32).to_be_bytes()[..], &header, &body].concat()
}

/// Nodes at one place, each with the same tag of a megabyte.
fn heavy_block() -> Vec<u8> {
    let count = 100_000;
    let value = vec![b'v'; 1 << 20];
    let strings = [field(1, b""), field(1, b"name"), field(1, &value)].concat();
    let ones: Vec<u8> = (0..count).flat_map(|_| [2]).collect();
    let zeros = vec![0; count];
    let tags: Vec<u8> = (0..count).flat_map(|_| [1, 2, 0]).collect();
    let dense = [field(1, &ones), field(8, &zeros), field(9, &zeros), field(10, &tags)].concat();
    [field(1, &strings), field(2, &field(2, &dense))].concat()
}

#[test]
fn pbf_that_lies_about_its_size_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let head = blob("OSMHeader", &field(4, b"OsmSchema-V0.6")[..], 16, None);
    let heavy = heavy_block();
    let blanks = || io::repeat(b' ').take(BOMB);
    for (name, block) in [
        ("blanks", blob("OSMData", blanks(), 100, None)),
        ("honest", blob("OSMData", blanks(), BOMB, None)),
        ("stored", blob("OSMData", blanks(), 100, Some(2_000_000_000))),
        ("heavy", blob("OSMData", &heavy[..], heavy.len() as u64, None).repeat(8)),
    ] {
        let file = format!("{name}.osm.pbf");
        fs::write(dir.path().join(&file), [head.clone(), block].concat()).unwrap();
        refuses(dir.path(), &["build", &file, "-o", "out"], &[&file, "not a usable PBF file"]);
    }
    let many = [head, blob("OSMData", &block_of_nodes()[..], 100, None).repeat(40)].concat();
    fs::write(dir.path().join("many.osm.pbf"), many).unwrap();
    let words = &["many.osm.pbf takes more than 100 MB in memory", "--max-input"];
    refuses(dir.path(), &["build", "many.osm.pbf", "-o", "out", "--max-input", "100MB"], words);
}

/// Many nodes at one place.
fn block_of_nodes() -> Vec<u8> {
    let count = 100_000;
    let zeros = vec![0; count];
    let dense = [field(1, &vec![2; count]), field(8, &zeros), field(9, &zeros)].concat();
    [field(1, &field(1, b"")), field(2, &field(2, &dense))].concat()
}
