//! The report in a real browser: what it shows, what a hand does to it, and that nothing of a map runs.
//!
//! Needs Debian's packages chromium and chromium-driver; skipped where they and `../shared` are missing. Pictures of what was
//! tested lie in target/tmp.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

#[path = "../common/mod.rs"]
mod common;
mod driver;
mod large;
mod reports;
mod review;
mod view;
mod workshop;

use driver::Browser;
use lanewright::diagnostic::{Place, Severity, Subject};
use lanewright::lanelet::index::extent;
use lanewright::lanelet::{Lanelet, LaneletId};
use serde_json::json;

const DESKTOP: (u32, u32) = (1440, 900);
const PHONE: (u32, u32) = (500, 900);

/// No complaint of the console, no request.
fn at_peace(browser: &Browser) {
    assert_eq!(browser.complaints(), [""; 0]);
    assert_eq!(browser.value("typeof window.evil"), json!("undefined"), "a script of the map ran");
}

fn open(name: &str, (width, height): (u32, u32), link: &str) -> Option<(Browser, reports::Written)> {
    let browser = Browser::start(width, height)?;
    let report = reports::broken(name);
    browser.open(&report.file, link);
    Some((browser, report))
}

fn data(browser: &Browser, element: &str, name: &str) -> String {
    let value = browser.value(&format!("document.getElementById('{element}').dataset.{name} ?? ''"));
    value.as_str().unwrap_or_default().to_owned()
}

/// The kinds by which pages name what they highlight.
fn named(subject: Subject) -> String {
    let kind = match subject {
        Subject::LineString(_) => "line",
        Subject::RegulatoryElement(_) => "rule",
        other => other.kind(),
    };
    format!("{kind}-{}", subject.id().unwrap_or_default())
}

#[test]
fn every_finding_has_a_pin_and_a_row() {
    let Some((browser, report)) = open("pins", DESKTOP, "") else { return };
    let count = report.findings.len().to_string();
    assert!(report.findings.len() >= 2);
    assert_eq!(data(&browser, "map", "pins"), count);
    assert_eq!(data(&browser, "list", "count"), count);
    let errors = report.findings.iter().filter(|one| one.severity == Severity::Error).count();
    let verdict = browser.value("document.getElementById('verdict').textContent");
    assert!(verdict.as_str().unwrap().contains(&format!("{errors} error")), "{verdict}");
    browser.wait("document.getElementById('map').dataset.painted");
    browser.picture("report-desktop.png");
    at_peace(&browser);
}

#[test]
fn a_click_on_a_row_centres_and_highlights() {
    let Some((browser, report)) = open("row", DESKTOP, "") else { return };
    browser.run("document.querySelector('.row.finding').click()");
    let finding = &report.findings[0].finding;
    let highlighted = data(&browser, "map", "highlighted");
    assert!(highlighted.split(' ').any(|one| one == named(finding.subject)), "{highlighted}");
    for related in &finding.related {
        assert!(
            matches!(related.subject, Subject::RegulatoryElement(_)) || highlighted.contains(&named(related.subject)),
            "{highlighted} lacks {}",
            related.subject
        );
    }
    // The middle of the finding's place, or of the whole subject, is the middle of the clear part of the map.
    let shape = match (&finding.place, finding.subject) {
        (Place::Line(points) | Place::Polygon(points), _) => points.clone(),
        (Place::Point(point), _) => vec![*point],
        (Place::Unknown, Subject::Lanelet(id)) => report.map.outline(report.map.lanelets.get(LaneletId(id)).unwrap()),
        (Place::Unknown, other) => panic!("{other}"),
    };
    let [low, high] = extent(&shape);
    browser.wait("document.getElementById('map').dataset.centre && !document.getElementById('card').hidden");
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let centre: Vec<f64> = data(&browser, "map", "centre").split(' ').map(|v| v.parse().unwrap()).collect();
    // The page counts from its own origin, which is a whole metre.
    let off = [(low.x + high.x) / 2.0 - centre[0], (low.y + high.y) / 2.0 - centre[1]];
    assert!(off.iter().all(|v| (v - v.round()).abs() < 0.03), "{off:?}");
    assert_eq!(browser.value("document.querySelectorAll('.row[aria-selected=true]').length"), json!(1));
    browser.picture("report-finding.png");
    at_peace(&browser);
}

