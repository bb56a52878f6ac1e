//! `lanewright view` as browsers and other programs on the machine request it.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;

use serde_json::Value;

use crate::common::drawing::Drawing;
use crate::common::program::{Server, lanewright};
use crate::common::root;

/// A directory with a bad map from `tests/rules`.
fn place() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::copy(root().join("tests/rules/vm-03-08/bad-lane-node-missing.osm"), dir.path().join("map.osm")).unwrap();
    dir
}

#[test]
fn only_pages_of_its_own_are_answered() {
    let dir = place();
    let server = Server::start(dir.path(), &["map.osm"]);
    let (host, port) = (server.host(), server.port);
    let (status, head, page) = server.ask("GET /", &host, "");
    assert_eq!(status, 200);
    assert!(head.contains("text/html") && !head.to_lowercase().contains("access-control"), "{head}");
    assert!(String::from_utf8(page).unwrap().contains("connect-src 'self' http://127.0.0.1:8111;"));
    let (status, head, data) = server.ask("GET /data", &format!("Host: localhost:{port}\r\n"), "");
    assert!(status == 200 && head.contains("Lanewright-Version: ") && data.len() > 1000, "{head}");
    // A name that an attacker lets point here, another port, no name at all; a page of somebody else.
    for headers in [
        "Host: evil.example\r\n".to_owned(),
        format!("Host: evil.example:{port}\r\n"),
        "Host: 127.0.0.1:1\r\n".to_owned(),
        String::new(),
        format!("{host}Origin: http://evil.example\r\n"),
        format!("{host}Origin: null\r\n"),
    ] {
        let (status, _, body) = server.ask("GET /data", &headers, "");
        assert_eq!((status, body.as_slice()), (403, b"only for pages of this server".as_slice()), "{headers}");
    }
    assert_eq!(server.ask("GET /data", &format!("{host}Origin: http://127.0.0.1:{port}\r\n"), "").0, 200);
    assert_eq!(server.ask("GET /../map.osm", &host, "").0, 404);
    assert_eq!(server.ask("POST /nothing", &host, "{}").0, 404);
    assert_eq!(server.ask("PUT /data", &host, "{}").0, 404);
}

#[test]
fn ctrl_c_ends_it_cleanly() {
    let dir = place();
    let mut server = Server::start(dir.path(), &["map.osm"]);
    // Somebody waits for news that will never come.
    let mut stream = TcpStream::connect(("127.0.0.1", server.port)).unwrap();
    write!(stream, "GET /changes?after=2 HTTP/1.1\r\n{}\r\n", server.host()).unwrap();
    let told = Command::new("kill").args(["-INT", &server.child.id().to_string()]).status().unwrap();
    assert!(told.success());
    assert_eq!(server.child.wait().unwrap().code(), Some(0));
}

#[test]
fn what_cannot_be_served_is_an_error_at_once() {
    let dir = place();
    lanewright(dir.path(), &["view", "no.osm"]).fails_saying(&["no.osm"]);
    let server = Server::start(dir.path(), &["map.osm"]);
    let port = server.port.to_string();
    lanewright(dir.path(), &["view", "map.osm", "--port", &port]).fails_saying(&["cannot listen", &port]);
}

/// The data that a page of `view --build` fetches, decoded.
pub fn unpacked(parcel: &[u8]) -> Value {
    let length = u32::from_le_bytes(parcel[..4].try_into().unwrap()) as usize;
    let mut text = String::new();
    flate2::read::DeflateDecoder::new(&parcel[4..4 + length]).read_to_string(&mut text).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// A directory with OpenStreetMap data to build from.
fn streets() -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let input = fs::read_to_string(root().join("sample_maps/staggered_left.osm")).unwrap();
    fs::write(dir.path().join("in.osm"), &input).unwrap();
    (dir, input)
}

