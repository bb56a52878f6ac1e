//! `lanewright view --build` in the browser: stages, hands on the input, decisions.

use std::fs;

use serde_json::json;

use super::driver::Browser;
use super::reports::EVIL;
use super::{DESKTOP, PHONE, at_peace, data};
use crate::common::program::Server;

/// Two side roads that leave a main road 9 m apart: too little for a vehicle to wait, so they are one intersection.
fn staggered() -> String {
    // Metres east and north of 48 N 11 E.
    let nodes = [(-150.0, 0.0), (0.0, 0.0), (9.0, 0.0), (160.0, 0.0), (0.0, 120.0), (9.0, -120.0)];
    let ways: [(i64, &[i64]); 5] = [(11, &[1, 2]), (12, &[2, 3]), (13, &[3, 4]), (14, &[2, 5]), (15, &[3, 6])];
    let evil = EVIL.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    let mut text = String::from("<osm version=\"0.6\">\n");
    for (i, (x, y)) in nodes.iter().enumerate() {
        let (lat, lon) = (48.0 + y / 111_200.0, 11.0 + x / 74_500.0);
        text += &format!("<node id=\"{}\" lat=\"{lat:.7}\" lon=\"{lon:.7}\"/>\n", i + 1);
    }
    for (id, nodes) in ways {
        let nodes: String = nodes.iter().map(|node| format!("<nd ref=\"{node}\"/>")).collect();
        text += &format!(
            "<way id=\"{id}\">{nodes}<tag k=\"highway\" v=\"residential\"/><tag k=\"lanes\" v=\"2\"/>\
             <tag k=\"name\" v=\"{evil}\"/><tag k=\"{evil}\" v=\"1\"/></way>\n"
        );
    }
    text + "</osm>\n"
}

/// A page of the staggered junction, with its file.
struct Shop {
    browser: Browser,
    file: std::path::PathBuf,
    _server: Server,
    _dir: tempfile::TempDir,
}

impl Shop {
    fn open((width, height): (u32, u32)) -> Option<Self> {
        let browser = Browser::start(width, height)?;
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("staggered.osm");
        fs::write(&file, staggered()).unwrap();
        let server = Server::start(dir.path(), &["--build", file.to_str().unwrap()]);
        browser.visit(&server.url);
        browser.wait("document.getElementById('map').dataset.painted");
        Some(Self { browser, file, _server: server, _dir: dir })
    }

    /// Where a place of the map is in the window; metres from the middle of the page's plane.
    fn window(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let numbers =
            |name| data(&self.browser, "map", name).split(' ').map(|v| v.parse().unwrap()).collect::<Vec<f64>>();
        let (centre, scale) = (numbers("centre"), numbers("scale")[0]);
        let stage = "(({ left, top, right, bottom }) => [(left + right) / 2, (top + bottom) / 2])\
                     (document.getElementById('map').getBoundingClientRect())";
        let middle = self.browser.value(stage);
        let middle: Vec<f64> = middle.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        [middle[0] + (x - centre[0]) * scale, middle[1] - (y - centre[1]) * scale]
    }

    /// Where an input node is in the window, as the server says it.
    fn node(&self, id: &str) -> [f64; 2] {
        let place = self.browser.run(&format!(
            "return fetch('build', {{ method: 'POST', body: '{{}}' }}).then((r) => r.arrayBuffer()).then(async (b) => {{ \
             const n = new DataView(b).getUint32(0, true); \
             const s = new Blob([new Uint8Array(b, 4, n)]).stream().pipeThrough(new DecompressionStream('deflate-raw')); \
             return JSON.parse(await new Response(s).text()).workshop.nodes.find((n) => n[0] === '{id}').slice(1); }})"
        ));
        let place: Vec<f64> = place.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        self.window([place[0], place[1]])
    }

    fn builds(&self) -> u32 {
        data(&self.browser, "map", "builds").parse().unwrap_or_default()
    }

    /// Does something that has the map built anew, and waits for it.
    fn rebuilt(&self, act: impl FnOnce(&Browser)) {
        let before = self.builds();
        act(&self.browser);
        self.browser.wait(&format!("Number(document.getElementById('map').dataset.builds) > {before} && !document.getElementById('map').dataset.building"));
    }

    /// What the canvas shows, when it no longer changes.
    fn canvas(&self) -> String {
        let look = || {
            std::thread::sleep(std::time::Duration::from_millis(250));
            self.browser.value("document.getElementById('map').toDataURL()").to_string()
        };
        let mut last = look();
        for _ in 0..80 {
            let next = look();
            if next == last {
                break;
            }
            last = next;
        }
        last
    }

    fn press_button(&self, text: &str) {
        self.browser.run(&format!(
            "[...document.querySelectorAll('#pane-stages button')].find((b) => b.textContent === '{text}').click()"
        ));
    }
}

