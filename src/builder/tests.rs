//! The whole builder on small hand-drawn networks: what must hold of the map that comes out.

use crate::geometry::polygon;
use crate::lanelet::{Lanelet, LaneletMap, PointId};
use crate::osm::{OsmData, read_bytes};

use super::tags::road_class::DrivingSide;
use super::*;

use std::collections::BTreeSet;

/// Builds from nodes in metres (about, driven on the right) and ways with tags.
fn built(nodes: &[(i64, f64, f64, &str)], ways: &[(i64, &[i64], &str)]) -> Built {
    built_as(&Asked { nodes, ways, options: driven_on(DrivingSide::Right) })
}

/// Options for a map where people drive on this side.
pub(super) fn driven_on(side: DrivingSide) -> BuildOptions {
    BuildOptions { driving_side: Some(side), ..BuildOptions::default() }
}

/// The lanelets of a subtype.
pub(super) fn of_subtype<'a>(map: &'a LaneletMap, subtype: &str) -> Vec<&'a Lanelet> {
    map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", subtype)).collect()
}

/// What is to be built, and how.
pub(super) struct Asked<'a> {
    /// Id, metres to the east and north, tags.
    pub nodes: &'a [(i64, f64, f64, &'a str)],
    /// Id, nodes, tags.
    pub ways: &'a [(i64, &'a [i64], &'a str)],
    pub options: BuildOptions,
}

/// As [`built`], with options.
pub(super) fn built_as(Asked { nodes, ways, options }: &Asked<'_>) -> Built {
    let tags = |text: &str| -> String {
        let pairs = text.split_whitespace().filter_map(|t| t.split_once('='));
        pairs.map(|(k, v)| format!("<tag k='{k}' v='{v}'/>")).collect()
    };
    let mut xml = String::from("<osm>");
    for (id, x, y, text) in *nodes {
        // Near the equator a degree is about as long in either direction.
        xml += &format!(
            "<node id='{id}' lon='{}' lat='{}'>{}</node>",
            9.5 + x / 111_320.0,
            0.5 + y / 110_574.0,
            tags(text)
        );
    }
    for (id, refs, text) in *ways {
        let refs: String = refs.iter().map(|r| format!("<nd ref='{r}'/>")).collect();
        xml += &format!("<way id='{id}'>{refs}{}</way>", tags(text));
    }
    let mut data = OsmData::default();
    read_bytes(&mut data, "test", (xml + "</osm>").into_bytes()).unwrap();
    build(&data, options).unwrap()
}

fn inside(map: &LaneletMap) -> Vec<&Lanelet> {
    map.lanelets.iter().filter(|l| l.attributes.has("intersection_area")).collect()
}

/// The nodes with which a lanelet begins, left and right, and those with which it ends.
pub(super) fn ends(map: &LaneletMap, lanelet: &Lanelet) -> [[PointId; 2]; 2] {
    let ends = |bound| {
        let ids: Vec<PointId> = map.bound_points(bound).map(|point| point.id).collect();
        [ids[0], ids[ids.len() - 1]]
    };
    let ([a, b], [c, d]) = (ends(lanelet.left), ends(lanelet.right));
    [[a, c], [b, d]]
}

#[test]
fn nobody_is_led_around_a_hairpin_without_room() {
    // A street that leaves another at 30 degrees, and forks after so many metres.
    let ways_through = |side: DrivingSide, length: f64| {
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        let [x, y] = [-length * cos, length * sin];
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -80.0, 0.0, ""),
            (3, 80.0, 0.0, ""),
            (4, x, y, ""),
            (5, x, y + 60.0, ""),
            (6, x - 60.0, y, ""),
        ];
        let street = "highway=residential lanes=2";
        let ways: [(i64, &[i64], &str); 5] = [
            (12, &[2, 1], street),
            (13, &[1, 3], street),
            (14, &[1, 4], street),
            (15, &[4, 5], street),
            (16, &[4, 6], street),
        ];
        let options = driven_on(side);
        inside(&built_as(&Asked { nodes: &nodes, ways: &ways, options }).map).len()
    };
    for side in [DrivingSide::Right, DrivingSide::Left] {
        assert_eq!([20.0, 80.0].map(|length| ways_through(side, length)), [11, 12], "{side:?}");
    }
}

