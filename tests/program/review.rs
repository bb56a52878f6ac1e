//! A review as other programs on the machine ask for it, and at the terminal.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::Stdio;

use serde_json::{Value, json};

use crate::common::program::{Run, Server, command, lanewright};
use crate::common::root;

/// A directory with a map of `tests/rules` that has fixes that need a review.
fn place() -> (tempfile::TempDir, PathBuf, String) {
    let dir = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(root().join("tests/rules/vm-05-01/bad-unreferenced.osm")).unwrap();
    let file = dir.path().join("map.osm");
    fs::write(&file, &text).unwrap();
    (dir, file, text)
}

struct Asked(Server);

impl Asked {
    fn start(dir: &tempfile::TempDir) -> Self {
        Self(Server::start(dir.path(), &["--review", "map.osm"]))
    }

    fn headers(&self) -> String {
        let token = self.0.url.split("token=").nth(1).unwrap();
        format!("{}Lanewright-Token: {token}\r\n", self.0.host())
    }

    fn post(&self, path: &str, question: &Value) -> Result<Value, String> {
        let (status, head, body) = self.0.ask(&format!("POST {path}"), &self.headers(), &question.to_string());
        let text = String::from_utf8(body).unwrap();
        assert_eq!(status, 200, "{text}");
        if head.contains("text/plain") { Err(text) } else { Ok(serde_json::from_str(&text).unwrap()) }
    }

    fn act(&self, action: Value) -> Result<String, String> {
        Ok(self.post("/review/do", &action)?["said"].as_str().unwrap().to_owned())
    }

    /// How far the review has come.
    fn facts(&self) -> Value {
        let (_, _, data) = self.0.ask("GET /data", &self.headers(), "");
        super::view::unpacked(&data)["review"].take()
    }

    /// The first fix that needs a review.
    fn item(&self) -> Value {
        let facts = self.facts();
        let items = facts["items"].as_array().unwrap();
        items.iter().find(|item| item["safe"] == json!(false) && item["status"] == "open").cloned().unwrap()
    }
}

#[test]
fn only_who_knows_the_token_may_ask_and_write() {
    let (dir, file, before) = place();
    let asked = Asked::start(&dir);
    let (server, own) = (&asked.0, asked.headers());
    let token = server.url.split("token=").nth(1).unwrap();
    assert_eq!(token.len(), 32, "{}", server.url);
    assert_eq!(server.ask(&format!("GET /?token={token}"), &server.host(), "").0, 200);
    let reject = r#"{"do":"save"}"#;
    for (request, headers) in [
        ("GET /", server.host()),
        ("GET /?token=0", server.host()),
        ("GET /data", server.host()),
        ("GET /changes?after=0", server.host()),
        ("POST /review/do", server.host()),
        ("POST /review/do", format!("{}Lanewright-Token: {}\r\n", server.host(), "0".repeat(32))),
        ("POST /review/do", format!("{own}Origin: http://evil.example\r\n")),
        ("POST /review/preview", format!("{own}Origin: null\r\n")),
    ] {
        assert_eq!(server.ask(request, &headers, reject).0, 403, "{request} {headers}");
    }
    for nonsense in
        [json!({}), json!({"do": "burn"}), json!({"do": "edit", "edit": {"edit": "turn", "lanelet": 1, "turn": "up"}})]
    {
        assert!(asked.act(nonsense).unwrap_err().contains("nothing that a review can do"));
    }
    assert_eq!(fs::read_to_string(file).unwrap(), before);
    // Another start has another one.
    assert_ne!(Asked::start(&dir).0.url.split("token=").nth(1).unwrap(), token);
}

