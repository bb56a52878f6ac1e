//! Plane geometry in metres. It knows no roads and no lanelets.
//!
//! Points and vectors are those of `nalgebra`. Unions and intersections of polygons use `geo`, in [`polygon`].

pub mod convex_hull;
pub mod curve;
pub mod diverge;
pub mod extended;
pub mod fillet;
pub mod insides;
pub mod line_index;
pub mod miter;
pub mod overlay;
pub mod polygon;
pub mod polyline;
pub mod pose;
pub mod s_curve;
pub mod separation;
pub mod simple_ring;
pub mod spatial_hash;
pub mod strip_index;
pub mod swing_out_turn;
pub mod tangled_ring;

pub use polyline::Polyline;

/// A point: east and north, metres.
pub type Point = nalgebra::Point2<f64>;
/// A displacement, metres.
pub type Vector = nalgebra::Vector2<f64>;

/// The vector turned by 90 degrees to the left.
pub fn left_of(v: Vector) -> Vector {
    Vector::new(-v.y, v.x)
}

/// The z component of the cross product: positive when `b` turns left of `a`.
pub fn cross(a: Vector, b: Vector) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Signed angle from `a` to `b` in radians, left positive, in (-pi, pi].
pub fn angle_between(a: Vector, b: Vector) -> f64 {
    cross(a, b).atan2(a.dot(&b))
}

/// Twice the signed area of a triangle, square metres: positive if `c` lies left of the line from `a` to `b`. The sign is exact.
pub fn orientation(a: Point, b: Point, c: Point) -> f64 {
    use geo::{Coord, Kernel};
    let coord = |p: Point| Coord { x: p.x, y: p.y };
    match geo::kernels::RobustKernel::orient2d(coord(a), coord(b), coord(c)) {
        geo::Orientation::CounterClockwise => cross(b - a, c - a).abs().max(f64::MIN_POSITIVE),
        geo::Orientation::Clockwise => -cross(b - a, c - a).abs().max(f64::MIN_POSITIVE),
        geo::Orientation::Collinear => 0.0,
    }
}

/// The crossing of the segments `a`-`b` and `c`-`d`: the parameters along each, 0 to 1, and the point; `None` if they are
/// parallel or do not meet.
pub fn segment_crossing(a: Point, b: Point, c: Point, d: Point) -> Option<(f64, f64, Point)> {
    let (s, t, p) = line_crossing(a, b - a, c, d - c)?;
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some((s, t, p))
}

/// The crossing of the lines through `p` along `u` and through `q` along `v`: the parameters along each, and the point; `None`
/// if they are parallel.
pub fn line_crossing(p: Point, u: Vector, q: Point, v: Vector) -> Option<(f64, f64, Point)> {
    let det = cross(u, v);
    if det.abs() < 1e-12 * u.norm() * v.norm() || det == 0.0 {
        return None;
    }
    let w = q - p;
    let s = cross(w, v) / det;
    let t = cross(w, u) / det;
    Some((s, t, p + u * s))
}
