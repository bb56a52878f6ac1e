//! Lanes of small OpenDRIVE files: where they open, turn tightly, change their ids inside junctions, or lie back to back.

use std::collections::BTreeSet;

use lanewright::api::{BuiltMap, Input, LayoutOptions};
use lanewright::build;
use lanewright::lanelet::Lanelet;

use crate::common::program::lanewright;

/// A lane: id, width where its section begins, width per metre, the lanes before and behind; 0 is none.
pub type LaneText = (i64, f64, f64, i64, i64);

/// A road: id, junction, predecessor and successor with their contact points, its geometry, and its sections with their stations.
pub struct RoadText<'a> {
    pub id: &'a str,
    pub junction: &'a str,
    pub links: [&'a str; 2],
    pub geometry: &'a str,
    pub length: f64,
    pub sections: &'a [(f64, &'a [LaneText])],
}

pub fn text(roads: &[RoadText], rest: &str) -> String {
    let mut out = String::from("<OpenDRIVE><header revMajor=\"1\" revMinor=\"6\"/>\n");
    for road in roads {
        let link = |side: &str, words: &str| match words.split_once(' ') {
            Some((to, contact)) => {
                format!("<{side} elementType=\"road\" elementId=\"{to}\" contactPoint=\"{contact}\"/>")
            }
            None if words.is_empty() => String::new(),
            None => format!("<{side} elementType=\"junction\" elementId=\"{words}\"/>"),
        };
        out += &format!("<road id=\"{}\" junction=\"{}\" length=\"{}\"><link>", road.id, road.junction, road.length);
        out += &link("predecessor", road.links[0]);
        out += &link("successor", road.links[1]);
        out += &format!(
            "</link><type s=\"0\" type=\"town\"><speed max=\"50\" unit=\"km/h\"/></type><planView>{}</planView><lanes>\n",
            road.geometry
        );
        for (start, lanes) in road.sections {
            out += &format!("<laneSection s=\"{start}\"><center><lane id=\"0\" type=\"none\"/></center>");
            for side in ["left", "right"] {
                out += &format!("<{side}>");
                for (id, width, slope, before, behind) in lanes.iter().filter(|lane| (lane.0 > 0) == (side == "left")) {
                    let link =
                        |name: &str, to: &i64| if *to == 0 { String::new() } else { format!("<{name} id=\"{to}\"/>") };
                    let links = link("predecessor", before) + &link("successor", behind);
                    out += &format!(
                        "<lane id=\"{id}\" type=\"driving\"><link>{links}</link><width sOffset=\"0\" a=\"{width}\" b=\"{slope}\" c=\"0\" d=\"0\"/></lane>\n"
                    );
                }
                out += &format!("</{side}>");
            }
            out += "</laneSection>";
        }
        out += "</lanes></road>\n";
    }
    out + rest + "</OpenDRIVE>"
}

pub fn line(x: f64, y: f64, length: f64) -> String {
    format!("<geometry s=\"0\" x=\"{x}\" y=\"{y}\" hdg=\"0\" length=\"{length}\"><line/></geometry>")
}

pub fn built(text: &str) -> BuiltMap {
    build(Input::bytes("survey.xodr", text), &LayoutOptions::default()).unwrap()
}

pub fn roads(map: &BuiltMap) -> Vec<&Lanelet> {
    map.built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road")).collect()
}

/// The errors of `check` on the map of a text.
pub fn errors(text: &str) -> Vec<String> {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("survey.xodr"), text).unwrap();
    lanewright(dir.path(), &["build", "survey.xodr", "-o", "map"]).exits(0);
    let check = lanewright(dir.path(), &["check", "map", "--fail-on", "never", "--format", "concise"]);
    check.stdout.lines().filter(|line| line.contains(" error[")).map(str::to_owned).collect()
}

#[test]
fn a_lane_that_opens_between_two_others_has_bounds_of_its_own() {
    let geometry = line(0.0, 0.0, 200.0);
    let road = RoadText {
        id: "a",
        junction: "-1",
        links: ["", ""],
        geometry: &geometry,
        length: 200.0,
        sections: &[
            (0.0, &[(-1, 3.5, 0.0, 0, -1), (-2, 3.5, 0.0, 0, -3)]),
            (100.0, &[(-1, 3.5, 0.0, -1, 0), (-2, 0.0, 0.035, 0, 0), (-3, 3.5, 0.0, -2, 0)]),
        ],
    };
    let text = text(&[road], "");
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    // Two before, two beside the opening, three behind.
    assert_eq!(roads(&map).len(), 7);
    for lanelet in roads(&map) {
        let points = |bound| map.built.map.bound_points(bound).map(|point| point.id).collect::<BTreeSet<_>>();
        assert!(points(lanelet.left).is_disjoint(&points(lanelet.right)));
    }
}

