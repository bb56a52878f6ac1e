//! Lanelets that `fix` cuts across, with what lies beside them and what hangs on them.

use std::convert::Infallible;

use lanewright::diagnostic::Severity;
use lanewright::fix::{Mended, mend};
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Lanelet, LaneletId, LaneletMap, LineStringId, PointId};
use lanewright::osm::OsmData;
use lanewright::rules::Config;
use lanewright::settings::Settings;

use crate::common::drawing::{Drawing, osm};
use crate::common::judging::{judge_as, loaded};
use crate::common::root;

/// Lanelet 240 runs west, over 80 m, along two oncoming ones that meet in nodes 31 and 41, at half its length.
fn drawn(more: &str, in_240: &str) -> OsmData {
    let path = root().join("tests/rules/vm-01-04/bad-cut-apart.osm");
    let text = std::fs::read_to_string(path).unwrap();
    let opened = "<relation id=\"240\">";
    assert!(text.contains(opened));
    osm(text.replace(opened, &format!("{opened}{in_240}")).replace("</osm>", &format!("{more}</osm>")))
}

/// Mended as far as the rules about lanes go; nothing is left, and nothing was refused.
fn mended(data: OsmData) -> (Mended, LaneletMap) {
    let (settings, config) = (Settings::default(), Config::default());
    let judge = |data: &OsmData| {
        let mut found = judge_as(&loaded(data), &settings, &config);
        found.retain(|one| one.code.starts_with("vm-01-0") || one.code.starts_with("load/"));
        Ok::<_, Infallible>(found)
    };
    let mended = mend(data, true, judge).unwrap();
    let errors: Vec<_> = mended.left.iter().filter(|one| one.severity == Severity::Error).collect();
    assert!(errors.is_empty() && mended.refused.is_empty(), "{errors:?} {:?}", mended.refused);
    let map = loaded(&mended.osm).map;
    (mended, map)
}

/// The points with which a lanelet starts and ends, left and right.
fn ends(map: &LaneletMap, lanelet: &Lanelet) -> [[PointId; 2]; 2] {
    let ids = |bound| map.bound_points(bound).map(|point| point.id).collect::<Vec<_>>();
    let [left, right] = [ids(lanelet.left), ids(lanelet.right)];
    [[left[0], right[0]], [left[left.len() - 1], right[right.len() - 1]]]
}

/// The piece in the east, with which lanelet 240 began, and the one behind it.
fn pieces(map: &LaneletMap) -> [&Lanelet; 2] {
    let starting = |edge| map.lanelets.iter().find(|lanelet| ends(map, lanelet)[0] == edge).unwrap();
    let first = starting([52, 42].map(PointId));
    [first, starting(ends(map, first)[1])]
}

fn points(map: &LaneletMap, way: LineStringId) -> Vec<i64> {
    map.linestrings.get(way).unwrap().points.iter().map(|id| id.0).collect()
}

#[test]
fn a_lane_is_cut_where_the_oncoming_ones_are() {
    let (_, map) = mended(drawn("", ""));
    let [first, second] = pieces(&map);
    assert_eq!([ends(&map, first)[0], ends(&map, second)[1]], [[52, 42], [50, 40]].map(|ids| ids.map(PointId)));
    assert_eq!(ends(&map, first)[1][1], PointId(41), "it is cut at the vertex that is there");
    let cut = map.points.get(ends(&map, first)[1][0]).unwrap();
    assert!(cut.id.0 > 240 && cut.ele() == Some(10.0), "on the other side a node is made, with its height: {cut:?}");
    assert_eq!(first.attributes.get("speed_limit"), Some("40"));
    let tags = |lanelet: &Lanelet| lanelet.attributes.iter().map(|(k, v)| format!("{k}={v}")).collect::<Vec<_>>();
    assert_eq!(tags(first), tags(second));
    // Each has the border in common with the oncoming lane beside it.
    for (piece, oncoming) in [(first, 231), (second, 230)] {
        assert_eq!(piece.right.line, map.lanelets.get(LaneletId(oncoming)).unwrap().right.line);
    }
}