#[test]
fn where_all_ways_on_turn_back_only_the_easy_ones_are_drawn() {
    // A one-way street leads into three aisles, the outer two of which are so many metres away from the middle one.
    let ways_back = |side: DrivingSide, apart: f64| {
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -80.0, 0.0, ""),
            (3, 80.0, 0.0, ""),
            (4, 14.0, apart, ""),
            (5, 80.0, apart, ""),
            (6, 14.0, -apart, ""),
            (7, 80.0, -apart, ""),
        ];
        let aisle = "highway=service service=parking_aisle lanes=2";
        let ways: [(i64, &[i64], &str); 4] = [
            (12, &[2, 1], "highway=service oneway=yes"),
            (13, &[1, 3], aisle),
            (14, &[1, 4, 5], aisle),
            (15, &[1, 6, 7], aisle),
        ];
        inside(&built_as(&Asked { nodes: &nodes, ways: &ways, options: driven_on(side) }).map).len() - 3
    };
    for side in [DrivingSide::Right, DrivingSide::Left] {
        // One from each aisle; farther apart there is room for a second one. There are six pairs.
        assert_eq!([6.0, 12.0].map(|apart| ways_back(side, apart)), [3, 4], "{side:?}");
    }
}

#[test]
fn no_lane_ends_under_a_turn_beside_it() {
    // A road that comes back at an acute angle: the turn between the outer two swings over the middle one.
    let nodes = [(1, 0.0, 0.0, ""), (2, 80.0, 30.0, ""), (3, 90.0, 8.0, ""), (4, 80.0, -12.0, ""), (5, -80.0, 5.0, "")];
    let street = "highway=residential lanes=2";
    let map =
        built(&nodes, &[(10, &[2, 1], street), (11, &[3, 1], street), (12, &[4, 1], street), (13, &[5, 1], street)])
            .map;
    let area = map.polygons.iter().next().unwrap();
    for lanelet in inside(&map) {
        for node in ends(&map, lanelet).into_iter().flatten() {
            assert!(area.points.contains(&node), "node {node} of {} is no vertex", lanelet.id);
        }
    }
}

#[test]
fn lanes_part_at_a_fork_without_crossing() {
    // Three lanes go on as two roads of two lanes, both nearly straight on.
    let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 100.0, 12.0, ""), (4, 100.0, -30.0, "")];
    let road = |lanes| format!("highway=primary oneway=yes lanes={lanes}");
    let (three, two) = (road(3), road(2));
    let map = built(&nodes, &[(10, &[1, 2], &three), (11, &[2, 3], &two), (12, &[2, 4], &two)]).map;
    assert!(
        map.lanelets.iter().count() >= 3 + 4 + 4,
        "seven lanes of roads, and one to each of the four that lead away"
    );
    assert_apart(&map);
}

/// No lane lies on another but for those that start together.
fn assert_apart(map: &LaneletMap) {
    let lanes: Vec<&Lanelet> = map.lanelets.iter().collect();
    for (i, a) in lanes.iter().enumerate() {
        for b in &lanes[i + 1..] {
            let siblings = ends(map, a)[0] == ends(map, b)[0];
            let overlap = polygon::overlap(&map.outline(a), &map.outline(b));
            assert!(siblings || overlap < 0.5, "{} and {} overlap {overlap} m2", a.id, b.id);
        }
    }
}

