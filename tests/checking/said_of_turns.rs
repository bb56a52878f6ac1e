//! What was told wrongly of turns, branches, strips and walkways on a third lot of strangers' maps.

use lanewright::diagnostic::{Edit, Subject};
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::{ElementKind, OsmData, Tags, read_file};
use lanewright::projection::Projector;
use lanewright::settings::Settings;

use crate::common::judging::{judge, loaded};
use crate::common::root;

use super::strangers_maps::{ROUND, Sheet, crossing, found, mended};

const URBAN: &str = "subtype=road location=urban speed_limit=40";
const PRIVATE: &str = "subtype=road location=private speed_limit=10";

fn count(data: &OsmData, code: &str) -> usize {
    found(data).iter().filter(|one| one.code == code).count()
}

/// A lane from private ground onto a road; where told, a public road leads into it as well.
fn driveway(is_turn: bool) -> OsmData {
    let mut sheet = Sheet::default();
    let rows = [3.5, 0.0].map(|y| sheet.nodes([0.0, 10.0, 60.0].map(|x| [x, y])));
    let before = |sheet: &mut Sheet, far: [[f64; 2]; 2], tags: &str| {
        let [left, right] = sheet.nodes(far);
        let bounds = [[left, rows[0][0]], [right, rows[1][0]]].map(|line| sheet.way(&line, "type=road_border"));
        sheet.lanelet(bounds, tags);
    };
    before(&mut sheet, [[-30.0, -16.5], [-28.0, -19.0]], PRIVATE);
    if is_turn {
        before(&mut sheet, [[-40.0, 3.5], [-40.0, 0.0]], URBAN);
    }
    sheet.road(&rows[0][..2], &rows[1][..2], "");
    sheet.road(&rows[0][1..], &rows[1][1..], "");
    let [left, right] = sheet.nodes([[-10.0, 30.0], [-12.0, 27.0]]);
    sheet.road(&[left, rows[0][1]], &[right, rows[1][1]], "");
    sheet.drawing.data()
}

#[test]
fn a_turn_off_the_road_is_no_exit_of_the_driveway_beside_it() {
    assert_eq!([false, true].map(|is_turn| count(&driveway(is_turn), "vm-03-13/exit-not-private")), [1, 0]);
}

#[test]
fn turns_of_an_intersection_without_area_are_no_stretches_of_road() {
    let data = crossing(&ROUND).0.drawing.data();
    let Loaded { map, faults, .. } = from_osm(&data, &Projector::Local);
    let settings = Settings::default();
    let index = MapIndex::new(&map, &faults, &settings);
    let turns: Vec<i64> =
        (0..index.lanes.len()).filter(|&at| index.turns_at_unmarked(at)).map(|at| index.lanes[at].id.0).collect();
    // The only lanelet that leads from the south to the east.
    assert_eq!(turns, [2007]);
}

/// A lane that forks into two, each of which begins with a piece of 5 m; the branch to the left is wide.
#[test]
fn a_branch_that_begins_with_short_pieces_is_no_intersection() {
    let mut sheet = Sheet::default();
    let [a, b] = sheet.nodes([[-40.0, 3.5], [-40.0, 0.0]]);
    let [left, right] = sheet.nodes([[0.0, 3.5], [0.0, 0.0]]);
    sheet.road(&[a, left], &[b, right], "");
    for [mid_left, mid_right, far_left, far_right] in
        [[[5.0, 3.5], [5.0, 0.0], [50.0, 3.5], [50.0, 0.0]], [[4.0, 5.0], [6.0, 1.0], [10.0, 50.0], [15.0, 50.0]]]
    {
        let [p, q, r, s] = sheet.nodes([mid_left, mid_right, far_left, far_right]);
        sheet.road(&[left, p], &[right, q], "");
        sheet.road(&[p, r], &[q, s], "");
    }
    let data = sheet.drawing.data();
    assert_eq!(["vm-03-01/unmarked", "vm-07-08/crossing"].map(|code| count(&data, code)), [0, 0]);
}

/// The two branches part and lie on each other again 60 m behind the fork: one of them is drawn wrongly.
#[test]
fn branches_that_cross_farther_on_are_told() {
    let mut sheet = Sheet::default();
    let [a, b] = sheet.nodes([[-40.0, 3.5], [-40.0, 0.0]]);
    let [left, right] = sheet.nodes([[0.0, 3.5], [0.0, 0.0]]);
    sheet.road(&[a, left], &[b, right], "");
    for [mid_left, mid_right, far_left, far_right] in [
        [[10.0, 6.0], [10.0, 2.5], [110.0, -30.0], [108.0, -33.5]],
        [[10.0, 1.0], [10.0, -2.5], [108.0, 36.5], [110.0, 33.0]],
    ] {
        let [p, q, r, s] = sheet.nodes([mid_left, mid_right, far_left, far_right]);
        let [t, u] = match mid_left[1] > 3.0 {
            true => sheet.nodes([[55.0, 40.0], [55.0, 36.5]]),
            false => sheet.nodes([[55.0, -33.0], [55.0, -36.5]]),
        };
        sheet.road(&[left, p], &[right, q], "");
        sheet.road(&[p, t, r], &[q, u, s], "");
    }
    let data = sheet.drawing.data();
    let told = ["vm-03-01/unmarked", "vm-07-08/crossing", "vm-07-08/overlap"].map(|code| count(&data, code));
    assert_eq!(told.iter().sum::<usize>(), 1, "{told:?}");
}

