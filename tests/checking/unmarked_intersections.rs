//! Intersections that nobody marked: which lanes belong to them, how their area is drawn, and who goes first.

use std::collections::BTreeSet;

use lanewright::diagnostic::{Edit, Subject};
use lanewright::osm::{OsmData, Relation};

use super::strangers_maps::{ROUND, Sheet, crossing, found, mended};
use crate::common::drawing::osm;

/// The nodes of the only area of a map.
fn area(data: &OsmData) -> &[i64] {
    let mut areas = data.ways.iter().filter(|way| way.tags.is("type", "intersection_area"));
    let area = areas.next().unwrap();
    assert!(areas.next().is_none());
    &area.nodes
}

#[test]
fn an_area_runs_along_the_kerb_of_a_corner_where_nobody_turns() {
    let (mut sheet, [from, to]) = crossing(&ROUND);
    let [first, second] = sheet.nodes([[-5.0, 3.0], [-3.0, 5.0]]);
    sheet.way(&[from, first, second, to], "type=road_border");
    let mended = mended(sheet.drawing.data());
    let kerb = [from, first, second, to];
    let twice = area(&mended.osm).repeat(2);
    assert!(twice.windows(4).any(|nodes| nodes == kerb), "{kerb:?} are not in {:?}", area(&mended.osm));
}

#[test]
fn an_area_runs_along_the_bound_of_a_turn_where_the_map_has_no_kerb() {
    let (sheet, _) = crossing(&ROUND);
    let data = osm(sheet.drawing.xml().replace("road_border", "virtual"));
    let mended = mended(data).osm;
    let turn = mended.relations.iter().find(|one| one.tags.is("turn_direction", "right")).unwrap();
    let bound = turn.members.iter().find(|member| member.role == "right").unwrap().id;
    let mut corner = mended.ways.iter().find(|way| way.id == bound).unwrap().nodes.clone();
    corner.reverse();
    assert!(corner.len() > 2, "{corner:?}");
    let twice = area(&mended).repeat(2);
    assert!(twice.windows(corner.len()).any(|nodes| nodes == corner), "{corner:?} are not in {:?}", area(&mended));
}

/// The right bound of a lanelet.
fn right(data: &OsmData, lanelet: i64) -> i64 {
    let lanelet = data.relations.iter().find(|one| one.id == lanelet).unwrap();
    lanelet.members.iter().find(|member| member.role == "right").unwrap().id
}

/// Where a pavement lies beside the lane before the turn, the straight line across its corner would take in ground beside the lanes.
#[test]
fn an_area_takes_in_no_ground_beside_the_lanes() {
    let (mut sheet, _) = crossing(&ROUND);
    let before = osm(sheet.drawing.xml());
    let (approach, bound) = (right(&before, 2003), right(&before, 2007));
    let kerb = sheet.nodes([[4.0, -40.0], [4.0, -10.0]]);
    let kerb = sheet.way(&kerb, "type=virtual");
    sheet.lanelet([approach, kerb], "subtype=walkway location=urban speed_limit=5");
    let mended = mended(osm(sheet.drawing.xml().replace("road_border", "virtual"))).osm;
    let mut corner = mended.ways.iter().find(|way| way.id == bound).unwrap().nodes.clone();
    corner.reverse();
    let twice = area(&mended).repeat(2);
    assert!(twice.windows(corner.len()).any(|nodes| nodes == corner), "{corner:?} are not in {:?}", area(&mended));
}

/// In the corners where nobody turns the bounds have no nodes: they get one there, and the area lies under its lanes.
#[test]
fn an_area_gets_corners_where_the_bounds_have_no_nodes() {
    let (sheet, [from, to]) = crossing(&ROUND);
    let data = osm(sheet.drawing.xml().replace("road_border", "virtual"));
    let mended = mended(data).osm;
    let twice = area(&mended).repeat(2);
    let start = twice.iter().position(|id| *id == from).unwrap();
    let corner = twice[start + 1];
    assert_eq!(twice[start + 2], to, "{:?}", area(&mended));
    let bounds = mended.ways.iter().filter(|way| !way.tags.is("type", "intersection_area"));
    assert!(bounds.into_iter().any(|way| way.nodes.contains(&corner)), "{corner} is a vertex of a bound");
    let number = |key: &str| mended.node(corner).unwrap().tags.get(key).unwrap().parse::<f64>().unwrap();
    let place = [number("local_x"), number("local_y"), number("ele")];
    assert!((place[0] + 3.0).abs() < 1.6 && (place[1] - 3.0).abs() < 1.6 && place[2] == 5.0, "{place:?}");
}

