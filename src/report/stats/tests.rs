//! What a map contains, counted on maps drawn for the purpose.

use super::*;
use crate::geometry::Point;
use crate::lanelet::{Bound, Lanelet, LaneletId, LineString, LineStringId, Point as MapPoint, PointId};
use crate::settings::Settings;

/// Two lanes, one after the other, 3.5 m wide and 10 m long, and a third one apart from them.
fn map() -> LaneletMap {
    let mut map = LaneletMap::default();
    for (column, x) in [0.0, 10.0, 20.0, 100.0, 110.0].into_iter().enumerate() {
        for (row, y) in [0.0, 3.5].into_iter().enumerate() {
            map.points.insert(MapPoint::new(PointId((column * 10 + row) as i64), Point::new(x, y), None));
        }
    }
    for (id, from, to) in [(1, 0, 1), (2, 1, 2), (3, 3, 4)] {
        let bound = |row: i64, map: &mut LaneletMap| {
            let line = LineStringId(id * 10 + row);
            let points = vec![PointId(from * 10 + row), PointId(to * 10 + row)];
            let attributes = [("type", "road_border")].into_iter().collect();
            map.linestrings.insert(LineString { id: line, points, attributes, span: None });
            Bound { line, inverted: false }
        };
        let (right, left) = (bound(0, &mut map), bound(1, &mut map));
        let attributes = [("type", "lanelet"), ("subtype", "road"), ("speed_limit", "50")].into_iter().collect();
        map.lanelets.insert(Lanelet {
            id: LaneletId(id),
            left,
            right,
            centerline: None,
            regulatory_elements: Vec::new(),
            attributes,
            span: None,
        });
    }
    map
}

#[test]
fn a_small_map_is_measured() {
    let (map, settings) = (map(), Settings::default());
    let stats = Stats::of(&MapIndex::new(&map, &[], &settings));
    assert_eq!(stats.lanelets["road"], SubtypeStats { count: 3, metres: 30.0 });
    let width = stats.width.unwrap();
    assert!((width.min - 3.5).abs() < 1e-9 && (width.max - 3.5).abs() < 1e-9);
    assert!(stats.curvature.unwrap().max < 1e-9);
    assert_eq!(stats.network.weakly_connected, [2, 1]);
    assert_eq!(stats.network.starts, [1, 3]);
    assert_eq!(stats.network.dead_ends, [2, 3]);
    assert_eq!(stats.network.unreachable, [3]);
    assert_eq!(stats.linestrings["road_border"], 6);
    let text = stats.text();
    assert!(text.contains("Lacks\n  heights, turn directions"), "{text}");
    assert!(text.contains("speed limits"), "{text}");
}

#[test]
fn an_empty_map_has_no_spread() {
    let (map, settings) = (LaneletMap::default(), Settings::default());
    let stats = Stats::of(&MapIndex::new(&map, &[], &settings));
    assert_eq!((stats.width, stats.network.weakly_connected.len()), (None, 0));
    assert!(stats.text().contains("lanes"));
}