#[test]
fn arrows_that_lead_past_a_road_are_not_meant_for_it() {
    // The arrows before node 2 speak of the next junction; nobody else could reach the road straight on.
    let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 100.0, 0.0, ""), (4, 0.0, -80.0, "")];
    let ways: [(i64, &[i64], &str); 3] = [
        (10, &[1, 2], "highway=primary oneway=yes lanes=2 turn:lanes=right|right"),
        (11, &[2, 3], "highway=primary oneway=yes lanes=2"),
        (12, &[2, 4], "highway=residential oneway=yes lanes=1"),
    ];
    assert_eq!(from_nowhere(&built(&nodes, &ways).map), 2, "only the two lanes at the edge of the map");
}

#[test]
fn an_arrow_is_meant_for_all_streets_that_leave_on_its_side() {
    // Two streets leave to the right of those who come from the west; those from the north lead to both, too.
    let nodes = [
        (1, -100.0, 0.0, ""),
        (2, 0.0, 0.0, ""),
        (3, 100.0, 0.0, ""),
        (4, 35.0, -90.0, ""),
        (5, -35.0, -90.0, ""),
        (6, 0.0, 100.0, ""),
    ];
    let street = "highway=residential oneway=yes lanes=1";
    let ways: [(i64, &[i64], &str); 5] = [
        (10, &[1, 2], "highway=primary oneway=yes lanes=2 turn:lanes=through|right"),
        (11, &[2, 3], "highway=primary oneway=yes lanes=2"),
        (12, &[2, 4], street),
        (13, &[2, 5], street),
        (14, &[6, 2], "highway=secondary oneway=yes lanes=2"),
    ];
    let map = built(&nodes, &ways).map;
    assert_eq!(map.lanelets.iter().filter(|one| one.attributes.is("turn_direction", "right")).count(), 2);
}

/// How many lanes nobody leads to.
fn from_nowhere(map: &LaneletMap) -> usize {
    let reached = |l: &&Lanelet| map.lanelets.iter().any(|before| ends(map, before)[1] == ends(map, l)[0]);
    map.lanelets.iter().filter(|l| !reached(l)).count()
}

#[test]
fn arrows_are_meant_for_roads_as_they_meet_behind_a_bend() {
    // The road bends, and the cut comes to lie before the bend: seen from there the road to the right leads back.
    let arrows = "highway=service oneway=yes lanes=2 turn:lanes=through|right";
    for (right, arrows) in [(1.0, arrows.to_owned()), (-1.0, arrows.replace("through|right", "left|through"))] {
        let nodes = [
            (1, 60.0, -40.0 * right, ""),
            (2, -6.0, -4.0 * right, ""),
            (3, 0.0, 6.0 * right, ""),
            (4, 5.0, 13.0 * right, ""),
            (5, 60.0, 13.0 * right, ""),
            (6, 60.0, -33.0 * right, ""),
        ];
        let ways: [(i64, &[i64], &str); 3] = [
            (10, &[1, 2, 3], &arrows),
            (11, &[3, 4, 5], "highway=service oneway=yes lanes=1"),
            (12, &[3, 6], "highway=service oneway=yes lanes=3"),
        ];
        let map = built(&nodes, &ways).map;
        assert_eq!(from_nowhere(&map), 2, "only the two lanes at the edge of the map");
        assert_apart(&map);
    }
}

#[test]
fn a_crossing_where_a_way_is_split_is_crossed_once() {
    let nodes = [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, "highway=crossing crossing=zebra"), (3, 60.0, 0.0, "")];
    let ways: [(i64, &[i64], &str); 2] =
        [(10, &[1, 2], "highway=residential name=One"), (11, &[2, 3], "highway=residential name=Two lit=yes")];
    let map = built(&nodes, &ways).map;
    let crosswalks = map.lanelets.iter().filter(|l| l.attributes.is("subtype", "crosswalk"));
    assert_eq!(crosswalks.count(), 1);
    let element = map.regulatory_elements.iter().find(|r| r.subtype == "crosswalk").unwrap();
    let carriers = map.lanelets.iter().filter(|l| l.regulatory_elements.contains(&element.id));
    assert_eq!(carriers.count(), 2, "the lanes of one of the two roads");
}

