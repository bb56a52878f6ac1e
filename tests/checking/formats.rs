//! Every format of a report is valid by its own schema, and text in a map cannot break out of it.

use lanewright::diagnostic::{Accepted, Diagnostic, Edit, Finding, Place, Severity, SourceSpan, Subject};
use lanewright::geometry::Point as PlanePoint;
use lanewright::lanelet::{
    Attributes, Bound, Lanelet, LaneletId, LaneletMap, LineString, LineStringId, Point, PointId,
};
use lanewright::projection::LonLat;
use lanewright::report::{self, FailOn, Report, Sources};
use lanewright::requirement::Requirement;
use serde_json::Value;

const TEXT: &str = "<osm>\n  <node id=\"1\"/>\n  <relation id=\"7\"/>\n</osm>\n";
/// Breaks out of every format that does not escape: XML, workflow commands, terminals, JSON, Markdown.
const HOSTILE: &str = "a\"b'c<d>&]]>\n::error::x%0A,y:z\r\u{1b}[31m\u{0}\\ ${{x}} `é` \u{202e}";
const DOCUMENT: &str = r#"```toml
id = "vm-03-02"
title = "Turn direction & \"bounds\""
category = "vm-03 intersections"
check = "automatic"
source = "https://example.org/vm-03-02"
edition = "1"

[faults.turn-missing]
severity = "error"
meaning = "No turn_direction."
help = "Give it one."