#[test]
fn a_lane_that_opens_at_the_edge_begins_with_its_section() {
    let geometry = line(0.0, 0.0, 200.0);
    let road = RoadText {
        id: "a",
        junction: "-1",
        links: ["", ""],
        geometry: &geometry,
        length: 200.0,
        sections: &[(0.0, &[(-1, 3.5, 0.0, 0, -1)]), (100.0, &[(-1, 3.5, 0.0, -1, 0), (-2, 0.0, 0.035, 0, 0)])],
    };
    let text = text(&[road], "");
    assert_eq!(errors(&text), Vec::<String>::new());
    assert_eq!(roads(&built(&text)).len(), 3);
}

#[test]
fn the_inner_bound_of_a_turn_does_not_run_back() {
    // Of the lane, which is 3.5 m wide, the inner border turns around a point 3.4 m from the middle of the road.
    let length = 3.4 * std::f64::consts::FRAC_PI_2;
    let geometry = format!(
        "<geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"20\"><line/></geometry><geometry s=\"20\" x=\"20\" y=\"0\" hdg=\"0\" length=\"{length}\"><arc curvature=\"{}\"/></geometry><geometry s=\"{}\" x=\"23.4\" y=\"-3.4\" hdg=\"{}\" length=\"20\"><line/></geometry>",
        -1.0 / 3.4,
        20.0 + length,
        -std::f64::consts::FRAC_PI_2
    );
    let road = RoadText {
        id: "a",
        junction: "-1",
        links: ["", ""],
        geometry: &geometry,
        length: 40.0 + length,
        sections: &[(0.0, &[(-1, 3.5, 0.0, 0, 0)])],
    };
    let map = built(&text(&[road], ""));
    let lanelet = roads(&map)[0];
    let points: Vec<_> = map.built.map.bound_points(lanelet.right).map(|point| point.position).collect();
    for pair in points.windows(2) {
        let step = pair[1] - pair[0];
        assert!(step.x > -1e-6 && step.y < 1e-6, "{points:?}");
    }
}

/// A road from the west, one to the east and one to the south; `through` has the sections of the way straight on.
pub fn junction(through: &[(f64, &[LaneText])], entry: i64) -> String {
    let [west, middle, east] = [line(0.0, 0.0, 50.0), line(50.0, 0.0, 20.0), line(70.0, 0.0, 50.0)];
    let quarter = 10.0 * std::f64::consts::FRAC_PI_2;
    let turn = format!(
        "<geometry s=\"0\" x=\"50\" y=\"0\" hdg=\"0\" length=\"{quarter}\"><arc curvature=\"-0.1\"/></geometry>"
    );
    let south = format!(
        "<geometry s=\"0\" x=\"60\" y=\"-10\" hdg=\"{}\" length=\"50\"><line/></geometry>",
        -std::f64::consts::FRAC_PI_2
    );
    let one: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.0, 0, 0)])];
    let both: &[(f64, &[LaneText])] = &[(0.0, &[(1, 3.5, 0.0, 0, 0), (-1, 3.5, 0.0, 0, 0)])];
    let way: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.0, -1, -1)])];
    let back: &[(f64, &[LaneText])] = &[(0.0, &[(1, 3.5, 0.0, 1, 1)])];
    let road =
        |id, junction, links, geometry, length, sections| RoadText { id, junction, links, geometry, length, sections };
    let links = |connection: &str, from: &str, to: &str, contact: &str, lanes: [i64; 2]| {
        format!(
            "<connection id=\"{connection}\" incomingRoad=\"{from}\" connectingRoad=\"{to}\" contactPoint=\"{contact}\"><laneLink from=\"{}\" to=\"{}\"/></connection>",
            lanes[0], lanes[1]
        )
    };
    let all = format!(
        "<junction id=\"J\">{}{}{}</junction>",
        links("0", "w", "on", "start", [-1, entry]),
        links("1", "w", "turn", "start", [-1, -1]),
        links("2", "e", "back", "end", [1, 1])
    );
    text(
        &[
            road("w", "-1", ["", "J"], &west, 50.0, both),
            road("e", "-1", ["J", ""], &east, 50.0, both),
            road("s", "-1", ["J", ""], &south, 50.0, one),
            road("on", "J", ["w end", "e start"], &middle, 20.0, through),
            road("back", "J", ["w end", "e start"], &middle, 20.0, back),
            road("turn", "J", ["w end", "s start"], &turn, quarter, way),
        ],
        &all,
    )
}

