//! What was told wrongly, twice, or not at all on a second lot of strangers' maps.

use lanewright::diagnostic::{Diagnostic, Severity};
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::projection::Projector;
use lanewright::settings::Settings;

use super::strangers_maps::{ROUND, Sheet, crossing, found, mended};

/// The messages of a code.
fn of_code<'f>(found: &'f [Diagnostic], code: &str) -> Vec<&'f str> {
    found.iter().filter(|one| one.code == code).map(|one| one.finding.message.as_str()).collect()
}

/// A road of three lanelets, the middle one 1 m long; beside its right border an idle line over nodes of the same places.
#[test]
fn a_copy_of_a_border_is_no_border_of_a_missing_lane() {
    let map = |is_there: bool, length: f64| {
        let mut sheet = Sheet::default();
        let rows = [3.5, 0.0].map(|y| sheet.nodes([0.0, 40.0, 40.0 + length, 80.0].map(|x| [x, y])));
        for at in (0..3).filter(|at| is_there || *at != 1) {
            sheet.road(&rows[0][at..at + 2], &rows[1][at..at + 2], "");
        }
        let copy = sheet.nodes([[40.0, 0.01], [40.0 + length, -0.01]]);
        for line in [&rows[1][1..3], &copy, &rows[0][1..3]] {
            sheet.way(line, "obstructed_shoulder=no");
        }
        of_code(&found(&sheet.drawing.data()), "health/hole").len()
    };
    assert_eq!([map(true, 1.0), map(true, 10.0), map(false, 10.0)], [0, 0, 1]);
}

#[test]
fn lanes_of_one_intersection_are_told_of_once() {
    let told = found(&crossing(&ROUND).0.drawing.data());
    assert_eq!(of_code(&told, "vm-03-01/unmarked").len(), 1);
    assert!(of_code(&told, "vm-07-08/crossing").is_empty());
    assert!(of_code(&told, "vm-07-08/overlap").is_empty());
}

/// How many intersections there are at a crossing of two streets of which the two lanelets that cross have these labels.
fn intersections(label: &str) -> usize {
    let mut data = crossing(&ROUND).0.drawing.data();
    for id in [2005, 2006] {
        data.relations.iter_mut().find(|one| one.id == id).unwrap().tags.set("turn_direction", label);
    }
    let Loaded { map, faults, .. } = from_osm(&data, &Projector::Local);
    let settings = Settings::default();
    MapIndex::new(&map, &faults, &settings).intersections.len()
}

#[test]
fn an_empty_label_makes_no_intersection() {
    assert_eq!(["straight", " ", ""].map(intersections), [1, 0, 0]);
}

/// On a lane of a road a label that is no word is taken away, and an empty one without asking.
#[test]
fn a_label_that_is_no_word_goes_where_no_lanes_meet() {
    for (label, safe) in [("straight_left", false), (" ", true)] {
        let mut sheet = Sheet::default();
        let [left, right] = [3.5, 0.0].map(|y| sheet.nodes([[0.0, y], [40.0, y]]));
        sheet.road(&left, &right, "");
        let mut data = sheet.drawing.data();
        data.relations.iter_mut().for_each(|one| one.tags.set("turn_direction", label));
        let told = found(&data);
        let fix = told.iter().find(|one| one.code == "vm-03-02/turn-invalid").unwrap().finding.fix.clone().unwrap();
        assert_eq!((fix.title.as_str(), fix.safe), ("remove the tag turn_direction", safe));
    }
}

/// A lane that begins in a point, on two nodes, beside a lane of which the border is not shared.
#[test]
fn a_lane_that_opens_on_two_nodes_is_not_narrow() {
    let map = |opening: f64| {
        let mut sheet = Sheet::default();
        let [left, middle] = [3.5, 0.0].map(|y| sheet.nodes([[0.0, y], [40.0, y]]));
        sheet.road(&left, &middle, "");
        let inner = sheet.nodes([[0.0, 0.0], [10.0, 0.0], [40.0, 0.0]]);
        let outer = sheet.nodes([[0.0, -opening], [10.0, -3.4], [40.0, -3.4]]);
        sheet.road(&inner, &outer, "");
        of_code(&found(&sheet.drawing.data()), "health/narrow").len()
    };
    assert_eq!([map(0.02), map(0.9)], [0, 1]);
}

