//! Signals of small OpenDRIVE files: stop lines before the end of their road, who goes first, and which lights change together.

use lanewright::lanelet::Lanelet;

use super::opendrive_lanes::{LaneText, built, errors, junction, told};

const THROUGH: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.0, -1, -1)])];

/// The junction with signals on its roads, and with more inside its own element.
fn with(signals: &[(&str, &str)], inside: &str, behind: &str) -> String {
    let mut text = junction(THROUGH, -1);
    for (road, signals) in signals {
        let begin = text.find(&format!("<road id=\"{road}\"")).unwrap();
        let end = begin + text[begin..].find("</lanes>").unwrap() + "</lanes>".len();
        text.insert_str(end, &format!("<signals>{signals}</signals>"));
    }
    text.replace("</junction>", &format!("{inside}</junction>{behind}"))
}

fn signal(id: &str, kind: &str, station: f64, facing: &str) -> String {
    let dynamic = if kind == "1000001" { "yes" } else { "no" };
    format!(
        "<signal id=\"{id}\" s=\"{station}\" t=\"-4\" zOffset=\"3\" type=\"{kind}\" orientation=\"{facing}\" dynamic=\"{dynamic}\"/>"
    )
}

#[test]
fn a_light_hangs_on_the_lanelet_that_begins_at_its_stop_line() {
    for station in [43.0, 48.2] {
        hangs_behind(station, &[], |text| text);
    }
}

#[test]
fn a_light_hangs_behind_a_far_stop_line_though_its_road_is_divided_between() {
    // Another speed limit divides the lane between the stop line and the junction.
    let slower = "<speed max=\"50\" unit=\"km/h\"/></type>";
    let divided = format!("{slower}<type s=\"40\" type=\"town\"><speed max=\"30\" unit=\"km/h\"/></type>");
    hangs_behind(30.0, &[40.0], |text| text.replacen(slower, &divided, 1));
}

fn hangs_behind(station: f64, divided: &[f64], changed: impl Fn(String) -> String) {
    let signals = signal("line", "294", station, "+") + &signal("light", "1000001", 49.0, "+");
    let text = changed(with(&[("w", &signals)], "", ""));
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text).built.map;
    let lights: Vec<_> = map.regulatory_elements.iter().filter(|it| it.subtype == "traffic_light").collect();
    let [light] = lights[..] else { panic!("{lights:?}") };
    let carriers: Vec<_> = map.lanelets.iter().filter(|it| it.regulatory_elements.contains(&light.id)).collect();
    // From the line to the junction, one behind the other.
    let mut begins: Vec<f64> = carriers.iter().map(|it| map.bound_points(it.left).next().unwrap().position.x).collect();
    begins.sort_by(f64::total_cmp);
    let (first, rest) = begins.split_first().unwrap();
    assert!((first - station).abs() < 0.01, "{begins:?}");
    assert_eq!(rest, divided);
}

/// How many ways the straight way from the west, and the one from the east, may ignore.
fn ignored(text: &str) -> [usize; 2] {
    let map = built(text).built.map;
    let begins = |lanelet: &Lanelet| map.bound_points(lanelet.left).next().unwrap().position.x;
    [true, false].map(|west| {
        let straight = map.lanelets.iter().filter(|it| it.attributes.is("turn_direction", "straight"));
        let own: Vec<i64> = straight.filter(|it| (begins(it) < 55.0) == west).map(|it| it.id.0).collect();
        let ignores = map
            .regulatory_elements
            .iter()
            .filter(|it| it.subtype == "right_of_way" && it.lanelets("right_of_way").any(|id| own.contains(&id.0)));
        ignores.map(|it| it.role("yield").count()).sum()
    })
}

#[test]
fn signs_and_priorities_of_junctions_tell_who_goes_first() {
    // The south has no way in: the turn from the west and the way from the east do not meet, so a road from the south is needed.
    let text = with(&[], "", "").replace("<junction id=\"J\">", &format!("<junction id=\"J\">{}", connection()));
    let text = text.replace("</OpenDRIVE>", &format!("{}</OpenDRIVE>", from_south()));
    let plain = ignored(&text);
    let south = text.replace("<!--south-->", &format!("<signals>{}</signals>", signal("yield", "205", 45.0, "+")));
    let west = ignored(&south);
    assert!(west[0] > plain[0], "{plain:?} {west:?}");
    let stated = text.replace("</junction>", "<priority high=\"on\" low=\"up\"/></junction>");
    assert_eq!(ignored(&stated)[0], west[0]);
}

