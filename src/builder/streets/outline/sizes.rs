//! Sizes that shape the outlines.

/// Radius of the kerb between two roads at a right angle, metres.
pub const KERB_RADIUS: f64 = 4.0;
/// As [`KERB_RADIUS`] beside a service road or track.
pub const KERB_RADIUS_MINOR: f64 = 2.5;
/// The largest distance of the kerb's tangent points from the collision of the two edges, metres.
pub const KERB_REACH: f64 = 4.0;
/// The largest trim of roads that diverge at a small angle, as a multiple of the wider road's width: the rest of their overlap is not part
/// of the intersection.
pub const MOST_TRIM: f64 = 2.0;
/// Distance between a cut and the collision that it is for, so that corners do not coincide, metres.
pub const MARGIN: f64 = 0.2;
/// Least trim of a road that meets another, metres.
pub const LEAST_TRIM: f64 = 0.5;
/// Least remaining length of a road that is long enough, metres.
pub const LEAST_ROAD: f64 = 1.5;
/// The same between two intersections, metres: room for a waiting car and half a metre. Kerbs get what is left.
pub const LEAST_ROAD_BETWEEN: f64 = 5.5;