#[test]
fn a_click_on_a_pin_selects_its_row() {
    let Some((browser, _)) = open("pin", DESKTOP, "") else { return };
    browser.run("document.querySelector('.row.finding').click()");
    std::thread::sleep(std::time::Duration::from_millis(1500));
    // The pin stands where it was flown to; with nothing chosen, a click there chooses again.
    let at = browser.value(
        "(() => { const s = document.getElementById('stage').getBoundingClientRect(), \
         c = document.getElementById('card').getBoundingClientRect(); return [s.left, c.left, s.top, s.bottom]; })()",
    );
    let at: Vec<f64> = at.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    browser.press("\u{e00c}");
    assert_eq!(data(&browser, "map", "highlighted"), "");
    let (x, y) = ((at[0] + at[1]) / 2.0, (at[2] + at[3]) / 2.0);
    for (dx, dy) in (-6..=6).flat_map(|i| (-6..=6).map(move |j| (f64::from(i) * 16.0, f64::from(j) * 16.0))) {
        let hit = browser.run(&format!(
            "const m = document.getElementById('map'); const s = m.getBoundingClientRect(); \
             m.dispatchEvent(new PointerEvent('pointermove', {{ clientX: {0}, clientY: {1}, bubbles: true }})); \
             return m.classList.contains('over');",
            x + dx,
            y + dy
        ));
        if hit == json!(true) {
            browser.click(x + dx, y + dy);
            browser.wait("location.hash.startsWith('#finding=') && document.querySelector('.row[aria-selected=true]')");
            at_peace(&browser);
            return;
        }
    }
    panic!("no pin near the middle");
}

#[test]
fn filters_narrow_list_and_map_alike() {
    let Some((browser, report)) = open("filters", DESKTOP, "") else { return };
    let id = report.findings.iter().find_map(|one| one.finding.subject.id()).unwrap();
    let both = |expected: usize| {
        browser.wait(&format!("document.getElementById('list').dataset.count === '{expected}'"));
        assert_eq!(data(&browser, "map", "pins"), expected.to_string());
    };
    browser.press("/");
    browser.press(&id.to_string());
    let digits = id.to_string();
    let about = report.findings.iter().filter(|one| {
        let subjects = std::iter::once(one.finding.subject).chain(one.finding.related.iter().map(|r| r.subject));
        subjects.filter_map(Subject::id).any(|id| id.to_string().contains(&digits))
            || one.finding.message.contains(&digits)
    });
    both(about.count());
    browser.run("const s = document.getElementById('search'); s.value = ''; s.dispatchEvent(new Event('input'))");
    both(report.findings.len());
    let severity = report.findings[0].severity;
    browser.run(&format!(
        "[...document.querySelectorAll('.chip')].find((c) => c.querySelector('.dot.{severity}')).click()"
    ));
    both(report.findings.iter().filter(|one| one.severity != severity).count());
    at_peace(&browser);
}

#[test]
fn an_id_leads_to_what_has_it() {
    let Some((browser, report)) = open("by-id", DESKTOP, "") else { return };
    let turning = |lanelet: &&Lanelet| lanelet.attributes.has("turn_direction");
    let lanelet = report.map.lanelets.iter().find(turning).unwrap();
    browser.press("/");
    browser.press(&format!("lanelet {}", lanelet.id));
    browser.wait("[...document.querySelectorAll('.chip')].some((c) => c.textContent.startsWith('Go to lanelet'))");
    browser.run("document.getElementById('filters').requestSubmit()");
    browser.wait(&format!("document.querySelector('#card .id')?.textContent.startsWith('{}')", lanelet.id));
    let said = "[...document.querySelectorAll('#card .part')].map((part) => part.textContent).join(' ')";
    browser.wait(&format!("/behind/.test({said}) && /ahead/.test({said})"));
    // What has no such id is a text like others.
    browser.run("const s = document.getElementById('search'); s.value = 'lanelet 12345678'; s.dispatchEvent(new Event('input'))");
    browser.wait("![...document.querySelectorAll('.chip')].some((c) => c.textContent.startsWith('Go to'))");
    at_peace(&browser);
}

