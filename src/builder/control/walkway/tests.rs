//! Walkways across driveways, on small networks.

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tests::{Asked, built_as, driven_on, of_subtype};
use crate::geometry::polygon;
use crate::lanelet::{Lanelet, LaneletMap};

/// A street with a driveway on its north side.
fn street(side: DrivingSide, street: &str, driveway: &str, at: &str) -> LaneletMap {
    let nodes = [(1, 0.0, 0.0, ""), (2, -80.0, 0.0, ""), (3, 80.0, 0.0, ""), (4, 0.0, 40.0, ""), (5, 0.0, 9.0, at)];
    let street = format!("highway=residential lanes=2 {street}");
    let driveway = format!("highway=service {driveway}");
    built_as(&Asked {
        nodes: &nodes,
        ways: &[(10, &[2, 1, 3], &street), (11, &[1, 5, 4], &driveway)],
        options: driven_on(side),
    })
    .map
}

#[test]
fn a_driveway_crosses_the_sidewalk_of_its_street() {
    for side in [DrivingSide::Right, DrivingSide::Left] {
        let map = street(side, "sidewalk=both", "service=driveway", "");
        let walkways = of_subtype(&map, "walkway");
        assert_eq!(walkways.len(), 1);
        let outline = map.outline(walkways[0]);
        let across: Vec<&Lanelet> = of_subtype(&map, "road")
            .into_iter()
            .filter(|lane| polygon::common_area(&map.outline(lane), &outline) > 0.01)
            .collect();
        assert_eq!(across.len(), 4, "two ways in and two ways out");
        let element = map.regulatory_elements.iter().find(|element| element.subtype == "crosswalk").unwrap();
        assert!(element.lanelets("refers").eq([walkways[0].id]));
        assert!(across.iter().all(|lane| lane.regulatory_elements.contains(&element.id)));
        // The lanes out of private ground are private up to the street.
        let private = across.iter().filter(|lane| lane.attributes.is("location", "private")).count();
        assert_eq!(private, 2);
    }
}

#[test]
fn there_is_no_walkway_without_a_sidewalk_or_private_ground_or_on_a_crosswalk() {
    let right = DrivingSide::Right;
    assert_eq!(of_subtype(&street(right, "sidewalk=right", "service=driveway", ""), "walkway").len(), 0);
    assert_eq!(of_subtype(&street(right, "sidewalk=left", "service=driveway", ""), "walkway").len(), 1);
    assert_eq!(of_subtype(&street(right, "sidewalk=both", "access=yes", ""), "walkway").len(), 0);
    assert_eq!(of_subtype(&street(right, "sidewalk=both", "access=private", ""), "walkway").len(), 1);
    let crossed = street(right, "sidewalk=both", "service=driveway", "highway=crossing");
    assert_eq!((of_subtype(&crossed, "walkway").len(), of_subtype(&crossed, "crosswalk").len()), (0, 1));
}

#[test]
fn a_sidewalk_mapped_as_a_way_of_its_own_crosses_a_driveway() {
    for (side, driveway, depth, walkways) in [
        (DrivingSide::Right, "service=driveway", 9.0, 1),
        (DrivingSide::Left, "service=driveway", 9.0, 1),
        (DrivingSide::Right, "service=driveway", 18.0, 1),
        (DrivingSide::Right, "access=yes", 9.0, 0),
    ] {
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -80.0, 0.0, ""),
            (3, 80.0, 0.0, ""),
            (4, 0.0, 60.0, ""),
            (5, 0.0, depth, ""),
            (6, -50.0, depth, ""),
            (7, 50.0, depth, ""),
        ];
        let driveway = format!("highway=service {driveway}");
        let ways: [(i64, &[i64], &str); 3] = [
            (10, &[2, 1, 3], "highway=residential lanes=2 sidewalk=separate"),
            (11, &[1, 5, 4], &driveway),
            (12, &[6, 5, 7], "highway=footway footway=sidewalk"),
        ];
        let map = built_as(&Asked { nodes: &nodes, ways: &ways, options: driven_on(side) }).map;
        let found = of_subtype(&map, "walkway");
        assert_eq!(found.len(), walkways, "{driveway}");
        let Some(walkway) = found.first() else { continue };
        let outline = map.outline(walkway);
        let element = map.regulatory_elements.iter().find(|element| element.subtype == "crosswalk").unwrap();
        assert!(element.lanelets("refers").eq([walkway.id]));
        let mut across = 0;
        for lane in of_subtype(&map, "road") {
            let crosses = polygon::common_area(&map.outline(lane), &outline) > 0.01;
            assert_eq!(lane.regulatory_elements.contains(&element.id), crosses, "{}", lane.id);
            across += usize::from(crosses);
        }
        assert!(across >= 2);
        // Lanes out end before the walkway unless the street is far away.
        let own = of_subtype(&map, "road").into_iter().filter(|lane| !lane.attributes.has("intersection_area"));
        let before = own.filter(|lane| polygon::common_area(&map.outline(lane), &outline) > 0.01).count() == 0;
        assert_eq!(before, depth < 10.0);
        let street = of_subtype(&map, "road")
            .into_iter()
            .filter(|lane| lane.attributes.is("location", "urban") && !lane.attributes.has("intersection_area"));
        let corners: Vec<f64> = street.flat_map(|lane| map.outline(lane)).map(|corner| corner.y).collect();
        let axis = corners.iter().sum::<f64>() / corners.len() as f64;
        let middle = outline.iter().map(|corner| corner.y).sum::<f64>() / outline.len() as f64;
        assert!((middle - axis - depth).abs() < 0.2, "{} m from the middle of the street", middle - axis);
    }
}

#[test]
fn a_walkway_on_a_short_road_keeps_clear_of_the_intersection_behind_it() {
    let mut found = 0;
    for length in [19.0, 20.0, 21.0, 22.0, 23.0, 24.0] {
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -80.0, 0.0, ""),
            (3, 80.0, 0.0, ""),
            (4, 0.0, length, ""),
            (5, 0.0, length / 2.0 + 0.5, ""),
            (6, -50.0, length / 2.0 + 0.5, ""),
            (7, 50.0, length / 2.0 + 0.5, ""),
            (8, -80.0, length, ""),
            (9, 80.0, length, ""),
        ];
        let ways: [(i64, &[i64], &str); 4] = [
            (10, &[2, 1, 3], "highway=primary lanes=6"),
            (11, &[1, 5, 4], "highway=service service=driveway"),
            (12, &[6, 5, 7], "highway=footway footway=sidewalk"),
            (13, &[8, 4, 9], "highway=residential lanes=2 sidewalk=separate"),
        ];
        let map = built_as(&Asked { nodes: &nodes, ways: &ways, options: driven_on(DrivingSide::Right) }).map;
        for walkway in of_subtype(&map, "walkway") {
            found += 1;
            let outline = map.outline(walkway);
            let element =
                map.regulatory_elements.iter().find(|it| it.lanelets("refers").any(|id| id == walkway.id)).unwrap();
            for lane in of_subtype(&map, "road") {
                let crosses = polygon::common_area(&map.outline(lane), &outline) > 0.01;
                assert_eq!(lane.regulatory_elements.contains(&element.id), crosses, "{length} m: {}", lane.id);
            }
        }
    }
    assert!(found > 0);
}
