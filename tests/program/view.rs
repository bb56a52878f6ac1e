//! `lanewright view` as browsers and other programs on the machine request it.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;

use serde_json::Value;

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
fn unpacked(parcel: &[u8]) -> Value {
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