#[test]
fn a_way_through_a_junction_is_one_lanelet_whatever_its_ids_are() {
    let plain = junction(&[(0.0, &[(-1, 3.5, 0.0, -1, -1)])], -1);
    let renamed = junction(
        &[
            (0.0, &[(-1, 3.5, 0.0, -1, -2)]),
            (8.0, &[(-1, 0.0, 0.0, 0, 0), (-2, 3.5, 0.0, -1, -1)]),
            (12.0, &[(-1, 3.5, 0.0, -2, -1)]),
        ],
        -1,
    );
    for text in [plain, renamed] {
        assert_eq!(errors(&text), Vec::<String>::new());
        let map = built(&text);
        let inside =
            roads(&map).into_iter().filter(|lanelet| lanelet.attributes.get("turn_direction").is_some()).count();
        assert_eq!(inside, 3);
    }
}

#[test]
fn connecting_roads_back_to_back_share_their_border() {
    let map = built(&junction(&[(0.0, &[(-1, 3.5, 0.0, -1, -1)])], -1));
    let straight: Vec<_> =
        roads(&map).into_iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "straight")).collect();
    let [a, b] = straight[..] else { panic!("{straight:?}") };
    assert_eq!(a.left.line, b.left.line);
}

#[test]
fn lanes_that_a_file_leads_to_nothing_are_named() {
    let text = junction(&[(0.0, &[(-1, 3.5, 0.0, -1, -1)])], -1);
    let from = text.find("<connection id=\"2\"").unwrap();
    let to = from + text[from..].find("</connection>").unwrap();
    let mut loose = text.clone();
    loose.replace_range(from..to, "<connection id=\"2\">");
    let loose = loose.replace("<road id=\"back\"", "<road id=\"unused\"").replace(
        "<predecessor elementType=\"road\" elementId=\"w\" contactPoint=\"end\"/><successor elementType=\"road\" elementId=\"e\" contactPoint=\"start\"/></link><type s=\"0\" type=\"town\"><speed max=\"50\" unit=\"km/h\"/></type><planView><geometry s=\"0\" x=\"50\" y=\"0\" hdg=\"0\" length=\"20\"><line/></geometry></planView><lanes>\n<laneSection s=\"0\"><center><lane id=\"0\" type=\"none\"/></center><left><lane",
        "</link><planView/><lanes>\n<laneSection s=\"0\"><center><lane id=\"0\" type=\"none\"/></center><left><lane",
    );
    let map = built(&loose);
    let told = map.built.notes.iter().any(|note| note.message.contains("leads nowhere from lane 1 of road e"));
    assert!(told, "{:?}", map.built.notes);
    assert_eq!(map.built.settings.loose_ends.ends.len(), 1);
    assert_eq!(built(&text).built.settings.loose_ends.ends.len(), 0);
}

/// Whether a note of a map has these words.
pub fn told(map: &BuiltMap, words: &str) -> bool {
    map.built.notes.iter().any(|note| note.message.contains(words))
}

#[test]
fn lanes_that_meet_though_nothing_links_them_are_joined_and_told() {
    let geometry = line(0.0, 0.0, 200.0);
    let road =
        |sections| RoadText { id: "a", junction: "-1", links: ["", ""], geometry: &geometry, length: 200.0, sections };
    let text = text(
        &[road(&[
            (0.0, &[(1, 3.5, 0.0, 0, 0), (-1, 3.5, 0.0, 0, 0)]),
            (100.0, &[(1, 3.5, 0.0, 0, 0), (-1, 3.5, 0.0, 0, 0)]),
        ])],
        "",
    );
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    assert!(told(&map, "at 2 places along road a lanes meet"), "{:?}", map.built.notes);
    let ends = |lanelet: &Lanelet, last: bool| {
        [lanelet.left, lanelet.right].map(|bound| {
            let points: Vec<_> = map.built.map.bound_points(bound).map(|point| point.id).collect();
            if last { points[points.len() - 1] } else { points[0] }
        })
    };
    let follow = |a: &Lanelet| roads(&map).into_iter().filter(|b| ends(a, true) == ends(b, false)).count();
    assert_eq!(roads(&map).into_iter().map(follow).sum::<usize>(), 2);
}