#[test]
fn a_lanelet_in_an_intersection_that_touches_nothing_is_removed_with_a_look() {
    let (mut sheet, _) = crossing(&ROUND);
    let ends = sheet.nodes([[-6.0, 1.5], [6.0, 1.5], [-6.0, -1.5], [6.0, -1.5]]);
    let stray = sheet.road(&ends[..2], &ends[2..], "turn_direction=straight");
    let mended = mended(sheet.drawing.data());
    assert!(mended.osm.relation(stray).is_none(), "{:?}", mended.refused);
    let removed = mended.done.iter().find(|mend| mend.subject == Subject::Lanelet(stray));
    assert_eq!(removed.unwrap().code, "vm-03-04/dangling-il");
}

#[test]
fn of_a_lane_that_is_cut_at_an_intersection_the_piece_there_keeps_the_id() {
    let mut sheet = Sheet::default();
    let west = sheet.nodes([[-60.0, 2.0], [-60.0, -2.0]]);
    let east = [10.0, 40.0].map(|x| sheet.nodes([[x, 2.0], [x, -2.0]]));
    let rows = [-40.0, -10.0, 10.0, 40.0].map(|y| sheet.nodes([[-2.0, y], [2.0, y]]));
    let through = sheet.road(&[west[0], east[0][0]], &[west[1], east[0][1]], "");
    sheet.road(&[east[0][0], east[1][0]], &[east[0][1], east[1][1]], "");
    let crossing: Vec<i64> =
        rows.windows(2).map(|ends| sheet.road(&[ends[0][0], ends[1][0]], &[ends[0][1], ends[1][1]], "")).collect();
    let mut arc = |from: i64, radius: f64, to: i64| -> Vec<i64> {
        let place =
            |degrees: f64| [10.0 + radius * degrees.to_radians().cos(), -10.0 + radius * degrees.to_radians().sin()];
        [vec![from], sheet.nodes(ROUND.map(place)).to_vec(), vec![to]].concat()
    };
    let [left, right] = [arc(rows[1][0], 12.0, east[0][0]), arc(rows[1][1], 8.0, east[0][1])];
    let turn = sheet.road(&left, &right, "");
    sheet.people_drive_on_the_right();
    let mended = mended(sheet.drawing.data());
    let tagged = mended.osm.relations.iter().filter(|one| one.tags.has("intersection_area"));
    assert_eq!(tagged.map(|one| one.id).collect::<Vec<_>>(), [through, crossing[1], turn]);
}

/// Two lanes and one of buses that lead east, side by side, over a road that leads north; from the lane on the left cars turn onto that
/// road. The lane of cars that goes on, that of buses, and the map.
fn carriageway() -> (i64, i64, OsmData) {
    let mut sheet = Sheet::default();
    let rows = [8.0, 4.0, 0.0, -4.0];
    let [west, entry, exit, east] = [-60.0, -14.0, 20.0, 60.0].map(|x| rows.map(|y| sheet.nodes([[x, y]])[0]));
    let buses = "subtype=bus_lane location=urban speed_limit=40 participant:vehicle:bus=yes";
    let cars = "subtype=road location=urban speed_limit=40";
    let mut own = Vec::new();
    for (from, to, lanes) in [(west, entry, 0..3), (entry, exit, 1..3), (exit, east, 1..3)] {
        let mut left = sheet.way(&[from[lanes.start], to[lanes.start]], "type=road_border");
        for lane in lanes {
            let right = sheet.way(&[from[lane + 1], to[lane + 1]], "type=road_border");
            own.push(sheet.lanelet([left, right], if lane == 2 { buses } else { cars }));
            left = right;
        }
    }
    let north = [-60.0, -20.0, 20.0, 60.0].map(|y| sheet.nodes([[-2.0, y], [2.0, y]]));
    for ends in north.windows(2) {
        sheet.road(&[ends[0][0], ends[1][0]], &[ends[0][1], ends[1][1]], "");
    }
    let mut arc = |from: i64, radius: f64, to: i64| -> Vec<i64> {
        let place =
            |degrees: f64| [-14.0 + radius * degrees.to_radians().cos(), 20.0 + radius * degrees.to_radians().sin()];
        [vec![from], sheet.nodes([-75.0, -60.0, -45.0, -30.0, -15.0].map(place)).to_vec(), vec![to]].concat()
    };
    let [left, right] = [arc(entry[0], 12.0, north[2][0]), arc(entry[1], 16.0, north[2][1])];
    sheet.road(&left, &right, "");
    sheet.people_drive_on_the_right();
    (own[3], own[4], sheet.drawing.data())
}

