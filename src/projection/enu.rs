//! East, north, up in the tangent plane of the WGS84 ellipsoid. PROJ's Rust crate carries no heights, so this is ours.

use nalgebra::{Rotation3, Vector3};

use crate::geometry::Point;

use super::LonLat;

/// Semi-major axis of WGS84, metres.
const A: f64 = 6_378_137.0;
/// Flattening of WGS84.
const F: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared.
const E2: f64 = F * (2.0 - F);

/// Steps to find a latitude or a height; each gains two digits or more, doubles have sixteen.
const STEPS: usize = 10;

/// East and north of `place` at height `ele` (metres) seen from `origin` at height 0.
pub(super) fn forward(origin: LonLat, place: LonLat, ele: f64) -> Point {
    let local = axes(origin) * (geocentric(place, ele) - geocentric(origin, 0.0));
    Point::new(local.x, local.y)
}

/// The place at height `ele` above the ellipsoid that lies over `point` of the tangent plane.
pub(super) fn inverse(origin: LonLat, point: Point, ele: f64) -> Option<LonLat> {
    let back = axes(origin).inverse();
    let zero = geocentric(origin, 0.0);
    let mut up = ele;
    let mut found = None;
    for _ in 0..STEPS {
        let (place, height) = geodetic(zero + back * Vector3::new(point.x, point.y, up));
        found = Some(place);
        up += ele - height;
    }
    found.filter(|p| p.lon.is_finite() && p.lat.is_finite())
}

/// From geocentric axes to east, north, up at `origin`.
fn axes(origin: LonLat) -> Rotation3<f64> {
    let (sin_lat, cos_lat) = origin.lat.to_radians().sin_cos();
    let (sin_lon, cos_lon) = origin.lon.to_radians().sin_cos();
    Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
        -sin_lon,
        cos_lon,
        0.0,
        -sin_lat * cos_lon,
        -sin_lat * sin_lon,
        cos_lat,
        cos_lat * cos_lon,
        cos_lat * sin_lon,
        sin_lat,
    ))
}

fn geocentric(place: LonLat, height: f64) -> Vector3<f64> {
    let (sin_lat, cos_lat) = place.lat.to_radians().sin_cos();
    let (sin_lon, cos_lon) = place.lon.to_radians().sin_cos();
    let n = A / (1.0 - E2 * sin_lat * sin_lat).sqrt();
    Vector3::new(
        (n + height) * cos_lat * cos_lon,
        (n + height) * cos_lat * sin_lon,
        (n * (1.0 - E2) + height) * sin_lat,
    )
}

fn geodetic(at: Vector3<f64>) -> (LonLat, f64) {
    let radius = at.x.hypot(at.y);
    let mut lat = at.z.atan2(radius * (1.0 - E2));
    let mut height = 0.0;
    for _ in 0..STEPS {
        let (sin, cos) = lat.sin_cos();
        let n = A / (1.0 - E2 * sin * sin).sqrt();
        // Good at the equator and at the poles alike.
        height = radius * cos + at.z * sin - A * A / n;
        lat = at.z.atan2(radius * (1.0 - E2 * n / (n + height)));
    }
    (LonLat { lon: at.y.atan2(at.x).to_degrees(), lat: lat.to_degrees() }, height)
}
