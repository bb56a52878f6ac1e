//! What the reader makes of sound, odd and broken files.

use super::*;
use crate::osm::pbf::MAX_REFERENCES;
use crate::osm::{ElementKind, OddityKind};
use crate::projection::LonLat;
use crate::text::SourceSpan;

fn read(text: &str) -> OsmData {
    let mut data = OsmData::default();
    read_bytes(&mut data, "test.osm", text.as_bytes().to_vec()).unwrap();
    data
}

fn fails(bytes: impl Into<Vec<u8>>) -> ReadError {
    read_bytes(&mut OsmData::default(), "test.osm", bytes.into()).unwrap_err()
}

/// Line, column and message of an error in XML.
fn place(error: &ReadError) -> (usize, usize, &str) {
    match error {
        ReadError::Broken { line, column, message, .. } => (*line, *column, message),
        other => unreachable!("{other}"),
    }
}

#[test]
fn elements_in_any_order_with_their_places() {
    let text = r#"<?xml version="1.0"?>
<osm version="0.6" generator="VMB">
  <relation id="3"><member type="way" ref="2" role="left"/><tag k="type" v="lanelet"/></relation>
  <way id="2"><nd ref="1"/><nd ref="-7"/><tag k="a" v="b"/></way>
  <validation name="kept by others"><node id="9"/></validation>
  <node lon="139.5" id="1" lat="35.5"/>
  <MetaInfo format_version="2" map_version="17"/>
</osm>"#;
    let data = read(text);
    assert_eq!((data.nodes.len(), data.ways.len(), data.relations.len()), (1, 1, 1));
    assert_eq!(data.node(1).unwrap().position, Some(LonLat { lon: 139.5, lat: 35.5 }));
    assert_eq!(data.way(2).unwrap().nodes, [1, -7]);
    assert_eq!(data.relation(3).unwrap().members[0].role, "left");
    assert_eq!(data.generator.as_deref(), Some("VMB"));
    let meta = data.meta.as_ref().unwrap();
    assert_eq!((meta.format_version.as_deref(), meta.map_version.as_deref()), (Some("2"), Some("17")));
    let shown = |span: &SourceSpan| &data.sources[0].text[span.start as usize..span.end as usize];
    assert_eq!(shown(&data.ways[0].span), r#"<way id="2"><nd ref="1"/><nd ref="-7"/><tag k="a" v="b"/></way>"#);
    assert_eq!(shown(&data.nodes[0].span), r#"<node lon="139.5" id="1" lat="35.5"/>"#);
    assert!(data.oddities.is_empty());
}

#[test]
fn deleted_elements_are_not_there() {
    let data = read(
        r#"<osm><node id="1" action="delete" lat="1" lon="1"><tag k="a" v="b"/></node>
        <node id="-2" action="modify" lat="1" lon="1"/><way id="3" action="delete"><nd ref="1"/></way></osm>"#,
    );
    assert!(!data.contains(ElementKind::Node, 1) && data.contains(ElementKind::Node, -2));
    assert!(data.ways.is_empty() && data.oddities.is_empty());
}

#[test]
fn entities_and_references_in_attributes() {
    let data = read(
        r#"<osm><way id="1"><tag k="a&amp;b" v="&lt;&#x9053;&#36335;&gt; &quot;x&quot; &apos;y&apos;"/><tag k="odd" v="&nope;"/></way></osm>"#,
    );
    assert_eq!(data.ways[0].tags.get("a&b"), Some("<道路> \"x\" 'y'"));
    assert_eq!(data.ways[0].tags.get("odd"), Some("&nope;"));
}

#[test]
fn a_byte_order_mark_does_not_move_the_places() {
    let data = read("\u{feff}<osm><node id=\"1\" lat=\"1\" lon=\"2\"/></osm>");
    let span = &data.nodes[0].span;
    assert_eq!(&data.sources[0].text[span.start as usize..span.end as usize], "<node id=\"1\" lat=\"1\" lon=\"2\"/>");
}

#[test]
fn gzip_whole_and_cut_off() {
    use std::io::Write;
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packer.write_all(br#"<osm><node id="1" lat="1" lon="2"/></osm>"#).unwrap();
    let packed = packer.finish().unwrap();
    let mut data = OsmData::default();
    read_bytes(&mut data, "test.osm.gz", packed.clone()).unwrap();
    assert_eq!(data.nodes.len(), 1);
    let error = fails(&packed[..packed.len() / 2]);
    assert!(matches!(error, ReadError::Packed { .. }) && error.help().contains("cut off"), "{error}");
}

#[test]
fn repeated_ids_are_kept_and_named() {
    let data = read(r#"<osm><node id="1" lat="1" lon="1"/><way id="1"/><node id="1" lat="2" lon="2"/></osm>"#);
    assert_eq!((data.nodes.len(), data.node(1).unwrap().position), (2, Some(LonLat { lon: 2.0, lat: 2.0 })));
    let [oddity] = data.oddities.as_slice() else { unreachable!("{:?}", data.oddities) };
    assert_eq!((oddity.kind, oddity.element), (OddityKind::DuplicateId, Some((ElementKind::Node, 1))));
}

#[test]
fn what_has_no_number_is_passed_over_and_named() {
    let data = read(
        r#"<osm><node id="x" lat="1" lon="1"/><node id="2" lat="" lon="1"/><node lat="1" lon="1"/>
        <way id="3"><nd ref="y"/><nd/></way><relation id="4"><member type="area" ref="1" role=""/></relation></osm>"#,
    );
    assert_eq!((data.nodes.len(), data.nodes[0].position), (1, None));
    assert!(data.ways[0].nodes.is_empty() && data.relations[0].members.is_empty());
    let count = |kind| data.oddities.iter().filter(|o| o.kind == kind).count();
    assert_eq!((count(OddityKind::BadElement), count(OddityKind::BadCoordinate)), (2, 1));
    assert_eq!(count(OddityKind::UnsaidElement), 3);
}

#[test]
fn not_xml() {
    assert!(matches!(fails(""), ReadError::Empty { .. }));
    assert!(matches!(fails(" \n\t"), ReadError::Empty { .. }));
    assert!(matches!(fails(vec![b'<', 0xff, 0xfe]), ReadError::NotText { offset: 1, .. }));
    assert_eq!(place(&fails("lat,lon\n1,2\n")).2, "this is not XML");
    assert_eq!(place(&fails("{\"type\": \"FeatureCollection\"}")), (1, 1, "this is not XML"));
    assert_eq!(place(&fails("<!-- nothing -->")).2, "there is no <osm> element");
    assert_eq!(place(&fails("<?xml version=\"1.0\"?>\n<gpx/>")), (2, 1, "the document is <gpx>, not <osm>"));
}

#[test]
fn cut_off_anywhere_is_an_error_with_a_place() {
    let text = r#"<osm>
  <node id="1" lat="1" lon="2"><tag k="name" v="道路"/></node>
  <way id="2"><nd ref="1"/></way>
</osm>"#;
    let bytes = text.as_bytes();
    for length in 1..bytes.len() {
        match fails(&bytes[..length]) {
            ReadError::Broken { offset, line, text, .. } => {
                assert!(offset <= length && text.is_char_boundary(offset) && (1..=4).contains(&line), "{length}");
                assert_eq!(text.len(), length);
            }
            ReadError::NotText { .. } => {}
            other => unreachable!("{length}: {other}"),
        }
    }
    assert_eq!(place(&fails(text.replace("</way>", "</relation>"))).0, 3);
}

#[test]
fn a_place_that_is_not_on_earth() {
    let data = read("<osm>\n <node id=\"5\" lat=\"200\" lon=\"8\"/></osm>");
    assert_eq!((data.nodes[0].position, data.oddities[0].off_earth), (None, Some([200.0, 8.0])));
    // Maps are judged all the same; nothing is built from such a place.
    let error = refuse_off_earth(&data).unwrap_err();
    let (line, column, message) = place(&error);
    assert_eq!((line, column), (2, 2));
    assert!(message.contains("latitude 200") && error.help().contains("swapped"), "{message}");
    for bad in ["nan", "inf", "-1e300"] {
        let data = read(&format!("<osm><node id=\"5\" lat=\"{bad}\" lon=\"8\"/></osm>"));
        place(&refuse_off_earth(&data).unwrap_err());
    }
}

#[test]
fn an_endless_way_is_refused_where_it_passes_the_limit() {
    let text = ["<osm><way id=\"6\">", &"<nd ref=\"1\"/>".repeat(MAX_REFERENCES + 5), "</way></osm>"].concat();
    let error = fails(text);
    assert_eq!(place(&error).2, "way 6 has more than 1000000 nodes");
    let text = ["<osm><relation id=\"7\">", &"<member type=\"node\" ref=\"1\"/>".repeat(MAX_REFERENCES + 5)].concat();
    assert_eq!(place(&fails(text)).2, "relation 7 has more than 1000000 members");
}

#[test]
fn entities_of_the_document_are_not_expanded() {
    let text = r#"<!DOCTYPE osm [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><osm><way id="1"><tag k="k" v="&b;"/></way></osm>"#;
    assert_eq!(read(text).ways[0].tags.get("k"), Some("&b;"));
}

#[test]
fn the_bounds_of_several_files_add_up() {
    let bounds = |text: &str| read(&format!("<osm>{text}</osm>")).bounds;
    let [min, max] = [LonLat { lon: 9.0, lat: 48.0 }, LonLat { lon: 9.5, lat: 48.25 }];
    let own = "<bounds minlat=\"48\" minlon=\"9\" maxlat=\"48.25\" maxlon=\"9.5\"/>";
    assert_eq!(bounds(own), [Extent { min, max }]);
    assert_eq!(bounds(&format!("{own}{own}")).len(), 2, "an editor notes each area that it has loaded");
    assert_eq!(bounds(""), [Extent::EARTH], "a file that names none may hold any place");
    assert_eq!(bounds("<bounds minlat=\"x\" minlon=\"9\" maxlat=\"48\" maxlon=\"9\"/>"), [Extent::EARTH]);
    let mut data = read(&format!("<osm>{own}</osm>"));
    let beside = |data: &OsmData| data.reaches_beyond(LonLat { lon: 10.0, lat: 48.1 });
    assert!(!beside(&data) && data.reaches_beyond(LonLat { lon: 9.1, lat: 48.1 }));
    read_bytes(&mut data, "more.osm", b"<osm/>".to_vec()).unwrap();
    assert!(beside(&data));
}