/// Nobody turns from the lane that goes on, and both roads are drawn at one height: who turns off beside it shows that they meet.
#[test]
fn a_lane_that_turns_off_beside_another_shows_that_the_roads_meet() {
    let (straight, buses, data) = carriageway();
    let unmarked: Vec<_> = found(&data).into_iter().filter(|one| one.code == "vm-03-01/unmarked").collect();
    let [one] = &unmarked[..] else { panic!("{unmarked:?}") };
    let told = format!("{:?} {:?}", one.finding.subject, one.finding.related);
    for lane in [straight, buses] {
        assert!(told.contains(&lane.to_string()), "{lane} is not in {told}");
    }
}

#[test]
fn a_lane_of_buses_is_part_of_the_intersection() {
    let (straight, buses, data) = carriageway();
    let mended = mended(data);
    let area = |id: i64| mended.osm.relation(id).and_then(|one| one.tags.get("intersection_area"));
    assert!(area(straight).is_some() && area(straight) == area(buses), "{:?} {:?}", area(straight), area(buses));
}

/// A lane of cars and one of buses side by side, each with its own border between them, and both with these tags.
fn buses_beside_cars(tags: &str) -> OsmData {
    let mut sheet = Sheet::default();
    let buses = "subtype=bus_lane participant:vehicle:bus=yes";
    for (sides, kind) in [([4.0, 0.05], "subtype=road"), ([-0.05, -4.0], buses)] {
        let [left, right] = sides.map(|y| sheet.nodes([[0.0, y], [30.0, y]]));
        let bounds = [left, right].map(|nodes| sheet.way(&nodes, "type=virtual"));
        sheet.lanelet(bounds, &format!("{kind} location=urban speed_limit=40 {tags}"));
    }
    sheet.drawing.data()
}

#[test]
fn a_lane_of_buses_in_an_intersection_has_its_own_borders() {
    let apart = |tags: &str| found(&buses_beside_cars(tags)).iter().any(|one| one.code == "vm-01-03/not-shared");
    assert!(apart(""));
    assert!(!apart("turn_direction=straight intersection_area=77"));
}

/// Two roads that cross, and a left turn from the south; those who come from these sides, south or north, have a stop sign. The map,
/// with the lanelets that lead south, east, and turn.
fn signed(sides: &[usize]) -> (OsmData, [i64; 3]) {
    let mut sheet = Sheet::default();
    let across = [-3.0, 0.0, 3.0];
    let mut rows = [-50.0, -12.0, 12.0, 50.0].map(|y| sheet.nodes(across.map(|x| [x, y])));
    let columns = [-50.0, -12.0, 12.0, 50.0].map(|x| sheet.nodes(across.map(|y| [x, y])));
    let mut north = Vec::new();
    for ends in rows.windows(2) {
        north.push(sheet.road(&[ends[0][1], ends[1][1]], &[ends[0][2], ends[1][2]], ""));
    }
    let east: Vec<i64> =
        columns.windows(2).map(|ends| sheet.road(&[ends[0][1], ends[1][1]], &[ends[0][0], ends[1][0]], "")).collect();
    for ends in columns.windows(2) {
        sheet.road(&[ends[1][1], ends[0][1]], &[ends[1][2], ends[0][2]], "");
    }
    rows.reverse();
    let mut south = Vec::new();
    for ends in rows.windows(2) {
        south.push(sheet.road(&[ends[0][1], ends[1][1]], &[ends[0][0], ends[1][0]], ""));
    }
    let [inner, outer] = [[[-1.0, -5.0], [-5.0, -1.0]], [[2.0, -3.0], [-3.0, 2.0]]].map(|line| sheet.nodes(line));
    let [_, north_cut, south_cut, _] = rows;
    let west = columns[1];
    let turn =
        sheet.road(&[south_cut[1], inner[0], inner[1], west[1]], &[south_cut[2], outer[0], outer[1], west[2]], "");
    let approaches = [north[0], south[0]];
    let lines = [[south_cut[1], south_cut[2]], [north_cut[1], north_cut[0]]];
    for &side in sides {
        let post = sheet.nodes([[5.0, -13.0], [5.5, -13.0]]);
        let [line, sign] = [(lines[side], "type=stop_line"), (post, "type=traffic_sign subtype=stop_sign")]
            .map(|(nodes, tags)| sheet.way(&nodes, tags));
        let tags = "type=regulatory_element subtype=traffic_sign";
        sheet.drawing.relation(3000 + side, &[("refers", sign), ("ref_line", line)], tags);
    }
    sheet.people_drive_on_the_right();
    let text = sides.iter().fold(sheet.drawing.xml(), |text, &side| {
        let lanelet = format!("<relation id='{}'>", approaches[side]);
        let element = format!("<member type='relation' role='regulatory_element' ref='{}'/>", 3000 + side);
        text.replace(&lanelet, &format!("{lanelet}{element}"))
    });
    (osm(text), [south[1], east[1], turn])
}