#[test]
fn a_drawn_area_narrows_list_and_map() {
    let Some((browser, report)) = open("area", DESKTOP, "") else { return };
    let shown = |expected: usize| {
        browser.wait(&format!("document.getElementById('list').dataset.count === '{expected}'"));
        assert_eq!(data(&browser, "map", "pins"), expected.to_string());
    };
    let stage = browser.value("(({ left, top, right, bottom }) => [left, top, right, bottom])(document.getElementById('stage').getBoundingClientRect())");
    let stage: Vec<f64> = stage.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let (low, high) = ([stage[0] + 60.0, stage[1] + 8.0], [stage[2] - 8.0, stage[3] - 60.0]);
    const SHIFT: char = '\u{e008}';
    // Nothing lies in a corner of the map.
    browser.drag([high[0] - 60.0, low[1]], [high[0], low[1] + 60.0], Some(SHIFT));
    shown(0);
    assert_ne!(data(&browser, "map", "area"), "");
    browser.press("\u{e00c}");
    shown(report.findings.len());
    // The map says it when it is drawn next.
    browser.wait("!document.getElementById('map').dataset.area");
    // By key instead of Shift, around everything; by button to leave it.
    browser.press("a");
    browser.drag(low, high, None);
    browser.wait("document.getElementById('map').dataset.area");
    shown(report.findings.len());
    browser.picture("report-drawn-area.png");
    browser.run("[...document.querySelectorAll('.chip')].find((c) => c.textContent === 'In the area ×').click()");
    browser.wait("!document.getElementById('map').dataset.area");
    at_peace(&browser);
}

#[test]
fn links_lead_to_findings_primitives_and_rules() {
    let Some((browser, report)) = open("links", DESKTOP, "") else { return };
    let one = &report.findings[1];
    let key = format!("{}@{}", one.code, named(one.finding.subject));
    browser.open(&report.file, &format!("#finding={key}"));
    assert!(data(&browser, "map", "highlighted").contains(&named(one.finding.subject)));
    let area = report.map.polygons.iter().next().unwrap().id;
    browser.open(&report.file, &format!("#id={area}"));
    assert_eq!(data(&browser, "map", "highlighted"), format!("polygon-{area}"));
    browser.picture("report-area.png");
    browser.open(&report.file, "#rule=vm-03-08");
    assert_eq!(browser.value("document.getElementById('rule-dialog').open"), json!(true));
    browser.picture("report-rule.png");
    at_peace(&browser);
}

#[test]
fn what_a_map_says_is_only_text() {
    let Some((browser, report)) = open("hostile", DESKTOP, "") else { return };
    assert_eq!(browser.value("document.getElementById('title').textContent"), json!(reports::EVIL));
    let hostile = report.map.lanelets.iter().find(|l| l.attributes.has("name")).unwrap();
    browser.open(&report.file, &format!("#id={}", hostile.id));
    let shown = browser.value("document.querySelector('.tags').textContent");
    assert!(shown.as_str().unwrap().matches(reports::EVIL).count() == 2, "{shown}");
    let message = browser.value("[...document.querySelectorAll('.message')].map((m) => m.textContent).join()");
    assert!(message.as_str().unwrap().contains(reports::EVIL));
    assert_eq!(browser.value("document.querySelectorAll('svg, script[src], iframe').length"), json!(0));
    at_peace(&browser);
}

#[test]
fn an_earlier_report_tells_what_is_new_and_gone() {
    let Some(browser) = Browser::start(DESKTOP.0, DESKTOP.1) else { return };
    let more = reports::compared("more", 3);
    browser.open(&more.file, "");
    let count = |status: &str| browser.value(&format!("document.querySelectorAll('.row.{status}').length"));
    assert_ne!(count("new"), json!(0));
    assert_eq!(count("gone"), json!(0));
    let fewer = reports::compared("fewer", 1);
    browser.open(&fewer.file, "");
    assert_eq!(count("new"), json!(0));
    assert_ne!(count("gone"), json!(0));
    browser.picture("report-compared.png");
    at_peace(&browser);
}

