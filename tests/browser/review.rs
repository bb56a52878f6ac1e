//! `lanewright view --review` in the browser: a whole review, from the first look to the saved map.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use lanewright::api::{CheckOptions, check};
use lanewright::diagnostic::{Diagnostic, Severity};
use serde_json::json;

use super::driver::Browser;
use super::{DESKTOP, PHONE, at_peace, data};
use crate::common::needs::shared;
use crate::common::program::{Server, lanewright};

/// A copy of Autoware's intersection that may be written to.
fn intersection(dir: &Path) -> Option<PathBuf> {
    let file = dir.join("map.osm");
    fs::copy(shared("corpus/lanelet2/autoware_intersection.osm")?, &file).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
    Some(file)
}

struct Page {
    browser: Browser,
    file: PathBuf,
    dir: tempfile::TempDir,
    _server: Server,
}

impl Page {
    fn open((width, height): (u32, u32)) -> Option<Self> {
        let browser = Browser::start(width, height)?;
        let dir = tempfile::tempdir().unwrap();
        let file = intersection(dir.path())?;
        let server = Server::start(dir.path(), &["--review", file.to_str().unwrap()]);
        browser.visit(&server.url);
        let page = Self { browser, file, dir, _server: server };
        page.tried();
        Some(page)
    }

    fn pane(&self, name: &str) -> String {
        data(&self.browser, "pane-review", name)
    }

    fn number(&self, name: &str) -> usize {
        self.pane(name).parse().unwrap()
    }

    /// Waits until it is known what would come of the fix that is looked at.
    fn tried(&self) {
        self.browser.wait("document.getElementById('pane-review').dataset.preview === 'yes'");
    }

    /// Does something and waits for what the server says of it.
    fn said(&self, act: impl FnOnce()) -> String {
        self.browser.run("document.getElementById('pane-review').dataset.said = ''");
        let version = self.browser.value("document.documentElement.dataset.version");
        act();
        self.browser.wait("document.getElementById('pane-review').dataset.said");
        self.browser.wait(&format!("document.documentElement.dataset.version !== {version}"));
        self.pane("said")
    }

    /// Rejects two fixes, for a reason.
    fn reject_two(&self) {
        for _ in 0..2 {
            self.tried();
            self.browser.press("x");
            self.browser.wait("document.activeElement.id === 'reason'");
            let said = self.said(|| self.browser.press("the sign stands on the other side\u{e007}"));
            assert!(said.starts_with("rejected"), "{said}");
        }
        assert_eq!(self.number("rejected"), 2);
    }

    /// Looks at an element, until the map has come to rest.
    fn choose(&self, id: &str) {
        self.browser.run(&format!("location.hash = '#id={id}'"));
        self.browser.wait("document.querySelector('#hand')");
        std::thread::sleep(std::time::Duration::from_millis(900));
    }

    /// The nodes that can be dragged, with their places in the window.
    fn handles(&self) -> Vec<(String, [f64; 2])> {
        self.browser.wait("document.getElementById('map').dataset.handles");
        std::thread::sleep(std::time::Duration::from_millis(300));
        let map = self
            .browser
            .value("(({ left, top }) => [left, top])(document.getElementById('map').getBoundingClientRect())");
        let [left, top] = [0, 1].map(|at| map[at].as_f64().unwrap());
        let read = |one: &str| {
            let parts: Vec<&str> = one.split(' ').collect();
            let [x, y] = [1, 2].map(|at| parts[at].parse::<f64>().unwrap());
            (parts[0].to_owned(), [x + left, y + top])
        };
        data(&self.browser, "map", "handles").split(", ").map(read).collect()
    }

    /// Has a lanelet no longer give way to another, on the card of that.
    fn take_a_yield(&self, text: &str) {
        let browser = &self.browser;
        let lanelet = lanelet_with_yield(text);
        browser.run(&format!("location.hash = '#id={lanelet}'"));
        browser.wait("document.querySelector('#hand .take-yield')");
        std::thread::sleep(std::time::Duration::from_millis(700));
        browser.picture("review-edit.png");
        let yields = "document.querySelectorAll('#hand .take-yield').length";
        let many = browser.value(yields).as_u64().unwrap();
        let said = self.said(|| _ = browser.run("document.querySelector('#hand .take-yield').click()"));
        assert!(said.contains("does not give way"), "{said}");
        browser.wait(&format!("{yields} === {}", many - 1));
    }
}

