//! Maps that are built from OpenDRIVE: the sample file, either hand, and what is wrong in files.

use std::collections::BTreeSet;
use std::path::PathBuf;

use lanewright::api::{BuiltMap, Input, LayoutOptions};
use lanewright::build;
use lanewright::geometry::{Point, Polyline};
use lanewright::lanelet::Lanelet;
use lanewright::projection::Projector;
use lanewright::xodr::{self, Road};

use crate::common::needs::{accept, shared};
use crate::common::program::lanewright;
use crate::common::root;

fn sample() -> PathBuf {
    root().join("sample_maps/survey_right.xodr")
}

fn text() -> String {
    std::fs::read_to_string(sample()).unwrap()
}

fn built_from(text: &str) -> BuiltMap {
    build(Input::bytes("survey.xodr", text), &LayoutOptions::default()).unwrap()
}

/// The file for people who drive on the left: all mirrored at the x axis, and the lanes of the other side.
fn mirrored(text: &str) -> String {
    let negated = |value: &str| format!("{}", -value.parse::<f64>().unwrap());
    let keys = ["y", "hdg", "curvature", "curvStart", "curvEnd", "t", "aV", "bV", "cV", "dV"];
    let mut out = String::new();
    for line in text.lines() {
        let mut line = line.replace("rule=\"RHT\"", "rule=\"LHT\"");
        for key in keys {
            let mark = format!(" {key}=\"");
            let mut done = 0;
            while let Some(begin) = line[done..].find(&mark).map(|at| done + at + mark.len()) {
                let end = begin + line[begin..].find('"').unwrap();
                let value = negated(&line[begin..end]);
                line.replace_range(begin..end, &value);
                done = begin + value.len();
            }
        }
        if line.contains("<laneOffset") {
            line = line.replace("a=\"1.75\"", "a=\"-1.75\"");
        }
        for key in
            ["<lane id=\"", "<predecessor id=\"", "<successor id=\"", " from=\"", " to=\"", "fromLane=\"", "toLane=\""]
        {
            let mut done = 0;
            while let Some(begin) = line[done..].find(key).map(|at| done + at + key.len()) {
                let end = begin + line[begin..].find('"').unwrap();
                let value = line[begin..end].parse::<i64>().map_or(line[begin..end].to_owned(), |id| (-id).to_string());
                line.replace_range(begin..end, &value);
                done = begin + value.len();
            }
        }
        let line = line.replace("<left>", "<@>").replace("<right>", "<left>").replace("<@>", "<right>");
        let line = line.replace("</left>", "</@>").replace("</right>", "</left>").replace("</@>", "</right>");
        out.push_str(&line);
        out.push('\n');
    }
    out
}

fn of_subtype<'a>(map: &'a BuiltMap, subtype: &str) -> Vec<&'a Lanelet> {
    map.built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", subtype)).collect()
}

/// The road, section and border of every lane that is driven, every two metres, in the file's own metres.
fn border_points(road: &Road) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for section in &road.sections {
        let count = (section.length() / 2.0).ceil() as usize;
        for lane in &section.lanes {
            for i in 0..=count {
                let station = section.span[0] + section.length() * i as f64 / count as f64;
                for border in [lane.id, xodr::inner(lane.id)] {
                    points.push(road.place(station, section.offset(road, border, station)));
                }
            }
        }
    }
    points
}

#[test]
fn borders_are_those_of_the_file() {
    let (file, map) = (xodr::read(&text()).unwrap(), built_from(&text()));
    assert!(matches!(map.built.projector, Projector::TransverseMercator { .. }));
    let all = &map.built.map;
    let bounds: BTreeSet<_> = all.lanelets.iter().flat_map(|it| [it.left.line, it.right.line]).collect();
    let lines: Vec<Vec<(Point, f64)>> = bounds
        .iter()
        .map(|id| {
            let line = all.linestrings.get(*id).unwrap();
            let points = line.points.iter().map(|id| all.points.get(*id).unwrap());
            points.map(|point| (point.position, point.ele().unwrap())).collect()
        })
        .collect();
    let (mut worst, mut count) = (0.0_f64, 0);
    for [x, y, z] in file.roads.iter().flat_map(border_points) {
        let at = Point::new(x, y);
        let off = |line: &Vec<(Point, f64)>| {
            let flat = Polyline::new(line.iter().map(|(at, _)| *at))?;
            let on = flat.project(at);
            let heights: Vec<f64> = line.iter().map(|(_, height)| *height).collect();
            let stations = flat.stations();
            let behind = stations.partition_point(|station| *station <= on.station).clamp(1, stations.len() - 1);
            let [a, b] = [behind - 1, behind].map(|i| stations[i]);
            let part = ((on.station - a) / (b - a).max(1e-9)).clamp(0.0, 1.0);
            let height = heights[behind - 1] + (heights[behind] - heights[behind - 1]) * part;
            Some(flat.distance(at).max((height - z).abs()))
        };
        let nearest = lines.iter().filter_map(off).fold(f64::INFINITY, f64::min);
        worst = worst.max(nearest);
        count += 1;
    }
    assert!(count > 1000 && worst <= 0.01, "{count} points, the worst {worst} m off");
}

