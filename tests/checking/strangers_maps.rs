//! Maps as strangers draw them: other words for lanes, clusters of nodes, lanes that join; and what `fix` makes of them.

use std::collections::BTreeMap;
use std::convert::Infallible;

use lanewright::diagnostic::{Diagnostic, Severity};
use lanewright::fix::{Mended, mend};
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{LaneletMap, ProjectorInfo, from_osm};
use lanewright::osm::OsmData;
use lanewright::projection::{LonLat, MgrsGrid, Projector};
use lanewright::settings::Settings;

use crate::common::drawing::Drawing;
use crate::common::judging::judge;

/// What is found in a map of metres.
pub fn found(data: &OsmData) -> Vec<Diagnostic> {
    judge(&from_osm(data, &Projector::Local), &Settings::default())
}

/// Such a map after all fixes.
pub fn mended(data: OsmData) -> Mended {
    mend(data, true, |data: &OsmData| Ok::<_, Infallible>(found(data))).unwrap()
}

fn map(data: &OsmData) -> LaneletMap {
    from_osm(data, &Projector::Local).map
}

/// How many errors and how many other findings there are of a code.
fn count(found: &[Diagnostic], code: &str) -> [usize; 2] {
    let of_code = || found.iter().filter(|one| one.code == code);
    let errors = of_code().filter(|one| one.severity == Severity::Error).count();
    [errors, of_code().count() - errors]
}

/// A map of lanes that is drawn line by line.
#[derive(Default)]
pub struct Sheet {
    pub drawing: Drawing,
    nodes: i64,
    ways: i64,
    lanelets: i64,
}

impl Sheet {
    /// Nodes at these places, in metres.
    pub fn nodes<const N: usize>(&mut self, places: [[f64; 2]; N]) -> [i64; N] {
        places.map(|[x, y]| {
            self.nodes += 1;
            let tags = format!("local_x={x} local_y={y} ele=5");
            self.drawing.node(self.nodes, [""; 2], &tags);
            self.nodes
        })
    }

    pub fn way(&mut self, nodes: &[i64], tags: &str) -> i64 {
        self.ways += 1;
        self.drawing.way(1000 + self.ways, nodes, tags);
        1000 + self.ways
    }

    pub fn lanelet(&mut self, [left, right]: [i64; 2], tags: &str) -> i64 {
        self.lanelets += 1;
        let tags = format!("type=lanelet one_way=yes {tags}");
        self.drawing.relation(2000 + self.lanelets, &[("left", left), ("right", right)], &tags);
        2000 + self.lanelets
    }

    /// A road lanelet between bounds of its own over these nodes.
    pub fn road(&mut self, left: &[i64], right: &[i64], tags: &str) -> i64 {
        let bounds = [left, right].map(|nodes| self.way(nodes, "type=road_border"));
        self.lanelet(bounds, &format!("subtype=road location=urban speed_limit=40 {tags}"))
    }

    /// A road far away, on which both directions say so.
    pub fn people_drive_on_the_right(&mut self) {
        let lines = [197.0, 200.0, 203.0].map(|y| self.nodes([[0.0, y], [60.0, y]]));
        let [low, middle, high] = lines.map(|line| self.way(&line, "type=line_thin subtype=solid"));
        for outer in [low, high] {
            self.lanelet([middle, outer], "subtype=road location=urban speed_limit=40");
        }
    }
}

/// Two lanes of a motorway and the strip beside them, in two pieces, as Lanelet2 names them.
fn motorway() -> OsmData {
    let mut sheet = Sheet::default();
    let rows = [0.0, 3.5, 7.0, 10.5].map(|y| sheet.nodes([0.0, 40.0, 80.0].map(|x| [x, y])));
    let kinds =
        ["type=road_border", "type=line_thin subtype=solid", "type=line_thin subtype=dashed", "type=road_border"];
    for at in 0..2 {
        let mut ways = [0; 4];
        for (way, (row, kind)) in ways.iter_mut().zip(rows.iter().zip(kinds)) {
            *way = sheet.way(&row[at..at + 2], kind);
        }
        for (lane, subtype) in ["emergency_lane", "highway", "highway"].into_iter().enumerate() {
            let tags =
                format!("subtype={subtype} location=nonurban speed_limit={}", if lane == 2 { "none" } else { "80" });
            sheet.lanelet([ways[lane + 1], ways[lane]], &tags);
        }
    }
    sheet.drawing.data()
}