#[test]
fn lanes_beside_it_are_cut_with_it_and_still_share_its_bounds() {
    // A shoulder in its direction, and a lane against it: both use way 192.
    let nodes = r#"<node id="70" lat="35.25524" lon="139.7258"><tag k="ele" v="10"/></node>
        <node id="72" lat="35.25524" lon="139.72667944728"><tag k="ele" v="10"/></node>"#;
    let way = r#"<way id="193"><nd ref="70"/><nd ref="72"/><tag k="type" v="road_border"/></way>"#;
    for (left, right, subtype) in [(193, 192, "road_shoulder"), (192, 193, "road")] {
        let beside = format!(
            r#"{nodes}{way}<relation id="250"><member type="way" role="left" ref="{left}"/>
            <member type="way" role="right" ref="{right}"/><tag k="type" v="lanelet"/><tag k="subtype" v="{subtype}"/>
            <tag k="location" v="urban"/><tag k="one_way" v="yes"/><tag k="speed_limit" v="40"/></relation>"#
        );
        let (_, map) = mended(drawn(&beside, ""));
        let [first, second] = pieces(&map);
        for piece in [first, second] {
            let is_beside = |lanelet: &&Lanelet| {
                lanelet.id != piece.id && [lanelet.left.line, lanelet.right.line].contains(&piece.left.line)
            };
            let beside = map.lanelets.iter().find(is_beside).unwrap();
            assert_eq!(beside.attributes.get("subtype"), Some(subtype));
            let [start, end] = ends(&map, beside);
            let shared = if subtype == "road" { [end[0], start[0]] } else { [start[1], end[1]] };
            assert_eq!(shared, ends(&map, piece).map(|[left, _]| left), "they begin and end together");
        }
        let settings = Settings::default();
        let index = MapIndex::new(&map, &[], &settings);
        let first_beside = index.lane(LaneletId(250)).unwrap();
        let linked = index.followers(first_beside).len() + index.predecessors(first_beside).len();
        assert_eq!(linked, 1, "the piece that kept the id leads to the other one, or follows it");
    }
}

/// A way across lanelet 240 at this longitude, as stop line 82 of an element 300.
fn with_element(longitude: f64, subtype: &str) -> String {
    format!(
        r#"<node id="80" lat="35.2553" lon="{longitude}"><tag k="ele" v="10"/></node>
        <node id="81" lat="35.25527070779" lon="{longitude}"><tag k="ele" v="10"/></node>
        <node id="83" lat="35.2553" lon="139.726"><tag k="ele" v="15"/></node>
        <node id="84" lat="35.25527" lon="139.726"><tag k="ele" v="15"/></node>
        <way id="82"><nd ref="80"/><nd ref="81"/><tag k="type" v="stop_line"/></way>
        <way id="85"><nd ref="83"/><nd ref="84"/><tag k="type" v="{subtype}"/><tag k="subtype" v="stop_sign"/></way>
        <relation id="300"><member type="way" role="refers" ref="85"/><member type="way" role="ref_line" ref="82"/>
        <tag k="type" v="regulatory_element"/><tag k="subtype" v="{subtype}"/></relation>"#
    )
}

const MEMBER: &str = r#"<member type="relation" role="regulatory_element" ref="300"/>"#;

#[test]
fn a_light_goes_to_the_piece_behind_its_stop_line() {
    let refer = |longitude: f64, subtype: &str| {
        let (_, map) = mended(drawn(&with_element(longitude, subtype), MEMBER));
        pieces(&map).map(|piece| piece.regulatory_elements.len())
    };
    // Half a metre before the cut: who has passed the line is on the second piece.
    assert_eq!(refer(139.726_245_2, "traffic_light"), [0, 1]);
    // Those that stop at a sign do so on the lane before its line.
    assert_eq!(refer(139.726_245_2, "traffic_sign"), [1, 0]);
    // In the middle of a piece.
    assert_eq!(refer(139.726_5, "traffic_light"), [1, 0]);
    assert_eq!(refer(139.726, "traffic_light"), [0, 1]);
}

#[test]
fn what_tells_no_place_concerns_both_pieces() {
    let element = r#"<relation id="300"><member type="relation" role="right_of_way" ref="240"/>
        <member type="relation" role="yield" ref="220"/><tag k="type" v="regulatory_element"/>
        <tag k="subtype" v="right_of_way"/></relation>"#;
    let (mended, map) = mended(drawn(element, MEMBER));
    let [first, second] = pieces(&map);
    assert_eq!([first.regulatory_elements.len(), second.regulatory_elements.len()], [1, 1]);
    let element = mended.osm.relations.iter().find(|relation| relation.id == 300).unwrap();
    let first_go = element.members.iter().filter(|member| member.role == "right_of_way").map(|member| member.id);
    let (mut named, mut both) = (first_go.collect::<Vec<i64>>(), [first.id.0, second.id.0]);
    named.sort_unstable();
    both.sort_unstable();
    assert_eq!(named, both);
    assert!(both.contains(&240), "one keeps the id");
}

