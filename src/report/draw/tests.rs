//! A lane, an intersection lanelet and a finding on a sheet.

use crate::diagnostic::{Finding, Severity, Subject};
use crate::lanelet::{Attributes, Bound, Lanelet, LineString, Point as MapPoint};
use crate::projection::{LonLat, Projector};

use super::*;

fn tags(pairs: &[(&str, &str)]) -> Attributes {
    pairs.iter().copied().collect()
}

/// One lane of 3 m by 20 m that goes north, with a road border on the right.
fn lane(subtype: &str, turn: Option<&str>) -> LaneletMap {
    let mut map = LaneletMap::default();
    for (id, x, y) in [(1, 0.0, 0.0), (2, 0.0, 20.0), (3, 3.0, 0.0), (4, 3.0, 20.0)] {
        map.points.insert(MapPoint::new(PointId(id), Point::new(x, y), Some(0.0)));
    }
    for (id, points, kind) in [(11, [1, 2], "line_thin"), (12, [3, 4], "road_border")] {
        map.linestrings.insert(LineString {
            id: LineStringId(id),
            points: points.map(PointId).to_vec(),
            attributes: tags(&[("type", kind), ("subtype", "solid")]),
            span: None,
        });
    }
    let mut attributes = tags(&[("type", "lanelet"), ("subtype", subtype)]);
    if let Some(turn) = turn {
        attributes.push("turn_direction", turn);
    }
    map.lanelets.insert(Lanelet {
        id: LaneletId(21),
        left: Bound { line: LineStringId(11), inverted: false },
        right: Bound { line: LineStringId(12), inverted: false },
        centerline: None,
        regulatory_elements: Vec::new(),
        attributes,
        span: None,
    });
    map
}

fn error_on(subject: Subject) -> Diagnostic {
    let finding = Finding::new("turn-missing", subject, "Lanelet 21 has no turn_direction.");
    Diagnostic::new("vm-03-02/turn-missing", Severity::Error, finding)
}

#[test]
fn surface_marking_and_arrow_are_drawn() {
    let svg = svg(&lane("road", None), &[], &Options::default()).unwrap();
    for class in ["road seam", "paint thin", "kerb", "tip plain"] {
        assert!(svg.contains(&format!("class=\"{class}\"")), "{class} is missing in {svg}");
    }
    assert!(!svg.contains("class=\"swatch"), "no turn, no hue to explain");
}

#[test]
fn a_turn_shows_its_hue() {
    let svg = svg(&lane("road", Some("left")), &[], &Options::default()).unwrap();
    assert!(svg.contains("class=\"turn left\"") && svg.contains("class=\"path left\""));
    assert!(svg.contains("class=\"swatch left\""));
}

#[test]
fn a_crosswalk_has_stripes() {
    let svg = svg(&lane("crosswalk", None), &[], &Options::default()).unwrap();
    assert_eq!(svg.matches("class=\"zebra\"").count(), 20, "20 m of half-metre stripes and gaps");
}

#[test]
fn a_finding_glows_and_has_a_pin() {
    let svg = svg(&lane("road", None), &[error_on(Subject::Lanelet(21))], &Options::default()).unwrap();
    assert!(svg.contains("class=\"veil error\"") && svg.contains("class=\"pin error\""));
    assert!(svg.contains("Lanelet 21 has no turn_direction."));
}

#[test]
fn the_same_map_gives_the_same_bytes() {
    let options = Options { ids: true, ..Options::default() };
    let draw = || png(&lane("road", Some("right")), &[error_on(Subject::LineString(12))], &options).unwrap();
    let picture = draw();
    assert!(picture.starts_with(b"\x89PNG"));
    assert!(picture == draw());
}

#[test]
fn pictures_that_cannot_be_are_refused() {
    let map = lane("road", None);
    let draw = |focus, scale| png(&map, &[], &Options { focus, scale, ..Options::default() });
    assert!(matches!(draw(Focus::Whole, Some(10_000.0)), Err(DrawError::TooLarge { .. })));
    assert!(matches!(draw(Focus::Primitive(99), None), Err(DrawError::NoSuchId(99))));
    assert!(matches!(draw(Focus::Whole, Some(0.0)), Err(DrawError::NotPositive { .. })));
    assert!(matches!(draw(Focus::Around(Point::new(0.0, 0.0), f64::NAN), None), Err(DrawError::NotPositive { .. })));
    assert!(matches!(svg(&LaneletMap::default(), &[], &Options::default()), Err(DrawError::Empty)));
}

#[test]
fn one_primitive_can_be_looked_at() {
    let map = lane("road", None);
    let around = view(&map, &Options { focus: Focus::Primitive(21), ..Options::default() }).unwrap();
    assert_eq!((around.min, around.max), (Point::new(-20.0, -20.0), Point::new(23.0, 40.0)));
}

/// A map whose left bound is painted so, in the plane of a projector.
fn painted(subtype: &str, colour: Option<&str>) -> LaneletMap {
    let mut map = lane("road", None);
    if let Some(line) = map.linestrings.get_mut(LineStringId(11)) {
        line.attributes.set("subtype", subtype);
        if let Some(colour) = colour {
            line.attributes.set("color", colour);
        }
    }
    map
}

