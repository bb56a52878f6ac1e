//! A large map in the browser: how big its report is, how soon it is open, how smoothly it moves.
//!
//! `make soak` (LANEWRIGHT_SOAK=1) holds the promises of a 100 MB map; else a small one is opened and nothing timed.

use std::path::{Path, PathBuf};

use lanewright::builder::{BuildOptions, build};
use lanewright::diagnostic::{Diagnostic, Finding, Severity, Subject};
use lanewright::lanelet::{from_osm, to_osm};
use lanewright::osm::read_file;
use lanewright::projection::Projector;
use lanewright::report::html::{Page, html};
use lanewright::report::{Report, Sources};
use serde_json::json;

use super::driver::Browser;
use super::{DESKTOP, at_peace, data};
use crate::common::drawing::osm;
use crate::common::{root, soak};

/// Bytes of XML with and without LANEWRIGHT_SOAK.
const SIZES: [usize; 2] = [100_000_000, 2_000_000];
/// Degrees between two copies of the crossing: some 350 m north, 330 m east.
const COPY_SPACING: (f64, f64) = (0.0032, 0.0045);

/// The text of one copy of a map: other ids, another place. Our maps have one tag a line.
fn copy(map: &str, number: usize, columns: usize, out: &mut String) {
    let (row, column) = (number / columns, number % columns);
    for line in map.lines() {
        let trimmed = line.trim_start();
        let own_id = trimmed.starts_with("<nd ") || trimmed.starts_with("<member ") || trimmed.contains(" id=\"");
        if trimmed.starts_with("<tag k=\"local_") {
            continue;
        }
        let mut line = line.to_owned();
        let id_tag = trimmed.starts_with("<tag k=\"intersection_area\"");
        for key in [(own_id, " id=\""), (own_id, " ref=\""), (id_tag, " v=\"")] {
            if key.0 {
                change(&mut line, key.1, |id| (id.parse::<i64>().unwrap() + number as i64 * 7_919).to_string());
            }
        }
        change(&mut line, " lat=\"", |lat| {
            format!("{:.11}", lat.parse::<f64>().unwrap() + row as f64 * COPY_SPACING.0)
        });
        change(&mut line, " lon=\"", |lon| {
            format!("{:.11}", lon.parse::<f64>().unwrap() + column as f64 * COPY_SPACING.1)
        });
        out.push_str(&line);
        out.push('\n');
    }
}

/// Changes the value behind a key.
fn change(line: &mut String, key: &str, with: impl Fn(&str) -> String) {
    if let Some(start) = line.find(key).map(|at| at + key.len()) {
        let end = start + line[start..].find('"').unwrap();
        let value = with(&line[start..end]);
        line.replace_range(start..end, &value);
    }
}

/// Many crossings side by side, as XML of at least this size.
fn tiled(size: usize) -> String {
    let built =
        build(&read_file(&root().join("sample_maps/crossing_right.osm")).unwrap(), &BuildOptions::default()).unwrap();
    let mut one = Vec::new();
    to_osm(&built.map, &built.projector, &mut one).unwrap();
    let one = String::from_utf8(one).unwrap();
    // Head, elements, tail: copies of each kind of element stand in one file just as well mixed.
    let (head, rest) = one.split_at(one.find("  <node ").unwrap());
    let elements = rest.strip_suffix("</osm>\n").unwrap();
    let columns = (size.div_ceil(elements.len()) as f64).sqrt().ceil() as usize;
    let mut text = head.to_owned();
    for number in 0.. {
        if text.len() >= size {
            break;
        }
        copy(elements, number, columns, &mut text);
    }
    text + "</osm>\n"
}

/// Writes the report of a map with two findings in each copy; its file.
fn written(name: &str, text: String) -> PathBuf {
    let osm = osm(text);
    assert!(osm.oddities.is_empty(), "ids repeat: {:?}", osm.oddities.first());
    let first = osm.nodes.iter().find_map(|node| node.position).unwrap();
    let map = from_osm(&osm, &Projector::transverse_mercator(first)).map;
    drop(osm);
    let findings: Vec<Diagnostic> = map
        .lanelets
        .iter()
        .step_by(12)
        .map(|lanelet| Diagnostic {
            code: "vm-03-02/turn-missing".to_owned(),
            severity: Severity::Error,
            finding: Finding::new(
                "turn-missing",
                Subject::Lanelet(lanelet.id.0),
                format!("Lanelet {} is odd.", lanelet.id),
            ),
            help: Some("Look at it.".to_owned()),
            span: None,
            lonlat: None,
            local: None,
        })
        .collect();
    let sources = Sources::new([]);
    let page = html(&Report::new(&findings, &sources, &map), &Page { title: name, ..Page::default() }).unwrap();
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.html"));
    std::fs::write(&file, page).unwrap();
    file
}

/// Frames a second while the map is moved by 80 pixels in each frame, to and fro.
fn frame_rate(browser: &Browser, frames: u32) -> f64 {
    let rate = browser.run(&format!(
        "return new Promise((done) => {{ const map = document.getElementById('map'); let n = 0, start = 0; \
         const step = (now) => {{ if (!n++) start = now; \
         if (n > {frames}) {{ done(1000 * (n - 1) / (now - start)); return; }} \
         map.dispatchEvent(new KeyboardEvent('keydown', {{ key: n % 60 < 30 ? 'ArrowRight' : 'ArrowLeft' }})); \
         requestAnimationFrame(step); }}; requestAnimationFrame(step); }})"
    ));
    rate.as_f64().unwrap()
}

#[test]
fn a_large_map_opens_soon_and_moves_smoothly() {
    let Some(browser) = Browser::start(DESKTOP.0, DESKTOP.1) else { return };
    let whole = soak();
    let text = tiled(SIZES[usize::from(!whole)]);
    let size = text.len();
    let file = written("large", text);
    let report = std::fs::metadata(&file).unwrap().len() as usize;
    browser.open(&file, "");
    let ready = data_number(&browser, "document.documentElement.dataset.ready");
    browser.wait("document.getElementById('map').dataset.painted");
    let painted = data_number(&browser, "document.getElementById('map').dataset.painted");
    browser.picture("large-whole.png");
    let mut rates = vec![frame_rate(&browser, if whole { 120 } else { 30 })];
    for closer in [6, 6] {
        (0..closer).for_each(|_| browser.press("+"));
        std::thread::sleep(std::time::Duration::from_millis(500));
        rates.push(frame_rate(&browser, if whole { 120 } else { 30 }));
    }
    browser.picture("large-close.png");
    eprintln!(
        "XML {size} bytes, report {report} bytes ({:.1} %), open after {ready:.0} ms, painted after {painted:.0} ms, \
         frames a second while panning, from afar to near: {rates:.0?}",
        100.0 * report as f64 / size as f64
    );
    assert_ne!(data(&browser, "list", "count"), "0");
    assert!(report < size / 3, "a report of {report} bytes for {size} bytes of XML");
    if whole {
        assert!(ready < 5000.0, "open after {ready} ms");
        assert!(rates.iter().all(|rate| *rate >= 30.0), "{rates:?} frames a second");
    }
    assert_eq!(browser.value("document.getElementById('title').textContent"), json!("large"));
    at_peace(&browser);
    std::fs::remove_file(file).unwrap();
}

fn data_number(browser: &Browser, expression: &str) -> f64 {
    browser.value(&format!("Number({expression})")).as_f64().unwrap()
}
