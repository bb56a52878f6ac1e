//! `lanewright view` in the browser: the page follows its file, and shows what fixes would change.

use std::fs;

use serde_json::{Value, json};

use super::driver::Browser;
use super::reports::EVIL;
use super::{DESKTOP, at_peace, data};
use crate::common::program::{Server, lanewright};
use crate::common::root;

/// A bad map of the rules' own; its area lacks a node, which a fix puts in.
fn bad_map() -> String {
    let file = root().join("tests/rules/vm-03-08/bad-lane-node-missing.osm");
    fs::read_to_string(file).unwrap()
}

/// The map with hostile tags on every relation.
fn hostile(map: &str) -> String {
    let evil = EVIL.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    map.replace("</relation>", &format!("<tag k=\"name\" v=\"{evil}\"/><tag k=\"{evil}\" v=\"1\"/></relation>"))
}

#[test]
fn a_page_follows_its_file_and_shows_fix_previews() {
    let Some(browser) = Browser::start(DESKTOP.0, DESKTOP.1) else { return };
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("a <b> & 'c'.osm");
    let bad = hostile(&bad_map());
    fs::write(&file, &bad).unwrap();
    let server = Server::start(&root(), &[file.to_str().unwrap()]);
    browser.visit(&server.url);
    browser.run("window.kept = 'the page was not loaded again'");
    browser.wait("Number(document.getElementById('map').dataset.fixPreviews) > 0");
    browser.wait("document.getElementById('list').dataset.count !== '0'");
    assert_eq!(browser.value("document.getElementById('title').textContent"), json!("a <b> & 'c'.osm"));

    // The finding says what its fix would change.
    browser
        .run("[...document.querySelectorAll('.row')].find((r) => r.textContent.includes('lane-node-missing')).click()");
    browser.wait("document.querySelector('.card .fix-previews')");
    let says = browser.value("document.querySelector('.card .fix-previews').textContent");
    assert!(says.as_str().unwrap().contains("polygon 150"), "{says}");
    std::thread::sleep(std::time::Duration::from_millis(700));
    browser.picture("view-fix-previews.png");
    browser.press("g");
    browser.wait("document.getElementById('map').dataset.fixPreviews === '0'");
    browser.press("g");

    // Mended by somebody: the finding goes, the page stays.
    let mended = bad.replace("v=\"intersection_area\"", "v=\"hatched_road_markings\"");
    assert_ne!(mended, bad);
    let chosen = data(&browser, "map", "highlighted");
    assert_ne!(chosen, "");
    fs::write(&file, &mended).unwrap();
    browser.wait("![...document.querySelectorAll('.row')].some((r) => r.textContent.includes('lane-node-missing'))");
    assert_eq!(browser.value("window.kept"), json!("the page was not loaded again"));

    // Half saved: the page says so and shows what it had.
    fs::write(&file, &bad[..bad.len() / 2]).unwrap();
    browser.wait("!document.getElementById('banner').hidden");
    let says = browser.value("document.getElementById('banner').textContent");
    assert!(says.as_str().unwrap().contains("cut off"), "{says}");
    browser.picture("view-broken.png");
    fs::write(&file, &bad).unwrap();
    browser.wait("document.getElementById('banner').hidden && [...document.querySelectorAll('.row')].some((r) => r.textContent.includes('lane-node-missing'))");
    assert_eq!(browser.value("window.kept"), json!("the page was not loaded again"));
    assert_eq!(fs::read_to_string(&file).unwrap(), bad, "the map is not written to");
    at_peace(&browser);
}

#[test]
fn a_phone_shows_a_served_page() {
    let Some(browser) = Browser::start(super::PHONE.0, super::PHONE.1) else { return };
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("map.osm");
    fs::write(&file, bad_map()).unwrap();
    let server = Server::start(&root(), &["--unsafe", file.to_str().unwrap()]);
    browser.visit(&server.url);
    browser.wait(
        "document.getElementById('map').dataset.painted && Number(document.getElementById('map').dataset.fixPreviews) > 0",
    );
    browser.picture("view-phone.png");
    assert_eq!(browser.value("document.documentElement.scrollWidth > innerWidth"), json!(false));
    at_peace(&browser);
}

/// A lanelet of an intersection is chosen: the page shows what `planner` tells of it.
fn the_planner_layer_of(size: (u32, u32), picture: &str) {
    let Some(browser) = Browser::start(size.0, size.1) else { return };
    let map = root().join("tests/rules/vm-03-10/good.osm");
    let server = Server::start(&root(), &[map.to_str().unwrap()]);
    browser.visit(&server.url);
    browser.wait("document.documentElement.dataset.ready");
    browser.run("location.hash = '#id=213'");
    browser.wait("document.getElementById('map').dataset.plan");
    let json = lanewright(&root(), &["planner", map.to_str().unwrap(), "--lanelet", "213", "--format", "json"]);
    let json: Value = serde_json::from_str(&json.exits(0).stdout).unwrap();
    let told = &json["lanelets"][0];
    let count = |key: &str| told[key].as_array().unwrap().len();
    assert_eq!(data(&browser, "map", "plan"), format!("{} {} {}", count("watched"), count("ignored"), count("marks")));
    let says = browser.value("document.querySelector('.card .plan').textContent");
    let says = says.as_str().unwrap();
    assert!(says.contains(told["sentence"].as_str().unwrap()) && says.contains("first attention line"), "{says}");
    browser.wait("document.getElementById('map').dataset.painted");
    std::thread::sleep(std::time::Duration::from_millis(700));
    browser.picture(picture);
    assert_eq!(browser.value("document.documentElement.scrollWidth > innerWidth"), json!(false));
    browser.press("w");
    browser.wait("document.getElementById('map').dataset.plan === ''");
    browser.press("w");
    // A lane of no intersection has no such layer.
    browser.run("location.hash = '#id=201'");
    browser.wait("document.getElementById('map').dataset.plan === '' && !document.querySelector('.card .plan')");
    at_peace(&browser);
}

#[test]
fn a_chosen_lanelet_shows_what_the_planner_will_do() {
    the_planner_layer_of(DESKTOP, "view-planner.png");
}

#[test]
fn a_phone_shows_what_the_planner_will_do() {
    the_planner_layer_of(super::PHONE, "view-planner-phone.png");
}
