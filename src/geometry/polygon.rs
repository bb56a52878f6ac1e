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