#[test]
fn keys_and_list_step_through_the_stages() {
    let Some(shop) = Shop::open(DESKTOP) else { return };
    let browser = &shop.browser;
    let stage = || data(browser, "map", "stage");
    assert_eq!(stage(), "movements");
    let mut seen = Vec::new();
    for (at, name) in ["thicken", "collide", "trim", "outline", "consolidate", "lanes"].iter().enumerate() {
        browser.press(&(at + 1).to_string());
        browser.wait(&format!("document.getElementById('map').dataset.stage === '{name}'"));
        assert_ne!(data(browser, "map", "marks"), "0", "{name}");
        seen.push(shop.canvas());
        browser.picture(&format!("workshop-{name}.png"));
    }
    seen.sort();
    seen.dedup();
    assert_eq!(seen.len(), 6, "every stage has a picture of its own");
    browser.press("]");
    browser.wait("document.getElementById('map').dataset.stage === 'movements'");
    browser.press("[[");
    browser.wait("document.getElementById('map').dataset.stage === 'consolidate'");
    browser.run("document.getElementById('stage-trim').click()");
    browser.wait("document.getElementById('map').dataset.stage === 'trim'");
    at_peace(browser);
}

#[test]
fn a_dragged_node_changes_every_stage_and_can_be_undone() {
    let Some(shop) = Shop::open(DESKTOP) else { return };
    let browser = &shop.browser;
    browser.press("1");
    let before = shop.canvas();
    let [x, y] = shop.node("6");
    shop.rebuilt(|browser| browser.drag([x, y], [x + 90.0, y - 20.0], None));
    let edit = browser.value("document.querySelector('.edit-list').textContent");
    assert!(edit.as_str().unwrap().starts_with("node 6 to 47.99"), "{edit}");
    let after = shop.canvas();
    assert_ne!(before, after);
    let says = browser.value("document.getElementById('editor-state').textContent");
    assert!(says.as_str().unwrap().starts_with("Built in "), "{says}");
    browser.press("7");
    browser.wait("document.getElementById('map').dataset.stage === 'movements'");
    browser.picture("workshop-dragged.png");
    shop.rebuilt(|browser| browser.press("u"));
    assert_eq!(browser.value("document.querySelectorAll('.edit-list .undone').length"), json!(1));
    browser.press("1");
    assert_eq!(shop.canvas(), before, "all is as it was");
    shop.rebuilt(|browser| browser.press("y"));
    assert_eq!(shop.canvas(), after);
    browser.run("document.getElementById('save-osm').click()");
    browser.wait("document.getElementById('toast').textContent.includes('staggered_edited.osm')");
    assert_eq!(fs::read_to_string(&shop.file).unwrap(), staggered(), "the input is not written to");
    at_peace(browser);
}

#[test]
fn lanes_change_and_merges_are_decided() {
    let Some(shop) = Shop::open(DESKTOP) else { return };
    let browser = &shop.browser;
    // Closer, so that the short road is wide enough for a click.
    for _ in 0..6 {
        browser.press("+");
    }
    std::thread::sleep(std::time::Duration::from_millis(600));
    let [a, b] = [shop.node("2"), shop.node("3")];
    browser.click((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0);
    browser.wait("document.querySelector('#road h3')?.textContent.startsWith('way 12')");
    let merged =
        |now: bool| browser.wait(&format!("document.querySelector('#road .decision')?.dataset.merged === '{now}'"));
    merged(true);
    let why = browser.value("document.querySelector('#road .why').textContent");
    assert!(why.as_str().unwrap().contains("no vehicle has room"), "{why}");
    browser.press("5");
    let as_found = shop.canvas();
    browser.picture("workshop-merged.png");
    shop.rebuilt(|_| shop.press_button("Keep apart"));
    merged(false);
    assert_ne!(shop.canvas(), as_found);
    browser.picture("workshop-apart.png");
    shop.rebuilt(|_| shop.press_button("As found"));
    merged(true);
    shop.rebuilt(|_| shop.press_button("Merge"));
    merged(true);

    browser.press("6");
    let two = shop.canvas();
    shop.rebuilt(|browser| {
        browser
            .run("const f = document.getElementById('tag-lanes'); f.value = '4'; f.dispatchEvent(new Event('change'))");
    });
    assert_eq!(browser.value("document.getElementById('tag-lanes').value"), json!("4"));
    assert_ne!(shop.canvas(), two);

    // What the tags say is only text.
    let shown = browser.value("document.querySelector('#road').textContent");
    assert!(shown.as_str().unwrap().contains(EVIL), "{shown}");
    assert_eq!(browser.value("document.querySelectorAll('#road svg, #road img, #road script').length"), json!(0));

    // The input changes on disk: the edits are made on what it is now.
    shop.rebuilt(|_| fs::write(&shop.file, staggered().replace("k=\"lanes\" v=\"2\"", "k=\"width\" v=\"9\"")).unwrap());
    browser.wait("document.getElementById('tag-width')?.value === '9'");
    assert_eq!(browser.value("document.getElementById('tag-lanes').value"), json!("4"));
    at_peace(browser);
}

#[test]
fn a_phone_shows_the_stages() {
    let Some(shop) = Shop::open(PHONE) else { return };
    shop.browser.press("5");
    shop.canvas();
    shop.browser.picture("workshop-phone.png");
    assert_eq!(shop.browser.value("document.documentElement.scrollWidth > innerWidth"), json!(false));
    at_peace(&shop.browser);
}