#[test]
fn a_single_track_is_no_intersection_of_its_two_directions() {
    // Where the track becomes a street, the only lanes that lie on each other are the track's own two directions.
    let nodes = [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 60.0, 20.0, "")];
    let ways: [(i64, &[i64], &str); 2] =
        [(10, &[1, 2], "highway=residential lanes=1 width=3"), (11, &[2, 3], "highway=residential lanes=1 width=4")];
    let map = built(&nodes, &ways).map;
    assert!(map.polygons.iter().next().is_none());
}

#[test]
fn paint_changes_where_a_way_with_other_tags_begins() {
    let nodes = [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 60.0, 0.0, "")];
    // The line between the lanes of the first and of the second way, if they are not one road.
    let painted = |first: &str, second: &str| -> Vec<String> {
        let [first, second] = [first, second].map(|tags| format!("highway=secondary lanes=2 sidewalk=no {tags}"));
        let map = built(&nodes, &[(10, &[1, 2], &first), (11, &[2, 3], &second)]).map;
        let mut uses: std::collections::BTreeMap<_, (f64, usize)> = std::collections::BTreeMap::new();
        for lanelet in map.lanelets.iter() {
            for bound in [lanelet.left, lanelet.right] {
                let east = map.bound_line(bound).iter().map(|p| p.x).sum();
                uses.entry(bound.line).or_insert((east, 0)).1 += 1;
            }
        }
        uses.retain(|_, (_, count)| *count == 2);
        let mut lines: Vec<_> =
            uses.into_iter().map(|(line, (east, _))| (east, map.linestrings.get(line).unwrap())).collect();
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(lines.windows(2).all(|w| w[0].1.points.iter().any(|node| w[1].1.points.contains(node))));
        let subtype = |line: &crate::lanelet::LineString| line.attributes.get("subtype").unwrap_or("none").to_owned();
        lines.into_iter().map(|(_, line)| subtype(line)).collect()
    };
    assert_eq!(painted("overtaking=yes", "overtaking=no"), ["dashed", "solid"]);
    assert_eq!(painted("divider=dashed_line", "divider=double_solid_line"), ["dashed", "solid_solid"]);
    assert_eq!(painted("lane_markings=no", ""), ["none", "solid"]);
    let one_way = |change: &str| format!("oneway=yes change:lanes={change}");
    assert_eq!(painted(&one_way("yes|yes"), &one_way("no|no")), ["dashed", "solid"]);
    assert_eq!(painted("overtaking=no", "overtaking=no"), ["solid"], "nothing changes: one road");
}

#[test]
fn what_is_known_of_a_road_is_known_of_its_lanelets() {
    let nodes = [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 60.0, 0.0, "")];
    let street = "highway=residential lanes=2 name=Main maxspeed:forward=30 maxspeed:backward=50 surface=sett";
    let yard = "highway=service service=parking_aisle lanes=2 surface=gravel";
    let map = built(&nodes, &[(10, &[1, 2], street), (11, &[2, 3], yard)]).map;
    let keys = ["subtype", "location", "one_way", "speed_limit", "road_name", "road_surface"];
    let mut told: Vec<[&str; 6]> =
        map.lanelets.iter().map(|lanelet| keys.map(|key| lanelet.attributes.get(key).unwrap_or("none"))).collect();
    told.sort_unstable();
    let expected = [
        ["road", "private", "yes", "20", "none", "gravel"],
        ["road", "private", "yes", "20", "none", "gravel"],
        ["road", "urban", "yes", "30", "Main", "sett"],
        ["road", "urban", "yes", "50", "Main", "sett"],
    ];
    assert_eq!(told, expected);
}