#[test]
fn the_sample_has_its_junctions_lights_signs_and_crosswalk() {
    for text in [text(), mirrored(&text())] {
        let map = built_from(&text);
        let all = &map.built.map;
        assert_eq!(of_subtype(&map, "crosswalk").len(), 1);
        let elements = |subtype: &str| all.regulatory_elements.iter().filter(|it| it.subtype == subtype).count();
        assert_eq!(elements("traffic_light"), 4);
        assert_eq!(elements("traffic_sign"), 2);
        assert_eq!(elements("crosswalk"), 1);
        let turns = |turn: &str| all.lanelets.iter().filter(|it| it.attributes.is("turn_direction", turn)).count();
        assert!(turns("left") >= 4 && turns("right") >= 4 && turns("straight") >= 4);
        assert!(map.built.summary.intersections >= 1);
        let limits: BTreeSet<&str> = all.lanelets.iter().filter_map(|it| it.attributes.get("speed_limit")).collect();
        assert!(["30", "50", "60", "100"].iter().all(|limit| limits.contains(limit)), "{limits:?}");
    }
}

#[test]
fn our_rules_and_lanelet2_accept_the_sample_on_either_hand() {
    let dir = tempfile::tempdir().unwrap();
    for (name, text) in [("right", text()), ("left", mirrored(&text()))] {
        let (file, map) = (dir.path().join(format!("{name}.xodr")), dir.path().join(name));
        std::fs::write(&file, text).unwrap();
        lanewright(dir.path(), &["build", file.to_str().unwrap(), "-o", map.to_str().unwrap()]).exits(0);
        let check =
            lanewright(dir.path(), &["check", map.to_str().unwrap(), "--fail-on", "error", "--format", "concise"]);
        assert_eq!(check.code, 0, "{name}: {}{}", check.stdout, check.stderr);
        if let Some(run) = accept(&map.join("lanelet2_map.osm"), false) {
            assert_eq!(run.code, 0, "{name}: {}{}", run.stdout, run.stderr);
        }
    }
}

#[test]
fn a_mirrored_file_gives_the_mirrored_map() {
    let [map, other] = [text(), mirrored(&text())].map(|text| built_from(&text).built);
    assert_eq!(map.summary, other.summary);
    let turns = |map: &lanewright::builder::Built, turn: &str| {
        map.map.lanelets.iter().filter(|it| it.attributes.is("turn_direction", turn)).count()
    };
    assert_eq!(turns(&map, "left"), turns(&other, "right"));
    assert_eq!(turns(&map, "straight"), turns(&other, "straight"));
}

#[test]
fn bad_files_are_told_with_their_line_and_nothing_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let whole = text();
    let cut = whole[..whole.len() / 2].to_owned();
    let none = whole.replace("type=\"driving\"", "type=\"none\"").replace("\"exit\"", "\"none\"");
    let none = none.replace("\"offRamp\"", "\"none\"");
    for (name, text, told) in [
        ("cut", cut, "survey.xodr:"),
        ("none", none, "lane for vehicles"),
        ("root", "<OpenDRIVE/>".into(), "lane for vehicles"),
    ] {
        let file = dir.path().join("survey.xodr");
        std::fs::write(&file, text).unwrap();
        let run = lanewright(dir.path(), &["build", "survey.xodr", "-o", "map"]);
        assert_eq!(run.code, 2, "{name}: {}", run.stdout);
        assert!(run.stderr.contains(told), "{name}: {}", run.stderr);
        assert!(!dir.path().join("map").exists(), "{name}");
    }
}

#[test]
fn odd_files_are_built_and_their_oddities_told() {
    let odd = text()
        .replacen("hdg=\"0\"", "hdg=\"NaN\"", 1)
        .replace("elementId=\"main_1\"", "elementId=\"gone\"")
        .replace("incomingRoad=\"north\"", "incomingRoad=\"nowhere\"")
        .replace("<road id=\"south\"", "<road id=\"bare\" length=\"3\"/><road id=\"south\"");
    let map = built_from(&odd);
    let told = |words: &str| {
        map.built.notes.iter().any(|note| note.message.starts_with("line ") && note.message.contains(words))
    };
    for words in ["hdg=\"NaN\"", "road nowhere", "road bare has no reference line"] {
        assert!(told(words), "{words}: {:?}", map.built.notes);
    }
}

#[test]
fn a_file_without_a_place_is_local_until_it_is_given_one() {
    let begin = text().find("<geoReference>").unwrap();
    let end = text().find("</geoReference>").unwrap() + "</geoReference>".len();
    let mut placeless = text();
    placeless.replace_range(begin..end, "");
    assert_eq!(built_from(&placeless).built.projector, Projector::Local);
    let options = LayoutOptions { origin: Some([48.1, 11.5]), ..LayoutOptions::default() };
    let placed = build(Input::bytes("survey.xodr", placeless.as_str()), &options).unwrap();
    assert!(matches!(placed.built.projector, Projector::TransverseMercator { .. }));
    let [a, b] = [built_from(&text()), placed].map(|map| {
        let mut out = Vec::new();
        map.write_osm(&mut out).unwrap();
        out
    });
    assert!(a == b, "the same place gives the same map");
}

