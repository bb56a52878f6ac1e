//! A PBF extract reads the same as the XML of the same extract.

use std::path::PathBuf;

use lanewright::osm::read_file;

fn shared() -> Option<PathBuf> {
    let path = std::env::var_os("LANEWRIGHT_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    path.is_dir().then_some(path)
}

#[test]
fn pbf_and_xml_agree_to_the_last_bit() {
    let Some(shared) = shared() else {
        println!("skipped: ../shared is not here");
        return;
    };
    let xml = read_file(&shared.join("corpus/osm/harrisburg.osm")).unwrap();
    let pbf = read_file(&shared.join("corpus/osm/harrisburg.osm.pbf")).unwrap();
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
