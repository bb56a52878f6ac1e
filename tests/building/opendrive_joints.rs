//! How roads of small OpenDRIVE files meet: over pieces too short for lanelets, over gaps, at ends that are named wrongly, beside each other.

use lanewright::api::BuiltMap;
use lanewright::lanelet::{Lanelet, Polygon};

use super::opendrive_lanes::{LaneText, RoadText, built, errors, junction, line, roads, text, told};

const TWO_WAY: &[(f64, &[LaneText])] = &[(0.0, &[(1, 3.5, 0.0, 1, 1), (-1, 3.5, 0.0, -1, -1)])];

fn road<'a>(id: &'a str, links: [&'a str; 2], geometry: &'a str, length: f64) -> RoadText<'a> {
    RoadText { id, junction: "-1", links, geometry, length, sections: TWO_WAY }
}

/// How many pairs of lanelets follow each other.
fn following(map: &BuiltMap) -> usize {
    let ends = |lanelet: &Lanelet, last: bool| {
        [lanelet.left, lanelet.right].map(|bound| {
            let points: Vec<_> = map.built.map.bound_points(bound).map(|point| point.id).collect();
            if last { points[points.len() - 1] } else { points[0] }
        })
    };
    let all = roads(map);
    all.iter().map(|a| all.iter().filter(|b| ends(a, true) == ends(b, false)).count()).sum()
}

#[test]
fn roads_too_short_for_lanelets_are_dissolved_and_their_links_bridged() {
    let [before, short, behind] = [line(0.0, 0.0, 50.0), line(50.0, 0.0, 0.3), line(50.3, 0.0, 50.0)];
    let text = text(
        &[
            road("a", ["", "b start"], &before, 50.0),
            road("b", ["a end", "c start"], &short, 0.3),
            road("c", ["b end", ""], &behind, 50.0),
        ],
        "",
    );
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    assert_eq!((roads(&map).len(), following(&map)), (4, 2));
    assert!(!told(&map, "linked but end"), "{:?}", map.built.notes);
}

#[test]
fn links_to_the_wrong_end_of_a_road_are_taken_for_the_right_one() {
    let [before, behind] = [line(0.0, 0.0, 50.0), line(50.0, 0.0, 50.0)];
    let text = text(&[road("a", ["", "b end"], &before, 50.0), road("b", ["a start", ""], &behind, 50.0)], "");
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    assert_eq!(following(&map), 2);
    assert!(told(&map, "roads a and b do not meet at the ends that are linked"), "{:?}", map.built.notes);
}

#[test]
fn a_border_that_ends_off_its_node_is_drawn_to_it_and_does_not_run_back() {
    // The second road begins 0.4 m before the first one ends, and 0.2 m beside it, and has a knot 0.2 m behind its begin.
    let before = line(0.0, 0.0, 50.0);
    let behind = "<geometry s=\"0\" x=\"49.6\" y=\"0.2\" hdg=\"0\" length=\"0.2\"><line/></geometry><geometry s=\"0.2\" x=\"49.8\" y=\"0.2\" hdg=\"0\" length=\"49.8\"><line/></geometry>";
    let text = text(&[road("a", ["", "b start"], &before, 50.0), road("b", ["a end", ""], behind, 50.0)], "");
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    assert_eq!(following(&map), 2);
    assert!(told(&map, "linked but end 0.45 m from each other"), "{:?}", map.built.notes);
    for lanelet in roads(&map) {
        for bound in [lanelet.left, lanelet.right] {
            let east: Vec<f64> = map.built.map.bound_points(bound).map(|point| point.position.x).collect();
            assert!(east.is_sorted() || east.iter().rev().is_sorted(), "{east:?}");
        }
    }
}

#[test]
fn borders_of_two_roads_a_few_centimetres_apart_are_one() {
    let [south, north] = [line(0.0, 0.0, 50.0), line(0.0, 3.53, 50.0)];
    let of =
        |id, geometry, lane| RoadText { id, junction: "-1", links: ["", ""], geometry, length: 50.0, sections: lane };
    let east: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.0, 0, 0)])];
    let west: &[(f64, &[LaneText])] = &[(0.0, &[(1, 3.5, 0.0, 0, 0)])];
    // The one leads east between 0 and -3.5 m, the other west between 0.03 and 3.53 m.
    let north = north.replace("3.53", "0.03");
    let text = text(&[of("a", &south, east), of("b", &north, west)], "");
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    let [a, b] = roads(&map)[..] else { panic!() };
    assert_eq!(a.left.line, b.left.line);
}

#[test]
fn strips_beside_a_short_piece_of_road_are_none() {
    let shoulder =
        "<lane id=\"-2\" type=\"shoulder\"><width sOffset=\"0\" a=\"2\" b=\"0\" c=\"0\" d=\"0\"/></lane></right>";
    let [before, short] = [line(0.0, 0.0, 50.0), line(50.0, 0.0, 1.2)];
    let text = text(&[road("a", ["", "b start"], &before, 50.0), road("b", ["a end", ""], &short, 1.2)], "");
    let text = text.replace("</right>", shoulder);
    let map = built(&text);
    let strips = map.built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road_shoulder"));
    assert_eq!(strips.count(), 1);
}

