//! A place on earth.

/// A place on the WGS84 ellipsoid, degrees.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, serde::Serialize, serde::Deserialize)]
pub struct LonLat {
    /// East positive, -180..=180.
    pub lon: f64,
    /// North positive, -90..=90.
    pub lat: f64,
}
