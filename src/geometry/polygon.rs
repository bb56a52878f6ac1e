//! Rings and the areas between them, through `geo`. A ring is a list of points, not closed.

use geo::{Area, BooleanOps, Contains, Coord, LineString, MultiPolygon, Polygon};

use super::Point;

/// `geo`'s polygon from a ring.
pub fn to_geo(ring: &[Point]) -> Polygon<f64> {
    Polygon::new(LineString::new(ring.iter().map(|p| Coord { x: p.x, y: p.y }).collect()), Vec::new())
}

/// Signed area in square metres: positive when the ring runs counter-clockwise.
pub fn signed_area(ring: &[Point]) -> f64 {
    let Some(&origin) = ring.first() else { return 0.0 };
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| super::cross(a - origin, b - origin)).sum::<f64>() / 2.0
}

/// Area in square metres that both rings cover. Rings that cross themselves count by the non-zero rule.
pub fn overlap(a: &[Point], b: &[Point]) -> f64 {
    intersection(a, b).unsigned_area()
}

/// What both rings cover.
pub fn intersection(a: &[Point], b: &[Point]) -> MultiPolygon<f64> {
    to_geo(a).intersection(&to_geo(b))
}

/// Whether the ring holds the point in its interior.
pub fn contains(ring: &[Point], p: Point) -> bool {
    to_geo(ring).contains(&geo::Point::new(p.x, p.y))
}

/// The convex hull of the points, clockwise, not closed (Andrew's monotone chain, exact orientations).
pub fn convex_hull(points: impl IntoIterator<Item = Point>) -> Vec<Point> {
    let mut points: Vec<Point> = points.into_iter().collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let chain = |points: &mut dyn Iterator<Item = Point>| {
        let mut hull: Vec<Point> = Vec::new();
        for p in points {
            while hull.len() >= 2 && super::orientation(hull[hull.len() - 2], hull[hull.len() - 1], p) >= 0.0 {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// The largest piece of `a` that `b` does not cover, as a ring that is not closed; `None` if nothing is left.
pub fn largest_outside(a: &[Point], b: &[Point]) -> Option<Vec<Point>> {
    let rest = to_geo(a).difference(&to_geo(b));
    let largest = rest.into_iter().max_by(|x, y| x.unsigned_area().total_cmp(&y.unsigned_area()))?;
    let mut ring: Vec<Point> = largest.exterior().coords().map(|c| Point::new(c.x, c.y)).collect();
    ring.pop();
    Some(ring)
}

/// The outer boundary of the largest piece of the union of these rings, clockwise, not closed; `None` if there is none.
/// Points come out moved by up to a millionth of the rings' extent.
pub fn union(rings: &[Vec<Point>]) -> Option<Vec<Point>> {
    let polygons: Vec<Polygon<f64>> = rings
        .iter()
        .map(|ring| match signed_area(ring) < 0.0 {
            true => ring.iter().rev().copied().collect::<Vec<_>>(),
            false => ring.clone(),
        })
        .map(|ring| to_geo(&ring))
        .collect();
    let union = geo::unary_union(&polygons);
    let largest = union.0.into_iter().max_by(|a, b| a.unsigned_area().total_cmp(&b.unsigned_area()))?;
    let mut ring: Vec<Point> = largest.exterior().coords().map(|c| Point::new(c.x, c.y)).collect();
    ring.pop();
    if signed_area(&ring) > 0.0 {
        ring.reverse();
    }
    (ring.len() > 2).then_some(ring)
}