/// A road from the south with a way across the others to the east.
fn from_south() -> String {
    let quarter = 10.0 * std::f64::consts::FRAC_PI_2;
    let north = std::f64::consts::FRAC_PI_2;
    let lane = |before: i64, behind: i64| {
        format!(
            "<lanes><laneSection s=\"0\"><center><lane id=\"0\" type=\"none\"/></center><right><lane id=\"-1\" type=\"driving\"><link><predecessor id=\"{before}\"/><successor id=\"{behind}\"/></link><width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/></lane></right></laneSection></lanes>"
        )
    };
    format!(
        "<road id=\"in\" junction=\"-1\" length=\"50\"><link><successor elementType=\"junction\" elementId=\"J\"/></link><planView><geometry s=\"0\" x=\"60\" y=\"-60\" hdg=\"{north}\" length=\"50\"><line/></geometry></planView>{}<!--south--></road>\n<road id=\"up\" junction=\"J\" length=\"{quarter}\"><link><predecessor elementType=\"road\" elementId=\"in\" contactPoint=\"end\"/><successor elementType=\"road\" elementId=\"e\" contactPoint=\"start\"/></link><planView><geometry s=\"0\" x=\"60\" y=\"-10\" hdg=\"{north}\" length=\"{quarter}\"><arc curvature=\"-0.1\"/></geometry></planView>{}</road>\n",
        lane(0, 0),
        lane(-1, -1)
    )
}

fn connection() -> &'static str {
    "<connection id=\"9\" incomingRoad=\"in\" connectingRoad=\"up\" contactPoint=\"start\"><laneLink from=\"-1\" to=\"-1\"/></connection>"
}

#[test]
fn lights_of_two_controllers_are_two_phases() {
    let controllers = "<controller id=\"A\"><control signalId=\"lw\"/></controller><controller id=\"B\"><control signalId=\"le\"/></controller>";
    let text = with(
        &[("w", &signal("lw", "1000001", 49.0, "+")), ("e", &signal("le", "1000001", 1.0, "-"))],
        "<controller id=\"A\"/><controller id=\"B\"/>",
        controllers,
    );
    let settings = built(&text).built.settings;
    assert_eq!(settings.intersection[0].phases.len(), 2);
    let one = text.replace("<controller id=\"A\"/><controller id=\"B\"/>", "<controller id=\"A\"/>");
    assert!(built(&one).built.settings.intersection.iter().all(|it| it.phases.is_empty()));
}

#[test]
fn a_light_counts_at_the_stop_line_at_which_it_is_referred_to() {
    // It stands on the road behind the junction; the line is at the end of the way straight on.
    let reference = "<signalReference id=\"light\" s=\"19.8\" t=\"0\" orientation=\"+\"/>";
    let text = with(
        &[("on", &(signal("line", "294", 19.8, "+") + reference)), ("e", &signal("light", "1000001", 3.0, "+"))],
        "",
        "",
    );
    let map = built(&text).built.map;
    let lights: Vec<_> = map.regulatory_elements.iter().filter(|it| it.subtype == "traffic_light").collect();
    let [light] = lights[..] else { panic!("{lights:?}") };
    let carriers: Vec<_> = map.lanelets.iter().filter(|it| it.regulatory_elements.contains(&light.id)).collect();
    let [behind] = carriers[..] else { panic!("{carriers:?}") };
    let begin = map.bound_points(behind.left).next().unwrap().position.x;
    assert!((begin - 70.0).abs() < 0.01, "{begin}");
}

#[test]
fn a_stop_line_inside_a_junction_is_drawn_and_told() {
    // Behind its section, the lane grows wider.
    let wider: &[(f64, &[LaneText])] = &[(0.0, &[(-1, 3.5, 0.0, -1, -1)]), (10.0, &[(-1, 3.5, 0.1, -1, -1)])];
    let text = with(&[("on", &signal("line", "294", 4.0, "+"))], "", "");
    let begin = text.find("<road id=\"on\"").unwrap();
    let sections = |text: &str| {
        let from = text.find("<road id=\"on\"").unwrap();
        let [first, last] = ["<laneSection", "</lanes>"].map(|mark| from + text[from..].find(mark).unwrap());
        text[first..last].to_owned()
    };
    let (plain, other) = (sections(&text[begin..]), sections(&junction(wider, -1)));
    assert!(plain != other);
    let map = built(&(text[..begin].to_owned() + &text[begin..].replacen(&plain, &other, 1)));
    let lines = map.built.map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line"));
    let at_line = lines.filter(|line| {
        let first = line.points.first().and_then(|id| map.built.map.points.get(*id)).unwrap();
        let last = line.points.last().and_then(|id| map.built.map.points.get(*id)).unwrap();
        (first.position.x - 54.0).abs() < 0.01 && ((first.position - last.position).norm() - 3.5).abs() < 0.01
    });
    assert_eq!(at_line.count(), 1);
    assert!(told(&map, "stop line line of road on lies where no lane"), "{:?}", map.built.notes);
}

