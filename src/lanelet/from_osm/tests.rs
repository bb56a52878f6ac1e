//! One small map for each thing the loader stumbles over.

use super::*;
use crate::lanelet::{BoundRole, LaneletId, RegulatoryElementId, role_limits};
use crate::osm::{Text, read_bytes};

const NODES: &str = r#"<MetaInfo format_version="2" map_version="1"/>
<node id="1" lat="35.00000" lon="139.30000"><tag k="ele" v="1"/></node>
<node id="2" lat="35.00000" lon="139.30010"><tag k="ele" v="1"/></node>
<node id="3" lat="34.99997" lon="139.30000"><tag k="ele" v="1"/></node>
<node id="4" lat="34.99997" lon="139.30010"><tag k="ele" v="1"/></node>"#;
const WAYS: &str = r#"<way id="11"><nd ref="1"/><nd ref="2"/></way><way id="12"><nd ref="3"/><nd ref="4"/></way>
<way id="13"><nd ref="1"/><nd ref="2"/><nd ref="4"/><tag k="area" v="yes"/></way>"#;
const LANELET: &str = r#"<relation id="21"><member type="way" ref="11" role="left"/><member type="way" ref="12" role="right"/>
<member type="relation" ref="31" role="regulatory_element"/><tag k="type" v="lanelet"/></relation>"#;
const LIGHT: &str = r#"<relation id="31"><member type="way" ref="11" role="refers"/><tag k="type" v="regulatory_element"/>
<tag k="subtype" v="traffic_light"/></relation>"#;

fn load_with(body: &str, projector: &Projector) -> Loaded {
    let mut osm = OsmData::default();
    read_bytes(&mut osm, "test", format!("<osm>{body}</osm>").into_bytes()).unwrap();
    from_osm(&osm, projector)
}

fn load(parts: &[&str]) -> Loaded {
    load_with(&parts.concat(), &Projector::mgrs("54SUD".parse().unwrap()))
}

fn conditions(loaded: &Loaded) -> Vec<(Subject, Condition)> {
    loaded.faults.iter().map(|f| (f.subject, f.condition.clone())).collect()
}

/// The faults of a whole map in which one piece of text is replaced by another.
fn changed(from: &str, to: &str) -> Vec<(Subject, Condition)> {
    let whole = [NODES, WAYS, LANELET, LIGHT].concat();
    assert!(whole.contains(from), "{from}");
    conditions(&load(&[&whole.replacen(from, to, 1)]))
}

fn text(word: &str) -> Text {
    Text::from(word)
}

#[test]
fn a_sound_map_has_no_fault() {
    let loaded = load(&[NODES, WAYS, LANELET, LIGHT]);
    assert_eq!(conditions(&loaded), []);
    let map = &loaded.map;
    let sizes = [map.points.len(), map.linestrings.len(), map.polygons.len(), map.lanelets.len()];
    assert_eq!((sizes, map.regulatory_elements.len()), ([4, 2, 1, 1], 1));
    let lanelet = map.lanelets.get(LaneletId(21)).unwrap();
    assert_eq!((lanelet.left.inverted, lanelet.right.inverted), (false, false));
    assert_eq!(lanelet.regulatory_elements, [RegulatoryElementId(31)]);
    assert_eq!(map.outline(lanelet).len(), 4);
    assert!(lanelet.span.is_some());
}

#[test]
fn elements_may_stand_in_any_order() {
    let loaded = load(&[LANELET, LIGHT, WAYS, NODES]);
    assert_eq!(conditions(&loaded), []);
    assert_eq!(loaded.map.lanelets.len(), 1);
}