#[test]
fn a_phone_shows_map_list_and_card() {
    let Some((browser, _)) = open("phone", PHONE, "") else { return };
    browser.wait("document.getElementById('map').dataset.painted");
    browser.picture("report-phone.png");
    assert_eq!(browser.value("document.documentElement.scrollWidth > innerWidth"), json!(false));
    browser.run("document.querySelector('.row.finding').click()");
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let shown = browser.value("document.getElementById('card').getBoundingClientRect().bottom <= innerHeight + 1");
    assert_eq!(shown, json!(true));
    browser.picture("report-phone-finding.png");
    at_peace(&browser);
}

/// A browser in which the graphics card draws black, and one that draws nothing.
#[test]
fn a_browser_that_cannot_draw_says_so() {
    let Some(browser) = Browser::start(DESKTOP.0, DESKTOP.1) else { return };
    let report = reports::broken("undrawn");
    browser.before_each_page(
        "const get = HTMLCanvasElement.prototype.getContext; \
         HTMLCanvasElement.prototype.getContext = function (kind, how) { \
         if (window.name === 'none') return null; \
         const context = get.call(this, kind, how); \
         if (how && !how.willReadFrequently) context.drawImage = () => {}; return context; }",
    );
    browser.open(&report.file, "");
    browser.wait("document.getElementById('map').dataset.painted");
    browser.wait("document.getElementById('toast').textContent.includes('graphics card')");
    let seen = "(() => { const c = document.getElementById('map'); \
                return new Set(c.getContext('2d').getImageData(0, 0, c.width, c.height).data).size; })()";
    assert!(browser.value(seen).as_u64().unwrap() > 20, "the map is drawn");
    browser.run("window.name = 'none'");
    browser.open(&report.file, "");
    browser.wait("document.querySelector('.no-map')?.textContent.includes('cannot draw')");
    browser.run("document.querySelector('.row.finding').click()");
    browser.wait("!document.getElementById('card').hidden");
    at_peace(&browser);
}

/// Two versions of a map as `diff --report` shows them.
#[test]
fn what_changed_is_shown_before_and_after() {
    for (size, name) in [(DESKTOP, "diff-desktop.png"), (PHONE, "diff-phone.png")] {
        let Some(browser) = Browser::start(size.0, size.1) else { return };
        let dir = tempfile::tempdir().unwrap();
        let text = std::fs::read_to_string(common::root().join("tests/rules/vm-03-08/good.osm")).unwrap();
        std::fs::write(dir.path().join("old.osm"), &text).unwrap();
        let turned = text.replacen("v=\"left\"", "v=\"right\"", 1).replacen("lat=\"35.25533", "lat=\"35.25535", 1);
        assert_ne!(turned, text);
        std::fs::write(dir.path().join("new.osm"), turned.replacen("v=\"50\"", "v=\"30\"", 2)).unwrap();
        common::program::lanewright(dir.path(), &["diff", "old.osm", "new.osm", "--report", "diff.html"]).exits(1);
        browser.open(&dir.path().join("diff.html"), "");
        browser
            .wait("document.documentElement.dataset.old === 'read' && document.getElementById('map').dataset.painted");
        assert_eq!(browser.value("document.getElementById('title').textContent"), json!("old.osm → new.osm"));
        let verdict = browser.value("document.getElementById('verdict').textContent");
        assert!(
            verdict.as_str().unwrap().contains("changed") && !verdict.as_str().unwrap().contains("info"),
            "{verdict}"
        );
        assert_eq!(
            browser.value("document.querySelector('#pane-changes h3').firstChild.textContent"),
            json!("Lanelets")
        );
        browser.press("j");
        browser.wait("document.querySelectorAll('#card canvas').length === 2");
        std::thread::sleep(std::time::Duration::from_millis(900));
        browser.picture(name);
        let pictures = "[...document.querySelectorAll('#card canvas')].map((c) => c.toDataURL().length)";
        let sizes = browser.value(pictures);
        assert!(sizes.as_array().unwrap().iter().all(|size| size.as_u64().unwrap() > 3000), "{sizes}");
        assert_eq!(browser.value("document.documentElement.scrollWidth > innerWidth"), json!(false));
        at_peace(&browser);
    }
}
