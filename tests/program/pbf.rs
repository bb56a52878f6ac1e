//! A PBF extract gives the same data as the XML file of the same extract.

use std::fs;

use lanewright::osm::read_file;

use crate::common::needs::shared;
use crate::common::program::lanewright;
use crate::common::soak;
use crate::pbf_fields::{field, number};

/// One extract in two formats.
const XML: &str = "corpus/osm/harrisburg.osm";
const PBF: &str = "corpus/osm/harrisburg.osm.pbf";

#[test]
fn pbf_and_xml_agree_to_the_last_bit() {
    let (Some(xml), Some(pbf)) = (shared(XML), shared(PBF)) else { return };
    let [xml, pbf] = [xml, pbf].map(|path| read_file(&path).unwrap());
    assert_eq!((xml.nodes.len(), xml.ways.len()), (pbf.nodes.len(), pbf.ways.len()));
    assert_eq!(xml.relations.len(), pbf.relations.len());
    println!("bounds of XML {:?}, of PBF {:?}", xml.bounds, pbf.bounds);
    for node in &xml.nodes {
        let other = pbf.node(node.id).unwrap();
        assert_eq!((node.position, &node.tags), (other.position, &other.tags), "node {}", node.id);
    }
    for way in &xml.ways {
        let other = pbf.way(way.id).unwrap();
        assert_eq!((&way.nodes, &way.tags), (&other.nodes, &other.tags), "way {}", way.id);
    }
    for relation in &xml.relations {
        let other = pbf.relation(relation.id).unwrap();
        assert_eq!((&relation.members, &relation.tags), (&other.members, &other.tags), "relation {}", relation.id);
    }
}

#[test]
fn pbf_and_xml_become_the_same_streets_and_the_same_map() {
    let (Some(xml), Some(pbf)) = (shared(XML), shared(PBF)) else { return };
    let [xml, pbf] = [&xml, &pbf].map(|path| path.to_str().unwrap());
    let dir = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| lanewright(dir.path(), arguments).exits(0);
    let same = |a: &str, b: &str| {
        let [a, b] = [a, b].map(|name| fs::read(dir.path().join(name)).unwrap());
        assert!(a.len() > 1_000_000 && a == b, "they differ");
    };
    run(&["geometry", xml, "-o", "xml.geojson"]);
    run(&["geometry", pbf, "-o", "pbf.geojson"]);
    same("xml.geojson", "pbf.geojson");
    if soak() {
        run(&["build", xml, "-o", "xml"]);
        run(&["build", pbf, "-o", "pbf"]);
        same("xml/lanelet2_map.osm", "pbf/lanelet2_map.osm");
    }
}

/// A file with nothing but a header that demands these features: <https://wiki.openstreetmap.org/wiki/PBF_Format>.
fn header_that_demands(features: &[&str]) -> Vec<u8> {
    let block: Vec<u8> = features.iter().flat_map(|feature| field(4, feature.as_bytes())).collect();
    let blob = field(1, &block);
    let head = [field(1, b"OSMHeader"), number(3, blob.len() as u64)].concat();
    [&(head.len() as u32).to_be_bytes()[..], &head, &blob].concat()
}

#[test]
fn a_file_that_demands_what_the_reader_has_not_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let build = |features: &[&str]| {
        fs::write(dir.path().join("a.osm.pbf"), header_that_demands(features)).unwrap();
        lanewright(dir.path(), &["build", "--isolated", "a.osm.pbf", "-o", "map"]).exits(2).stderr
    };
    let history = build(&["OsmSchema-V0.6", "HistoricalInformation"]);
    assert!(history.contains("a.osm.pbf needs a reader that knows `HistoricalInformation`"), "{history}");
    assert!(history.contains("time-filter"), "{history}");
    let other = build(&["DenseNodes", "Curves"]);
    assert!(other.contains("`Curves`") && other.contains("without that feature"), "{other}");
    let known = build(&["OsmSchema-V0.6", "DenseNodes"]);
    assert!(!known.contains("needs a reader"), "{known}");
}