#[test]
fn a_centre_line_is_cut_too() {
    let center = r#"<node id="90" lat="35.2552853539" lon="139.72667944728"><tag k="ele" v="10"/></node>
        <node id="91" lat="35.2552853539" lon="139.7258"><tag k="ele" v="10"/></node>
        <way id="92"><nd ref="90"/><nd ref="91"/></way>"#;
    let (_, map) = mended(drawn(center, r#"<member type="way" role="centerline" ref="92"/>"#));
    let lines = pieces(&map).map(|piece| points(&map, piece.centerline.unwrap()));
    assert_eq!((lines[0][0], lines[1][1]), (90, 91));
    assert_eq!((lines[0].len(), lines[1].len()), (2, 2));
    assert_eq!(lines[0][1], lines[1][0], "both have the node at the cut");
}

#[test]
fn a_second_run_changes_nothing() {
    let (first, _) = mended(drawn("", ""));
    let text = first.osm.sources[0].text.clone();
    let (second, _) = mended(osm(text.to_string()));
    assert!(second.done.is_empty(), "{:?}", second.done);
}

/// A road to the east in three lanelets, and one of 80 m to the north across the middle one, at a tenth of a metre more height; on the
/// right of it, if so asked, a second lane that is cut 8 m south and 12 m north of the middle, and has a border of its own.
fn crossing(has_lane_beside: bool) -> OsmData {
    let mut map = Drawing::default();
    let place = |[east, north]: [f64; 2]| [35.25 + north / 110_950.0, 139.72 + east / 91_170.0];
    let mut line = |way: i64, places: &[[f64; 2]], ele: &str| {
        let ids: Vec<i64> = (0..).zip(places).map(|(i, _)| way * 10 + i).collect();
        for (id, at) in ids.iter().zip(places) {
            map.node(id, place(*at), ele);
        }
        ids
    };
    let road = |north: f64| [-45.0, -5.0, 5.0, 45.0].map(|east| [east, north]);
    let [left, right] = [(1, 1.75), (2, -1.75)].map(|(way, north)| line(way, &road(north), "ele=10"));
    let across = [(3, -1.75), (4, 1.75)].map(|(way, east)| line(way, &[[east, -40.0], [east, 40.0]], "ele=10.1"));
    let beside = has_lane_beside.then(|| {
        let lane = |east: f64| [-40.0, -8.0, 12.0, 40.0].map(|north| [east, north]);
        [(7, 1.8), (8, 4.8)].map(|(way, east)| line(way, &lane(east), "ele=10.1"))
    });
    for (at, way) in [(0, 51), (1, 53), (2, 55)] {
        map.way(way, &left[at..at + 2], "type=road_border");
        map.way(way + 1, &right[at..at + 2], "type=road_border");
    }
    map.way(57, &across[0], "type=road_border");
    map.way(58, &across[1], "type=road_border");
    let mut lanelets = vec![(61, [51, 52]), (62, [53, 54]), (63, [55, 56]), (64, [57, 58])];
    if let Some([left, right]) = &beside {
        for (at, way) in [(0, 71), (1, 73), (2, 75)] {
            map.way(way, &left[at..at + 2], "type=line_thin subtype=solid");
            map.way(way + 1, &right[at..at + 2], "type=road_border");
            lanelets.push((way + 10, [way, way + 1]));
        }
    }
    for (id, [left, right]) in lanelets {
        let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
        map.relation(id, &[("left", left), ("right", right)], tags);
    }
    map.data()
}

/// What the fixes of vm-03-01 do, the map then, and how far its area reaches from south to north, metres.
fn marked(data: OsmData) -> (Vec<String>, LaneletMap, f64) {
    let (settings, config) = (Settings::default(), Config::default());
    let judge = |data: &OsmData| {
        let mut found = judge_as(&loaded(data), &settings, &config);
        found.retain(|one| one.code.starts_with("vm-03-01/") || one.code.starts_with("load/"));
        Ok::<_, Infallible>(found)
    };
    let mended = mend(data, true, judge).unwrap();
    let map = loaded(&mended.osm).map;
    let area = map.polygons.iter().next().unwrap();
    let north = |id: &PointId| map.points.get(*id).unwrap().position.y;
    let [low, high] = area.points.iter().map(north).fold([f64::MAX, f64::MIN], |[a, b], y| [a.min(y), b.max(y)]);
    let of_lanes = mended.done.into_iter().filter(|one| one.code.starts_with("vm-03-01/"));
    (of_lanes.map(|one| one.title).collect(), map, high - low)
}

#[test]
fn a_road_across_an_intersection_is_cut_where_the_lane_beside_it_is_cut() {
    let (titles, map, reach) = marked(crossing(true));
    let area = "draw the area of the intersection, tag its 3 lanelets and say where they turn";
    assert_eq!(titles, ["cut lanelet 64 where the intersection begins and ends", area]);
    assert_eq!(map.lanelets.len(), 9);
    assert!((19.9..20.2).contains(&reach), "{reach}: from end to end of the lane beside it");
}

#[test]
fn a_road_across_an_intersection_is_cut_before_the_area_is_drawn() {
    let (titles, map, reach) = marked(crossing(false));
    let area = "draw the area of the intersection, tag its 2 lanelets and say where they turn";
    assert_eq!(titles, ["cut lanelet 64 where the intersection begins and ends", area]);
    assert_eq!(map.lanelets.len(), 6);
    // From 2 m before the road to 2 m behind it.
    assert!((reach - 7.5).abs() < 0.05, "{reach}");
    let turning = map.lanelets.iter().filter(|lanelet| lanelet.attributes.has("turn_direction"));
    assert_eq!(turning.count(), 2, "the pieces before and behind it are lanes of a road");
}