#[test]
fn saved_edits_build_what_was_shown() {
    let (dir, input) = streets();
    let server = Server::start(dir.path(), &["--build", "in.osm"]);
    let host = server.host();
    let (_, _, first) = server.ask("GET /data", &host, "");
    let before = unpacked(&first);
    let id = before["workshop"]["ways"][0]["id"].as_str().unwrap();
    // In the midst, so that the saved input has the same extent, and the page the same origin.
    let node = "1";
    let place = input.split(&format!("id=\"{node}\"")).nth(1).unwrap();
    let degrees = |name: &str| -> f64 {
        place.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    let ends = &before["workshop"]["roads"][0]["ends"];
    let edits = serde_json::json!({ "edits": [
        { "edit": "move", "node": node, "lat": degrees("lat") + 0.000_1, "lon": degrees("lon") - 0.000_05 },
        { "edit": "tag", "way": id, "key": "width", "value": "8 & <more>" },
        { "edit": "tag", "way": id, "key": "lanes", "value": "4" },
        { "edit": "tag", "way": id, "key": "name", "value": null },
        { "edit": "merge", "nodes": ends, "merge": false },
    ] });
    let (status, _, built) = server.ask("POST /build", &host, &edits.to_string());
    assert_eq!(status, 200);
    let shown = unpacked(&built);
    assert!(shown["workshop"]["stages"] != before["workshop"]["stages"]);
    let (_, head, saved) = server.ask("POST /save/osm", &host, &edits.to_string());
    assert!(head.contains("Lanewright-Name: in_edited.osm"), "{head}");
    let (_, _, toml) = server.ask("POST /save/toml", &host, &edits.to_string());
    assert_eq!(fs::read_to_string(dir.path().join("in.osm")).unwrap(), input, "the input is not written to");

    // Elsewhere, with the settings beside it, the saved input gives the same stages.
    let there = tempfile::tempdir().unwrap();
    fs::write(there.path().join("in.osm"), &saved).unwrap();
    fs::write(there.path().join("said.toml"), &toml).unwrap();
    let again = Server::start(there.path(), &["--build", "in.osm", "--config", "said.toml"]);
    let again = unpacked(&again.ask("GET /data", &again.host(), "").2);
    for part in ["stages", "nodes", "ways"] {
        assert!(again["workshop"][part] == shown["workshop"][part], "{part} differ");
    }
    // Nothing else in the text changed.
    let (old, new): (Vec<&str>, String) = (input.lines().collect(), String::from_utf8(saved).unwrap());
    let new: Vec<&str> = new.lines().collect();
    let kept = old.iter().filter(|line| new.contains(line)).count();
    assert!(kept + 4 >= old.len(), "{} of {} lines are left", kept, old.len());
}

/// Five long roads across 330 short ones, 18 m apart: they meet 1,650 times, more densely than in any city.
#[test]
fn of_few_long_roads_only_those_around_the_place_are_built() {
    let mut drawing = Drawing::default();
    let id = |row: i64, column: i64| 1 + 1000 * row + column;
    for (row, column) in (0..5).flat_map(|row| (0..330).map(move |column| (row, column))) {
        drawing.node(id(row, column), [48.0 + 0.000_162 * row as f64, 11.0 + 0.000_242 * column as f64], "");
    }
    for row in 0..5 {
        let nodes: Vec<i64> = (0..330).map(|column| id(row, column)).collect();
        drawing.way(10_000 + row, &nodes, "highway=residential");
    }
    for column in 0..330 {
        let nodes: Vec<i64> = (0..5).map(|row| id(row, column)).collect();
        drawing.way(20_000 + column, &nodes, "highway=residential");
    }
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("in.osm"), drawing.xml()).unwrap();
    let server = Server::start(dir.path(), &["--build", "in.osm"]);
    let first = unpacked(&server.ask("GET /data", &server.host(), "").2);
    let ways = first["workshop"]["ways"].as_array().unwrap().len();
    // The long ones, and those within 300 m to either side.
    assert!((35..=41).contains(&ways), "{ways} ways");
}