#[test]
fn lights_stand_behind_the_intersection_and_face_who_waits() {
    let nodes = [
        (1, 0.0, 0.0, "highway=traffic_signals"),
        (2, -90.0, 0.0, ""),
        (3, 90.0, 0.0, ""),
        (4, 0.0, -90.0, ""),
        (5, 0.0, 90.0, ""),
    ];
    let tags = "highway=secondary lanes=4";
    let ways: [(i64, &[i64], &str); 4] =
        [(12, &[2, 1], tags), (13, &[3, 1], tags), (14, &[4, 1], tags), (15, &[5, 1], tags)];
    for side in [DrivingSide::Right, DrivingSide::Left] {
        let options = driven_on(side);
        let map = built_as(&Asked { nodes: &nodes, ways: &ways, options }).map;
        let points = |line| -> Vec<&crate::lanelet::Point> {
            let line: &crate::lanelet::LineString = map.linestrings.get(line).unwrap();
            line.points.iter().map(|id| map.points.get(*id).unwrap()).collect()
        };
        let lights: Vec<_> = map.regulatory_elements.iter().filter(|r| r.subtype == "traffic_light").collect();
        assert_eq!(lights.len(), 8, "one for each lane that arrives");
        for element in lights {
            let [body, bulbs, stop] =
                ["refers", "light_bulbs", "ref_line"].map(|role| points(element.linestrings(role).next().unwrap()));
            let behind: Vec<&Lanelet> =
                map.lanelets.iter().filter(|l| l.regulatory_elements.contains(&element.id)).collect();
            assert!(!behind.is_empty());
            // The line before the light is where these lanelets begin.
            let ids: Vec<PointId> = stop.iter().map(|point| point.id).collect();
            assert!(behind.iter().all(|lanelet| ends(&map, lanelet)[0] == ids[..]));
            let ahead = crate::geometry::left_of(stop[0].position - stop[1].position) * -1.0;
            let middle = |points: &[&crate::lanelet::Point]| nalgebra::center(&points[0].position, &points[1].position);
            let off = (middle(&body) - middle(&stop)).dot(&ahead.normalize());
            assert!((15.0..50.0).contains(&off), "{side:?}: {off} m ahead, on the far side");
            // Its line runs from left to right of who looks at it, above what trucks need.
            let across = (body[1].position - body[0].position).normalize();
            let right = (stop[1].position - stop[0].position).normalize();
            assert!(across.dot(&right) > 0.99, "{side:?}");
            assert!(body.iter().all(|point| point.ele() == Some(5.0)));
            let colours: Vec<_> = bulbs.iter().map(|bulb| bulb.attributes().get("color").unwrap()).collect();
            assert_eq!(colours, ["green", "yellow", "red"]);
        }
    }
}

#[test]
fn a_dead_end_keeps_clear_of_a_carriageway_that_it_is_not_joined_to() {
    let gap_of = |end: f64, tags: &str, ending_nodes: &[i64]| {
        let nodes = [(1, -80.0, 0.0, ""), (2, 80.0, 0.0, ""), (3, 0.0, 80.0, ""), (4, 0.0, end, "")];
        let through = "highway=residential lanes=2 name=Through";
        let ending = format!("highway=residential lanes=2 name=Ending {tags}");
        let map = built(&nodes, &[(10, &[1, 2], through), (11, ending_nodes, &ending)]).map;
        let norths = |name: &str| {
            let own = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("road_name", name));
            own.flat_map(|lanelet| map.outline(lanelet)).map(|place| place.y).collect::<Vec<_>>()
        };
        norths("Ending").into_iter().fold(f64::MAX, f64::min) - norths("Through").into_iter().fold(f64::MIN, f64::max)
    };
    let gap = |end: f64, tags: &str| gap_of(end, tags, &[3, 4]);
    let far = gap(8.0, "");
    assert!(far > 4.0, "{far}: it ends where it is drawn to end");
    for end in [1.0, 0.2] {
        let gap = gap(end, "");
        assert!((3.0..3.6).contains(&gap), "drawn to {end}: {gap} m are left for the square at its end");
    }
    assert!(gap(0.2, "layer=1") < 0.5, "on another level nothing is in the way");
    let cut_off = gap_of(0.2, "", &[3, 4, 5]);
    assert!((1.4..2.2).contains(&cut_off), "where the extract ends: {cut_off} m are left");
}

