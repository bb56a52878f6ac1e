//! Where lanelets lead into areas and out of them, held against the real Lanelet2 library.

use std::io::Write;
use std::path::PathBuf;
use std::process::Stdio;

use lanewright::lanelet::index::MapIndex;
use lanewright::settings::Settings;
use serde_json::Value;

use crate::common::judging::load;
use crate::common::needs::python;
use crate::common::root;

/// What a line may say of being crossed.
const LINES: [&str; 14] = [
    "",
    "type=line_thin subtype=dashed",
    "type=line_thick subtype=dashed",
    "type=line_thin subtype=solid",
    "type=line_thin subtype=dashed_solid",
    "type=line_thick subtype=solid_dashed",
    "type=virtual",
    "type=virtual lane_change=no",
    "type=virtual lane_change:left=yes",
    "type=virtual lane_change:left=no",
    "type=virtual lane_change:right=yes",
    "type=road_border",
    "type=road_border lane_change=yes",
    "type=line_thin subtype=solid lane_change:left=yes lane_change:right=yes",
];

/// The good map of the rule, with other tags on one way and its points in this order, and an area beside the second lanelet.
fn variants() -> Vec<String> {
    let good = std::fs::read_to_string(root().join("tests/rules/area/good.osm")).unwrap();
    let beside = "<way id=\"120\"><nd ref=\"7\"/><nd ref=\"21\"/><nd ref=\"5\"/></way>\n\
                  <relation id=\"320\"><member type=\"way\" role=\"outer\" ref=\"104\"/><member type=\"way\" role=\"outer\" ref=\"120\"/>\
                  <tag k=\"type\" v=\"multipolygon\"/><tag k=\"participant:vehicle\" v=\"yes\"/></relation>\n</osm>";
    let node = "<node id=\"21\" lat=\"35.2552\" lon=\"139.7265\"><tag k=\"ele\" v=\"10\"/></node>\n  <way id=\"101\">";
    let good = good.replace("</osm>", beside).replacen("<way id=\"101\">", node, 1);
    let mut all = Vec::new();
    for way in ["104", "105", "107"] {
        let start = good.find(&format!("<way id=\"{way}\">")).unwrap();
        let end = start + good[start..].find("</way>").unwrap();
        let nodes: Vec<&str> =
            good[start..end].split("ref=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        for tags in LINES {
            for backwards in [false, true] {
                let mut order = nodes.clone();
                if backwards {
                    order.reverse();
                }
                let points: String = order.iter().map(|id| format!("<nd ref=\"{id}\"/>")).collect();
                let tags = tags.split_whitespace().filter_map(|tag| tag.split_once('='));
                let tags: String = tags.map(|(key, value)| format!("<tag k=\"{key}\" v=\"{value}\"/>")).collect();
                let map = format!("{}<way id=\"{way}\">{points}{tags}{}", &good[..start], &good[end..]);
                all.push(map.clone());
                all.push(map.replace("k=\"one_way\" v=\"yes\"", "k=\"one_way\" v=\"no\""));
            }
        }
    }
    all
}

#[test]
fn lanelets_lead_into_areas_and_out_of_them_as_lanelet2_says() {
    let Some(mut python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (mut paths, mut ours) = (Vec::new(), Vec::new());
    for (at, text) in variants().into_iter().enumerate() {
        let path: PathBuf = folder.path().join(format!("{at}.osm"));
        std::fs::write(&path, &text).unwrap();
        let (_, loaded) = load(&path);
        let settings = Settings::default();
        let index = MapIndex::new(&loaded.map, &loaded.faults, &settings);
        let mut doors = Vec::new();
        for area in &loaded.map.areas {
            let open = index.doors(area).into_iter().filter(|door| door.is_open);
            let sign = |leads_in: bool| if leads_in { "+" } else { "-" };
            doors.extend(open.map(|door| (sign(door.leads_in), index.lanes[door.lane].id.0, area.id.0)));
        }
        doors.sort_unstable();
        doors.dedup();
        ours.push(doors);
        // The library lets no vehicle into an area; bicycles cross the same paint.
        std::fs::write(&path, text.replace("participant:vehicle", "participant:bicycle")).unwrap();
        paths.push(path);
    }
    python.arg(root().join("tests/checking/area_doors.py"));
    let mut running = python.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    running.stdin.take().unwrap().write_all(serde_json::to_string(&paths).unwrap().as_bytes()).unwrap();
    let output = running.wait_with_output().unwrap();
    assert!(output.status.success(), "tests/checking/area_doors.py failed");
    let theirs: Vec<Vec<(String, i64, i64)>> =
        serde_json::from_slice::<Value>(&output.stdout).and_then(serde_json::from_value).unwrap();
    assert_eq!(theirs.len(), ours.len());
    assert!(theirs.iter().flatten().any(|(sign, _, area)| sign == "-" && *area == 320), "no way out over a bound");
    for (at, (theirs, ours)) in theirs.iter().zip(&ours).enumerate() {
        let theirs: Vec<(&str, i64, i64)> =
            theirs.iter().map(|(sign, lanelet, area)| (sign.as_str(), *lanelet, *area)).collect();
        assert_eq!(*ours, theirs, "variant {at}:\n{}", variants()[at]);
    }
}