/// A ring that bends to the left, or goes straight on, and an exit that bends to the left by 59 degrees; a lane joins what goes on.
#[test]
fn who_leaves_a_ring_turns_right() {
    let map = |ring_bends: bool| {
        let mut sheet = Sheet::default();
        let mut line = |from: &[i64], places: &[[f64; 2]]| -> Vec<i64> {
            let more = places.iter().map(|place| sheet.nodes([*place])[0]);
            from.iter().copied().chain(more.collect::<Vec<i64>>()).collect()
        };
        let edge = [line(&[], &[[-15.6, -9.0]])[0], line(&[], &[[-19.0, -11.0]])[0]];
        let round = |radius: f64| -> Vec<[f64; 2]> {
            let on = |degrees: f64| [radius * degrees.to_radians().cos(), radius * degrees.to_radians().sin()];
            (1..=10).map(|step| on(f64::from(15 * step) - 150.0)).collect()
        };
        let (inner, outer) = match ring_bends {
            true => (round(18.0), round(22.0)),
            false => (vec![[-5.6, -26.3], [4.4, -43.6]], vec![[-9.0, -28.3], [1.0, -45.6]]),
        };
        let (inner, outer) = (line(&edge[..1], &inner), line(&edge[1..], &outer));
        let left =
            [[-13.1, -13.2], [-9.5, -16.5], [-5.1, -18.9], [0.0, -20.5], [5.7, -21.3], [12.2, -21.2], [18.0, -21.4]];
        let right =
            [[-16.0, -16.0], [-11.5, -19.9], [-6.1, -22.8], [0.0, -24.5], [6.7, -25.1], [14.2, -24.7], [20.5, -24.5]];
        let exit = [line(&edge[..1], &left), line(&edge[1..], &right)];
        // It crosses the exit.
        let entry = [line(&[], &[[0.0, -50.0], [2.0, -10.0]]), line(&[], &[[4.0, -50.0], [6.0, -12.0]])];
        sheet.road(&inner, &outer, "turn_direction=straight");
        sheet.road(&exit[0], &exit[1], "turn_direction=right");
        sheet.road(&entry[0], &entry[1], "turn_direction=straight");
        let told = found(&sheet.drawing.data());
        of_code(&told, "vm-03-02/turn-mismatch")
            .iter()
            .filter(|message| message.contains("turn_direction=right"))
            .count()
    };
    assert_eq!([map(true), map(false)], [0, 1]);
}

/// A line that begins off the road and ends before the middle of the lane that stops at it.
#[test]
fn a_stop_line_beside_the_middle_of_its_lane_is_short() {
    let map = |reach: f64| {
        let mut sheet = Sheet::default();
        let rows = [3.5, 0.0].map(|y| sheet.nodes([0.0, 40.0, 80.0].map(|x| [x, y])));
        sheet.road(&rows[0][..2], &rows[1][..2], "");
        sheet.road(&rows[0][1..], &rows[1][1..], "");
        let ends = sheet.nodes([[40.0, -1.5], [40.0, reach]]);
        let line = sheet.way(&ends, "type=stop_line");
        let members = [("refers", line)];
        sheet.drawing.relation(3000, &members, "type=regulatory_element subtype=road_marking");
        let mut data = sheet.drawing.data();
        let lanelet = data.relations.iter_mut().find(|one| one.id == 2001).unwrap();
        lanelet.members.push(lanewright::osm::Member {
            kind: lanewright::osm::ElementKind::Relation,
            id: 3000,
            role: "regulatory_element".into(),
        });
        of_code(&found(&data), "vm-02-01/short").len()
    };
    assert_eq!([map(1.2), map(3.3)], [1, 0]);
}