#[test]
fn an_invalid_edit_is_refused_with_a_reason() {
    let (dir, _) = streets();
    let server = Server::start(dir.path(), &["--build", "in.osm"]);
    for (body, word) in [
        ("", "no list of edits"),
        (r#"{"edits":[{"edit":"move","node":"1","lat":95,"lon":0}]}"#, "cannot go to"),
        (r#"{"path":"/etc/passwd"}"#, "no list of edits"),
    ] {
        let (status, head, answer) = server.ask("POST /build", &server.host(), body);
        let answer = String::from_utf8(answer).unwrap();
        assert!(status == 200 && head.contains("text/plain") && answer.contains(word), "{head}\n{answer}");
    }
    let evil = format!("{}Origin: http://evil.example\r\n", server.host());
    assert_eq!(server.ask("POST /build", &evil, "{}").0, 403);
    fs::write(
        dir.path().join("map.osm"),
        fs::read(root().join("tests/rules/vm-03-08/bad-lane-node-missing.osm")).unwrap(),
    )
    .unwrap();
    lanewright(dir.path(), &["view", "--build", "map.osm"]).fails_saying(&["Lanelet2 map already"]);
    lanewright(dir.path(), &["view", "--build", "no.osm"]).fails_saying(&["no.osm"]);
}

/// The answer to raw bytes, as far as there is one.
fn said_to(server: &Server, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", server.port)).unwrap();
    // Who is refused in the midst may not take all of it.
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn a_request_has_bounds() {
    let dir = place();
    let server = Server::start(dir.path(), &["map.osm"]);
    let host = server.host();
    let endless = format!("GET / HTTP/1.1\r\n{host}X: {}", "x".repeat(50_000_000));
    assert!(said_to(&server, endless.as_bytes()).starts_with("HTTP/1.1 431 "));
    let lines = format!("GET / HTTP/1.1\r\n{host}{}\r\n", "X: x\r\n".repeat(500));
    assert!(said_to(&server, lines.as_bytes()).starts_with("HTTP/1.1 431 "));
    for (head, status) in [
        ("Content-Length: 99999999\r\n", 413),
        ("Content-Length: -1\r\n", 400),
        ("Content-Length: 1\r\nContent-Length: 2\r\n", 400),
        ("Transfer-Encoding: chunked\r\n", 400),
    ] {
        let answer = said_to(&server, format!("POST /build HTTP/1.1\r\n{host}{head}\r\n").as_bytes());
        assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{head}: {answer}");
    }
    assert!(said_to(&server, b"\x16\x03\x01\x02 no request\r\n\r\n").starts_with("HTTP/1.1 400 "));
    assert_eq!(server.ask("GET /", &host, "").0, 200);
}

/// Connections that say nothing, more than the process may have files open, and half of what a request is.
#[test]
fn connections_that_say_nothing_do_not_end_it() {
    let dir = place();
    let server = Server::start(dir.path(), &["map.osm"]);
    let silent: Vec<TcpStream> = (0..300).filter_map(|_| TcpStream::connect(("127.0.0.1", server.port)).ok()).collect();
    let mut slow = TcpStream::connect(("127.0.0.1", server.port)).unwrap();
    let _ = slow.write_all(b"GET / HTTP/1.1\r\n");
    assert!(silent.len() > 100);
    let open = fs::read_dir(format!("/proc/{}/fd", server.child.id())).map_or(0, Iterator::count);
    assert!(open < 150, "{open} files are open");
    drop(silent);
    assert_eq!(answered(&server), 200);
    // Those who keep silence lose their places.
    let silent: Vec<TcpStream> = (0..64).filter_map(|_| TcpStream::connect(("127.0.0.1", server.port)).ok()).collect();
    std::thread::sleep(std::time::Duration::from_secs(11));
    assert_eq!(answered(&server), 200);
    drop(silent);
}

/// Without any descriptor left, it waits until there is one.
#[test]
#[cfg(target_os = "linux")]
fn without_descriptors_it_waits() {
    let dir = place();
    let server = Server::start(dir.path(), &["map.osm"]);
    let limit = |files: u32| {
        let pid = server.child.id().to_string();
        let set = Command::new("prlimit").args(["--pid", &pid, &format!("--nofile={files}:4096")]).status();
        set.is_ok_and(|status| status.success())
    };
    let open = fs::read_dir(format!("/proc/{}/fd", server.child.id())).unwrap().count() as u32;
    if !limit(open) {
        // Where prlimit is missing, the other test has to do.
        return;
    }
    let waiting: Vec<TcpStream> = (0..10).filter_map(|_| TcpStream::connect(("127.0.0.1", server.port)).ok()).collect();
    std::thread::sleep(std::time::Duration::from_millis(300));
    drop(waiting);
    assert!(limit(1024));
    assert_eq!(answered(&server), 200);
}

/// The status of the page, once there is a place for who asks.
fn answered(server: &Server) -> u16 {
    for _ in 0..100 {
        let answer = said_to(server, format!("GET / HTTP/1.1\r\n{}\r\n", server.host()).as_bytes());
        if let Some(status) = answer.split(' ').nth(1).and_then(|status| status.parse().ok())
            && status != 503
        {
            return status;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    0
}