/// Whom a lanelet of a map may ignore.
fn ignored(data: &OsmData, lanelet: i64) -> BTreeSet<i64> {
    let elements = data.relations.iter().filter(|one| one.tags.is("subtype", "right_of_way"));
    let members = |one: &Relation, role: &str| -> Vec<i64> {
        one.members.iter().filter(|member| member.role == role).map(|member| member.id).collect()
    };
    let own = elements.filter(|one| members(one, "right_of_way").contains(&lanelet));
    own.flat_map(|one| members(one, "yield")).collect()
}

#[test]
fn who_comes_from_opposite_a_sign_may_have_one_that_is_missing() {
    let (data, [south, east, turn]) = signed(&[0]);
    let mended = mended(data).osm;
    assert!(ignored(&mended, east).contains(&turn), "the road without signs goes first");
    assert!(!ignored(&mended, east).contains(&south), "of the other side nobody knows");
    assert_eq!(ignored(&mended, south), BTreeSet::new());
}

/// Nobody enters an intersection on a lanelet that begins in a point, so it needs no direction of the blinker.
#[test]
fn a_lanelet_that_begins_in_a_point_does_not_say_where_it_turns() {
    let (data, [south, _, turn]) = signed(&[]);
    let relation = data.relation(turn).unwrap();
    let [left, right] = ["left", "right"].map(|role| {
        let bound = relation.members.iter().find(|member| member.role == role).unwrap().id;
        (bound, data.way(bound).unwrap().nodes[0])
    });
    let start = |node: i64| format!("<way id='{}'><nd ref='{node}'/>", right.0);
    let pointed = osm(data.sources[0].text.to_string().replace(&start(right.1), &start(left.1)));
    for (data, turns) in [(data, true), (pointed, false)] {
        let found = found(&data);
        let unmarked = found.iter().find(|one| one.code == "vm-03-01/unmarked").unwrap();
        let edits = &unmarked.finding.fix.as_ref().unwrap().edits;
        let turns_at = |lanelet: i64| {
            let on_it = |on: &Subject| *on == Subject::Lanelet(lanelet);
            edits
                .iter()
                .any(|edit| matches!(edit, Edit::SetTag { on, key, .. } if on_it(on) && key == "turn_direction"))
        };
        assert_eq!([south, turn].map(turns_at), [true, turns]);
    }
}

#[test]
fn without_signs_only_who_turns_off_the_same_road_is_known_to_wait() {
    let (data, [south, east, turn]) = signed(&[]);
    let mended = mended(data).osm;
    assert_eq!(
        ignored(&mended, south),
        BTreeSet::from([turn]),
        "its road goes straight on to where the turn comes from"
    );
    assert_eq!([east, turn].map(|lane| ignored(&mended, lane)), [BTreeSet::new(), BTreeSet::new()]);
}

#[test]
fn two_signs_settle_who_goes_first() {
    let (data, [south, east, turn]) = signed(&[0, 1]);
    let mended = mended(data).osm;
    assert_eq!(ignored(&mended, south), BTreeSet::from([turn]), "of two that give way the far turn waits");
    assert!([south, turn].iter().all(|lane| ignored(&mended, east).contains(lane)));
}

