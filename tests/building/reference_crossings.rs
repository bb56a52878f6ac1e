//! The elements of which the map of a four-way crossing and of a T junction must consist, for traffic on either side.

use std::collections::{BTreeMap, BTreeSet};

use lanewright::builder::{BuildOptions, Built, build};
use lanewright::geometry::polygon;
use lanewright::lanelet::{Bound, Lanelet, LaneletMap, LineStringId, PointId, Polygon, Target};
use lanewright::osm::read_file;

use crate::common::root;
use crate::networks::{elements, referrers};

fn built(sample: &str) -> Built {
    let path = root().join("sample_maps").join(sample);
    build(&read_file(&path).unwrap(), &BuildOptions::default()).unwrap()
}

fn turning(map: &LaneletMap) -> Vec<&Lanelet> {
    map.lanelets.iter().filter(|l| l.attributes.has("turn_direction")).collect()
}

fn roads(map: &LaneletMap) -> Vec<&Lanelet> {
    let road = |l: &&Lanelet| l.attributes.is("subtype", "road") && !l.attributes.has("turn_direction");
    map.lanelets.iter().filter(road).collect()
}

fn lines(map: &LaneletMap, kind: &str) -> usize {
    map.linestrings.iter().filter(|l| l.attributes.is("type", kind)).count()
}

fn ends(map: &LaneletMap, bound: Bound) -> [PointId; 2] {
    let points: Vec<PointId> = map.bound_points(bound).map(|p| p.id).collect();
    [points[0], points[points.len() - 1]]
}

fn area(map: &LaneletMap) -> &Polygon {
    assert_eq!(map.polygons.len(), 1);
    map.polygons.iter().next().unwrap()
}

/// What holds for every intersection: bounds virtual, all end nodes and all kerb nodes vertices, everything covered.
fn check_area(map: &LaneletMap, bound_lines: usize, end_nodes: usize) {
    let area = area(map);
    let vertices: BTreeSet<PointId> = area.points.iter().copied().collect();
    assert_eq!(vertices.len(), area.points.len(), "no vertex twice");
    let ring: Vec<_> = area.points.iter().map(|&p| map.points.get(p).unwrap().position).collect();
    assert!(polygon::signed_area(&ring) < 0.0, "clockwise");
    let mut used: BTreeSet<LineStringId> = BTreeSet::new();
    let mut nodes: BTreeSet<PointId> = BTreeSet::new();
    for lanelet in turning(map) {
        assert_eq!(lanelet.attributes.get("intersection_area"), Some(area.id.to_string().as_str()));
        for bound in [lanelet.left, lanelet.right] {
            assert!(map.linestrings.get(bound.line).unwrap().attributes.is("type", "virtual"));
            used.insert(bound.line);
            nodes.extend(ends(map, bound));
        }
        let outline = map.outline(lanelet);
        let size = polygon::signed_area(&outline).abs();
        assert!(polygon::overlap(&outline, &ring) >= 0.99 * size, "{} sticks out", lanelet.id);
    }
    assert_eq!(used.len(), bound_lines);
    assert_eq!(nodes.len(), end_nodes);
    assert!(nodes.is_subset(&vertices));
    let of_kerb: BTreeSet<PointId> =
        kerbs(map, &vertices).into_iter().flat_map(|id| map.linestrings.get(id).unwrap().points.clone()).collect();
    assert!(vertices.iter().all(|v| nodes.contains(v) || of_kerb.contains(v)), "every vertex is lane end or kerb");
}

/// The kerbs of the box: all their nodes are vertices.
fn kerbs(map: &LaneletMap, vertices: &BTreeSet<PointId>) -> Vec<LineStringId> {
    let kerb = |l: &&lanewright::lanelet::LineString| {
        l.attributes.is("type", "road_border") && l.points.iter().all(|p| vertices.contains(p))
    };
    map.linestrings.iter().filter(kerb).map(|l| l.id).collect()
}

fn turns(map: &LaneletMap) -> BTreeMap<String, usize> {
    let mut turns = BTreeMap::new();
    for lanelet in turning(map) {
        *turns.entry(lanelet.attributes.get("turn_direction").unwrap().to_owned()).or_default() += 1;
    }
    turns
}

