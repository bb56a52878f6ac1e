//! A PBF extract gives the same data as the XML file of the same extract.

use std::fs;

use lanewright::osm::read_file;

use crate::common::needs::shared;
use crate::common::program::lanewright;
use crate::common::soak;

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