#[test]
fn a_turn_on_the_spot_is_left_out() {
    // Its left border begins and ends at the middle of the road.
    let half = 1.75 * std::f64::consts::PI;
    let turn = format!(
        "<geometry s=\"0\" x=\"50\" y=\"-1.75\" hdg=\"0\" length=\"{half}\"><arc curvature=\"{}\"/></geometry>",
        1.0 / 1.75
    );
    let plain = junction(&[(0.0, &[(-1, 3.5, 0.0, -1, -1)])], -1);
    let width = "<width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/>";
    let road = format!(
        "<road id=\"about\" junction=\"J\" length=\"{half}\"><link><predecessor elementType=\"road\" elementId=\"w\" contactPoint=\"end\"/><successor elementType=\"road\" elementId=\"w\" contactPoint=\"end\"/></link><planView>{turn}</planView><lanes><laneOffset s=\"0\" a=\"1.75\" b=\"0\" c=\"0\" d=\"0\"/><laneSection s=\"0\"><center><lane id=\"0\" type=\"none\"/></center><right><lane id=\"-1\" type=\"driving\"><link><predecessor id=\"-1\"/><successor id=\"1\"/></link>{width}</lane></right></laneSection></lanes></road>"
    );
    let text = plain.replace("</OpenDRIVE>", &format!("{road}</OpenDRIVE>"));
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    assert!(told(&map, "lane -1 of road about turns on the spot"), "{:?}", map.built.notes);
    assert_eq!(roads(&map).len(), roads(&built(&plain)).len());
}

#[test]
fn a_helix_is_cut_before_its_outline_crosses_itself() {
    let length = 40.0 * std::f64::consts::TAU;
    let arc =
        format!("<geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"{length}\"><arc curvature=\"0.05\"/></geometry>");
    let road = RoadText {
        id: "ramp",
        junction: "-1",
        links: ["", ""],
        geometry: &arc,
        length,
        sections: &[(0.0, &[(-1, 3.5, 0.0, 0, 0)])],
    };
    let text = text(&[road], "").replace(
        "</planView>",
        "</planView><elevationProfile><elevation s=\"0\" a=\"0\" b=\"0.05\" c=\"0\" d=\"0\"/></elevationProfile>",
    );
    assert!(!errors(&text).iter().any(|line| line.contains("self-crossing")));
    assert_eq!(roads(&built(&text)).len(), 4);
}

#[test]
fn borders_of_two_roads_above_each_other_are_two() {
    let flat = junction(&[(0.0, &[(-1, 3.5, 0.0, -1, -1)])], -1);
    let hump = "<elevationProfile><elevation s=\"0\" a=\"0\" b=\"0\" c=\"0.0012\" d=\"-0.00006\"/></elevationProfile>";
    let begin = flat.find("<road id=\"back\"").unwrap();
    let at = begin + flat[begin..].find("</planView>").unwrap() + "</planView>".len();
    let mut raised = flat.clone();
    raised.insert_str(at, hump);
    for (text, one) in [(flat, true), (raised, false)] {
        let map = built(&text);
        let straight: Vec<_> =
            roads(&map).into_iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "straight")).collect();
        let [a, b] = straight[..] else { panic!("{straight:?}") };
        assert_eq!(a.left.line == b.left.line, one);
    }
}

#[test]
fn odd_shapes_inside_junctions_are_told() {
    let bulge: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.3, -1, -1)]), (10.0, &[(-1, 6.5, -0.3, -1, -1)])];
    let map = built(&junction(bulge, -1));
    let swells = map.built.notes.iter().find(|note| note.message.contains("lane -1 of road on (lanelet "));
    let swells = swells.expect("a note about the lane");
    assert!(swells.message.contains(") is 6."), "{swells:?}");
    let named = |lanelet: &&Lanelet| swells.message.contains(&lanelet.id.0.to_string());
    assert_eq!(roads(&map).into_iter().filter(named).count(), 1, "{swells:?}");
    let plain = built(&junction(&[(0.0, &[(-1, 3.5, 0.0, -1, -1)])], -1));
    assert!(!told(&plain, "it is built as it is"), "{:?}", plain.built.notes);
}