[faults.bound-type]
severity = "warning"
meaning = "Not virtual."
help = "Make it virtual."
```

# vm-03-02

## Required
This.

## Why
That.

## How to mend
So.

## Good and bad
Look.
"#;

fn lonlat(x: f64, y: f64) -> LonLat {
    LonLat { lon: 139.0 + x * 1e-5, lat: 35.0 + y * 1e-5 }
}

/// One straight lanelet, 7, between the ways 5 and 6.
fn map() -> LaneletMap {
    let mut map = LaneletMap::default();
    for (id, x, y) in [(1, 0.0, 3.0), (2, 10.0, 3.0), (3, 0.0, 0.0), (4, 10.0, 0.0)] {
        map.points.insert(Point::new(PointId(id), PlanePoint::new(x, y), Some(0.0)).with_lonlat(Some(lonlat(x, y))));
    }
    for (id, points) in [(5, [1, 2]), (6, [3, 4])] {
        let points = points.map(PointId).to_vec();
        map.linestrings.insert(LineString { id: LineStringId(id), points, attributes: Attributes::new(), span: None });
    }
    let bound = |id| Bound { line: LineStringId(id), inverted: false };
    map.lanelets.insert(Lanelet {
        id: LaneletId(7),
        left: bound(5),
        right: bound(6),
        centerline: None,
        regulatory_elements: Vec::new(),
        attributes: Attributes::new(),
        span: None,
    });
    map
}

fn diagnostic(code: &str, severity: Severity, finding: Finding) -> Diagnostic {
    Diagnostic {
        code: code.to_owned(),
        severity,
        finding,
        help: Some("Give it one.".to_owned()),
        span: Some(SourceSpan { file: 0, start: 25, end: 44 }),
        lonlat: Some(lonlat(5.0, 1.5)),
        local: Some(PlanePoint::new(5.0, 1.5)),
    }
}

fn diagnostics() -> Vec<Diagnostic> {
    let turn = Finding::new("turn-missing", Subject::Lanelet(7), format!("turn {HOSTILE}"))
        .with(Subject::LineString(5), "left bound")
        .measured(12.5, f64::NAN, "deg")
        .fixed_by(
            "set it",
            true,
            vec![Edit::SetTag { on: Subject::Lanelet(7), key: "turn_direction".into(), value: HOSTILE.into() }],
        );
    let bound = Finding::new("bound-type", Subject::LineString(5), "not virtual");
    let point = Finding::new("odd", Subject::Point(1), "odd").at(Place::Polygon(vec![
        PlanePoint::new(0.0, 0.0),
        PlanePoint::new(0.0, 1.0),
        PlanePoint::new(1.0, 1.0),
    ]));
    let mut whole = diagnostic("load/empty", Severity::Warning, Finding::new("empty", Subject::Map, "empty"));
    (whole.span, whole.lonlat, whole.local, whole.help) = (None, None, None, None);
    vec![
        diagnostic("vm-03-02/bound-type", Severity::Warning, bound.clone()),
        diagnostic("vm-03-02/bound-type", Severity::Warning, bound),
        diagnostic("vm-03-02/turn-missing", Severity::Error, turn),
        diagnostic("x/odd", Severity::Info, point),
        whole,
    ]
}

type Writer = fn(&Report<'_>, &mut dyn std::io::Write) -> std::io::Result<()>;

fn written(writer: Writer, diagnostics: &[Diagnostic], change: impl Fn(&mut Report<'_>)) -> String {
    let map = map();
    let name = format!("maps/{}", "a b,c%.osm");
    let sources = Sources::new([(name.as_str(), TEXT)]);
    let requirement = Requirement::parse("vm-03-02", DOCUMENT).unwrap();
    let requirements = [&requirement];
    let gone = Finding::new("odd", Subject::Lanelet(7), "odd");
    let accepted =
        [Accepted { found: diagnostic("x/odd", Severity::Warning, gone), reason: "it stands there".to_owned() }];
    let mut report = Report {
        diagnostics,
        sources: &sources,
        map: &map,
        requirements: &requirements,
        fail_on: FailOn::Error,
        show: Severity::Info,
        cap: None,
        suppressed: 2,
        known: 3,
        accepted: &accepted,
        unproject: Some(&|points| Some(points.iter().map(|p| lonlat(p.x, p.y)).collect())),
        root: None,
    };
    change(&mut report);
    let mut out = Vec::new();
    writer(&report, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn plain(writer: Writer) -> String {
    written(writer, &diagnostics(), |_| {})
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in\n{text}"))
}

#[track_caller]
fn assert_valid(schema: &str, value: &Value) {
    let validator = jsonschema::validator_for(&json(schema)).unwrap();
    let errors: Vec<String> =
        validator.iter_errors(value).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert!(errors.is_empty(), "{}", errors.join("\n"));
}

#[test]
fn json_is_as_its_schema_says() {
    let value = json(&plain(report::json::write));
    assert_valid(include_str!("../../docs/report.schema.json"), &value);
    let totals = &value["totals"];
    assert_eq!((&totals["error"], &totals["warning"], &totals["info"]), (&1.into(), &3.into(), &1.into()));
    assert_eq!((&totals["suppressed"], &totals["baseline"]), (&2.into(), &3.into()));
    let accepted = &value["accepted"][0];
    assert_eq!((&accepted["code"], &accepted["primitive"]["id"]), (&"x/odd".into(), &7.into()));
    assert_eq!(accepted["reason"], "it stands there");
    let turn = &value["findings"][2];
    assert_eq!(turn["message"], format!("turn {HOSTILE}"));
    assert_eq!(turn["source"], json(r#"{"file":"maps/a b,c%.osm","line":3,"column":3}"#));
    assert_eq!(turn["measure"], json(r#"{"value":12.5,"limit":null,"unit":"deg"}"#));
    assert_eq!(turn["fix"]["edits"][0]["edit"], "set-tag");
    assert_eq!(turn["position"]["x"], 5.0);
    let chain = json(r#"[{"kind":"lanelet","id":7},{"kind":"linestring","id":5}]"#);
    assert_eq!(value["findings"][3]["referrers"], chain);
}

#[test]
fn json_caps_each_code_and_keeps_its_total() {
    let value = json(&written(report::json::write, &diagnostics(), |report| report.cap = Some(1)));
    assert_valid(include_str!("../../docs/report.schema.json"), &value);
    assert_eq!(value["findings"].as_array().unwrap().len(), 4);
    assert_eq!(value["totals"]["shown"], 4);
    let most = &value["totals"]["codes"][0];
    assert_eq!((&most["code"], &most["count"], &most["shown"]), (&"vm-03-02/bound-type".into(), &2.into(), &1.into()));
}

#[test]
fn sarif_is_valid_by_the_official_schema() {
    let value = json(&plain(report::sarif::write));
    assert_valid(include_str!("../schemas/sarif-2.1.0.json"), &value);
    let run = &value["runs"][0];
    let first = &run["results"][0];
    assert_eq!(first["ruleId"], "vm-03-02/turn-missing", "the worst first");
    assert_eq!(run["tool"]["driver"]["rules"][0]["help"]["text"], "Give it one.");
    assert!(run["tool"]["driver"]["rules"][0]["help"]["markdown"].as_str().unwrap().contains("## How to mend"));
    let location = &first["locations"][0]["physicalLocation"];
    assert_eq!(location["artifactLocation"]["uri"], "maps/a%20b%2Cc%25.osm");
    assert_eq!(location["region"], json(r#"{"startLine":3,"startColumn":3}"#));
    assert!(first["message"]["text"].as_str().unwrap().contains("lanelet 7"));
    let odd = run["results"].as_array().unwrap().iter().find(|one| one["ruleId"] == "x/odd").unwrap();
    assert_eq!(odd["locations"][0]["logicalLocations"][0]["fullyQualifiedName"], "lanelet 7/linestring 5/point 1");
    let prints: Vec<&Value> =
        run["results"].as_array().unwrap().iter().map(|one| &one["partialFingerprints"]["primitive/v1"]).collect();
    assert_ne!(prints[1], prints[2], "two findings of a kind on one primitive");
    let dismissed = run["results"].as_array().unwrap().last().unwrap();
    assert_eq!(dismissed["suppressions"][0]["justification"], "it stands there");
    assert_eq!(first["suppressions"], Value::Null);
}

#[test]
fn sarif_keeps_the_worst_that_code_scanning_keeps() {
    let mut many: Vec<Diagnostic> = (0..6_000)
        .map(|id| diagnostic("x/odd", Severity::Info, Finding::new("odd", Subject::Lanelet(id), "odd")))
        .collect();
    many.push(diagnostic("x/bad", Severity::Error, Finding::new("bad", Subject::Lanelet(1), "bad")));
    let value = json(&written(report::sarif::write, &many, |_| {}));
    let run = &value["runs"][0];
    assert_eq!(
        run["results"].as_array().unwrap().len(),
        report::sarif::MAX_RESULTS,
        "none is left for what was dismissed"
    );
    assert_eq!(run["results"][0]["ruleId"], "x/bad");
    let note = run["invocations"][0]["toolExecutionNotifications"][0]["message"]["text"].as_str().unwrap();
    assert!(note.contains("6001 findings"), "{note}");
}

#[test]
fn github_commands_stay_on_their_lines() {
    let text = plain(report::github::write);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 5, "{text}");
    assert!(
        lines[0]
            .starts_with("::error file=maps/a b%2Cc%25.osm,line=3,col=3,title=vm-03-02/turn-missing::lanelet 7: turn "),
        "{}",
        lines[0]
    );
    assert!(lines[0].contains("x%250A,y:z"), "{}", lines[0]);
    assert!(lines[0].contains("%0AGive it one.%0Afix: set it%0A"), "{}", lines[0]);
    assert!(!text.contains('\u{1b}'));
    assert!(lines.iter().any(|line| line.starts_with("::notice ")));
    assert!(
        lines.iter().any(|line| line.starts_with("::warning file=maps/a b%2Cc%25.osm,line=1,col=1,title=load/empty"))
    );
}

#[test]
fn gitlab_issues_have_what_gitlab_asks_for() {
    let value = json(&plain(report::gitlab::write));
    let issues = value.as_array().unwrap();
    let mut prints = std::collections::BTreeSet::new();
    for issue in issues {
        for key in ["description", "check_name", "fingerprint"] {
            assert!(issue[key].as_str().is_some_and(|text| !text.is_empty()), "{issue}");
        }
        assert!(["info", "minor", "major", "critical", "blocker"].contains(&issue["severity"].as_str().unwrap()));
        assert!(issue["location"]["lines"]["begin"].as_u64().unwrap() >= 1);
        assert_eq!(issue["location"]["path"], "maps/a b,c%.osm");
        assert!(prints.insert(issue["fingerprint"].as_str().unwrap()), "{issue}");
    }
    assert_eq!(issues.len(), 5);
}

#[test]
fn junit_is_xml_with_a_case_for_every_rule() {
    let text = plain(report::junit::write);
    let mut reader = quick_xml::Reader::from_str(&text);
    let mut names = Vec::new();
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Eof => break,
            quick_xml::events::Event::Start(tag) | quick_xml::events::Event::Empty(tag) => {
                tag.attributes().for_each(|attribute| drop(attribute.unwrap()));
                names.push(format!("{:?}", tag.name()));
            }
            _ => {}
        }
    }
    let count = |part: &str| names.iter().filter(|name| name.contains(part)).count();
    assert_eq!((count("testcase"), count("failure"), count("system-out")), (3, 1, 3), "{text}");
    assert!(text.contains(r#"tests="3" failures="1" errors="0" skipped="0""#), "{text}");
    assert!(text.contains("lanelet 7: turn a&quot;b"), "{text}");
    assert!(!text.contains('\u{1b}') && !text.contains('\u{0}'));
}

#[test]
fn geojson_features_are_where_the_findings_are() {
    let value = json(&plain(report::geojson::write));
    assert_eq!(value["type"], "FeatureCollection");
    let features = value["features"].as_array().unwrap();
    assert_eq!(features.len(), 5);
    let geometry = |at: usize| &features[at]["geometry"];
    assert_eq!(*geometry(0), json(r#"{"type":"LineString","coordinates":[[139.0,35.00003],[139.0001,35.00003]]}"#));
    assert_eq!(geometry(2)["type"], "Polygon");
    for at in [2, 3] {
        let ring = geometry(at)["coordinates"][0].as_array().unwrap();
        assert_eq!(ring.first(), ring.last(), "a ring is closed");
        let place = |i: usize| [ring[i][0].as_f64().unwrap() - 139.0, ring[i][1].as_f64().unwrap() - 35.0];
        let twice: f64 =
            (1..ring.len()).map(|i| (place(i - 1), place(i))).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        assert!(twice > 0.0, "an outer ring runs counter-clockwise: {ring:?}");
    }
    assert_eq!(*geometry(4), Value::Null, "the map as a whole lies nowhere");
    assert_eq!(features[2]["properties"]["message"], format!("turn {HOSTILE}"));
}

#[test]
fn geojson_without_a_projection_shows_the_primitive() {
    let value = json(&written(report::geojson::write, &diagnostics(), |report| report.unproject = None));
    assert_eq!(value["features"][3]["geometry"]["type"], "Point");
}

#[test]
fn paths_are_relative_to_the_repository() {
    let root = std::env::current_dir().unwrap();
    let root = root.parent().unwrap().to_owned();
    let value = json(&written(report::gitlab::write, &diagnostics(), |report| {
        // The tests run in the package's own directory.
        report.root = Some(Box::leak(Box::new(root.clone())));
    }));
    let own = std::env::current_dir().unwrap();
    let name = own.file_name().unwrap().to_str().unwrap();
    assert_eq!(value[0]["location"]["path"], format!("{name}/maps/a b,c%.osm"));
}

#[test]
fn concise_gives_a_line_each() {
    let mut out = Vec::new();
    report::concise(&mut out, &diagnostics(), &Sources::new([("a.osm", TEXT)])).unwrap();
    let text = String::from_utf8(out).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 5);
    assert_eq!(
        lines[0],
        "a.osm:3:3: warning[vm-03-02/bound-type] linestring 5: not virtual (at 35.0000150, 139.0000500)"
    );
    assert!(lines[2].contains("turn a\"b'c<d>&]]>\\n::error"), "{}", lines[2]);
    assert!(!text.contains('\u{1b}') && !text.contains('\u{202e}'));
    assert_eq!(lines[4], "warning[load/empty] empty");
}

#[test]
fn an_empty_report_is_valid_too() {
    let empty = |writer: Writer| written(writer, &[], |_| {});
    assert_valid(include_str!("../../docs/report.schema.json"), &json(&empty(report::json::write)));
    assert_valid(include_str!("../schemas/sarif-2.1.0.json"), &json(&empty(report::sarif::write)));
    assert_eq!(json(&empty(report::geojson::write))["features"], json("[]"));
    assert_eq!(json(&empty(report::gitlab::write)), json("[]"));
    assert_eq!(empty(report::github::write), "");
    assert!(empty(report::junit::write).contains(r#"failures="0""#));
}

#[test]
fn every_format_has_room_for_the_details() {
    let texts = [plain(report::github::write), plain(report::gitlab::write), plain(report::junit::write)];
    let mut written_text = Vec::new();
    let (map, found) = (map(), diagnostics());
    let sources = Sources::new([("a.osm", TEXT)]);
    report::full(&mut written_text, &Report::new(&found, &sources, &map), report::TextStyle::default()).unwrap();
    for text in texts.into_iter().chain([String::from_utf8(written_text).unwrap()]) {
        let parts = [
            "Give it one.",
            "fix: set it",
            "see also: linestring 5 (left bound)",
            "part of: lanelet 7",
            "x 5.00 m, y 1.50 m",
        ];
        for part in parts {
            assert!(text.contains(part), "`{part}` is missing in\n{text}");
        }
    }
    let value = json(&plain(report::geojson::write));
    let properties = &value["features"][2]["properties"];
    let expected = [("fix", json(r#""set it""#)), ("column", 3.into()), ("x", json("5.0")), ("lat", json("35.000015"))];
    for (key, expected) in expected {
        assert_eq!(properties[key], expected, "{key}");
    }
    assert_eq!(properties["related"], json(r#"["linestring 5 (left bound)"]"#));
    assert_eq!(value["features"][3]["properties"]["referrers"], json(r#"["lanelet 7","linestring 5"]"#));
}
