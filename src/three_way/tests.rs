//! Merges of small maps.

mod random;

use super::{Deletions, Merged, Side, Versions, merge};
use crate::diagnostic::Subject;
use crate::osm::{OsmData, read_bytes};

const MAP: &str = r#"<?xml version="1.0"?>
<osm version="0.6">
  <MetaInfo format_version="1" map_version="3"/>
  <node id="1" lat="48.1000000" lon="11.5000000"><tag k="ele" v="1"/></node>
  <node id="2" lat="48.1000000" lon="11.5001000"/>
  <node id="3" lat="48.1000000" lon="11.5002000"/>
  <node id="4" lat="48.1001000" lon="11.5000000"/>
  <node id="5" lat="48.1001000" lon="11.5002000"/>
  <node id="6" lat="48.1002000" lon="11.5000000"/>
  <node id="7" lat="48.1002000" lon="11.5002000"/>
  <way id="11">
    <nd ref="1"/>
    <nd ref="2"/>
    <nd ref="3"/>
    <tag k="type" v="line_thin"/>
  </way>
  <way id="12"><nd ref="4"/><nd ref="5"/></way>
  <way id="13"><nd ref="6"/><nd ref="7"/></way>
  <!-- a word -->
  <relation id="21">
    <member type="way" ref="11" role="left"/>
    <member type="way" ref="12" role="right"/>
    <tag k="type" v="lanelet"/>
    <tag k="speed_limit" v="30"/>
  </relation>
  <relation id="22">
    <member type="way" ref="12" role="left"/>
    <member type="way" ref="13" role="right"/>
    <tag k="type" v="lanelet"/>
  </relation>
  <relation id="31">
    <member type="relation" ref="21" role="right_of_way"/>
    <member type="relation" ref="22" role="yield"/>
    <tag k="type" v="regulatory_element"/>
    <tag k="subtype" v="right_of_way"/>
  </relation>
</osm>
"#;

fn read(text: &str) -> OsmData {
    let mut osm = OsmData::default();
    read_bytes(&mut osm, "map.osm", text.as_bytes().to_vec()).unwrap_or_else(|error| panic!("{error}\n{text}"));
    osm
}

fn merged(base: &str, ours: &str, theirs: &str) -> Merged {
    let [base, ours, theirs] = [base, ours, theirs].map(read);
    merge(Versions { base: &base, ours: &ours, theirs: &theirs }, Deletions::Kept)
}

/// The map with some text in place of other text, all of which is there.
fn with(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(MAP.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    })
}

/// What is merged without a conflict.
#[track_caller]
fn clean(ours: &str, theirs: &str) -> String {
    let merged = merged(MAP, ours, theirs);
    assert_eq!(merged.conflicts, [], "{}", merged.text);
    merged.text
}

const NEW_NODE: (&str, &str) =
    ("  <node id=\"3\"", "  <node id=\"8\" lat=\"48.1\" lon=\"11.50015\"/>\n  <node id=\"3\"");

#[test]
fn each_side_s_changes_are_there_and_no_other_letter_changes() {
    let moved = ("<node id=\"2\" lat=\"48.1000000\"", "<node id=\"2\" lat=\"48.1000050\"");
    let inserted = ("    <nd ref=\"3\"/>\n", "    <nd ref=\"8\"/>\n    <nd ref=\"3\"/>\n");
    let faster = ("v=\"30\"", "v=\"50\"");
    let tagged = ("<way id=\"13\"><nd", "<way id=\"13\"><tag k=\"type\" v=\"road_border\"/><nd");
    // One moves a vertex of a line, the other inserts one.
    let text = clean(&with(&[moved, tagged]), &with(&[inserted, faster, NEW_NODE]));
    // Nodes are in the order of ids, so that the new one comes behind the others.
    let new = ("  <way id=\"11\"", "  <node id=\"8\" lat=\"48.1\" lon=\"11.50015\"/>\n  <way id=\"11\"");
    assert_eq!(text, with(&[moved, tagged, inserted, faster, new]));
    // Both change one line, each something else.
    let solid = ("    <tag k=\"type\" v=\"line_thin\"/>", "    <tag k=\"type\" v=\"line_thick\"/>");
    let text = clean(&with(&[solid]), &with(&[inserted, NEW_NODE]));
    assert!(text.contains(
        "    <nd ref=\"2\"/>\n    <nd ref=\"8\"/>\n    <nd ref=\"3\"/>\n    <tag k=\"type\" v=\"line_thick\"/>"
    ));
}

#[test]
fn what_both_insert_between_two_vertices_lies_in_the_order_of_the_line() {
    let at = |id: i64, lon: &str| {
        let node = format!("  <node id=\"{id}\" lat=\"48.1\" lon=\"{lon}\"/>\n  <node id=\"3\"");
        with(&[
            ("  <node id=\"3\"", &node),
            ("    <nd ref=\"3\"/>\n", &format!("    <nd ref=\"{id}\"/>\n    <nd ref=\"3\"/>\n")),
        ])
    };
    for (ours, theirs) in [(at(8, "11.50013"), at(9, "11.50017")), (at(9, "11.50017"), at(8, "11.50013"))] {
        let nodes = read(&clean(&ours, &theirs)).way(11).map(|way| way.nodes.clone());
        assert_eq!(nodes, Some(vec![1, 2, 8, 9, 3]));
    }
    let beyond = merged(MAP, &at(8, "11.50013"), &at(9, "11.50030"));
    assert_eq!(beyond.conflicts[0].about, "nodes");
    assert_eq!(beyond.conflicts[0].theirs.as_deref(), Some("1 2 9 3"));
}