/// A link joins the second lane of a road over its first lane, at this angle, degrees: how many intersections are told of.
fn told_of_a_link_at(angle: f64) -> usize {
    let mut sheet = Sheet::default();
    let columns = [-60.0, -20.0, 20.0, 60.0].map(|x| sheet.nodes([[x, 8.0], [x, 4.0], [x, 0.0]]));
    for ends in columns.windows(2) {
        let [left, middle, right] = [0, 1, 2].map(|row| sheet.way(&[ends[0][row], ends[1][row]], "type=road_border"));
        let tags = "subtype=road location=urban speed_limit=40";
        sheet.lanelet([left, middle], tags);
        sheet.lanelet([middle, right], tags);
    }
    let (sin, cos) = angle.to_radians().sin_cos();
    let across = |far: f64| {
        let middle = [20.0 - far * cos, 6.0 - far * sin];
        [[middle[0] - 2.0 * sin, middle[1] + 2.0 * cos], [middle[0] + 2.0 * sin, middle[1] - 2.0 * cos]]
    };
    let [far, near] = [70.0, 30.0].map(|length| sheet.nodes(across(length)));
    sheet.road(&[far[0], near[0]], &[far[1], near[1]], "");
    sheet.road(&[near[0], columns[2][0]], &[near[1], columns[2][1]], "");
    sheet.people_drive_on_the_right();
    found(&sheet.drawing.data()).iter().filter(|one| one.code == "vm-03-01/unmarked").count()
}

#[test]
fn a_link_that_joins_a_road_as_a_ramp_does_is_no_intersection() {
    assert_eq!([25.0, 45.0].map(told_of_a_link_at), [0, 1]);
}

/// An oval is a roundabout if nobody crosses it, and who crosses whom is judged otherwise at a roundabout: the second must not be asked
/// for the first. Here a lane lies on a straight side of the ring, against it.
#[test]
fn a_lane_against_an_oval_ring_is_judged() {
    let mut sheet = Sheet::default();
    sheet.people_drive_on_the_right();
    let corner = |radius: f64, at: usize| {
        let (middle, eighth) = if at < 5 { (-15.0, at) } else { (15.0, at - 1) };
        let angle = (90.0 + eighth as f64 * 45.0).to_radians();
        [middle + radius * angle.cos(), radius * angle.sin()]
    };
    let [inner, outer] =
        [15.0, 19.0].map(|radius| sheet.nodes([0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|at| corner(radius, at))));
    for at in 0..inner.len() {
        let next = (at + 1) % inner.len();
        sheet.road(&[inner[at], inner[next]], &[outer[at], outer[next]], "");
    }
    let [a, b, c, d] = sheet.nodes([corner(18.0, 5), corner(18.0, 4), corner(14.0, 5), corner(14.0, 4)]);
    sheet.road(&[a, b], &[c, d], "");
    assert!(found(&sheet.drawing.data()).iter().any(|one| one.code == "vm-01-13/overlap"));
}

/// Two lanes that part and join again around a block: an area over the block would be no intersection.
#[test]
fn no_area_is_drawn_over_a_block_between_lanes() {
    let mut sheet = Sheet::default();
    sheet.people_drive_on_the_right();
    let [a, b] = sheet.nodes([[-20.0, 2.0], [-20.0, -2.0]]);
    let [c, d] = sheet.nodes([[0.0, 2.0], [0.0, -2.0]]);
    let [e, f] = sheet.nodes([[60.0, 2.0], [60.0, -2.0]]);
    let [g, h] = sheet.nodes([[80.0, 2.0], [80.0, -2.0]]);
    sheet.road(&[a, c], &[b, d], "");
    sheet.road(&[c, e], &[d, f], "turn_direction=straight");
    let [left, right] = [[[10.0, 30.0], [50.0, 30.0]], [[14.0, 26.0], [46.0, 26.0]]].map(|line| sheet.nodes(line));
    sheet.road(&[c, left[0], left[1], e], &[d, right[0], right[1], f], "turn_direction=left");
    sheet.road(&[e, g], &[f, h], "");
    let found = found(&sheet.drawing.data());
    let draws = |one: &Edit| matches!(one, Edit::CreateArea { .. });
    assert!(found.iter().any(|one| one.code == "vm-03-01/turn-without-ia"), "{found:?}");
    assert!(!found.iter().filter_map(|one| one.finding.fix.as_ref()).any(|fix| fix.edits.iter().any(draws)));
}