#[test]
fn a_georeference_whose_origin_is_far_away_is_not_that_of_the_map() {
    let begin = text().find("<geoReference>").unwrap();
    let end = text().find("</geoReference>").unwrap();
    for (words, name) in [
        ("+proj=tmerc +lat_0=0 +lon_0=9 +k=0.9996 +x_0=-174000 +y_0=-5405000", "MGRS"),
        ("+proj=tmerc +lat_0=0 +lon_0=12 +k=1 +x_0=4500000 +y_0=-5405000", "MGRS"),
        ("+proj=tmerc +lat_0=48 +lon_0=11.4 +k=1", "TransverseMercator"),
    ] {
        let mut far = text();
        far.replace_range(begin..end, &format!("<geoReference>{words}"));
        let projector = built_from(&far).built.projector;
        assert_eq!(projector.name(), name, "{words}: {projector:?}");
    }
}

#[test]
fn an_offset_that_exporters_write_with_the_wrong_sign_is_subtracted() {
    let begin = text().find("<geoReference>").unwrap();
    let end = text().find("</geoReference>").unwrap() + "</geoReference>".len();
    let latitude = |offset: &str| {
        let mut placed = text();
        let words = "<geoReference>+proj=utm +zone=16 +ellps=WGS84 +units=m</geoReference>";
        placed.replace_range(begin..end, &format!("{words}<offset {offset} z=\"0\" hdg=\"0\"/>"));
        let map = built_from(&placed).built;
        let node = map.map.points.iter().next().unwrap().position;
        map.projector.inverse(node).unwrap().lat
    };
    let [added, subtracted] = ["x=\"667733\" y=\"3878705\"", "x=\"-667733\" y=\"-3878705\""].map(latitude);
    assert!((added - 35.04).abs() < 0.1 && (added - subtracted).abs() < 0.01, "{added} {subtracted}");
}

#[test]
fn metres_from_a_place_that_is_named_beside_a_zone_are_taken_so() {
    let begin = text().find("<geoReference>").unwrap();
    let end = text().find("</geoReference>").unwrap();
    let place = |words: &str| {
        let mut placed = text();
        placed.replace_range(begin..end, &format!("<geoReference>{words} +datum=WGS84"));
        let map = built_from(&placed).built;
        let node = map.map.points.iter().next().unwrap().position;
        map.projector.inverse(node).unwrap()
    };
    // The corner of a square of MGRS, half a metre off.
    let named = place("+proj=utm +zone=54 +lat_0=35.23809209301421 +lon_0=139.90096462111694");
    assert!((named.lat - 35.24).abs() < 0.05 && (named.lon - 139.9).abs() < 0.05, "{named:?}");
    let other_zone = place("+proj=utm +zone=32 +lat_0=37.35 +lon_0=-122.09");
    assert!(other_zone.lat.abs() < 0.1, "{other_zone:?}");
}

#[test]
fn every_public_file_is_built() {
    let Some(folder) = shared("corpus/xodr") else { return };
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "xodr") {
            let map = build(path.as_path(), &LayoutOptions::default());
            assert!(map.is_ok_and(|map| !of_subtype(&map, "road").is_empty()), "{}", path.display());
            count += 1;
        }
    }
    assert!(count >= 17);
}

/// A road of one lane that begins at `x`.
fn one_road(x: &str, lane: &str) -> String {
    format!(
        r#"<OpenDRIVE><header revMajor="1" revMinor="4"/><road id="1" junction="-1" length="100">
<planView><geometry s="0" x="{x}" y="0" hdg="0" length="100"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right><lane id="-1" type="{lane}">
<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right></laneSection></lanes></road></OpenDRIVE>"#
    )
}

#[test]
fn each_fault_of_a_file_is_said_once() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.xodr"), one_road("1e300", "driving")).unwrap();
    for more in [&["--guesses"][..], &[]] {
        let arguments = [&["build", "--isolated", "a.xodr", "-o", "map", "--force"], more].concat();
        let run = lanewright(dir.path(), &arguments).exits(0);
        let said = format!("{}{}", run.stdout, run.stderr);
        assert_eq!(said.matches("x=\"1e300\"").count(), 1, "{said}");
    }
}

#[test]
fn a_file_without_a_lane_says_what_else_is_wrong_with_it() {
    let dir = tempfile::tempdir().unwrap();
    let refused = |text: String| {
        std::fs::write(dir.path().join("a.xodr"), text).unwrap();
        lanewright(dir.path(), &["build", "--isolated", "a.xodr", "-o", "map"]).exits(2).stderr
    };
    let far = refused(one_road("1e9", "driving"));
    assert!(far.contains("road 1 leads out of the world at s=0.0: it is left out)"), "{far}");
    let other = refused(one_road("0", "sidewalk"));
    assert!(other.contains("none of the 1 roads has a lane for vehicles") && !other.contains("width ("), "{other}");
}