#[test]
fn four_ways_with_lights_and_crosswalks() {
    for (sample, near) in [("crossing_left.osm", "left"), ("crossing_right.osm", "right")] {
        let Built { map, .. } = built(sample);
        assert_eq!(roads(&map).len(), 8);
        assert_eq!(turning(&map).len(), 12);
        assert!(turns(&map).values().all(|&n| n == 4));
        check_area(&map, 18, 12);
        assert_eq!(lines(&map, "stop_line"), 4);
        // One per approach for drivers, two per crosswalk for people on foot.
        assert_eq!(lines(&map, "traffic_light"), 12);
        assert_eq!(lines(&map, "light_bulbs"), 12);
        let lights = elements(&map, "traffic_light");
        let (walk, drive): (Vec<_>, Vec<_>) =
            lights.into_iter().partition(|light| light.linestrings("refers").count() == 2);
        assert_eq!((walk.len(), drive.len()), (4, 4));
        for light in walk {
            let crosswalks = referrers(&map, light);
            assert!(crosswalks.len() == 1 && crosswalks[0].attributes.is("subtype", "crosswalk"));
            let mut bodies = light.linestrings("refers").map(|id| map.linestrings.get(id).unwrap());
            assert!(bodies.all(|body| body.attributes.is("subtype", "red_green")));
        }
        for light in drive {
            assert_eq!(light.linestrings("ref_line").count(), 1);
            let line = map.linestrings.get(light.linestrings("ref_line").next().unwrap()).unwrap();
            let behind = referrers(&map, light);
            assert_eq!(behind.len(), 3);
            for lanelet in behind {
                let start = [ends(&map, lanelet.left)[0], ends(&map, lanelet.right)[0]];
                assert_eq!(line.points, start, "the stop line is where the lanelet begins");
            }
        }
        let rights = elements(&map, "right_of_way");
        assert_eq!(rights.len(), 8);
        for right in rights {
            let owner: Vec<_> = right.lanelets("right_of_way").collect();
            assert_eq!(owner.len(), 1);
            let lanelet = map.lanelets.get(owner[0]).unwrap();
            assert_eq!(referrers(&map, right).iter().map(|l| l.id).collect::<Vec<_>>(), owner);
            let wanted = if lanelet.attributes.is("turn_direction", near) { 2 } else { 4 };
            assert!(!lanelet.attributes.is("turn_direction", "straight"));
            assert_eq!(right.lanelets("yield").count(), wanted);
        }
        let crosswalks = elements(&map, "crosswalk");
        assert_eq!(map.lanelets.iter().filter(|l| l.attributes.is("subtype", "crosswalk")).count(), 4);
        assert_eq!(crosswalks.len(), 4);
        for crosswalk in crosswalks {
            assert_eq!(crosswalk.lanelets("refers").count(), 1);
            assert_eq!(referrers(&map, crosswalk).len(), 6);
        }
        let vertices = area(&map).points.iter().copied().collect();
        assert_eq!(kerbs(&map, &vertices).len(), 4);
    }
}

#[test]
fn a_t_junction_without_lights() {
    for sample in ["tjunction_left.osm", "tjunction_right.osm"] {
        let Built { map, settings, .. } = built(sample);
        assert_eq!(roads(&map).len(), 6);
        assert_eq!(turning(&map).len(), 6);
        assert!(turns(&map).values().all(|&n| n == 2));
        check_area(&map, 9, 9);
        assert_eq!(lines(&map, "stop_line"), 1, "nobody waits on the road that leads through");
        assert_eq!(elements(&map, "right_of_way").len(), 4);
        // That of a give-way sign is in two: its sign's, and that of who begins there.
        let marked = elements(&map, "road_marking").into_iter().flat_map(|element| element.linestrings("refers"));
        let signed = elements(&map, "traffic_sign").into_iter().flat_map(|element| element.linestrings("ref_line"));
        let hung: BTreeSet<i64> = marked.chain(signed).map(|line| line.0).collect();
        assert_eq!(hung.len(), 1, "every stop line hangs on an element");
        let vertices = area(&map).points.iter().copied().collect();
        assert_eq!(kerbs(&map, &vertices).len(), 3);
        assert_eq!(settings.intersection.len(), 1);
        assert_eq!(settings.intersection[0].priority_arms.len(), 2);
    }
}

#[test]
fn every_reference_resolves_and_every_id_is_used_once() {
    let Built { map, .. } = built("crossing_left.osm");
    let mut ids: BTreeSet<i64> = BTreeSet::new();
    let all = (map.points.iter().map(|p| p.id.0))
        .chain(map.linestrings.iter().map(|l| l.id.0))
        .chain(map.polygons.iter().map(|p| p.id.0))
        .chain(map.lanelets.iter().map(|l| l.id.0))
        .chain(map.regulatory_elements.iter().map(|r| r.id.0));
    for id in all {
        assert!(id > 0 && id < 1 << 53 && ids.insert(id), "{id}");
    }
    for member in map.regulatory_elements.iter().flat_map(|r| &r.members) {
        assert!(match member.target {
            Target::Point(id) => map.points.contains(id),
            Target::LineString(id) => map.linestrings.contains(id),
            Target::Polygon(id) => map.polygons.contains(id),
            Target::Lanelet(id) => map.lanelets.contains(id),
        });
    }
    assert!(map.points.iter().all(|p| p.lonlat().is_some() && p.ele().is_some()));
}

#[test]
fn the_same_input_gives_the_same_map() {
    for sample in ["crossing_left.osm", "turn_lanes_right.osm"] {
        let [first, second] = [built(sample), built(sample)].map(|b| {
            format!("{:?}", (b.map.points.as_slice(), b.map.linestrings.as_slice(), b.map.lanelets.as_slice()))
        });
        assert!(first == second, "{sample}");
    }
}