#[test]
fn members_are_merged_by_their_roles() {
    let elements = |rows: &str| {
        let old = "    <member type=\"relation\" ref=\"21\" role=\"right_of_way\"/>\n    <member type=\"relation\" ref=\"22\" role=\"yield\"/>\n";
        with(&[(
            old,
            &rows
                .split(' ')
                .map(|row| {
                    let (id, role) = row.split_once(':').unwrap();
                    format!("    <member type=\"relation\" ref=\"{id}\" role=\"{role}\"/>\n")
                })
                .collect::<String>(),
        )])
    };
    let roles = |text: &str| {
        let osm = read(text);
        let members = osm.relation(31).unwrap().members.iter().map(|one| format!("{}:{}", one.id, one.role));
        members.collect::<Vec<_>>().join(" ")
    };
    // One takes a yield away, the other adds one.
    let text = clean(&elements("21:right_of_way"), &elements("21:right_of_way 22:yield 21:yield"));
    assert_eq!(roles(&text), "21:right_of_way 21:yield");
    let both = merged(MAP, &elements("21:right_of_way 22:right_of_way"), &elements("21:right_of_way"));
    assert_eq!(both.conflicts[0].about, "role of relation 22");
    assert_eq!((both.conflicts[0].ours.as_deref(), both.conflicts[0].theirs.as_deref()), (Some("right_of_way"), None));
    assert_eq!(roles(&both.text), "21:right_of_way 22:right_of_way");
    // A lanelet has one left bound.
    let bound = |id: &str| with(&[("ref=\"11\" role=\"left\"", &format!("ref=\"{id}\" role=\"left\""))]);
    let both = merged(MAP, &bound("13"), &bound("12"));
    assert!(both.conflicts.iter().any(|one| one.about == "left"), "{:?}", both.conflicts);
    let lefts = read(&both.text).relation(21).unwrap().members.iter().filter(|one| one.role == "left").count();
    assert_eq!(lefts, 1);
}

#[test]
fn what_both_change_to_something_else_is_told_with_both_values() {
    let of = |speed: &str, lat: &str| {
        with(&[
            ("v=\"30\"", &format!("v=\"{speed}\"")),
            ("<node id=\"5\" lat=\"48.1001000\"", &format!("<node id=\"5\" lat=\"{lat}\"")),
        ])
    };
    let merged = merged(MAP, &of("50", "48.1001500"), &of("20", "48.1001700"));
    assert_eq!(merged.text, of("50", "48.1001500"), "the result is what ours says");
    let [place, speed] = &merged.conflicts[..] else { panic!("{:?}", merged.conflicts) };
    assert_eq!((place.subject, place.about.as_str()), (Subject::Point(5), "position"));
    assert_eq!(place.at.map(|at| at.lat), Some(48.10015));
    let said = [&speed.base, &speed.ours, &speed.theirs].map(|one| one.as_deref().unwrap_or_default());
    assert_eq!(
        (speed.subject, speed.about.as_str(), said),
        (Subject::Lanelet(21), "tag speed_limit", ["30", "50", "20"])
    );
    assert!(speed.text().contains("conflict: lanelet 21: tag speed_limit (at 48.1"), "{}", speed.text());
    assert!(speed.text().contains("ours    50  <- in the result\n  theirs  20\n"), "{}", speed.text());
}

/// The map without lanelet 22 and what only it needs.
fn without_lanelet() -> String {
    let text = with(&[
        ("    <member type=\"relation\" ref=\"22\" role=\"yield\"/>\n", ""),
        ("  <way id=\"13\"><nd ref=\"6\"/><nd ref=\"7\"/></way>\n", ""),
        ("  <node id=\"6\" lat=\"48.1002000\" lon=\"11.5000000\"/>\n", ""),
        ("  <node id=\"7\" lat=\"48.1002000\" lon=\"11.5002000\"/>\n", ""),
    ]);
    let (before, rest) = text.split_once("  <relation id=\"22\">").unwrap();
    format!("{before}{}", rest.split_once("</relation>\n").unwrap().1)
}

