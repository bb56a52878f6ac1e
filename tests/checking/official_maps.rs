//! Loads the official and other public maps of the shared corpus.
use lanewright::geometry::Point;
use lanewright::lanelet::{Attributes, Condition, Loaded, PointId, RegulatoryElement, from_osm, to_osm};
use lanewright::osm::{Node, OsmData};
use lanewright::projection::Projector;

use crate::common::drawing::osm;
use crate::common::hand_made_maps;
use crate::common::judging;
use crate::common::needs::shared;

fn load(name: &str) -> Option<(OsmData, Loaded)> {
    Some(judging::load(&shared("corpus/lanelet2")?.join(name)))
}

/// The largest distance between `local_x`, `local_y` and the projected latitude and longitude, metres.
fn worst(osm: &OsmData, loaded: &Loaded) -> f64 {
    let distance = |node: &Node| {
        let [x, y] = ["local_x", "local_y"].map(|key| node.tags.get(key).and_then(|text| text.parse::<f64>().ok()));
        let position = loaded.map.points.get(PointId(node.id)).map(|p| p.position);
        let apart = |p: Point| Some((p - Point::new(x?, y?)).norm());
        position.and_then(apart).unwrap_or(f64::INFINITY)
    };
    osm.nodes.iter().map(distance).fold(0.0, f64::max)
}

#[test]
fn local_coordinates_are_utm_modulo_100_km_to_a_millimetre() {
    for name in ["autoware_vm_03_left_hand.osm", "autoware_vm_03_right_hand.osm", "autoware_intersection.osm"] {
        let Some((osm, loaded)) = load(name) else { return };
        assert_eq!(loaded.map.points.len(), osm.nodes.len());
        let worst = worst(&osm, &loaded);
        assert!(worst < 1e-3, "{name}: {worst} m");
    }
}

#[test]
fn official_maps_load_but_for_one_road_marking_without_line() {
    for (name, broken) in
        [("autoware_vm_03_left_hand.osm", 0), ("autoware_vm_03_right_hand.osm", 1), ("autoware_intersection.osm", 0)]
    {
        let Some((osm, loaded)) = load(name) else { return };
        let of_type = |t: &str| osm.relations.iter().filter(|r| r.tags.is("type", t)).count();
        assert_eq!(loaded.map.lanelets.len(), of_type("lanelet"), "{name}");
        assert_eq!(loaded.map.regulatory_elements.len() + broken, of_type("regulatory_element"), "{name}");
        let found: Vec<_> =
            loaded.faults.iter().filter(|f| !matches!(f.condition, Condition::BothBoundsTurned { .. })).collect();
        // One for the element, one for the lanelet that refers to it.
        assert_eq!(found.len(), 2 * broken, "{name}: {found:?}");
        let without_line = |c: &Condition| match c {
            Condition::MemberCount { subtype, limit, count: 0 } => subtype == "road_marking" && limit.role == "refers",
            Condition::WithoutMembers { subtype } => subtype == "road_marking",
            _ => false,
        };
        assert_eq!(found.iter().filter(|f| without_line(&f.condition)).count(), broken, "{name}: {found:?}");
    }
}

#[test]
fn every_map_loads() {
    for path in hand_made_maps() {
        let name = path.display();
        let (osm, loaded) = judging::load(&path);
        let mut kinds = std::collections::BTreeMap::<String, usize>::new();
        for fault in &loaded.faults {
            let words = format!("{:?}", fault.condition);
            *kinds.entry(words.split([' ', '{']).next().unwrap_or_default().to_owned()).or_default() += 1;
        }
        println!("{name}: {} nodes, {} lanelets, {kinds:?}", osm.nodes.len(), loaded.map.lanelets.len());
        assert!(!loaded.map.lanelets.is_empty() && loaded.map.points.len() == osm.nodes.len(), "{name}");
    }
}

/// Tags by key: they are written in canonical order.
fn said(tags: &Attributes) -> std::collections::BTreeMap<&str, &str> {
    tags.iter().collect()
}

#[test]
fn official_maps_are_the_same_after_writing_and_reading() {
    for name in ["autoware_vm_03_left_hand.osm", "autoware_intersection.osm", "mapping_example.osm"] {
        let Some((_, first)) = load(name) else { return };
        let projector = Projector::mgrs("54SUE".parse().unwrap());
        let mut bytes = Vec::new();
        to_osm(&first.map, &projector, &mut bytes).unwrap();
        let second = from_osm(&osm(bytes), &projector);
        for point in &first.map.points {
            let again = second.map.points.get(point.id).unwrap();
            assert!(
                (again.position - point.position).norm() < 1e-5 && again.ele() == point.ele(),
                "{name} {}",
                point.id
            );
            assert_eq!(said(again.attributes()), said(point.attributes()));
        }
        for line in &first.map.linestrings {
            let again = second.map.linestrings.get(line.id).unwrap();
            assert_eq!((&again.points, said(&again.attributes)), (&line.points, said(&line.attributes)));
        }
        for polygon in &first.map.polygons {
            let again = second.map.polygons.get(polygon.id).unwrap();
            assert_eq!((&again.points, said(&again.attributes)), (&polygon.points, said(&polygon.attributes)));
        }
        for lanelet in &first.map.lanelets {
            let again = second.map.lanelets.get(lanelet.id).unwrap();
            assert_eq!((again.left, again.right, again.centerline), (lanelet.left, lanelet.right, lanelet.centerline));
            assert_eq!(again.regulatory_elements, lanelet.regulatory_elements);
            assert_eq!(said(&again.attributes), said(&lanelet.attributes));
        }
        for element in &first.map.regulatory_elements {
            let again = second.map.regulatory_elements.get(element.id).unwrap();
            let members = |e: &RegulatoryElement| format!("{:?}", e.members);
            assert_eq!((members(again), said(&again.attributes)), (members(element), said(&element.attributes)));
        }
        assert_eq!(first.map.lanelets.len(), second.map.lanelets.len());
        assert_eq!(first.map.regulatory_elements.len(), second.map.regulatory_elements.len());
    }
}
