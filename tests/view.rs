//! `lanewright view` as browsers and others on the machine speak to it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]
#![cfg(unix)]

mod support;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use support::{command, lanewright, root};

/// The program while it serves a page.
struct Program {
    child: Child,
    port: u16,
}

impl Program {
    fn start(dir: &Path, arguments: &[&str]) -> Self {
        let mut command = command(dir, &[&["view", "--isolated"], arguments].concat());
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let port = line.strip_prefix("http://127.0.0.1:").and_then(|rest| rest.split_once('/')?.0.parse().ok());
        Self { child, port: port.unwrap_or_else(|| panic!("no address: {line}")) }
    }

    /// Status, head and body of an answer.
    fn ask(&self, request: &str, headers: &str, body: &str) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let length = body.len();
        write!(stream, "{request} HTTP/1.1\r\n{headers}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}")
            .unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(answer[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, head, answer[end + 4..].to_vec())
    }

    fn host(&self) -> String {
        format!("Host: 127.0.0.1:{}\r\n", self.port)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A directory with a bad map of the rules' own.
fn place() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::copy(root().join("tests/rules/vm-03-08/bad-lane-node-missing.osm"), dir.path().join("map.osm")).unwrap();
    dir
}

#[test]
fn only_pages_of_its_own_are_answered() {
    let dir = place();
    let program = Program::start(dir.path(), &["map.osm"]);
    let (host, port) = (program.host(), program.port);
    let (status, head, page) = program.ask("GET /", &host, "");
    assert_eq!(status, 200);
    assert!(head.contains("text/html") && !head.to_lowercase().contains("access-control"), "{head}");
    assert!(String::from_utf8(page).unwrap().contains("connect-src 'self' http://127.0.0.1:8111;"));
    let (status, head, data) = program.ask("GET /data", &format!("Host: localhost:{port}\r\n"), "");
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
        let (status, _, body) = program.ask("GET /data", &headers, "");
        assert_eq!((status, body.as_slice()), (403, b"only for pages of this server".as_slice()), "{headers}");
    }
    assert_eq!(program.ask("GET /data", &format!("{host}Origin: http://127.0.0.1:{port}\r\n"), "").0, 200);
    assert_eq!(program.ask("GET /../map.osm", &host, "").0, 404);
    assert_eq!(program.ask("POST /nothing", &host, "{}").0, 404);
    assert_eq!(program.ask("PUT /data", &host, "{}").0, 404);
}

#[test]
fn ctrl_c_ends_it_cleanly() {
    let dir = place();
    let mut program = Program::start(dir.path(), &["map.osm"]);
    // Somebody waits for news that will never come.
    let mut stream = TcpStream::connect(("127.0.0.1", program.port)).unwrap();
    write!(stream, "GET /changes?after=2 HTTP/1.1\r\n{}\r\n", program.host()).unwrap();
    let told = Command::new("kill").args(["-INT", &program.child.id().to_string()]).status().unwrap();
    assert!(told.success());
    assert_eq!(program.child.wait().unwrap().code(), Some(0));
}

#[test]
fn what_cannot_be_served_is_told_at_once() {
    let dir = place();
    lanewright(dir.path(), &["view", "no.osm"]).fails_saying(&["no.osm"]);
    let program = Program::start(dir.path(), &["map.osm"]);
    let port = program.port.to_string();
    lanewright(dir.path(), &["view", "map.osm", "--port", &port]).fails_saying(&["cannot listen", &port]);
}
