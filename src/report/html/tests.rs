//! The page on small maps: what it holds, and that hostile text stays text.

use crate::diagnostic::{Diagnostic, Finding, Place, Severity, Subject};
use crate::geometry::Point;
use crate::lanelet::{LaneletMap, LineString, LineStringId, Point as MapPoint, PointId};
use crate::projection::LonLat;
use crate::report::Sources;

use super::*;

const EVIL: &str = "</script><script>alert('{{map}}')</script><img src=x onerror=alert(1)>";

fn map() -> LaneletMap {
    let mut map = LaneletMap::default();
    for i in 1..=2_i64 {
        map.points.insert(MapPoint::new(PointId(i), Point::new(i as f64 * 10.0, 5.0), None));
    }
    let attributes = [("type", "line_thin"), ("name", EVIL)].into_iter().collect();
    map.linestrings.insert(LineString {
        id: LineStringId(9),
        points: vec![PointId(1), PointId(2)],
        attributes,
        span: None,
    });
    map
}

fn diagnostic(id: i64, code: &str, place: LonLat) -> Diagnostic {
    let finding = Finding::new("odd", Subject::LineString(id), EVIL).at(Place::Point(Point::new(12.0, 5.0)));
    let help = Some(EVIL.to_owned());
    Diagnostic { help, lonlat: Some(place), ..Diagnostic::new(code, Severity::Error, finding) }
}

fn with_report<T>(diagnostics: &[Diagnostic], make: impl FnOnce(&Report<'_>) -> T) -> T {
    let (map, sources) = (map(), Sources::new([]));
    make(&Report::new(diagnostics, &sources, &map))
}

fn report(diagnostics: &[Diagnostic], earlier: Option<&Earlier>) -> String {
    with_report(diagnostics, |report| html(report, &Page { title: EVIL, earlier, ..Page::default() }).unwrap())
}

fn findings(diagnostics: &[Diagnostic]) -> Vec<data::PageFinding> {
    with_report(diagnostics, |report| data::findings(&report.entries(), report.map, &Frame::of(report.map, None)))
}

const HERE: LonLat = LonLat { lon: 139.0, lat: 35.0 };

#[test]
fn no_text_of_the_map_becomes_markup() {
    let page = report(&[diagnostic(9, "x/odd", HERE)], None);
    assert!(!page.contains("<img") && !page.contains("<script>alert"), "hostile text stands in the page");
    assert_eq!(page.matches("<script").count(), 3, "data, map and the page's own script");
    assert!(page.contains("&lt;/script&gt;"), "the title is shown as it is");
}

#[test]
fn the_policy_names_the_script_that_is_there() {
    let page = report(&[], None);
    let (_, rest) = page.rsplit_once("<script>").unwrap();
    let (script, _) = rest.split_once("</script>").unwrap();
    let hash = STANDARD.encode(Sha256::digest(script.as_bytes()));
    assert!(page.contains(&format!("script-src 'sha256-{hash}'")));
    let (_, rest) = page.split_once("<style>").unwrap();
    let (style, _) = rest.split_once("</style>").unwrap();
    let hash = STANDARD.encode(Sha256::digest(style.as_bytes()));
    assert!(page.contains(&format!("style-src 'sha256-{hash}'")));
    assert!(!page.contains(" style=\""), "the policy forbids style attributes");
}

#[test]
fn the_same_map_gives_the_same_bytes() {
    let diagnostics = [diagnostic(9, "x/odd", HERE)];
    assert_eq!(report(&diagnostics, None), report(&diagnostics, None));
}

#[test]
fn an_earlier_report_tells_new_from_same_and_gone() {
    let far = LonLat { lon: 139.1, lat: 35.0 };
    let near = LonLat { lon: 139.000_005, lat: 35.0 };
    let old = [diagnostic(9, "x/odd", HERE), diagnostic(10, "x/odd", far), diagnostic(11, "x/even", far)];
    let earlier = Earlier::read(&report(&old, None)).unwrap();
    assert_eq!(earlier.title(), EVIL);
    let frame = Frame::of(&map(), None);
    let now = [diagnostic(77, "x/odd", near), diagnostic(11, "x/even", HERE), diagnostic(12, "x/even", HERE)];
    let mut findings = findings(&now);
    compare::compare(&mut findings, &earlier, &frame);
    let told: Vec<_> = findings.iter().map(|f| (f.key.as_str(), f.status.unwrap())).collect();
    use data::Status::{Gone, New, Same};
    assert_eq!(
        told,
        [
            // Another id at the same place.
            ("x/odd@line-77", Same),
            ("x/even@line-11", Same),
            ("x/even@line-12", New),
            ("x/odd@line-10", Gone),
        ]
    );
    assert_eq!(findings[3].at, Some([12.0 - frame.origin.x, 5.0 - frame.origin.y]));
}

#[test]
fn a_key_is_never_given_twice() {
    let twice = [diagnostic(9, "x/odd", HERE), diagnostic(9, "x/odd", HERE)];
    let findings = findings(&twice);
    assert_eq!([findings[0].key.as_str(), findings[1].key.as_str()], ["x/odd@line-9", "x/odd@line-9~2"]);
}

#[test]
fn what_is_no_report_is_refused() {
    assert!(matches!(Earlier::read("<html>"), Err(EarlierError::NoReport)));
    let damaged = report(&[], None).replacen(compare::DATA_MARK, &format!("{}AAAA", compare::DATA_MARK), 1);
    assert!(matches!(Earlier::read(&damaged), Err(EarlierError::Damaged(_))));
}