/// Paint changes where a strip between the directions, which closes ahead, is narrower than Lanelet2's users take for one line.
#[test]
fn a_road_is_not_cut_where_a_strip_between_its_directions_closes() {
    let geometry = line(0.0, 0.0, 80.0);
    let road = RoadText {
        id: "a",
        junction: "-1",
        links: ["", ""],
        geometry: &geometry,
        length: 80.0,
        sections: &[
            (0.0, &[(1, 3.5, 0.0, 0, 1), (-1, 1.0, -0.025, 0, 0), (-2, 3.5, 0.0, 0, -1)]),
            (40.0, &[(1, 3.5, 0.0, 1, 0), (-1, 3.5, 0.0, -2, 0)]),
        ],
    };
    let strip = "<lane id=\"-1\" type=\"driving\"><link></link>";
    let text = text(&[road], "").replace(strip, &strip.replace("driving", "restricted"));
    let outer = "<lane id=\"-2\" type=\"driving\"><link><successor id=\"-1\"/></link><width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/>";
    assert!(text.contains(outer) && text.contains("restricted"), "{text}");
    let marks = "<roadMark sOffset=\"0\" type=\"solid\"/><roadMark sOffset=\"30\" type=\"broken\"/>";
    let text = text.replace(outer, &format!("{outer}{marks}"));
    assert_eq!(errors(&text), Vec::<String>::new());
    // 30 m on the strip is 0.25 m wide; 2.8 m before that, 0.32 m.
    let map = built(&text);
    let begins = |at: f64| {
        let first = |lanelet: &&Lanelet| map.built.map.bound_points(lanelet.left).next().unwrap().position.x;
        roads(&map).iter().any(|lanelet| (first(lanelet) - at).abs() < 0.15)
    };
    assert!(begins(27.2) && !begins(30.0));
}

/// A lane opens behind a road that is too short for lanelets and is left out: its inner border has no other to be joined with.
#[test]
fn a_lane_that_opens_behind_a_short_road_is_upright() {
    let geometry = [line(0.0, 0.0, 20.0), line(20.0, 0.0, 0.12), line(20.12, 0.0, 20.0)];
    let lanes: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 0.5, 0.0, 0, -1), (-2, 3.0, 0.0, 0, -2)])];
    let short: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 0.5, 0.0, -1, -1), (-2, 3.0, 0.0, -2, -3)])];
    let opening: &[(f64, &[LaneText])] =
        &[(0.0, &[(-1, 0.5, 0.0, -1, 0), (-2, 0.0, 0.2, 0, 0), (-3, 3.0, 0.0, -2, 0)])];
    let road = |id, links, at: usize, sections| RoadText {
        id,
        junction: "-1",
        links,
        geometry: &geometry[at],
        length: [20.0, 0.12, 20.0][at],
        sections,
    };
    let roads = [
        road("a", ["", "b start"], 0, lanes),
        road("b", ["a end", "c start"], 1, short),
        road("c", ["b end", ""], 2, opening),
    ];
    let strip = |text: String| {
        let typed = |line: &str| match line.contains("<lane id=\"-1\"") {
            true => line.replace("driving", "shoulder"),
            false => line.to_owned(),
        };
        text.lines().map(typed).collect::<Vec<_>>().join("\n")
    };
    // The third road's lanes lead to the left of its reference line.
    let (before, third) =
        strip(text(&roads, "")).split_once("<road id=\"c\"").map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
    let third = third.replace("<lanes>", "<lanes><laneOffset s=\"0\" a=\"0\" b=\"0.446\" c=\"0\" d=\"0\"/>");
    assert_eq!(errors(&format!("{before}<road id=\"c\"{third}")), Vec::<String>::new());
}

#[test]
fn errors_that_the_lanes_of_a_file_make_are_told_with_its_own_names() {
    let lanes: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.0, -1, -1)])];
    let geometry = [line(0.0, 0.0, 50.0), line(50.0, 0.0, 50.0)];
    let road = |id, links, at: usize| RoadText {
        id,
        junction: "-1",
        links,
        geometry: &geometry[at],
        length: 50.0,
        sections: lanes,
    };
    let plain = text(&[road("a", ["", "b start"], 0), road("b", ["a end", ""], 1)], "");
    assert_eq!(errors(&plain), Vec::<String>::new());
    // The second road's lane is driven the other way.
    let (first, second) = plain.split_once("<road id=\"b\"").unwrap();
    let against = second.replace("<lane id=\"-1\"", "<lane id=\"-1\" direction=\"reversed\"");
    let text = format!("{first}<road id=\"b\"{against}");
    let found = errors(&text);
    assert!(found.len() == 1 && found[0].contains("health/head-on"), "{found:?}");
    let map = built(&text);
    let notes: Vec<_> = map.built.notes.iter().filter(|note| note.fault == "opendrive-error").collect();
    let [note] = notes[..] else { panic!("one note: {notes:?}") };
    for part in ["lane -1 of road a (lanelet ", " and lane -1 of road b (lanelet ", "[health/head-on]"] {
        assert!(note.message.contains(part), "{note:?}");
    }
    assert!(!built(&plain).built.notes.iter().any(|note| note.fault == "opendrive-error"));
}