#[test]
fn lanes_of_a_motorway_get_the_words_that_autoware_reads() {
    let before = found(&motorway());
    // The two lanes of cars may be changed between, and are not asked.
    assert_eq!(count(&before, "vm-01-20/foreign-word"), [0, 1]);
    let mended = mended(motorway());
    for code in ["vm-01-20/foreign-word", "vm-01-20/neighbours", "vm-01-21/other-kind", "vm-01-01/location"] {
        assert_eq!(count(&mended.left, code), [0, 0], "{code}");
    }
    // What the lanes are not asked before they are roads is told then.
    assert_eq!(count(&mended.left, "vm-01-09/speed-invalid"), [2, 0]);
    let mut kinds: BTreeMap<[Option<String>; 2], usize> = BTreeMap::new();
    for lanelet in map(&mended.osm).lanelets.iter() {
        let tag = |key| lanelet.attributes.get(key).map(str::to_owned);
        *kinds.entry([tag("subtype"), tag("participant:vehicle")]).or_default() += 1;
    }
    let words =
        |[kind, vehicle]: [&str; 2]| [Some(kind.to_owned()), Some(vehicle.to_owned()).filter(|it| !it.is_empty())];
    let wanted = [(words(["road", "yes"]), 4), (words(["road_shoulder", ""]), 2)];
    assert_eq!(kinds, BTreeMap::from(wanted));
}

/// A lane behind which three others begin, each with nodes of its own at the same places.
fn clusters() -> OsmData {
    let mut sheet = Sheet::default();
    let [a, b] = sheet.nodes([[0.0, 3.5], [0.0, 0.0]]);
    let [left, right] = sheet.nodes([[40.0, 3.5], [40.0, 0.0]]);
    sheet.road(&[a, left], &[b, right], "");
    for end in [-12.0, 0.0, 12.0] {
        let [p, q, r, s] = sheet.nodes([[40.1, 3.5], [40.0, 0.1], [80.0, 3.5 + end], [80.0, end]]);
        sheet.road(&[p, r], &[q, s], "");
    }
    sheet.drawing.data()
}

#[test]
fn a_cluster_of_nodes_becomes_one_at_once() {
    let before = found(&clusters());
    let fixes = before.iter().filter(|one| one.code == "health/near-miss").filter_map(|one| one.finding.fix.as_ref());
    let titles: BTreeMap<&str, usize> = fixes.fold(BTreeMap::new(), |mut titles, fix| {
        *titles.entry(fix.title.as_str()).or_default() += 1;
        titles
    });
    assert_eq!(titles, BTreeMap::from([("use node 3 instead of 5, 9, 13", 3), ("use node 4 instead of 6, 10, 14", 3)]));
    let map = map(&mended(clusters()).osm);
    let settings = Settings::default();
    let index = MapIndex::new(&map, &[], &settings);
    assert_eq!(index.followers(0).len(), 3);
}

/// Two lanes of one road that become one: a blinker, and no intersection.
fn joining_lanes() -> OsmData {
    let mut sheet = Sheet::default();
    let [a, b, c] = sheet.nodes([[0.0, 7.0], [0.0, 3.5], [0.0, 0.0]]);
    let [d, e] = sheet.nodes([[40.0, 7.0], [40.0, 3.5]]);
    let [f, g] = sheet.nodes([[80.0, 7.0], [80.0, 3.5]]);
    sheet.road(&[a, d], &[b, e], "turn_direction=straight");
    sheet.road(&[b, d], &[c, e], "turn_direction=left");
    sheet.road(&[d, f], &[e, g], "");
    sheet.drawing.data()
}

#[test]
fn a_blinker_where_two_lanes_become_one_is_no_error() {
    assert_eq!(count(&found(&joining_lanes()), "vm-03-01/turn-without-ia"), [0, 2]);
}

/// A road of two lanes that becomes a single lane for both directions.
fn narrowing_road() -> OsmData {
    let mut sheet = Sheet::default();
    let single = sheet.nodes([[-40.0, 1.75], [-40.0, -1.75], [0.0, 1.75], [0.0, -1.75]]);
    let [high, middle, low] = sheet.nodes([[15.0, 3.5], [15.0, 0.0], [15.0, -3.5]]);
    let far = sheet.nodes([[60.0, 3.5], [60.0, 0.0], [60.0, -3.5]]);
    sheet.road(&[single[0], single[2]], &[single[1], single[3]], "");
    sheet.road(&[single[3], single[1]], &[single[2], single[0]], "");
    sheet.road(&[single[2], middle], &[single[3], low], "");
    sheet.road(&[middle, single[3]], &[high, single[2]], "");
    sheet.road(&[middle, far[1]], &[low, far[2]], "");
    sheet.road(&[far[1], middle], &[far[0], high], "");
    sheet.drawing.data()
}

#[test]
fn cars_meet_where_a_road_becomes_a_single_lane() {
    assert_eq!(count(&found(&narrowing_road()), "vm-03-01/unmarked"), [0, 1]);
}

/// A crossing of two one-way roads with a turn over places in these directions from a place in the south-east, degrees, where another
/// lane begins inside, though nothing leads there.
fn loose_lane(directions: &[f64]) -> OsmData {
    crossing(directions).0.drawing.data()
}