#[test]
fn a_missing_node_takes_the_way_and_its_lanelet_along() {
    let faults = changed(r#"<nd ref="4"/></way>"#, r#"<nd ref="9"/></way>"#);
    let (kind, id) = (ElementKind::Node, 9);
    let missing = Condition::MissingReference { kind, id, role: None };
    let dropped = Condition::BoundDropped { role: BoundRole::Right, way: 12 };
    assert_eq!(faults, [(Subject::LineString(12), missing), (Subject::Lanelet(21), dropped)]);
}

#[test]
fn a_deleted_way_leaves_its_references_dangling() {
    let faults = changed(r#"<way id="12">"#, r#"<way id="12" action="delete">"#);
    let (kind, id, role) = (ElementKind::Way, 12, Some(text("right")));
    let missing = Condition::MissingReference { kind, id, role };
    let count = Condition::BoundCount { role: BoundRole::Right, count: 0, ways: vec![], meant: None };
    assert_eq!(faults, [(Subject::Lanelet(21), missing), (Subject::Lanelet(21), count)]);
}

#[test]
fn bounds_are_two_ways_without_area() {
    let right = r#"<member type="way" ref="12" role="right"/>"#;
    let lanelet = |condition| vec![(Subject::Lanelet(21), condition)];
    let role = BoundRole::Right;
    assert_eq!(
        changed(right, r#"<member type="way" ref="13" role="right"/>"#),
        lanelet(Condition::BoundIsPolygon { role, way: 13 })
    );
    assert_eq!(
        changed(right, r#"<member type="node" ref="3" role="right"/>"#),
        lanelet(Condition::BoundIsNotWay { role, kind: ElementKind::Node, id: 3 })
    );
    assert_eq!(
        changed(right, &right.repeat(2)),
        lanelet(Condition::BoundCount { role, count: 2, ways: vec![12, 12], meant: None })
    );
    assert_eq!(
        changed(r#"<nd ref="3"/><nd ref="4"/></way>"#, r#"<nd ref="3"/></way>"#),
        lanelet(Condition::BoundTooShort { role, way: 12 })
    );
    assert_eq!(
        changed(r#"<nd ref="3"/><nd ref="4"/></way>"#, "</way>"),
        [
            (Subject::LineString(12), Condition::WayWithoutNodes),
            (Subject::Lanelet(21), Condition::BoundDropped { role, way: 12 })
        ]
    );
    let centerline = r#"<member type="way" ref="12" role="centerline"/>"#;
    let role = BoundRole::Centerline;
    assert_eq!(
        changed(right, &[right, centerline, centerline].concat()),
        lanelet(Condition::BoundCount { role, count: 2, ways: vec![12, 12], meant: None })
    );
}

#[test]
fn a_lanelet_without_bounds_is_off_the_shelf_and_off_the_elements() {
    let yields = LIGHT.replace("traffic_light", "right_of_way").replace(
        r#"<member type="way" ref="11" role="refers"/>"#,
        r#"<member type="relation" ref="21" role="right_of_way"/><member type="relation" ref="22" role="yield"/>"#,
    );
    let broken = LANELET.replace("21", "22").replace(r#"ref="12""#, r#"ref="13""#);
    let loaded = load(&[NODES, WAYS, LANELET, &broken, &yields]);
    assert!(!loaded.map.lanelets.contains(LaneletId(22)));
    let element = loaded.map.regulatory_elements.get(RegulatoryElementId(31)).unwrap();
    assert_eq!(element.members.len(), 1);
    let dropped = Condition::MemberDropped { kind: ElementKind::Relation, id: 22, role: text("yield") };
    assert!(conditions(&loaded).contains(&(Subject::RegulatoryElement(31), dropped)));
}

#[test]
fn regulatory_elements_need_what_their_constructor_needs() {
    let element = |condition| (Subject::RegulatoryElement(31), condition);
    let gone = {
        let role = text("regulatory_element");
        (Subject::Lanelet(21), Condition::MemberDropped { kind: ElementKind::Relation, id: 31, role })
    };
    let subtype = r#"<tag k="subtype" v="traffic_light"/>"#;
    assert_eq!(changed(subtype, ""), [element(Condition::WithoutSubtype { meant: None }), gone.clone()]);
    let unknown = Condition::UnknownSubtype { subtype: text("yield"), has_bounds: false };
    assert_eq!(changed(subtype, r#"<tag k="subtype" v="yield"/>"#), [element(unknown), gone.clone()]);
    let count = |subtype: &str, at: usize, count| {
        element(Condition::MemberCount { subtype: text(subtype), limit: role_limits(subtype).unwrap()[at], count })
    };
    assert_eq!(
        changed(r#"<member type="way" ref="11" role="refers"/>"#, ""),
        [element(Condition::WithoutMembers { subtype: text("traffic_light") }), gone.clone()]
    );
    assert_eq!(
        changed(subtype, r#"<tag k="subtype" v="right_of_way"/>"#),
        [count("right_of_way", 0, 0), count("right_of_way", 1, 0), gone.clone()]
    );
    assert_eq!(
        changed(subtype, r#"<tag k="subtype" v="detection_area"/>"#),
        [count("detection_area", 0, 0), count("detection_area", 1, 0), gone.clone()]
    );
    assert_eq!(changed(subtype, r#"<tag k="subtype" v="road_marking"/>"#), []);
    let sign = Condition::SignWithoutType { subtype: text("traffic_sign"), sign: Some(11) };
    assert_eq!(changed(subtype, r#"<tag k="subtype" v="traffic_sign"/>"#), [element(sign.clone()), gone.clone()]);
    // The tag of the element is of no use to a sign that is there.
    let typed = r#"<tag k="subtype" v="traffic_sign"/><tag k="sign_type" v="de206"/>"#;
    assert_eq!(changed(subtype, typed), [element(sign), gone]);
    let display = |subtype: &str, at: usize| role_limits(subtype).unwrap()[at].to_string();
    assert_eq!(display("road_marking", 0), "exactly 1");
    assert_eq!(display("right_of_way", 1), "at least 1");
    assert_eq!(display("right_of_way", 2), "at most 1");
}

#[test]
fn members_of_elements_are_no_elements() {
    let refers = r#"<member type="way" ref="11" role="refers"/>"#;
    let with = |more: &str| changed(refers, &[refers, more].concat());
    let element = |condition| vec![(Subject::RegulatoryElement(31), condition)];
    let (id, role) = (31, text("refers"));
    assert_eq!(
        with(r#"<member type="relation" ref="31" role="refers"/>"#),
        element(Condition::MemberIsRegulatoryElement { id, role })
    );
    let faults = conditions(&load(&[
        NODES,
        WAYS,
        LANELET,
        &LIGHT.replacen(refers, &[refers, r#"<member type="relation" ref="41" role="refers"/>"#].concat(), 1),
        r#"<relation id="41"><member type="way" ref="11" role=""/></relation>"#,
    ]));
    let member = Condition::MemberOfUnknownType { id: 41, role: text("refers"), found: None };
    assert_eq!(
        faults,
        [
            (Subject::Relation(41), Condition::UnknownRelationType { found: None, meant: None }),
            (Subject::RegulatoryElement(31), member)
        ]
    );
    let (kind, id) = (ElementKind::Way, 11);
    assert_eq!(
        changed(r#"type="relation" ref="31""#, r#"type="way" ref="11""#),
        [(Subject::Lanelet(21), Condition::NotRegulatoryElement { kind, id, untyped: false })]
    );
}

#[test]
fn ids() {
    let faults = changed(
        r#"<node id="1" lat"#,
        r#"<node id="2" lat="35" lon="139.3"><tag k="ele" v="1"/></node><node id="1" lat"#,
    );
    let [(Subject::Point(2), Condition::DuplicateId { kind: ElementKind::Node, spans, .. })] = faults.as_slice() else {
        unreachable!("{faults:?}")
    };
    assert_eq!(spans.len(), 2);
    let twice = conditions(&load(&[NODES, WAYS, LANELET, LANELET, LIGHT]));
    assert!(matches!(twice[0], (Subject::Lanelet(21), Condition::DuplicateId { .. })));
    let count = |role, way| Condition::BoundCount { role, count: 2, ways: vec![way, way], meant: None };
    assert_eq!(twice[1].1, count(BoundRole::Left, 11));
    assert_eq!(twice[2].1, count(BoundRole::Right, 12));
    let reused = conditions(&load(&[NODES, WAYS, r#"<way id="3"><nd ref="1"/><nd ref="2"/></way>"#]));
    assert_eq!(reused, [(Subject::LineString(3), Condition::IdReused { kinds: vec![ElementKind::Node] })]);
    let negative = conditions(&load(&[NODES, r#"<way id="-3"><nd ref="1"/><nd ref="2"/></way>"#]));
    assert_eq!(negative, [(Subject::LineString(-3), Condition::IdNotPositive)]);
    let large = changed(r#"<way id="13">"#, r#"<way id="2147483648">"#);
    assert_eq!(large, [(Subject::Polygon(2_147_483_648), Condition::PolygonIdTooLarge)]);
}

#[test]
fn of_a_line_and_a_polygon_with_one_id_the_last_loads() {
    let line = r#"<way id="14"><nd ref="1"/><nd ref="2"/></way>"#;
    let polygon = r#"<way id="14"><nd ref="1"/><nd ref="2"/><nd ref="3"/><tag k="area" v="yes"/></way>"#;
    let kept = |ways: [&str; 2]| {
        let map = load(&[NODES, ways[0], ways[1]]).map;
        (map.linestrings.contains(LineStringId(14)), map.polygons.contains(PolygonId(14)))
    };
    assert_eq!(kept([line, polygon]), (false, true));
    assert_eq!(kept([polygon, line]), (true, false));
}

#[test]
fn repeating_a_border_in_the_next_file_is_no_fault() {
    let mut osm = OsmData::default();
    for name in ["a", "b"] {
        read_bytes(&mut osm, name, format!("<osm>{NODES}</osm>").into_bytes()).unwrap();
    }
    let loaded = from_osm(&osm, &Projector::mgrs("54SUD".parse().unwrap()));
    assert_eq!(conditions(&loaded), []);
    assert_eq!(loaded.map.points.len(), 4);
}

#[test]
fn nodes() {
    let ele = r#"<tag k="ele" v="1"/>"#;
    let point = |condition| vec![(Subject::Point(1), condition)];
    let high = [NODES, WAYS, LANELET, LIGHT].concat().replace(ele, r#"<tag k="ele" v="30"/>"#);
    let one_without = high.replacen(r#"<tag k="ele" v="30"/>"#, "", 1);
    assert_eq!(conditions(&load(&[&one_without])), point(Condition::NoElevation));
    // Lanelet2's own writer leaves a height of 0 out.
    assert_eq!(changed(ele, ""), [(Subject::Map, Condition::ElevationLeftOut { nodes: 1 })]);
    // Of two heights the first counts, and it is a number.
    assert_eq!(changed(ele, r#"<tag k="ele" v="1"/><tag k="ele" v="high"/>"#), []);
    assert_eq!(changed(ele, r#"<tag k="ele" v="high"/>"#), point(Condition::BadElevation { found: text("high") }));
    assert!(
        changed(r#"lat="35.00000""#, r#"lat="""#)
            .contains(&(Subject::Point(1), Condition::BadCoordinate { said: None, meant: None }))
    );
    assert!(changed(r#"lat="35.00000""#, r#"lat="88""#).contains(&(Subject::Point(1), Condition::Unprojectable)));
    let other = changed(r#"lon="139.30000""#, r#"lon="138.5""#);
    assert!(matches!(other[0], (Subject::Point(1), Condition::OtherSquare { nodes: 1, .. })), "{other:?}");
}

/// The four nodes with local coordinates, each moved by what `moved` says for its number.
fn with_local(moved: impl Fn(usize) -> f64) -> String {
    let loaded = load(&[NODES]);
    let mut nodes = NODES.to_owned();
    for (at, point) in loaded.map.points.iter().enumerate() {
        let (x, y) = (point.position.x + moved(at), point.position.y);
        let local = format!(r#"<tag k="local_x" v="{x:.4}"/><tag k="local_y" v="{y:.4}"/>"#);
        nodes = nodes.replacen(&format!(r#"<node id="{}""#, at + 1), &format!(r#"<NODE id="{}""#, at + 1), 1);
        let tag = nodes.find("<NODE").map(|n| n + nodes[n..].find('>').unwrap() + 1).unwrap();
        nodes.insert_str(tag, &local);
        nodes = nodes.replace("<NODE", "<node");
    }
    nodes
}

#[test]
fn local_coordinates_agree_or_are_named() {
    assert_eq!(conditions(&load(&[&with_local(|_| 0.0)])), []);
    let one = conditions(&load(&[&with_local(|at| if at == 2 { 0.5 } else { 0.0 })]));
    let [(Subject::Point(3), Condition::LocalMismatch { distance })] = one.as_slice() else { unreachable!("{one:?}") };
    assert!((distance - 0.5).abs() < 1e-3);
    let all = conditions(&load(&[&with_local(|_| 7.0)]));
    let [(Subject::Map, Condition::LocalShifted { east, north })] = all.as_slice() else { unreachable!("{all:?}") };
    assert!((east - 7.0).abs() < 1e-3 && north.abs() < 1e-3);
    let partial = conditions(&load(&[&NODES.replacen("<tag", r#"<tag k="local_x" v="1"/><tag"#, 1)]));
    assert_eq!(partial[0], (Subject::Point(1), Condition::PartialLocal { x: true, y: false }));
    assert_eq!(partial[3], (Subject::Point(4), Condition::PartialLocal { x: false, y: false }));
}

#[test]
fn a_local_map_takes_its_coordinates_from_the_tags() {
    let nodes = with_local(|_| 0.0).replace("lat=", "no_lat=");
    let loaded = load_with(&nodes, &Projector::Local);
    assert_eq!(conditions(&loaded), []);
    let positions = |l: &Loaded| l.map.points.iter().map(|p| p.position).collect::<Vec<_>>();
    for (a, b) in positions(&loaded).iter().zip(positions(&load(&[NODES]))) {
        assert!((a - b).norm() < 1e-3);
    }
}

#[test]
fn format_versions() {
    let version = |v: &str| changed(r#"format_version="2""#, v).pop().map(|(_, c)| c);
    assert_eq!(version(r#"format_version="1.0.3""#), None);
    assert_eq!(version(""), Some(Condition::NoFormatVersion));
    let found = text("2-beta");
    assert_eq!(version(r#"format_version="2-beta""#), Some(Condition::BadFormatVersion { found }));
    let (found, supported) = (text("3"), 2);
    assert_eq!(version(r#"format_version="3""#), Some(Condition::UnsupportedFormatVersion { found, supported }));
}

#[test]
fn bounds_that_run_against_one_another() {
    // A left bound whose middle vertex hangs over to the right turns the right one around.
    let node = |id, lat, lon| format!(r#"<node id="{id}" lat="{lat}" lon="{lon}"><tag k="ele" v="1"/></node>"#);
    let curl = [node(5, 35.0, 139.300_005), node(6, 34.9998, 139.300_01), node(7, 35.0, 139.300_015)].concat();
    let whole = [NODES, &curl, WAYS, LANELET, LIGHT].concat();
    let bent = r#"<nd ref="1"/><nd ref="5"/><nd ref="6"/><nd ref="7"/><nd ref="2"/>"#;
    let whole = whole.replacen(r#"<nd ref="1"/><nd ref="2"/>"#, bent, 1);
    let faults = conditions(&load(&[&whole]));
    let opposed = Condition::BoundsOpposed { left: (11, false), right: (12, true) };
    assert_eq!(faults, [(Subject::Lanelet(21), opposed)]);
    let exchanged = changed(
        r#"ref="11" role="left"/><member type="way" ref="12" role="right""#,
        r#"ref="12" role="left"/><member type="way" ref="11" role="right""#,
    );
    assert_eq!(exchanged, [(Subject::Lanelet(21), Condition::BothBoundsTurned { left: 12, right: 11 })]);
}

mod random {
    //! Whatever the bytes, reading, loading and writing end without a panic.

    use proptest::prelude::*;

    use crate::lanelet::to_osm;
    use crate::projection::LonLat;

    use super::*;

    /// What is done to a sound file at a place (a fraction of its length).
    #[derive(Clone, Debug)]
    enum Damage {
        Cut(usize),
        Repeat(usize),
        Put(&'static str),
        Byte(u8),
    }

    fn damage() -> impl Strategy<Value = (f64, Damage)> {
        let words = [
            "-1",
            "0",
            "21",
            "31",
            "13",
            "nan",
            "1e308",
            "9223372036854775807",
            "99999999999999999999",
            "\"",
            "<",
            ">",
            "&",
            "&#0;",
            "/>",
            "<node ",
            "relation",
            "way",
            "node",
            "yes",
            "lanelet",
            "right_of_way",
            "refers",
            "regulatory_element",
            "道",
            "action=\"delete\"",
            "left",
            "local_x",
            "ele",
        ];
        let kind = prop_oneof![
            (1..200_usize).prop_map(Damage::Cut),
            (1..200_usize).prop_map(Damage::Repeat),
            prop::sample::select(words.to_vec()).prop_map(Damage::Put),
            any::<u8>().prop_map(Damage::Byte),
        ];
        (0.0..1.0, kind)
    }

    fn apply(bytes: &mut Vec<u8>, at: f64, damage: &Damage) {
        let at = (bytes.len() as f64 * at) as usize;
        let end = |length: usize| (at + length).min(bytes.len());
        match damage {
            Damage::Cut(length) => drop(bytes.drain(at..end(*length))),
            Damage::Repeat(length) => {
                let again = bytes[at..end(*length)].to_vec();
                drop(bytes.splice(at..at, again));
            }
            Damage::Put(word) => drop(bytes.splice(at..at, word.bytes())),
            Damage::Byte(byte) => bytes.get_mut(at).into_iter().for_each(|b| *b = *byte),
        }
    }

    fn whole_way(bytes: Vec<u8>) {
        let mut osm = OsmData::default();
        if read_bytes(&mut osm, "random", bytes).is_err() {
            return;
        }
        let origin = LonLat { lon: 139.0, lat: 35.0 };
        for projector in [
            Projector::mgrs("54SUD".parse().unwrap()),
            Projector::transverse_mercator(origin),
            Projector::LocalCartesian { origin },
            Projector::Local,
        ] {
            let map = from_osm(&osm, &projector).map;
            for lanelet in &map.lanelets {
                assert!(map.outline(lanelet).len() >= 4, "a reference does not resolve");
            }
            let mut text = Vec::new();
            to_osm(&map, &projector, &mut text).unwrap();
            read_bytes(&mut OsmData::default(), "written", text).unwrap();
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, ..ProptestConfig::default() })]

        #[test]
        fn bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            whole_way(bytes);
        }

        #[test]
        fn damaged_maps(damages in prop::collection::vec(damage(), 1..12)) {
            let mut bytes = ["<osm>", NODES, WAYS, LANELET, LIGHT, "</osm>"].concat().into_bytes();
            for (at, damage) in &damages {
                apply(&mut bytes, *at, damage);
            }
            whole_way(bytes);
        }
    }
}