#[test]
fn a_dead_end_beside_a_carriageway_ends_where_it_is_drawn_to_end() {
    let length = |beside: f64| {
        let nodes = [(1, -80.0, 0.0, ""), (2, 80.0, 0.0, ""), (3, -80.0, beside, ""), (4, 0.0, beside, "")];
        let tags = "highway=residential lanes=2 width=6";
        let ways: [(i64, &[i64], &str); 2] = [(10, &[1, 2], tags), (11, &[3, 4], &format!("{tags} name=Ending"))];
        let map = built(&nodes, &ways).map;
        let ending = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("road_name", "Ending"));
        let easts: Vec<f64> = ending.flat_map(|lanelet| map.outline(lanelet)).map(|place| place.x).collect();
        easts.iter().copied().fold(f64::MIN, f64::max) - easts.iter().copied().fold(f64::MAX, f64::min)
    };
    let alone = length(12.0);
    for beside in [5.2, 4.8] {
        let length = length(beside);
        assert!((length - alone).abs() < 0.1, "{beside} m beside: {length} m of {alone} are left");
    }
}

#[test]
fn every_lane_of_a_wide_road_leads_on_where_it_meets_a_narrow_one() {
    for lanes in 1..=5 {
        let wide = format!("highway=secondary oneway=yes lanes={lanes}");
        let nodes = [(1, 0.0, 0.0, ""), (2, -90.0, 0.0, ""), (3, 90.0, 0.0, ""), (4, 0.0, 90.0, "")];
        let built = built(&nodes, &[(10, &[2, 1, 3], "highway=tertiary lanes=2"), (11, &[4, 1], &wide)]);
        // The wide road begins where none leads to it.
        let mut closed = built.notes.iter().filter(|note| note.fault == "lane-closed");
        assert!(closed.all(|note| note.message.ends_with("where it begins")), "{lanes} lanes: {:?}", built.notes);
        let entered: Vec<[PointId; 2]> = inside(&built.map).into_iter().map(|way| ends(&built.map, way)[0]).collect();
        let road = built.map.lanelets.iter().filter(|lane| lane.attributes.is("road_id", "11:4-1:0"));
        let leads_on: Vec<bool> = road.map(|lane| entered.contains(&ends(&built.map, lane)[1])).collect();
        assert_eq!(leads_on, vec![true; lanes]);
    }
}

#[test]
fn an_id_that_nobody_gets_changes_no_other() {
    let nodes = [(1, 0.0, 0.0, ""), (2, 90.0, 0.0, ""), (3, 0.0, 90.0, ""), (4, -90.0, 0.0, ""), (5, 0.0, -90.0, "")];
    let ways: [(i64, &[i64], &str); 2] = [(10, &[4, 1, 2], "highway=primary"), (11, &[3, 1, 5], "highway=primary")];
    let built = |contested: BTreeSet<i64>| {
        let options = BuildOptions { contested, ..driven_on(DrivingSide::Right) };
        built_as(&Asked { nodes: &nodes, ways: &ways, options }).map
    };
    let whole = built(BTreeSet::new());
    let area = whole.polygons.iter().find(|area| area.attributes.is("type", "intersection_area")).unwrap().id;
    let line = whole.linestrings.iter().next().unwrap().id;
    let other = built(BTreeSet::from([area.0, line.0]));
    assert_eq!((whole.counts(), other.repeated_ids()), (other.counts(), vec![]));
    assert!(!other.polygons.contains(area) && !other.linestrings.contains(line));
    assert!(whole.points.iter().all(|point| other.points.contains(point.id)));
    assert!(whole.linestrings.iter().all(|it| it.id == line || other.linestrings.contains(it.id)));
}