/// The same, with the nodes on both sides of its corner in the north-west.
pub fn crossing(directions: &[f64]) -> (Sheet, [i64; 2]) {
    let mut sheet = Sheet::default();
    let west = sheet.nodes([[-40.0, 2.0], [-40.0, -2.0], [-10.0, 2.0], [-10.0, -2.0]]);
    let east = sheet.nodes([[10.0, 2.0], [10.0, -2.0], [40.0, 2.0], [40.0, -2.0]]);
    let south = sheet.nodes([[-2.0, -40.0], [2.0, -40.0], [-2.0, -10.0], [2.0, -10.0]]);
    let north = sheet.nodes([[-2.0, 10.0], [2.0, 10.0], [-2.0, 40.0], [2.0, 40.0]]);
    for [a, b, c, d] in [west, east, south, north] {
        sheet.road(&[a, c], &[b, d], "");
    }
    let mut arc = |radius: f64| -> Vec<i64> {
        let place = |degrees: &f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            [10.0 + radius * cosine, -10.0 + radius * sine]
        };
        directions.iter().flat_map(|degrees| sheet.nodes([place(degrees)])).collect()
    };
    let [outer, inner] = [arc(12.0), arc(8.0)];
    sheet.road(&[west[2], east[0]], &[west[3], east[1]], "");
    sheet.road(&[south[2], north[0]], &[south[3], north[1]], "");
    let turn = |from: i64, along: Vec<i64>, to: i64| [vec![from], along, vec![to]].concat();
    sheet.road(&turn(south[2], outer, east[0]), &turn(south[3], inner, east[1]), "");
    let [loose] = sheet.nodes([[-4.0, -1.0]]);
    sheet.road(&[west[2], east[0]], &[loose, east[1]], "");
    sheet.people_drive_on_the_right();
    (sheet, [west[2], north[0]])
}

/// The directions of a turn that a vehicle can take.
pub const ROUND: [f64; 5] = [165.0, 150.0, 135.0, 120.0, 105.0];

#[test]
fn an_area_is_drawn_though_a_lane_begins_inside() {
    assert_eq!(count(&found(&loose_lane(&ROUND)), "vm-03-01/unmarked"), [1, 0]);
    let mended = mended(loose_lane(&ROUND));
    for code in ["vm-03-01/unmarked", "vm-03-01/turn-without-ia", "vm-03-08/lane-node-missing"] {
        assert_eq!(count(&mended.left, code), [0, 0], "{code}");
    }
    // What is wrong with that lane is said once.
    assert_eq!(count(&mended.left, "vm-03-04/dangling-il").iter().sum::<usize>(), 1);
}

/// The turn has a corner at both ends, which is an error in an intersection alone.
#[test]
fn an_area_that_brings_more_to_light_than_it_mends_is_not_drawn() {
    let mended = mended(loose_lane(&[]));
    assert_eq!(count(&mended.left, "vm-03-01/unmarked"), [1, 0]);
    let (_, reason) = mended.refused.iter().find(|(mend, _)| mend.code == "vm-03-01/unmarked").unwrap();
    assert!(reason.starts_with("errors that it brings to light: 3, that it mends: 1"), "{reason}");
}

/// What is found on nodes of which the local coordinates come from degrees by `to_metres`; in the MGRS square of the first.
fn placed_twice(to_metres: impl Fn(&[LonLat]) -> Vec<[f64; 2]>) -> Vec<Diagnostic> {
    let places: Vec<LonLat> = (0..60)
        .map(|at| LonLat { lon: 26.72 + 1e-4 * f64::from(at % 10), lat: 58.38 + 1e-4 * f64::from(at / 10) })
        .collect();
    let mut drawing = Drawing::default();
    for (at, (place, [x, y])) in places.iter().zip(to_metres(&places)).enumerate() {
        drawing.node(at + 1, [place.lat, place.lon], &format!("local_x={x} local_y={y} ele=5"));
    }
    let data = drawing.data();
    let projector = MgrsGrid::of(places[0]).map_or(Projector::Local, Projector::mgrs);
    let mut loaded = from_osm(&data, &projector);
    ProjectorInfo::default().judge(&data, &projector, &mut loaded.faults);
    judge(&loaded, &Settings::default())
}

#[test]
fn metres_of_an_unknown_projection_are_told_once_and_kept() {
    // A grid that is turned and shrunk against every one of Autoware's.
    let found = placed_twice(|places| places.iter().map(|at| [at.lat * 9e4, at.lon * 7e4]).collect());
    let about: Vec<&Diagnostic> = found.iter().filter(|one| one.code == "node/local-mismatch").collect();
    let [only] = about[..] else { panic!("{about:?}") };
    assert!(only.finding.message.contains("60 points") && only.finding.fix.is_none(), "{only:?}");
}