#[test]
fn nothing_is_written_before_it_is_saved_and_saving_is_undone() {
    let (dir, file, before) = place();
    let asked = Asked::start(&dir);
    let item = asked.item();
    assert_ne!(item["assumes"], "");
    let preview = asked.post("/review/preview", &json!({ "item": item["id"] })).unwrap();
    assert_eq!(preview["refused"], Value::Null);
    assert!(preview["changes"].as_array().unwrap().len() > 1, "{preview}");
    let pictures: Vec<&str> = preview["pictures"].as_array().unwrap().iter().map(|one| one.as_str().unwrap()).collect();
    assert!(pictures.len() == 2 && pictures[0] != pictures[1] && pictures.iter().all(|one| one.starts_with("<svg")));
    let said = asked.act(json!({ "do": "accept", "items": [item["id"]] })).unwrap();
    assert!(said.starts_with("accepted `") && said.contains("errors"), "{said}");
    assert!(asked.act(json!({ "do": "accept", "items": [item["id"]] })).unwrap_err().contains("not open"));
    assert_eq!(fs::read_to_string(&file).unwrap(), before);
    let diff = asked.post("/review/diff", &json!({})).unwrap();
    assert!(diff["diff"].as_str().unwrap().contains("\n+"), "{diff}");

    assert!(asked.act(json!({ "do": "save" })).unwrap().contains("1 file written"));
    let saved = fs::read_to_string(&file).unwrap();
    assert_ne!(saved, before);
    // The smallest change: all lines but those of the elements concerned are as they were.
    let gone = before.lines().filter(|line| !saved.contains(line)).count();
    assert!(gone < 10, "{gone} lines are gone");
    assert!(asked.act(json!({ "do": "undo" })).unwrap().starts_with("undone: accepted"));
    asked.act(json!({ "do": "save" })).unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), before, "the state before is written again");
    assert!(!dir.path().join("baseline.json").exists(), "nothing was rejected");
}

#[test]
fn what_is_rejected_is_remembered_and_not_proposed_again() {
    let (dir, file, before) = place();
    let asked = Asked::start(&dir);
    let item = asked.item();
    let reject = |reason: &str| asked.act(json!({ "do": "reject", "items": [item["id"]], "reason": reason }));
    assert!(reject("  ").unwrap_err().contains("needs a reason"));
    reject("nobody\n  crosses here").unwrap();
    asked.act(json!({ "do": "save" })).unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), before, "the map is as it was");
    let baseline = fs::read_to_string(dir.path().join("baseline.json")).unwrap();
    assert!(baseline.contains(r#""reason":"nobody crosses here""#), "{baseline}");
    // Who asks with the baseline reads why, and `fix` leaves it alone.
    let checked = lanewright(dir.path(), &["check", "map.osm", "--isolated", "--baseline", "baseline.json"]);
    assert!(checked.stdout.contains("nobody crosses here"), "{}", checked.stdout);
    let code = item["code"].as_str().unwrap();
    let fix = |more: &[&str]| {
        lanewright(
            dir.path(),
            &[&["fix", "map.osm", "--isolated", "--unsafe", "--diff", "--select", code], more].concat(),
        )
        .stdout
    };
    assert_ne!(fix(&[]), "");
    assert_eq!(fix(&["--baseline", "baseline.json"]), "");
    // A later review does not propose it.
    let again = Asked::start(&dir);
    assert!(again.facts()["items"].as_array().unwrap().iter().all(|one| one["title"] != item["title"]));
    // A baseline that is written anew keeps the reason.
    lanewright(dir.path(), &["check", "map.osm", "--isolated", "--write-baseline", "baseline.json"]).exits(0);
    assert!(fs::read_to_string(dir.path().join("baseline.json")).unwrap().contains("nobody crosses here"));
}

#[test]
fn edits_by_hand_are_judged_and_refused_with_a_reason() {
    let (dir, file, before) = place();
    let asked = Asked::start(&dir);
    let lanelet = |nth: usize| {
        let relation =
            before.split("<relation id=\"").skip(1).filter(|one| one.contains("v=\"lanelet\"")).nth(nth).unwrap();
        relation.split('"').next().unwrap().to_owned()
    };
    let (first, second) = (lanelet(0), lanelet(1));
    let edit = |edit: Value| asked.act(json!({ "do": "edit", "edit": edit }));
    for (wrong, why) in [
        (json!({ "edit": "tag", "kind": "lanelet", "id": "999999", "key": "a", "value": "b" }), "no lanelet 999999"),
        (json!({ "edit": "turn", "lanelet": first, "turn": "up" }), "no turn"),
        (json!({ "edit": "add-yield", "first": first, "waits": first }), "itself"),
        (json!({ "edit": "remove-yield", "first": first, "waits": second }), "no right_of_way"),
        (
            json!({ "edit": "tag", "kind": "lanelet", "id": first, "key": "type", "value": "regulatory_element" }),
            "would not load",
        ),
        (
            json!({ "edit": "tag", "kind": "lanelet", "id": first, "key": "note", "value": "a\u{1}b" }),
            "control characters",
        ),
    ] {
        let said = edit(wrong.clone()).unwrap_err();
        assert!(said.contains(why), "{wrong}: {said}");
    }
    let said =
        edit(json!({ "edit": "tag", "kind": "lanelet", "id": first, "key": "note", "value": "<a> & \"b\"" })).unwrap();
    assert!(said.starts_with("edited: set note="), "{said}");
    edit(json!({ "edit": "add-yield", "first": first, "waits": second })).unwrap();
    assert!(edit(json!({ "edit": "add-yield", "first": first, "waits": second })).unwrap_err().contains("already"));
    let third = lanelet(2);
    edit(json!({ "edit": "add-yield", "first": first, "waits": third })).unwrap();
    edit(json!({ "edit": "remove-yield", "first": first, "waits": second })).unwrap();
    // With the last yield the element goes, which would not load without.
    edit(json!({ "edit": "remove-yield", "first": first, "waits": third })).unwrap();
    edit(json!({ "edit": "add-yield", "first": first, "waits": second })).unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), before);
    asked.act(json!({ "do": "save" })).unwrap();
    let saved = fs::read_to_string(&file).unwrap();
    assert!(saved.contains("&lt;a&gt; &amp; &quot;b&quot;") && saved.contains("right_of_way"), "{saved}");
    lanewright(dir.path(), &["check", "map.osm", "--isolated", "--select", "load"]).exits(0);
}