#[test]
fn a_direct_junction_is_a_fork_without_an_area() {
    let [before, ahead, aside] = [line(0.0, 0.0, 50.0), line(50.0, 0.0, 50.0), line(50.0, -3.5, 50.0)];
    let of = |id, links, geometry, sections| RoadText { id, junction: "-1", links, geometry, length: 50.0, sections };
    let one: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.0, 0, 0)])];
    let two: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.0, 0, 0), (-2, 3.5, 0.0, 0, 0)])];
    let aside = aside.replace("hdg=\"0\"", "hdg=\"-0.1\"");
    let junction = "<junction id=\"D\" type=\"direct\"><connection id=\"0\" incomingRoad=\"a\" linkedRoad=\"b\" contactPoint=\"start\"><laneLink from=\"-1\" to=\"-1\"/></connection><connection id=\"1\" incomingRoad=\"a\" linkedRoad=\"c\" contactPoint=\"start\"><laneLink from=\"-2\" to=\"-1\"/></connection></junction>";
    let text = text(
        &[of("a", ["", "D"], &before, two), of("b", ["D", ""], &ahead, one), of("c", ["D", ""], &aside, one)],
        junction,
    );
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    assert_eq!((roads(&map).len(), following(&map)), (4, 2));
    assert!(map.built.map.polygons.iter().next().is_none());
}

#[test]
fn a_road_that_branches_off_within_another_is_told() {
    let [main, branch] = [line(0.0, 0.0, 100.0), line(40.0, -3.5, 30.0)];
    let text = text(
        &[road("main", ["", ""], &main, 100.0), road("branch", ["main end", ""], &branch, 30.0)],
        "<junction id=\"V\" type=\"virtual\" mainRoad=\"main\" sStart=\"38\" sEnd=\"42\"/>",
    );
    let text =
        text.replace("elementId=\"main\" contactPoint=\"end\"", "elementId=\"main\" elementS=\"40\" elementDir=\"+\"");
    let map = built(&text);
    assert!(told(&map, "branches off road main at s=40"), "{:?}", map.built.notes);
    assert!(!told(&map, "linked but end"), "{:?}", map.built.notes);
    assert!(map.built.map.polygons.iter().next().is_none());
}

#[test]
fn lateral_shapes_and_heights_of_lanes_lift_the_borders() {
    let geometry = line(0.0, 0.0, 50.0);
    let text = text(&[road("a", ["", ""], &geometry, 50.0)], "");
    let shapes = "</planView><lateralProfile><shape s=\"0\" t=\"-3.5\" a=\"0.14\" b=\"-0.04\" c=\"0\" d=\"0\"/><shape s=\"0\" t=\"0\" a=\"0\" b=\"0\" c=\"0\" d=\"0\"/></lateralProfile>";
    let text = text.replace("</planView>", shapes).replacen(
        "<lane id=\"1\" type=\"driving\">",
        "<lane id=\"1\" type=\"driving\"><height sOffset=\"0\" inner=\"0\" outer=\"0.2\"/>",
        1,
    );
    let map = built(&text);
    let mut heights: Vec<(f64, f64)> = roads(&map)
        .into_iter()
        .flat_map(|lanelet| [lanelet.left, lanelet.right])
        .flat_map(|bound| map.built.map.bound_points(bound).collect::<Vec<_>>())
        .map(|point| ((point.position.y * 10.0).round() / 10.0, point.ele().unwrap()))
        .collect();
    heights.sort_by(|a, b| a.0.total_cmp(&b.0));
    heights.dedup();
    assert_eq!(heights, [(-3.5, 0.14), (0.0, 0.0), (3.5, 0.2)]);
}

#[test]
fn a_way_through_a_junction_that_does_not_reach_its_lane_is_left_out() {
    // The way back ends 3 m beside the lane that it is linked to.
    let plain = junction(&[(0.0, &[(-1, 3.5, 0.0, -1, -1)])], -1);
    let at = plain.find("<road id=\"back\"").unwrap();
    let moved = plain[at..].replacen("x=\"50\" y=\"0\"", "x=\"50\" y=\"3\"", 1);
    let text = plain[..at].to_owned() + &moved;
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    assert_eq!(roads(&map).len() + 1, roads(&built(&plain)).len());
    assert!(told(&map, "lane 1 of road back does not reach the lane that it is linked to"), "{:?}", map.built.notes);
}

#[test]
fn a_ramp_that_leaves_a_road_is_no_intersection() {
    let plain = junction(&[(0.0, &[(-1, 3.5, 0.0, -1, -1)])], -1);
    let areas = |text: &str| {
        let is_area = |polygon: &Polygon| polygon.attributes.is("type", "intersection_area");
        built(text).built.map.polygons.iter().filter(|polygon| is_area(polygon)).count()
    };
    assert_eq!(areas(&plain), 1);
    let at = plain.find("<road id=\"turn\"").unwrap();
    let ramp = plain[..at].to_owned() + &plain[at..].replacen("type=\"driving\"", "type=\"offRamp\"", 1);
    assert_eq!(areas(&ramp), 0);
    assert_eq!(errors(&ramp), Vec::<String>::new());
}