#[test]
fn crosswalks_of_the_own_list_are_as_broad_as_they_say_and_have_their_lights() {
    let crosswalk = signal("zebra", "1000003", 20.0, "+").replace("type=", "value=\"4\" type=");
    let signals = crosswalk + &signal("walk", "1000002", 20.0, "-");
    let text = with(&[("w", &signals)], "", "");
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text);
    assert!(!told(&map, "stands at no crosswalk"), "{:?}", map.built.notes);
    let map = map.built.map;
    let crosswalks: Vec<&Lanelet> = map.lanelets.iter().filter(|it| it.attributes.is("subtype", "crosswalk")).collect();
    let [crosswalk] = crosswalks[..] else { panic!("{crosswalks:?}") };
    let mut sides = [crosswalk.left, crosswalk.right].map(|side| map.bound_points(side).next().unwrap().position.x);
    sides.sort_by(f64::total_cmp);
    assert!((sides[0] - 18.0).abs() < 0.01 && (sides[1] - 22.0).abs() < 0.01, "{sides:?}");
    let lights = map.regulatory_elements.iter().filter(|it| it.subtype == "traffic_light");
    assert!(lights.map(|it| it.id).eq(crosswalk.regulatory_elements.iter().copied()));
}

#[test]
fn a_speed_limit_in_metres_that_names_another_unit_is_converted_and_told() {
    let sign = signal("limit", "274", 1.0, "+").replace("type=", "value=\"8.333333\" unit=\"km/h\" type=");
    let text = with(&[("w", &sign)], "", "").replace("<speed max=\"50\" unit=\"km/h\"/>", "");
    let map = built(&text);
    assert!(told(&map, "signal limit is a usual one in m/s"), "{:?}", map.built.notes);
    let limits = map.built.map.lanelets.iter().filter_map(|it| it.attributes.get("speed_limit"));
    assert!(limits.filter(|limit| *limit == "30").count() > 0);
}

#[test]
fn a_type_of_road_without_a_limit_ends_the_limit_before() {
    let slower = "<speed max=\"50\" unit=\"km/h\"/></type>";
    let town = "<speed max=\"30\" unit=\"km/h\"/></type>";
    let text = with(&[], "", "").replacen(slower, &format!("{town}<type s=\"20\" type=\"rural\"/>"), 1);
    let map = built(&text);
    assert!(told(&map, "has no speed limit: 50 km/h"), "{:?}", map.built.notes);
    let map = &map.built.map;
    let begin = |lanelet: &Lanelet| map.bound_points(lanelet.left).next().unwrap().position.x;
    let of_road = map.lanelets.iter().filter(|it| begin(it) < 45.0 && !it.attributes.has("turn_direction"));
    let mut limits: Vec<(i64, &str)> =
        of_road.map(|it| (begin(it).round() as i64, it.attributes.get("speed_limit").unwrap())).collect();
    limits.sort_unstable();
    // One lane leads there in two pieces, and one back.
    assert_eq!(limits, [(0, "30"), (20, "30"), (20, "50")]);
}

#[test]
fn the_lights_of_a_lanelet_are_one_element() {
    let signals = signal("left", "1000001", 49.0, "+") + &signal("right", "1000001", 49.5, "+");
    let text = with(&[("w", &signals)], "", "");
    assert_eq!(errors(&text), Vec::<String>::new());
    let map = built(&text).built.map;
    let lights: Vec<_> = map.regulatory_elements.iter().filter(|it| it.subtype == "traffic_light").collect();
    let [element] = lights[..] else { panic!("{lights:?}") };
    let count = |role: &str| element.role(role).count();
    assert_eq!(["refers", "light_bulbs", "ref_line"].map(count), [2, 2, 1]);
    assert!(map.lanelets.iter().any(|it| it.regulatory_elements.contains(&element.id)));
}
