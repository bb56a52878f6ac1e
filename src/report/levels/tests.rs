//! Streets as strips of ground at a height, and which of them is shown last.

use crate::lanelet::{
    Attributes, Bound, LaneletId, Member, Point as MapPoint, PolygonId, RegulatoryElement, RegulatoryElementId,
};

use super::*;

/// South-west corner, size to the east and north, heights of start and end.
type Strip = ((f64, f64), (f64, f64), [f64; 2]);

/// A map of strips, each a lanelet along its longer side: 1, 2, ... with the bounds 10, 11, 20, 21, ...
fn strips(of_each: &[Strip]) -> LaneletMap {
    let mut map = LaneletMap::default();
    for (at, &((x, y), (wide, long), [start, end])) in of_each.iter().enumerate() {
        let base = (at as i64 + 1) * 10;
        // A strip runs along its longer side.
        let corners = if long >= wide {
            [(x, y, start), (x, y + long, end), (x + wide, y, start), (x + wide, y + long, end)]
        } else {
            [(x, y + long, start), (x + wide, y + long, end), (x, y, start), (x + wide, y, end)]
        };
        for (id, (x, y, height)) in (base..).zip(corners) {
            map.points.insert(MapPoint::new(PointId(id), Point::new(x, y), Some(height)));
        }
        for (id, from) in [(base, base), (base + 1, base + 2)] {
            line(&mut map, id, &[from, from + 1]);
        }
        let [left, right] = [base, base + 1].map(|id| Bound { line: LineStringId(id), inverted: false });
        let attributes = Attributes::default();
        let (id, centerline, span) = (LaneletId(at as i64 + 1), None, None);
        map.lanelets.insert(Lanelet { id, left, right, centerline, regulatory_elements: Vec::new(), attributes, span });
    }
    map
}

fn line(map: &mut LaneletMap, id: i64, points: &[i64]) {
    let points = points.iter().map(|id| PointId(*id)).collect();
    map.linestrings.insert(LineString { id: LineStringId(id), points, attributes: Attributes::default(), span: None });
}

/// A street from south to north over a tunnel from west to east.
fn tunnel() -> LaneletMap {
    strips(&[((0.0, 0.0), (4.0, 60.0), [0.0, 0.0]), ((-30.0, 28.0), (60.0, 4.0), [-6.0, -6.0])])
}

#[test]
fn a_street_is_shown_after_the_tunnel_below_it() {
    let map = tunnel();
    let levels = Levels::of(&map);
    assert_eq!((levels.count(), &levels.lanelets[..], &levels.lines[..]), (2, &[1, 0][..], &[1, 1, 0, 0][..]));
    let [below, above] = &levels.split(&map)[..] else { panic!("two levels") };
    assert_eq!((below.lanelets[0].id, above.lanelets[0].id), (LaneletId(2), LaneletId(1)));
    assert!(levels.is_covered(Point::new(2.0, 30.0), 0) && !levels.is_covered(Point::new(2.0, 30.0), 1));
    assert!(!levels.is_covered(Point::new(20.0, 30.0), 0), "beside the street the tunnel is seen");
}

#[test]
fn what_overlaps_on_one_height_stays_together() {
    let mut map = tunnel();
    // The area of an intersection that begins beside the tunnel, and a lanelet that crosses only the area.
    let crossing = strips(&[
        ((0.0, 0.0), (4.0, 60.0), [0.0, 0.0]),
        ((-30.0, 28.0), (60.0, 4.0), [-6.0, -6.0]),
        ((-20.0, 50.0), (40.0, 4.0), [0.0, 0.0]),
    ]);
    for (id, x, y) in [(901, -1.0, 40.0), (902, 5.0, 40.0), (903, 5.0, 59.0), (904, -1.0, 59.0)] {
        map.points.insert(MapPoint::new(PointId(id), Point::new(x, y), Some(0.2)));
    }
    let (points, attributes) = ([901, 902, 903, 904].map(PointId).to_vec(), Attributes::default());
    map.polygons.insert(Polygon { id: PolygonId(900), points, attributes, span: None });
    crossing.points.iter().for_each(|point| drop(map.points.insert(point.clone())));
    crossing.linestrings.iter().for_each(|line| drop(map.linestrings.insert(line.clone())));
    crossing.lanelets.iter().for_each(|lanelet| drop(map.lanelets.insert(lanelet.clone())));
    let levels = Levels::of(&map);
    assert_eq!((&levels.lanelets[..], &levels.polygons[..]), (&[1, 0, 1][..], &[1][..]));
}

#[test]
fn a_flat_map_and_one_without_heights_have_one_level() {
    assert_eq!(
        Levels::of(&strips(&[((0.0, 0.0), (4.0, 60.0), [0.0; 2]), ((-30.0, 28.0), (60.0, 4.0), [2.4; 2])])).count(),
        1
    );
    let mut map = tunnel();
    for id in 10..14 {
        let place = map.points.get(PointId(id)).unwrap().position;
        map.points.insert(MapPoint::new(PointId(id), place, None));
    }
    assert_eq!(Levels::of(&map).count(), 1, "nobody knows how high the street is");
}

#[test]
fn a_ramp_is_as_high_as_where_it_crosses() {
    // It climbs from 0 to 12 m; the street at 6 m crosses it near its start, the one at 1 m near its end.
    let ramp = ((0.0, 0.0), (4.0, 120.0), [0.0, 12.0]);
    let map = strips(&[((-30.0, 10.0), (60.0, 4.0), [6.0; 2]), ramp, ((-30.0, 100.0), (60.0, 4.0), [1.0; 2])]);
    assert_eq!(Levels::of(&map).lanelets, [2, 1, 0]);
}

#[test]
fn surfaces_that_wind_around_each_other_end_somewhere() {
    let ramp = |x, y, size, heights| ((x, y), size, heights);
    // Each of four ramps passes over the next one.
    let map = strips(&[
        ramp(0.0, -20.0, (4.0, 80.0), [0.0, 10.0]),
        ramp(-20.0, 40.0, (80.0, 4.0), [0.0, 10.0]),
        ramp(40.0, -20.0, (4.0, 80.0), [10.0, 0.0]),
        ramp(-20.0, 0.0, (80.0, 4.0), [10.0, 0.0]),
    ]);
    assert!(Levels::of(&map).count() <= MOST_LEVELS);
}

#[test]
fn lines_that_bound_nothing_lie_where_they_are_used_or_stand() {
    let mut map = tunnel();
    for (id, y, height) in [(91, 30.0, -6.0), (92, 30.0, 4.5), (93, 30.0, -1.0)] {
        for (id, x) in [(id * 10, 1.0), (id * 10 + 1, 3.0)] {
            map.points.insert(MapPoint::new(PointId(id), Point::new(x, y), Some(height)));
        }
        line(&mut map, id, &[id * 10, id * 10 + 1]);
    }
    // The light at -1 m hangs in the tunnel, though the street is nearer.
    let id = RegulatoryElementId(70);
    let member = Member { role: "refers".into(), target: Target::LineString(LineStringId(93)) };
    map.regulatory_elements.insert(RegulatoryElement {
        id,
        subtype: "traffic_light".into(),
        members: vec![member],
        attributes: Attributes::default(),
        span: None,
    });
    map.lanelets.get_mut(LaneletId(2)).unwrap().regulatory_elements.push(id);
    let levels = Levels::of(&map);
    let of = |id| levels.lines[map.linestrings.position(LineStringId(id)).unwrap()];
    assert_eq!([91, 92, 93].map(of), [0, 1, 0]);
}