/// A walkway beside a lane, which it reaches over by so many metres.
fn walkway(over: f64) -> OsmData {
    let mut sheet = Sheet::default();
    let [a, b, c, d] = sheet.nodes([[-40.0, 3.5], [40.0, 3.5], [-40.0, 0.0], [40.0, 0.0]]);
    sheet.road(&[a, b], &[c, d], "");
    let [e, f, g, h] = sheet.nodes([[-1.0, -8.0], [-1.0, over], [1.0, -8.0], [1.0, over]]);
    let bounds = [[e, f], [g, h]].map(|line| sheet.way(&line, "type=virtual"));
    sheet.lanelet(bounds, "subtype=walkway location=urban participant:pedestrian=yes");
    sheet.drawing.data()
}

#[test]
fn a_walkway_that_ends_at_the_kerb_crosses_nothing() {
    let told = |over: f64| ["idle", "short"].map(|fault| count(&walkway(over), &format!("vm-03-13/walkway-{fault}")));
    assert_eq!([told(0.02), told(4.0)], [[1, 0], [0, 1]]);
}

/// A shoulder beside a road over one line that may or may not be crossed.
#[test]
fn a_shoulder_beside_a_line_that_may_be_crossed_is_not_alone() {
    for change in ["yes", "no"] {
        let mut sheet = Sheet::default();
        let rows = [3.5, 0.0, -2.0].map(|y| sheet.nodes([[0.0, y], [80.0, y]]));
        let shared = format!("type=line_thin subtype=solid lane_change={change}");
        let [outer, line, edge] = [(0, "type=road_border"), (1, shared.as_str()), (2, "type=road_border")]
            .map(|(row, tags)| sheet.way(&rows[row], tags));
        sheet.lanelet([outer, line], URBAN);
        sheet.lanelet([line, edge], "subtype=road_shoulder location=urban speed_limit=10");
        assert_eq!(count(&sheet.drawing.data(), "vm-01-15/alone"), 0, "lane_change={change}");
    }
}

/// Two lanes that cross in one phase, of which the first has the right of way by an element with as many stop lines as told.
fn element_with_stop_lines(count: usize) -> OsmData {
    let mut sheet = Sheet::default();
    let west = sheet.nodes([[-20.0, 2.0], [20.0, 2.0], [-20.0, -2.0], [20.0, -2.0]]);
    let south = sheet.nodes([[-2.0, -20.0], [-2.0, 20.0], [2.0, -20.0], [2.0, 20.0]]);
    let [first, second] = [west, south].map(|[a, b, c, d]| sheet.road(&[a, b], &[c, d], ""));
    let lines: Vec<i64> = (0..count).map(|at| sheet.way(&[south[0], south[2 - at]], "type=stop_line")).collect();
    let mut members = vec![("right_of_way", 'r', first), ("yield", 'r', second)];
    members.extend(lines.iter().map(|&line| ("ref_line", 'w', line)));
    sheet.drawing.members(900, &members, "type=regulatory_element subtype=right_of_way");
    let mut data = sheet.drawing.data();
    let lanelet = data.relations.iter_mut().find(|one| one.id == first).unwrap();
    lanelet.members.push(lanewright::osm::Member {
        kind: ElementKind::Relation,
        id: 900,
        role: "regulatory_element".into(),
    });
    data
}

#[test]
fn a_right_of_way_with_two_stop_lines_loads() {
    for count in [1, 2] {
        let data = element_with_stop_lines(count);
        assert_eq!(from_osm(&data, &Projector::Local).map.regulatory_elements.iter().count(), 1);
        let codes: Vec<String> =
            found(&data).into_iter().map(|one| one.code).filter(|it| it.starts_with("load/")).collect();
        assert_eq!(codes.iter().filter(|code| *code == "load/re-members").count(), count - 1, "{codes:?}");
        assert!(!codes.iter().any(|code| code == "load/skipped"), "{codes:?}");
    }
}

/// A lanelet whose element is a member without role obeys nothing.
#[test]
fn an_element_without_role_is_an_error_that_fix_mends() {
    let mut data = element_with_stop_lines(1);
    let lanelet = data.relations.iter_mut().find(|one| one.id == 2001).unwrap();
    lanelet.members.last_mut().unwrap().role = "".into();
    assert_eq!(count(&data, "tag/role"), 1);
    let mended = mended(data);
    let lanelet = mended.osm.relations.iter().find(|one| one.id == 2001).unwrap();
    let roles: Vec<&str> = lanelet.members.iter().filter(|one| one.id == 900).map(|one| one.role.as_str()).collect();
    assert_eq!(roles, ["regulatory_element"]);
}