fn errors(file: &Path) -> Vec<Diagnostic> {
    let found = check(file, CheckOptions::default()).unwrap().sorted.left;
    found.into_iter().filter(|one| one.severity == Severity::Error).collect()
}

#[test]
fn a_review_ends_in_a_map() {
    let Some(page) = Page::open(DESKTOP) else { return };
    let Page { browser, file, dir, .. } = &page;
    let before = fs::read_to_string(file).unwrap();
    let errors_before = errors(file).len();
    std::thread::sleep(std::time::Duration::from_millis(900));
    browser.picture("review-desktop.png");
    assert_eq!(browser.value("document.querySelectorAll('button.pair img').length"), json!(2));
    let assumed = browser.value("document.querySelector('.why').textContent");
    assert!(assumed.as_str().unwrap().contains("Takes for granted"), "{assumed}");

    // Keys: look at the next one and back, accept five, put one off.
    let first = page.pane("at");
    browser.press("n");
    browser.wait(&format!("document.getElementById('pane-review').dataset.at !== '{first}'"));
    browser.press("p");
    browser.wait(&format!("document.getElementById('pane-review').dataset.at === '{first}'"));
    let mut accepted = 0;
    while accepted < 5 {
        page.tried();
        let can = browser.value("!document.getElementById('accept').disabled");
        let said = page.said(|| browser.press(if can == json!(true) { "y" } else { "l" }));
        assert!(said.starts_with(if can == json!(true) { "accepted" } else { "put off" }), "{said}");
        accepted += usize::from(can == json!(true));
    }
    assert_eq!(page.number("accepted"), 5);
    // What was accepted is undone and made again.
    page.said(|| browser.press("u"));
    assert_eq!(page.number("accepted"), 4);
    page.tried();
    page.said(|| _ = browser.run("document.getElementById('accept').click()"));
    assert_eq!(page.number("accepted"), 5);

    page.reject_two();
    // What is chosen on the map is the next fix, of which the pane tells all: no card lies over the map.
    assert_eq!(browser.value("document.getElementById('card').hidden"), json!(true));
    std::thread::sleep(std::time::Duration::from_millis(700));
    browser.picture("review-decided.png");

    page.take_a_yield(&before);
    assert_eq!(fs::read_to_string(file).unwrap(), before, "nothing is written before it is saved");
    assert_eq!(page.pane("unsaved"), "yes");

    let said = page.said(|| browser.press("w"));
    assert!(said.starts_with("saved"), "{said}");
    assert_eq!(page.pane("unsaved"), "");
    at_peace(browser);

    // The map has what was decided, and the baseline what was rejected.
    let after = fs::read_to_string(file).unwrap();
    assert_ne!(after, before);
    let removed = before.lines().filter(|line| line.contains("role=\"yield\"")).count();
    assert!(after.lines().filter(|line| line.contains("role=\"yield\"")).count() + 1 >= removed);
    let kept = before.lines().filter(|line| after.contains(line)).count();
    assert!(kept + 60 > before.lines().count(), "{kept} of {} lines are left", before.lines().count());
    let baseline = fs::read_to_string(dir.path().join("baseline.json")).unwrap();
    let known: serde_json::Value = serde_json::from_str(&baseline).unwrap();
    let known = known["findings"].as_array().unwrap();
    // One fix may mend several findings.
    assert!(
        known.len() >= 2 && known.iter().all(|one| one["reason"] == "the sign stands on the other side"),
        "{baseline}"
    );
    assert!(errors(file).len() < errors_before, "{} errors, {errors_before} before", errors(file).len());
    let checked = lanewright(dir.path(), &["check", "map.osm", "--isolated", "--baseline", "baseline.json"]);
    assert!(checked.stdout.contains(&format!("{} known from the baseline", known.len())), "{}", checked.stdout);
    assert!(checked.stdout.contains(": the sign stands on the other side"), "{}", checked.stdout);
}