#[test]
fn a_role_that_was_cut_short_is_told_with_the_one_that_was_meant() {
    let mut sheet = Sheet::default();
    let [left, middle, right] = [3.5, 1.75, 0.0].map(|y| sheet.nodes([[0.0, y], [40.0, y]]));
    let [left, right] = [left, right].map(|nodes| sheet.way(&nodes, "type=road_border"));
    let middle = sheet.way(&middle, "");
    let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
    sheet.drawing.relation(2500, &[("left", left), ("right", right), ("center", middle)], tags);
    let told = found(&sheet.drawing.data());
    assert_eq!(
        of_code(&told, "tag/role"),
        ["Lanelet 2500 has way 1003 as center, which nothing reads; did you mean centerline?"]
    );
}

#[test]
fn a_map_on_which_autoware_drives_nowhere_has_an_error() {
    let severity = |subtypes: [&str; 2]| {
        let mut sheet = Sheet::default();
        for (at, subtype) in subtypes.into_iter().enumerate() {
            let y = 50.0 * at as f64;
            let bounds = [y + 3.5, y].map(|y| {
                let nodes = sheet.nodes([[0.0, y], [40.0, y]]);
                sheet.way(&nodes, "type=road_border")
            });
            sheet.lanelet(bounds, &format!("subtype={subtype} location=urban speed_limit=40"));
        }
        let told = found(&sheet.drawing.data());
        told.iter().find(|one| one.code == "access/not-road").map(|one| one.severity)
    };
    assert_eq!(severity(["highway", "highway"]), Some(Severity::Error));
    assert_eq!(severity(["highway", "road"]), Some(Severity::Warning));
}

/// A slip that a program wrote on each of 40 lines is told of once, and mended on all.
#[test]
fn a_slip_on_many_lines_is_told_of_once() {
    let mut sheet = Sheet::default();
    let rows: Vec<[i64; 2]> = (0..20).map(|x| sheet.nodes([3.5, 0.0].map(|y| [f64::from(20 * x), y]))).collect();
    for pair in rows.windows(2) {
        let bounds = [0, 1].map(|side| sheet.way(&[pair[0][side], pair[1][side]], "type=road_boarder"));
        sheet.lanelet(bounds, "subtype=road location=urban speed_limit=40");
    }
    let data = sheet.drawing.data();
    let told = found(&data);
    let [one] = of_code(&told, "tag/value")[..] else { panic!("{told:?}") };
    assert!(one.ends_with("did you mean road_border? So it stands 38 times."), "{one}");
    let mended = mended(data);
    assert!(of_code(&mended.left, "tag/value").is_empty());
    assert!(mended.osm.ways.iter().all(|way| way.tags.first("type") == Some("road_border")));
}

/// Of 60 nodes with ids below 0, one goes: what is said of the others begins with another one then, and is not new.
#[test]
fn a_group_with_another_first_member_is_no_new_finding() {
    let mut sheet = Sheet::default();
    let mut nodes = 0_i64;
    let mut node = |sheet: &mut Sheet, place: [f64; 2]| {
        nodes -= 1;
        sheet.drawing.node(nodes, [""; 2], &format!("local_x={} local_y={} ele=5", place[0], place[1]));
        nodes
    };
    let stray = node(&mut sheet, [40.0, 0.1]);
    let mut line =
        |sheet: &mut Sheet, y: f64| -> Vec<i64> { (0..21).map(|x| node(sheet, [f64::from(2 * x), y])).collect() };
    let (left, right) = (line(&mut sheet, 3.5), line(&mut sheet, 0.0));
    let ahead = [3.5, 0.0].map(|y| sheet.nodes([[80.0, y]])[0]);
    sheet.road(&left, &right, "");
    sheet.road(&[left[20], ahead[0]], &[stray, ahead[1]], "");
    let data = sheet.drawing.data();
    assert_eq!(of_code(&found(&data), "health/near-miss").len(), 1);
    let told = lanewright::fix::mend(data, false, |data: &lanewright::osm::OsmData| {
        Ok::<_, std::convert::Infallible>(found(data))
    });
    assert!(of_code(&told.unwrap().left, "health/near-miss").is_empty());
}