#[test]
fn what_one_deletes_and_the_other_changes_or_uses_is_kept_whole() {
    let moved = with(&[("<node id=\"7\" lat=\"48.1002000\"", "<node id=\"7\" lat=\"48.1002100\"")]);
    for (ours, theirs, taken) in
        [(moved.clone(), without_lanelet(), Side::Ours), (without_lanelet(), moved, Side::Theirs)]
    {
        let merged = merged(MAP, &ours, &theirs);
        let [conflict] = &merged.conflicts[..] else { panic!("{:?}", merged.conflicts) };
        assert_eq!(
            (conflict.subject, conflict.about.as_str(), conflict.taken),
            (Subject::Lanelet(22), "deletion", taken)
        );
        let osm = read(&merged.text);
        assert!(osm.relation(22).is_some() && osm.way(13).is_some() && osm.node(6).is_some(), "{}", merged.text);
        assert!(merged.text.contains("48.1002100"));
    }
    let used = with(&[(
        "    <tag k=\"type\" v=\"regulatory_element\"/>",
        "    <member type=\"way\" ref=\"13\" role=\"ref_line\"/>\n    <tag k=\"type\" v=\"regulatory_element\"/>",
    )]);
    for (ours, theirs) in [(used.clone(), without_lanelet()), (without_lanelet(), used)] {
        let merged = merged(MAP, &ours, &theirs);
        let [conflict] = &merged.conflicts[..] else { panic!("{:?}", merged.conflicts) };
        assert_eq!(conflict.subject, Subject::LineString(13));
        let said = [&conflict.ours, &conflict.theirs].into_iter().flatten().next().map(String::as_str);
        assert_eq!(said, Some("used by regulatory element 31"));
        let osm = read(&merged.text);
        assert!(osm.relation(22).is_none() && osm.way(13).is_some() && osm.node(6).is_some(), "{}", merged.text);
    }
    // What both delete is gone.
    assert!(read(&clean(&without_lanelet(), &without_lanelet())).relation(22).is_none());
    assert_eq!(clean(MAP, &without_lanelet()), without_lanelet());
}

#[test]
fn a_rule_of_which_both_take_the_members_is_gone() {
    let yielding = "    <member type=\"relation\" ref=\"22\" role=\"yield\"/>\n";
    let first = "    <member type=\"relation\" ref=\"21\" role=\"right_of_way\"/>\n";
    let text = clean(&with(&[(yielding, "")]), &with(&[(first, "")]));
    assert!(read(&text).relation(31).is_none(), "{text}");
    // A lanelet that names it names it no more.
    let names = "    <member type=\"way\" ref=\"11\" role=\"left\"/>\n";
    let named = |text: String| {
        text.replacen(
            names,
            &format!("{names}    <member type=\"relation\" ref=\"31\" role=\"regulatory_element\"/>\n"),
            1,
        )
    };
    let merged = merged(&named(MAP.to_owned()), &named(with(&[(yielding, "")])), &named(with(&[(first, "")])));
    let osm = read(&merged.text);
    assert!(osm.relation(31).is_none() && osm.relation(21).unwrap().members.len() == 2, "{}", merged.text);
    assert_eq!(merged.conflicts, []);
}

#[test]
fn elements_that_both_made_under_one_id_are_told_apart() {
    let made = |lon: &str, role: &str| {
        let node = format!("  <node id=\"9\" lat=\"48.1\" lon=\"{lon}\"/>\n  <way id=\"11\"");
        let way = "  <way id=\"14\"><nd ref=\"9\"/><nd ref=\"1\"/><tag k=\"area\" v=\"yes\"/></way>\n  <!-- a word -->";
        let names = format!("<tag k=\"speed_limit\" v=\"30\"/>\n    <tag k=\"{role}\" v=\"14\"/>");
        with(&[("  <way id=\"11\"", &node), ("  <!-- a word -->", way), ("<tag k=\"speed_limit\" v=\"30\"/>", &names)])
    };
    let merged = merged(MAP, &made("11.51", "intersection_area"), &made("11.52", "waypoints"));
    assert_eq!(merged.conflicts, []);
    assert_eq!(merged.renumbered, [(Subject::Point(9), 10), (Subject::Polygon(14), 15)]);
    let osm = read(&merged.text);
    assert_eq!((osm.way(14).unwrap().nodes.clone(), osm.way(15).unwrap().nodes.clone()), (vec![9, 1], vec![10, 1]));
    let tags = &osm.relation(21).unwrap().tags;
    assert_eq!((tags.get("intersection_area"), tags.get("waypoints")), (Some("14"), Some("15")));
    // The same drawn twice, as where a change is on both branches, is one.
    let twice = super::tests::merged(MAP, &made("11.51", "waypoints"), &made("11.510000001", "waypoints"));
    assert_eq!((twice.renumbered.len(), twice.text), (0, made("11.51", "waypoints")));
}

#[test]
fn of_two_version_numbers_the_higher_counts() {
    let version = |number: &str| with(&[("map_version=\"3\"", &format!("map_version=\"{number}\""))]);
    assert_eq!(clean(&version("4"), &version("5")), version("5"));
    assert_eq!(clean(&version("5"), &version("4")), version("5"));
    assert_eq!(clean(MAP, &version("4")), version("4"));
}

#[test]
fn what_only_one_has_formatted_is_formatted() {
    let formatted = crate::fix::canonical(MAP).unwrap();
    let changed = with(&[("v=\"30\"", "v=\"50\"")]);
    let text = clean(&changed, &formatted);
    assert!(text.contains("  <way id=\"12\" version=\"1\">\n    <nd ref=\"4\"/>"), "{text}");
    assert!(text.contains("v=\"50\""));
}