#[test]
fn paint_is_true_to_scale() {
    let drawn = |map: &LaneletMap| svg(map, &[], &Options { scale: Some(10.0), ..Options::default() }).unwrap();
    // 20 m of dashes that are 3 m long and begin every 9 m: from the south edge, 60 px under the sheet's upper one.
    let dashed = drawn(&painted("dashed", None));
    assert!(
        dashed.contains("class=\"paint thin\" d=\"M60.0 260.0L60.0 230.0M60.0 170.0L60.0 140.0M60.0 80.0L60.0 60.0\"")
    );
    // Two lines 0.18 m either side, yellow; the left one, seen along the line, first.
    let double = drawn(&painted("solid_dashed", Some("yellow")));
    let lines = "d=\"M58.2 260.0L58.2 60.0M61.8 260.0L61.8 230.0M61.8 170.0L61.8 140.0M61.8 80.0L61.8 60.0\"";
    assert!(double.contains(&format!("class=\"paint thin paint-yellow\" {lines}")), "{double}");
}

#[test]
fn strokes_are_written_as_they_are_drawn() {
    let map = painted("solid_solid", Some("yellow"));
    let projector = Projector::transverse_mercator(LonLat { lon: 9.5, lat: 47.5 });
    let view = view(&map, &Options::default()).unwrap();
    let written = || {
        let mut out = Vec::new();
        geojson(&map, &projector, &view, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    };
    assert_eq!(written(), written());
    let read: serde_json::Value = serde_json::from_str(&written()).unwrap();
    let strokes: Vec<_> = read["features"].as_array().unwrap().iter().map(|one| &one["properties"]).collect();
    // The points of this lane have no longitude and latitude, so it has no outline.
    let [left, right, kerb] = strokes[..] else { panic!("{strokes:?}") };
    assert!(
        left == right && left["linestring"] == 11 && left["type"] == "line_thin" && left["subtype"] == "solid_solid"
    );
    assert!(left["color"] == "yellow" && left["breadth"] == 0.12);
    assert!(kerb["linestring"] == 12 && kerb["color"] == "grey" && kerb["breadth"] == 0.3);
    let first = |at: usize| {
        let place = &read["features"][at]["geometry"]["coordinates"][0];
        projector.forward(LonLat { lon: place[0].as_f64().unwrap(), lat: place[1].as_f64().unwrap() }, 0.0).unwrap()
    };
    assert!((first(0) - Point::new(-0.18, 0.0)).norm() < 1e-3 && (first(1) - Point::new(0.18, 0.0)).norm() < 1e-3);
}

#[test]
fn a_tunnel_is_drawn_before_the_street_above_it() {
    let mut map = lane("road", None);
    for (id, x, y) in [(5, -20.0, 12.0), (6, 20.0, 12.0), (7, -20.0, 8.0), (8, 20.0, 8.0)] {
        map.points.insert(MapPoint::new(PointId(id), Point::new(x, y), Some(-6.0)));
    }
    for (id, points) in [(13, [5, 6]), (14, [7, 8])] {
        let (points, attributes) = (points.map(PointId).to_vec(), tags(&[("type", "line_thin"), ("subtype", "solid")]));
        map.linestrings.insert(LineString { id: LineStringId(id), points, attributes, span: None });
    }
    // By its number the tunnel comes last.
    let tunnel = map.lanelets.get(LaneletId(21)).unwrap();
    let [left, right] = [13, 14].map(|id| Bound { line: LineStringId(id), inverted: false });
    map.lanelets.insert(Lanelet { id: LaneletId(22), left, right, ..tunnel.clone() });
    let options = Options { ids: true, ..Options::default() };
    let drawn = svg(&map, &[], &options).unwrap();
    let at = |words: &str| drawn.find(words).unwrap_or_else(|| panic!("{words} is not in {drawn}"));
    assert!(at("lanelet 22 ") < at("line_thin solid 13") && at("line_thin solid 13") < at("lanelet 21 "));
    // Not in the middle of the tunnel, where the street lies on it.
    let id_22 = drawn.split("<title>22</title>").nth(1).unwrap();
    let pixel = |text: &str| text.split("d=\"M").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
    let [street_left, street_right] = [0.0, 3.0].map(|x| view(&map, &options).unwrap().pixel(Point::new(x, 0.0)).x);
    assert!(!(street_left..street_right).contains(&pixel(id_22)));
}

#[test]
fn ids_do_not_lie_on_each_other() {
    let mut map = lane("road", Some("left"));
    let lanelet = map.lanelets.get(LaneletId(21)).unwrap().clone();
    for id in 100_000_000..100_000_060 {
        map.lanelets.insert(Lanelet { id: LaneletId(id), ..lanelet.clone() });
    }
    let drawn = svg(&map, &[], &Options { ids: true, ..Options::default() }).unwrap();
    let boxes: Vec<(f64, f64)> = drawn.split("<g class=\"id-turn\">").skip(1).map(pen_start).collect();
    assert!((2..61).contains(&boxes.len()), "{} of 61 ids in 20 m", boxes.len());
    for (i, a) in boxes.iter().enumerate() {
        for b in &boxes[..i] {
            assert!((a.1 - b.1).abs() > 9.0 || (a.0 - b.0).abs() > 60.0, "{a:?} and {b:?}");
        }
    }
}

/// Where the pen is set down first.
fn pen_start(group: &str) -> (f64, f64) {
    let path = group.split("d=\"M").nth(1).unwrap();
    let mut numbers = path.split([' ', 'L', 'M']).map(|number| number.parse::<f64>().unwrap());
    (numbers.next().unwrap(), numbers.next().unwrap())
}
