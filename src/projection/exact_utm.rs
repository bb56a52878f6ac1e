//! Easting and northing of UTM to the last digit as Autoware's projector of MGRS has them, which asks GeographicLib: Krüger's series
//! to the sixth order, in the same order of operations. Other libraries agree within nanometres, which is not enough where a
//! decision hangs on the last digit.

use std::f64::consts::PI;

use super::LonLat;
use super::mgrs::{SQUARE, zone_of};
use crate::geometry::Point;

/// Equatorial radius of WGS 84, metres.
const RADIUS: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Scale along the central meridian of a zone.
const SCALE: f64 = 0.9996;
/// Metres added to the east, and to the north in the southern half.
const FALSE_EASTING: f64 = 500_000.0;
const FALSE_NORTHING: f64 = 10_000_000.0;
/// Krüger's coefficients of sin(2kζ) and sinh, k from 1: polynomials of the third flattening, highest power first, and what divides
/// them.
const SERIES: [(&[f64], f64); 6] = [
    (&[31_564.0, -66_675.0, 34_440.0, 47_250.0, -100_800.0, 75_600.0], 151_200.0),
    (&[-1_983_433.0, 863_232.0, 748_608.0, -1_161_216.0, 524_160.0], 1_935_360.0),
    (&[670_412.0, 406_647.0, -533_952.0, 184_464.0], 725_760.0),
    (&[6_601_661.0, -7_732_800.0, 2_230_245.0], 7_257_600.0),
    (&[-13_675_556.0, 3_438_171.0], 7_983_360.0),
    (&[212_378_941.0], 319_334_400.0),
];

type Complex = [f64; 2];

fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().copied().reduce(|y, coefficient| y * x + coefficient).unwrap_or_default()
}

/// Sine and cosine of an angle in degrees, reduced to at most 45 before it is turned into radians.
fn sin_cos(degrees: f64) -> [f64; 2] {
    let quarters = (degrees / 90.0).round();
    let angle = (degrees - quarters * 90.0) * (PI / 180.0);
    let (sin, cos) = (angle.sin(), angle.cos());
    match quarters.rem_euclid(4.0) as u8 {
        0 => [sin, cos],
        1 => [cos, -sin],
        2 => [-sin, -cos],
        _ => [-cos, sin],
    }
}

// The standard library computes these two in another way than C does.

fn atanh(x: f64) -> f64 {
    let twice = x.abs() + x.abs();
    (0.5 * (twice + twice * x.abs() / (1.0 - x.abs())).ln_1p()).copysign(x)
}

/// Of less than 2.
fn asinh(x: f64) -> f64 {
    let square = x * x;
    (x.abs() + square / (1.0 + (1.0 + square).sqrt())).ln_1p().copysign(x)
}

/// Easting and northing, of the places of many points.
pub struct ExactUtm {
    /// Radius of the meridian, metres.
    radius: f64,
    eccentricity: f64,
    series: [f64; 6],
}

impl Default for ExactUtm {
    fn default() -> Self {
        let n = FLATTENING / (2.0 - FLATTENING);
        let mut power = n;
        let series = SERIES.map(|(coefficients, by)| {
            let coefficient = power * polynomial(coefficients, n) / by;
            power *= n;
            coefficient
        });
        let mean = polynomial(&[1.0, 4.0, 64.0, 256.0], n * n) / (256.0 * (1.0 + n));
        Self { radius: mean * RADIUS, eccentricity: (FLATTENING * (2.0 - FLATTENING)).sqrt(), series }
    }
}