/// The id of the first area of an intersection.
fn intersection_area(text: &str) -> String {
    let is_area = |way: &&str| way.split("</way>").next().unwrap().contains("v=\"intersection_area\"");
    let way = text.split("<way id=\"").skip(1).find(is_area).unwrap();
    way.split('"').next().unwrap().to_owned()
}

#[test]
fn nodes_are_dragged_by_hand() {
    let Some(page) = Page::open(DESKTOP) else { return };
    let Page { browser, file, .. } = &page;
    let before = fs::read_to_string(file).unwrap();

    // A vertex of an area goes where it is let go.
    page.choose(&intersection_area(&before));
    let handles = page.handles();
    let far = |one: &(String, [f64; 2])| {
        let gap = |other: &(String, [f64; 2])| (other.1[0] - one.1[0]).hypot(other.1[1] - one.1[1]);
        handles.iter().filter(|other| other.0 != one.0).map(gap).fold(f64::INFINITY, f64::min)
    };
    let (node, [x, y]) = handles.iter().max_by(|a, b| far(a).total_cmp(&far(b))).unwrap().clone();
    // Where another node stands it would run over that, which is undone.
    let moved =
        [[31.0, -33.0], [-40.0, 25.0], [27.0, 40.0], [-33.0, -30.0], [60.0, 9.0]].into_iter().find(|[right, down]| {
            let said = page.said(|| browser.drag([x, y], [x + right, y + down], None));
            assert!(said.starts_with("edited: "), "{said}");
            let moved = said.starts_with(&format!("edited: vertex {node}"));
            if !moved {
                page.said(|| browser.press("u"));
            }
            moved
        });
    let [right, down] = moved.unwrap();
    let (_, now) = page.handles().into_iter().find(|(id, _)| *id == node).unwrap();
    assert!((now[0] - x - right).abs() < 2.0 && (now[1] - y - down).abs() < 2.0, "{x} {y} to {now:?}");
    browser.picture("review-vertex.png");
    page.said(|| browser.press("u"));
    assert_eq!(page.pane("unsaved"), "");

    // An end of a bound becomes the node that it is let fall onto, the nearest of those that lie there.
    page.choose(&lanelet_with_yield(&before));
    let ends = page.handles();
    let (from, there) = (ends[0].clone(), ends[2].1);
    let said = page.said(|| browser.drag(from.1, there, None));
    let onto = said.strip_prefix(&format!("edited: node {} becomes node ", from.0)).unwrap_or_else(|| panic!("{said}"));
    let (from, onto) = (from.0, onto.split(' ').next().unwrap());
    assert_eq!(page.pane("unsaved"), "yes");
    let said = page.said(|| browser.press("w"));
    assert!(said.starts_with("saved"), "{said}");
    let after = fs::read_to_string(file).unwrap();
    assert!(!after.contains(&format!("<node id=\"{from}\"")) && after.contains(&format!("<node id=\"{onto}\"")));
    at_peace(browser);
}

/// A lanelet of which a right of way lets others give way.
fn lanelet_with_yield(text: &str) -> String {
    let mut rights = String::new();
    for relation in text.split("<relation ").skip(1) {
        let is_right = relation.contains("v=\"right_of_way\"") && relation.contains("role=\"yield\"");
        let goes_first = |line: &&str| line.contains("role=\"right_of_way\"") || line.contains("role='right_of_way'");
        if let Some(line) = relation.lines().find(goes_first).filter(|_| is_right) {
            rights = line.split("ref=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
        }
    }
    rights
}

#[test]
fn a_phone_shows_a_review() {
    let Some(page) = Page::open(PHONE) else { return };
    std::thread::sleep(std::time::Duration::from_millis(900));
    page.browser.picture("review-phone.png");
    assert_eq!(page.browser.value("document.documentElement.scrollWidth > innerWidth"), json!(false));
    at_peace(&page.browser);
}