/// Somebody wrote a lanelet's type wrongly.
#[test]
fn what_has_two_bounds_is_a_lanelet() {
    let mut data = driveway(false);
    let lanelet = data.relations.iter_mut().find(|one| one.id == 2002).unwrap();
    lanelet.tags.set("type", "regulatory_element");
    let all = found(&data);
    let finding = all.iter().find(|one| one.code == "load/re-subtype").unwrap();
    let title = finding.finding.fix.as_ref().map(|fix| fix.title.as_str());
    assert_eq!(title, Some("set type=lanelet: it has a left and a right bound"));
}

#[test]
fn limits_in_metres_per_second_are_told() {
    let told = |limit: &str| {
        let mut data = driveway(false);
        data.relations.iter_mut().for_each(|one| one.tags.set("speed_limit", limit));
        count(&data, "vm-01-09/speed-metres")
    };
    assert_eq!(["13.89", "13.888888888", "11.175", "19.44", "13.9", "8.3", "16.7"].map(told), [4; 7]);
    assert_eq!(["50", "10", "12.5", "5", "40.23", "14", "48.3", "80.5"].map(told), [0; 8]);
}

/// A lanelet of 12 m is drawn for a whole road; on a circuit its centre line says where vehicles drive.
#[test]
fn a_lane_as_wide_as_three_is_told_unless_it_has_a_centre_line() {
    let map = |is_circuit: bool| {
        let mut sheet = Sheet::default();
        let [a, b, c, d, e, f] =
            sheet.nodes([[0.0, 12.0], [80.0, 12.0], [0.0, 0.0], [80.0, 0.0], [0.0, 4.0], [80.0, 4.0]]);
        sheet.road(&[a, b], &[c, d], "");
        let line = sheet.way(&[e, f], "type=virtual");
        let mut data = sheet.drawing.data();
        if is_circuit {
            let member = lanewright::osm::Member { kind: ElementKind::Way, id: line, role: "centerline".into() };
            data.relations[0].members.push(member);
        }
        count(&data, "health/wide")
    };
    assert_eq!([map(false), map(true)], [1, 0]);
}

/// The turn of a crossing without an area says that it goes straight on.
#[test]
fn a_turn_at_a_crossing_without_an_area_is_not_called_straight() {
    let mut data = crossing(&ROUND).0.drawing.data();
    let labelled = |data: &mut OsmData, direction: &str| {
        for (id, direction) in [(2005, "straight"), (2006, "straight"), (2007, direction)] {
            let lane = data.relations.iter_mut().find(|one| one.id == id).unwrap();
            lane.tags.set("turn_direction", direction);
        }
        count(data, "vm-03-02/turn-mismatch")
    };
    assert_eq!(["straight", "right"].map(|direction| labelled(&mut data, direction)), [1, 0]);
}

/// The limit of a road whose key ends in a blank is told once.
#[test]
fn a_blank_in_a_key_is_told_and_not_what_follows_from_it() {
    let mut sheet = Sheet::default();
    let rows = [3.5, 0.0].map(|y| sheet.nodes([[0.0, y], [60.0, y]]));
    sheet.road(&rows[0], &rows[1], "");
    let mut data = sheet.drawing.data();
    let road = data.relations.iter_mut().find(|one| one.id == 2001).unwrap();
    road.tags = without(&road.tags, &["speed_limit"]);
    road.tags.set("speed_limit ", "40");
    assert_eq!(["tag/key", "access/standstill"].map(|code| count(&data, code)), [1, 0]);
}

/// A light hangs on the lane before its stop line; one of the two lanes behind it says nothing of the intersection.
#[test]
fn a_light_moves_to_every_lane_behind_its_stop_line() {
    let mut data = read_file(&root().join("tests/rules/vm-03-04/bad-signal-on-in-lane.osm")).unwrap();
    let behind = data.relations.iter_mut().find(|one| one.id == 215).unwrap();
    behind.tags = without(&behind.tags, &["turn_direction", "intersection_area"]);
    let all = judge(&loaded(&data), &Settings::default());
    let moved = all.iter().find(|one| one.code == "vm-03-04/signal-on-in-lane").unwrap();
    let edits = &moved.finding.fix.as_ref().unwrap().edits;
    let gets = |lanelet: i64| {
        edits.iter().any(|edit| matches!(edit, Edit::AddMember { on: Subject::Lanelet(id), .. } if *id == lanelet))
    };
    assert_eq!([215, 216].map(gets), [true; 2]);
}

fn without(tags: &Tags, keys: &[&str]) -> Tags {
    tags.iter().filter(|(key, _)| !keys.contains(key)).collect()
}
