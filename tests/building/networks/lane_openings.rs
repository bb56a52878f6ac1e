//! Where a road becomes wider or narrower by several lanes, these open or close one after another.

use std::collections::BTreeMap;

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::lanelet::{Lanelet, LaneletMap, PointId};

use super::{SIDES, built, found, network_of};

/// The largest number of lanelets that begin in one pair of nodes, and of those that end in one.
fn most_in_one_edge(map: &LaneletMap) -> [usize; 2] {
    [true, false].map(|first| {
        let mut edges: BTreeMap<[PointId; 2], usize> = BTreeMap::new();
        map.lanelets.iter().for_each(|lane| *edges.entry(edge(map, lane, first)).or_default() += 1);
        edges.into_values().max().unwrap_or_default()
    })
}

/// The left and the right node at which a lanelet begins (`first`) or ends.
fn edge(map: &LaneletMap, lane: &Lanelet, first: bool) -> [PointId; 2] {
    [lane.left, lane.right].map(|bound| {
        let points = &map.linestrings.get(bound.line).unwrap().points;
        if first == bound.inverted { points[points.len() - 1] } else { points[0] }
    })
}

/// A road of 300 m westward or eastward that goes on as another of this length, metres, drawn in either direction.
fn joined(side: DrivingSide, [one, other]: [&str; 2], length: f64) -> Built {
    let nodes = [(1, -300.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, length, 0.0, "")];
    built(&network_of(side, &nodes, &[(11, &[1, 2], one), (12, &[2, 3], other)]), side, "")
}

#[test]
fn lanes_open_and_close_one_after_another() {
    let one_way = |lanes: usize| format!("highway=primary oneway=yes lanes={lanes}");
    let two_way = "highway=primary lanes=4 lanes:forward=3 lanes:backward=1".to_owned();
    for side in SIDES {
        for (ways, closed) in [
            ([one_way(1), one_way(4)], 2),
            ([one_way(4), one_way(1)], 2),
            ([one_way(2), one_way(4)], 1),
            ([one_way(2), one_way(3)], 0),
            (["highway=primary lanes=2".to_owned(), two_way.clone()], 1),
        ] {
            let Built { map, settings, notes, .. } = joined(side, [&ways[0], &ways[1]], 300.0);
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {ways:?}");
            assert!(most_in_one_edge(&map).iter().all(|most| *most <= 2), "{side:?} {ways:?}");
            let told = notes.iter().filter(|note| note.fault == "lanes-closed").count();
            assert_eq!(told, closed, "{side:?} {ways:?}");
        }
    }
}

#[test]
fn lanes_open_at_once_where_there_is_no_room() {
    for side in SIDES {
        let ways = ["highway=primary oneway=yes lanes=1", "highway=primary oneway=yes lanes=3"];
        assert_eq!(most_in_one_edge(&joined(side, ways, 24.0).map)[0], 3, "{side:?}");
    }
}