/// Somebody else saves the map in the midst of a review.
#[test]
fn a_map_that_somebody_else_saved_is_not_written_over() {
    let (dir, file, before) = place();
    let asked = Asked::start(&dir);
    let item = asked.item();
    asked.act(json!({ "do": "accept", "items": [item["id"]] })).unwrap();
    let theirs = before.replacen("</osm>", "<!-- theirs -->\n</osm>", 1);
    fs::write(&file, &theirs).unwrap();
    assert!(asked.act(json!({ "do": "save" })).is_err());
    assert_eq!(fs::read_to_string(&file).unwrap(), theirs);
    // Read again, the decisions are made on what it says now.
    assert_eq!(asked.act(json!({ "do": "reload" })).unwrap(), "read again");
    assert_eq!(asked.facts()["steps"].as_array().unwrap().len(), 1);
    asked.act(json!({ "do": "save" })).unwrap();
    let both = fs::read_to_string(&file).unwrap();
    assert!(both.contains("<!-- theirs -->") && both != theirs);
}

fn answered(dir: &tempfile::TempDir, more: &[&str], answers: &str) -> Run {
    let arguments = [&["fix", "map.osm", "--isolated", "--interactive"], more].concat();
    let mut child = command(dir.path(), &arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(answers.as_bytes()).unwrap();
    child.wait_with_output().unwrap().into()
}

#[test]
fn the_terminal_asks_about_each_fix() {
    let (dir, file, before) = place();
    let run = answered(&dir, &[], "?\ny\nq\nn\n");
    assert!(run.stdout.contains("takes for granted: "), "{}", run.stdout);
    assert!(run.stdout.contains("accepted `") && run.stdout.contains("nothing was written"), "{}", run.stdout);
    assert_eq!(fs::read_to_string(&file).unwrap(), before);
    // The input ends: nothing is written.
    let run = answered(&dir, &[], "y\n");
    assert!(run.stdout.contains("nothing was written"), "{}", run.stdout);
    assert_eq!(fs::read_to_string(&file).unwrap(), before);
    let run = answered(&dir, &["--baseline", "known.json"], "l\nn\nnobody crosses here\nu\ny\ny\n");
    assert!(run.stdout.contains("put off") && run.stdout.contains("undone: rejected"), "{}", run.stdout);
    assert!(run.stdout.contains("saved: 1 file written"), "{}", run.stdout);
    assert_ne!(fs::read_to_string(&file).unwrap(), before);
    assert!(!dir.path().join("known.json").exists());
    let run = answered(&dir, &["--baseline", "known.json"], "q\n");
    assert!(!run.stdout.contains("Write this?"), "{}", run.stdout);
}
