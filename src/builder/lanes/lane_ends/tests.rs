//! Where vehicles stop before an intersection, on small networks.

use crate::builder::network::hand_drawn::{network, osm};
use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tests::{Asked, built_as, driven_on};
use crate::lanelet::{LaneletMap, PointId};

use super::{ROAD_LEFT, clear_of_bends};

type Nodes<'a> = &'a [(i64, f64, f64, &'a str)];
type Ways<'a> = &'a [(i64, &'a [i64], &'a str)];

const STREET: &str = "highway=tertiary lanes=2";
const LINE: &str = "road_marking=stop_line stroke=solid";
const SIDES: [DrivingSide; 2] = [DrivingSide::Right, DrivingSide::Left];

/// Four roads of 150 m that meet in the middle, the western one as ways over these nodes: its own end is 2.
fn crossing(side: DrivingSide, west: &[&[i64]], nodes: Nodes<'_>, ways: Ways<'_>) -> LaneletMap {
    let mut all = vec![(1, 0.0, 0.0, ""), (2, -150.0, 0.0, ""), (3, 150.0, 0.0, "")];
    all.extend([(4, 0.0, -150.0, ""), (5, 0.0, 150.0, "")]);
    all.extend(nodes);
    let mut roads = vec![(13, &[1, 3][..], STREET), (14, &[4, 1, 5], STREET)];
    roads.extend(west.iter().zip(20..).map(|(nodes, id)| (id, *nodes, STREET)));
    roads.extend(ways);
    built_as(&Asked { nodes: &all, ways: &roads, options: driven_on(side) }).map
}

/// Metres east and north of the middle, as the nodes were given.
fn place(map: &LaneletMap, point: PointId) -> [f64; 2] {
    let place = map.points.get(point).and_then(|point| point.lonlat()).unwrap();
    [(place.lon - 9.5) * 111_320.0, (place.lat - 0.5) * 110_574.0]
}

/// The distance of the western stop line from the middle, metres.
fn stop(map: &LaneletMap) -> f64 {
    let lines = map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line"));
    let eastings = |line: &crate::lanelet::LineString| -> Vec<f64> {
        line.points.iter().map(|&point| place(map, point)[0]).collect()
    };
    let west = lines.map(eastings).min_by(|a, b| a[0].total_cmp(&b[0])).unwrap();
    assert!(west.iter().all(|x| (x - west[0]).abs() < 0.05), "straight across");
    -west[0]
}

/// The same with a node with these tags in the west.
fn stop_at(side: DrivingSide, tags: &str, west: f64) -> f64 {
    stop(&crossing(side, &[&[2, 6, 1]], &[(6, -west, 0.0, tags)], &[]))
}

#[test]
fn vehicles_stop_at_a_sign_or_light_that_faces_them() {
    for side in SIDES {
        let usual = stop_at(side, "", 12.0);
        for tags in [
            "highway=stop direction=forward",
            "highway=give_way direction=forward",
            "highway=traffic_signals traffic_signals:direction=forward",
        ] {
            assert!((stop_at(side, tags, 12.0) - 12.0).abs() < 0.1, "{tags}");
            assert_eq!(stop_at(side, tags, 2.0), usual, "nearer than the turns allow");
            assert_eq!(stop_at(side, tags, 30.0), usual, "a sign, but no stop line");
        }
        assert_eq!(stop_at(side, "highway=give_way", 12.0), usual, "it faces nobody for certain");
        assert_eq!(stop_at(side, "highway=give_way direction=backward", 12.0), usual, "for the other direction");
        assert_eq!(stop_at(side, "highway=traffic_signals crossing=traffic_signals direction=forward", 12.0), {
            stop_at(side, "highway=crossing crossing=traffic_signals", 12.0)
        });
    }
}

#[test]
fn on_a_one_way_road_all_signs_face_its_traffic() {
    let street = "highway=tertiary oneway=yes lanes=1";
    let ways: [(i64, &[i64], &str); 1] = [(30, &[2, 6, 1], street)];
    let map = crossing(DrivingSide::Right, &[], &[(6, -11.0, 0.0, "highway=give_way")], &ways);
    assert!((stop(&map) - 11.0).abs() < 0.1);
}

#[test]
fn vehicles_stop_where_a_line_is_painted() {
    for (side, kerb) in SIDES.into_iter().zip([-1.0, 1.0]) {
        let painted = |x: f64, from: f64, to: f64, tags: &str| {
            let nodes = [(6, -20.0, 0.0, ""), (7, -x, from * kerb, ""), (8, -x, to * kerb, "")];
            stop(&crossing(side, &[&[2, 6, 1]], &nodes, &[(30, &[7, 8], tags)]))
        };
        let usual = painted(13.0, 0.0, 3.0, "barrier=kerb");
        assert!((painted(13.0, 0.2, 3.2, LINE) - 13.0).abs() < 0.1, "before the approach");
        assert!((painted(13.0, 3.0, 0.0, "road_marking=solid_stop_line") - 13.0).abs() < 0.1);
        assert!(
            (painted(13.0, -3.0, 3.0, "road_marking=dashed_stop_line") - 13.0).abs() < 0.1,
            "across the whole road"
        );
        assert_eq!(painted(13.0, -3.0, -0.2, LINE), usual, "for the other direction");
        assert_eq!(painted(13.0, 8.0, 11.0, LINE), usual, "beside the road");
        // The paint tells better than the sign beside it where vehicles stop.
        let nodes = [(6, -8.0, 0.0, "highway=stop direction=forward"), (7, -12.0, 0.0, ""), (8, -12.0, 3.0 * kerb, "")];
        let both = stop(&crossing(side, &[&[2, 6, 1]], &nodes, &[(30, &[7, 8], LINE)]));
        assert!((both - 12.0).abs() < 0.1);
    }
}

#[test]
fn a_crosswalk_stays_between_the_stop_line_and_the_intersection() {
    for side in SIDES {
        let walked = |sign: f64| {
            let nodes = [(6, -sign, 0.0, "highway=stop direction=forward"), (7, -10.0, 0.0, "highway=crossing")];
            let west: &[i64] = if sign > 10.0 { &[2, 6, 7, 1] } else { &[2, 7, 6, 1] };
            let map = crossing(side, &[west], &nodes, &[]);
            let crosswalk = map.lanelets.iter().find(|lanelet| lanelet.attributes.is("subtype", "crosswalk")).unwrap();
            let places = [crosswalk.left, crosswalk.right].map(|bound| {
                let points: Vec<f64> = map.bound_points(bound).map(|point| place(&map, point.id)[0]).collect();
                -points.iter().sum::<f64>() / points.len() as f64
            });
            (stop(&map), f64::midpoint(places[0], places[1]))
        };
        for (sign, line) in [(17.0, 17.0), (13.0, 13.0), (12.0, 12.7)] {
            let (stop, crosswalk) = walked(sign);
            assert!((stop - line).abs() < 0.1 && (crosswalk - 10.0).abs() < 0.1, "{sign}: {stop} {crosswalk}");
        }
        let (stop, crosswalk) = walked(5.0);
        assert!(stop > 13.0 && (crosswalk - 10.0).abs() < 0.1, "the crosswalk asks for more: {stop} {crosswalk}");
    }
}

#[test]
fn the_stop_line_may_lie_on_another_piece_of_the_way() {
    let nodes = [(6, -14.0, 0.0, "highway=give_way direction=forward"), (7, -9.0, 0.0, "")];
    let cut = crossing(DrivingSide::Right, &[&[2, 6, 7], &[7, 1]], &nodes, &[]);
    assert!((stop(&cut) - 14.0).abs() < 0.1);
    let reversed = [(6, -14.0, 0.0, "highway=give_way direction=backward"), (7, -9.0, 0.0, "")];
    let reversed = crossing(DrivingSide::Right, &[&[7, 6, 2], &[7, 1]], &reversed, &[]);
    assert!((stop(&reversed) - 14.0).abs() < 0.1, "the way runs against the approach");
}

#[test]
fn a_road_without_room_is_not_cut_back_to_its_stop_line() {
    // A street crosses 22 m before the intersection.
    let street = |tags: &str| {
        let nodes = [(6, -11.0, 0.0, tags), (7, -22.0, 0.0, ""), (8, -22.0, 90.0, "")];
        let map = crossing(DrivingSide::Right, &[&[2, 7, 6, 1]], &nodes, &[(30, &[7, 8], STREET)]);
        let lines = map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line"));
        lines.map(|line| line.points.iter().map(|&point| place(&map, point)).collect::<Vec<_>>()).collect::<Vec<_>>()
    };
    assert_eq!(street("highway=stop direction=forward").len(), street("").len());
    let control: Vec<_> = street("highway=give_way direction=forward");
    assert_eq!(control, street(""));
}

#[test]
fn vehicles_that_give_way_stop_only_for_others() {
    for (tags, subtype, elements) in [("stop", "stop_sign", (1, 3)), ("give_way", "give_way", (1, 4))] {
        let tags = format!("highway={tags} direction=forward");
        let map = crossing(DrivingSide::Right, &[&[2, 6, 1]], &[(6, -12.0, 0.0, &tags)], &[]);
        let of =
            |kind: &str| map.regulatory_elements.iter().filter(|element| element.subtype == kind).collect::<Vec<_>>();
        let (signs, markings) = (of("traffic_sign"), of("road_marking"));
        assert_eq!((signs.len(), markings.len()), elements, "{tags}");
        let sign = signs[0].linestrings("refers").next().and_then(|id| map.linestrings.get(id)).unwrap();
        assert!(sign.attributes.is("type", "traffic_sign") && sign.attributes.is("subtype", subtype));
        let line = signs[0].linestrings("ref_line").next().unwrap();
        let marked = markings.iter().any(|marking| marking.linestrings("refers").any(|of| of == line));
        assert_eq!(marked, subtype == "give_way", "the line holds who waits for others");
        let bound: Vec<_> = map.lanelets.iter().filter(|l| l.regulatory_elements.contains(&signs[0].id)).collect();
        assert!(bound.len() == 1 && !bound[0].attributes.has("intersection_area"), "the lane before the line");
    }
}

#[test]
fn no_cut_lies_in_a_bend_or_just_before_one() {
    // The road bends by 45 degrees at 50 m.
    let nodes = [(1, 0.0, 0.0, ""), (2, 50.0, 0.0, ""), (3, 80.0, 30.0, "")];
    let network = network(&osm(&nodes, &[(10, &[1, 2, 3], STREET)]));
    let (road, length) = (&network.roads[0], network.roads[0].line.length());
    let cut = |kept, firm| clear_of_bends(road, ([0.0, length], firm, ROAD_LEFT), kept);
    assert_eq!(cut([5.0, length - 5.0], [0.0; 2]), [5.0, length - 5.0], "straight on");
    assert_eq!(cut([5.0, 51.0], [0.0; 2]), [5.0, 50.0], "up the road, before the bend");
    assert_eq!(cut([5.0, 51.0], [0.0, length - 60.0]), [5.0, 50.0], "the setback may grow");
    let near = |kept, firm: f64, wanted: f64| (cut(kept, [firm, 0.0])[0] - wanted).abs() < 1e-9;
    assert!(near([47.1, 85.0], 0.0, 50.1), "up the road, to where it goes on straight");
    assert!(near([47.1, 51.0], 0.0, 46.6), "back, where there is no room");
    assert!(near([48.8, 85.0], 48.8, 50.3), "but not where lanelets lie over the road");
}

#[test]
fn lights_hold_vehicles_before_the_first_crosswalk() {
    for side in SIDES {
        let light = (7, -9.0, 0.0, "highway=traffic_signals traffic_signals:direction=forward");
        let crosswalk = (6, -21.0, 0.0, "highway=crossing crossing=marked");
        let lit = stop(&crossing(side, &[&[2, 6, 7, 1]], &[light, crosswalk], &[]));
        assert!(lit > 22.5 && lit < 27.0, "{lit}");
        // Without lights a car waits between.
        let unlit = stop(&crossing(side, &[&[2, 6, 1]], &[crosswalk], &[]));
        assert!(unlit < 16.0, "{unlit}");
    }
}

#[test]
fn a_car_fits_between_two_side_streets() {
    for side in SIDES {
        // Nearer, turns leave less than 7 m, and the two are one intersection.
        for (apart, least) in [(14.5, None), (16.5, None), (26.0, Some(7.0)), (30.0, Some(7.0))] {
            let nodes = [
                (1, -150.0, 0.0, ""),
                (2, 0.0, 0.0, ""),
                (3, apart, 0.0, ""),
                (4, 150.0, 0.0, ""),
                (5, 0.0, 90.0, ""),
                (6, apart, 90.0, ""),
            ];
            let ways = [(10, &[1, 2, 3, 4][..], STREET), (11, &[2, 5], STREET), (12, &[3, 6], STREET)];
            let map = built_as(&Asked { nodes: &nodes, ways: &ways, options: driven_on(side) }).map;
            let between = |at: &[f64; 2]| at[0] > 1.0 && at[0] < apart - 1.0 && at[1].abs() < 5.0;
            let on_road = map.lanelets.iter().filter(|lanelet| lanelet.attributes.get("intersection_area").is_none());
            let lengths = on_road.filter_map(|lanelet| {
                let bound = map.linestrings.get(lanelet.left.line)?;
                let ends = [bound.points.first()?, bound.points.last()?].map(|point| place(&map, *point));
                ends.iter().all(between).then(|| (ends[0][0] - ends[1][0]).abs())
            });
            let lengths: Vec<f64> = lengths.collect();
            match least {
                Some(least) => {
                    assert!(lengths.len() >= 2 && lengths.iter().all(|length| *length > least), "{apart}: {lengths:?}");
                }
                None => assert!(lengths.is_empty(), "{apart}: {lengths:?}"),
            }
        }
    }
}