impl ExactUtm {
    /// Easting and northing modulo 100 km of a place in its own zone; `None` where there is none.
    pub fn in_square(&self, place: LonLat) -> Option<Point> {
        let zone = zone_of(place)?;
        let east = place.lon - (6.0 * f64::from(zone) - 183.0);
        let east = east - 360.0 * ((east + 180.0) / 360.0).floor();
        let [north_sign, east_sign] = [place.lat, east].map(|angle| 1_f64.copysign(angle));
        let [sin_lat, cos_lat] = sin_cos(place.lat * north_sign);
        let [sin_lon, cos_lon] = sin_cos(east * east_sign);
        let conformal = self.conformal(sin_lat / cos_lat);
        let along = conformal.atan2(cos_lon);
        let across = asinh(sin_lon / conformal.hypot(cos_lon));
        let [northing, easting] = self.summed(along, across);
        let (scale, south) = (self.radius * SCALE, if north_sign < 0.0 { FALSE_NORTHING } else { 0.0 });
        let (x, y) = (scale * easting * east_sign + FALSE_EASTING, scale * northing * north_sign + south);
        Some(Point::new(x % SQUARE, y % SQUARE))
    }

    /// Tangent of the conformal latitude, of that of the latitude.
    fn conformal(&self, tan: f64) -> f64 {
        let secant = 1_f64.hypot(tan);
        let sinh = (self.eccentricity * atanh(self.eccentricity * (tan / secant))).sinh();
        1_f64.hypot(sinh) * tan - sinh * secant
    }

    /// The series, summed as Clenshaw does.
    fn summed(&self, along: f64, across: f64) -> [f64; 2] {
        let (cos, cosh) = ((2.0 * along).cos(), (2.0 * across).cosh());
        let (sin, sinh) = ((2.0 * along).sin(), (2.0 * across).sinh());
        let twice = [2.0 * cos * cosh, -2.0 * sin * sinh];
        let [mut now, mut before] = [[0.0; 2]; 2];
        for coefficient in self.series.iter().rev() {
            let [re, im] = times(twice, now);
            (now, before) = ([re - before[0] + coefficient, im - before[1]], now);
        }
        let [re, im] = times([sin * cosh, cos * sinh], now);
        [along + re, across + im]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::{MgrsGrid, Projector};

    /// Places, with what the existing validator makes of them.
    #[test]
    fn places_come_out_to_the_last_digit() {
        let exact = ExactUtm::default();
        for (lat, lon, x, y) in [
            (48.123456789012344, 11.567890123456788, 91088.69215700263, 33211.49816905614),
            (47.694737703680254, 17.628135068945866, 97194.3768999991, 85718.40510000009),
            (-33.8568123456, 151.2153987654, 34909.73115863401, 52287.542431186885),
            (1.2345678e-05, 0.0031282033255, 66370.01421500545, 1.366449731334036),
            (-6.188e-09, 0.0031282033255, 66370.01421499776, 99999.99931509793),
            (60.3913, 5.3221, 97353.9327291511, 648.3452317360789),
            (78.2232, 15.6356, 14481.484890425403, 83357.65618108585),
            (51.500123, -0.1000987, 1270.273916813545, 9430.528623002581),
            (1.3521, 103.8198, 68700.27237303834, 49479.866291019134),
            (-79.5, -179.9, 41025.35737473093, 72753.13723809272),
            (40.7128, -74.006, 83959.37232408463, 7350.998243320733),
            (64.1466, -21.9426, 54138.376516023825, 13689.868973985314),
            (37.5665, 126.978, 21424.286193708424, 59640.64141244395),
        ] {
            assert_eq!(exact.in_square(LonLat { lon, lat }), Some(Point::new(x, y)), "{lat} {lon}");
        }
    }

    #[test]
    fn they_are_those_of_the_projector() {
        let exact = ExactUtm::default();
        for (lat, lon) in
            [(48.1, 11.5), (-33.86, 151.2), (60.39, 5.32), (78.22, 15.6), (1e-9, -0.01), (0.0, 179.9), (35.2, 139.0)]
        {
            let place = LonLat { lon, lat };
            let projected = Projector::mgrs(MgrsGrid::of(place).unwrap()).forward(place, 0.0).unwrap();
            let found = exact.in_square(place).unwrap();
            assert!((found - projected).norm() < 1e-6, "{lat} {lon}: {found} {projected}");
        }
    }
}