#[test]
fn a_projection_is_known_though_a_node_was_moved_by_hand() {
    let origin = LonLat { lon: 26.7, lat: 58.3 };
    let found = placed_twice(|places| {
        let metres = Projector::LocalCartesianUtm { origin }.forward_each(places, |_| 5.0);
        let mut metres: Vec<[f64; 2]> = metres.into_iter().map(|at| at.unwrap().into()).collect();
        metres[7][0] += 0.2;
        metres
    });
    let codes: Vec<&str> = found.iter().map(|one| one.code.as_str()).collect();
    assert!(codes.contains(&"projector/missing") && !codes.contains(&"node/local-mismatch"), "{codes:?}");
}

/// An element of another program's kind keeps Autoware from loading the map.
#[test]
fn an_element_that_autoware_does_not_know_is_removed() {
    let mut sheet = Sheet::default();
    let [a, b, c, d] = sheet.nodes([[0.0, 3.0], [50.0, 3.0], [0.0, 0.0], [50.0, 0.0]]);
    let bounds = [[a, b], [c, d]].map(|nodes| sheet.way(&nodes, "type=road_border"));
    let members = [("left", 'w', bounds[0]), ("right", 'w', bounds[1]), ("regulatory_element", 'r', 900)];
    let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
    sheet.drawing.members(2000, &members, tags);
    sheet.drawing.members(
        900,
        &[("refers", 'r', 2000)],
        "type=regulatory_element subtype=digital_speed_limit limit=25",
    );
    let data = sheet.drawing.data();
    assert!(found(&data).iter().any(|one| one.code == "load/re-subtype"));
    let mended = mended(data);
    let [lanelet] = &mended.osm.relations[..] else { panic!("{:?}", mended.osm.relations) };
    assert_eq!((lanelet.id, lanelet.members.len()), (2000, 2));
    assert!(!mended.left.iter().any(|one| one.code.starts_with("load/re-")));
}

/// A path in two pieces that crosses no road: nobody stops before either.
#[test]
fn a_path_in_pieces_beside_all_roads_is_a_warning() {
    let mut sheet = Sheet::default();
    let rows = [0.0, 2.0].map(|y| sheet.nodes([0.0, 20.0, 40.0].map(|x| [x, y])));
    for at in 0..2 {
        let [right, left] = [0, 1].map(|row| sheet.way(&rows[row][at..at + 2], "type=virtual"));
        sheet.lanelet([left, right], "subtype=walkway location=urban participant:pedestrian=yes");
    }
    let found = found(&sheet.drawing.data());
    let of_path: Vec<Severity> =
        found.iter().filter(|one| one.code == "vm-01-21/follower").map(|one| one.severity).collect();
    assert!(!of_path.is_empty() && of_path.iter().all(|one| *one == Severity::Warning), "{found:?}");
}

/// The severities of what is said of pieces of a path from x to x that lead over a road from x = 21 to 29, each with its subtype.
fn said_of_pieces(pieces: &[(&str, [f64; 2])]) -> Vec<Severity> {
    let mut sheet = Sheet::default();
    let mut edge = sheet.nodes([[pieces[0].1[0], 0.0], [pieces[0].1[0], 2.0]]);
    for (subtype, [_, end]) in pieces {
        let next = sheet.nodes([[*end, 0.0], [*end, 2.0]]);
        let [right, left] = [0, 1].map(|row| sheet.way(&[edge[row], next[row]], "type=virtual"));
        sheet.lanelet([left, right], &format!("subtype={subtype} location=urban participant:pedestrian=yes"));
        edge = next;
    }
    let bounds = [21.0, 29.0].map(|x| {
        let nodes = sheet.nodes([[x, -20.0], [x, 20.0]]);
        sheet.way(&nodes, "type=road_border")
    });
    sheet.lanelet(bounds, "subtype=road location=urban one_way=yes speed_limit=40");
    let found = found(&sheet.drawing.data());
    found.iter().filter(|one| one.code == "vm-01-21/follower").map(|one| one.severity).collect()
}

/// Vehicles stop before one crossing; whether a path leads up to it is nothing to them.
#[test]
fn a_crossing_with_a_path_up_to_it_is_a_warning_and_one_in_pieces_an_error() {
    let whole = said_of_pieces(&[("walkway", [0.0, 20.0]), ("crosswalk", [20.0, 30.0]), ("walkway", [30.0, 50.0])]);
    assert!(!whole.is_empty() && whole.iter().all(|one| *one == Severity::Warning), "{whole:?}");
    let halved = said_of_pieces(&[("crosswalk", [20.0, 25.0]), ("crosswalk", [25.0, 30.0])]);
    assert!(halved.contains(&Severity::Error), "{halved:?}");
}
