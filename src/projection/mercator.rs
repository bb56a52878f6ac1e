//! The transverse Mercator of the ellipsoid WGS84 by the series of Poder and Engsager, step by step as PROJ computes it.
//!
//! What PROJ does beside that costs more than the roads of a town: it opens a database for each thread that asks it.

use std::f64::consts::PI;

use super::LonLat;
use crate::geometry::Point;

/// Metres from the middle of the ellipsoid to its equator.
const SEMIMAJOR: f64 = 6_378_137.0;
/// Its flattening.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Degrees to radians, as PROJ has it.
const RADIANS: f64 = 0.017_453_292_519_943_296;
/// Beyond this, 150 degrees from the central meridian, the series tell nothing.
const FARTHEST: f64 = 2.623_395_162_778;
/// Places farther north or south than the poles by more than this, radians, are none.
const BEYOND_POLE: f64 = 1e-12;

/// The coefficients of a series, the lowest order first.
type Series = [f64; 6];

/// A transverse Mercator with northings from the equator.
pub(super) struct Mercator {
    /// The central meridian, radians.
    meridian: f64,
    /// The east of the central meridian, metres.
    false_east: f64,
    /// Length of a quarter of a meridian by its angle, as a multiple of [`SEMIMAJOR`].
    quadrant: f64,
    /// From geodetic to Gaussian latitude, and back.
    gaussian: [Series; 2],
    /// From the sphere to the ellipsoid, and back.
    ellipsoidal: [Series; 2],
}

impl Mercator {
    /// The plane of a zone of UTM, 1 to 60.
    pub fn utm(zone: u8) -> Self {
        Self::new((f64::from(zone) - 1.0 + 0.5) * PI / 30.0 - PI, 0.9996, 500_000.0)
    }

    /// The plane around the meridian of a longitude, degrees.
    pub fn around(lon: f64, scale: f64) -> Self {
        Self::new(lon * RADIANS, scale, 0.0)
    }

    fn new(meridian: f64, scale: f64, false_east: f64) -> Self {
        let eccentricity = (2.0 * FLATTENING - FLATTENING * FLATTENING).sqrt();
        // The third flattening and its powers.
        let n = (eccentricity.asin() / 2.0).tan().powi(2);
        let squared = n * n;
        let even = 1.0 + squared * (1.0 / 4.0 + squared * (1.0 / 64.0 + squared / 256.0));
        // Each row holds the factors of the powers of n that one coefficient has, from the row's own power on.
        let series = |rows: [&[f64]; 6]| {
            let mut power = 1.0;
            rows.map(|factors| {
                power *= n;
                power * factors.iter().rev().copied().reduce(|sum, factor| factor + n * sum).unwrap_or_default()
            })
        };
        let to_gaussian = series([
            &[-2.0, 2.0 / 3.0, 4.0 / 3.0, -82.0 / 45.0, 32.0 / 45.0, 4642.0 / 4725.0],
            &[5.0 / 3.0, -16.0 / 15.0, -13.0 / 9.0, 904.0 / 315.0, -1522.0 / 945.0],
            &[-26.0 / 15.0, 34.0 / 21.0, 8.0 / 5.0, -12686.0 / 2835.0],
            &[1237.0 / 630.0, -12.0 / 5.0, -24832.0 / 14175.0],
            &[-734.0 / 315.0, 109_598.0 / 31185.0],
            &[444_337.0 / 155_925.0],
        ]);
        let from_gaussian = series([
            &[2.0, -2.0 / 3.0, -2.0, 116.0 / 45.0, 26.0 / 45.0, -2854.0 / 675.0],
            &[7.0 / 3.0, -8.0 / 5.0, -227.0 / 45.0, 2704.0 / 315.0, 2323.0 / 945.0],
            &[56.0 / 15.0, -136.0 / 35.0, -1262.0 / 105.0, 73814.0 / 2835.0],
            &[4279.0 / 630.0, -332.0 / 35.0, -399_572.0 / 14175.0],
            &[4174.0 / 315.0, -144_838.0 / 6237.0],
            &[601_676.0 / 22275.0],
        ]);
        let to_ellipsoid = series([
            &[0.5, -2.0 / 3.0, 5.0 / 16.0, 41.0 / 180.0, -127.0 / 288.0, 7891.0 / 37800.0],
            &[13.0 / 48.0, -3.0 / 5.0, 557.0 / 1440.0, 281.0 / 630.0, -1_983_433.0 / 1_935_360.0],
            &[61.0 / 240.0, -103.0 / 140.0, 15061.0 / 26880.0, 167_603.0 / 181_440.0],
            &[49561.0 / 161_280.0, -179.0 / 168.0, 6_601_661.0 / 7_257_600.0],
            &[34729.0 / 80640.0, -3_418_889.0 / 1_995_840.0],
            &[212_378_941.0 / 319_334_400.0],
        ]);
        let from_ellipsoid = series([
            &[-0.5, 2.0 / 3.0, -37.0 / 96.0, 1.0 / 360.0, 81.0 / 512.0, -96199.0 / 604_800.0],
            &[-1.0 / 48.0, -1.0 / 15.0, 437.0 / 1440.0, -46.0 / 105.0, 1_118_711.0 / 3_870_720.0],
            &[-17.0 / 480.0, 37.0 / 840.0, 209.0 / 4480.0, -5569.0 / 90720.0],
            &[-4397.0 / 161_280.0, 11.0 / 504.0, 830_251.0 / 7_257_600.0],
            &[-4583.0 / 161_280.0, 108_847.0 / 3_991_680.0],
            &[-20_648_693.0 / 638_668_800.0],
        ]);
        Self {
            meridian,
            false_east,
            quadrant: scale / (1.0 + n) * even,
            gaussian: [to_gaussian, from_gaussian],
            ellipsoidal: [to_ellipsoid, from_ellipsoid],
        }
    }

    /// East and north of a place; `None` where it has none.
    pub fn forward(&self, place: LonLat) -> Option<Point> {
        let (lon, lat) = (place.lon * RADIANS, place.lat * RADIANS);
        if lat.abs() - PI / 2.0 > BEYOND_POLE {
            return None;
        }
        let (lon, lat) = (turned(turned(lon) - self.meridian), lat.clamp(-PI / 2.0, PI / 2.0));
        let gaussian = latitude(&self.gaussian[0], lat, (2.0 * lat).cos(), (2.0 * lat).sin());
        let (sin, cos) = (gaussian.sin(), gaussian.cos());
        let toward = cos * lon.cos();
        let norm = 1.0 / sin.hypot(toward);
        let tan_east = lon.sin() * cos * norm;
        let (north, east) = (sin.atan2(toward), arsinh(tan_east));
        let twice = 2.0 * norm;
        let square = twice * norm;
        let scaled = toward * square;
        let angles = [sin * scaled, toward * scaled - 1.0, tan_east * twice, square - 1.0];
        let [more_north, more_east] = complex(&self.ellipsoidal[0], angles);
        let (north, east) = (north + more_north, east + more_east);
        let metres = |angle: f64| self.quadrant * angle * SEMIMAJOR;
        (east.abs() <= FARTHEST).then(|| Point::new(metres(east) + self.false_east, metres(north)))
    }

    /// The place of a point; `None` where there is none.
    pub fn inverse(&self, point: Point) -> Option<LonLat> {
        let angle = |metres: f64| metres * (1.0 / SEMIMAJOR) / self.quadrant;
        let (north, east) = (angle(point.y), angle(point.x - self.false_east));
        if !(east.abs() <= FARTHEST && north.is_finite()) {
            return None;
        }
        let exp = (2.0 * east).exp();
        let (half, half_inverse) = (0.5 * exp, 0.5 / exp);
        let angles = [(2.0 * north).sin(), (2.0 * north).cos(), half - half_inverse, half + half_inverse];
        let [more_north, more_east] = complex(&self.ellipsoidal[1], angles);
        let (north, east) = (north + more_north, east + more_east);
        let (sin, cos, sinh) = (north.sin(), north.cos(), east.sinh());
        let modulus = sinh.hypot(cos);
        let scaled = 2.0 * modulus / (sinh * sinh + 1.0);
        let lat = latitude(&self.gaussian[1], sin.atan2(modulus), scaled * modulus - 1.0, sin * scaled);
        let lon = turned(sinh.atan2(cos) + self.meridian);
        Some(LonLat { lon: lon / RADIANS, lat: lat / RADIANS })
    }
}

/// A longitude from half a turn west to half a turn east, radians.
fn turned(lon: f64) -> f64 {
    // A little more is let be, lest the sign change at the date line.
    if lon.abs() < PI + 1e-12 {
        return lon;
    }
    let east = lon + PI;
    east - 2.0 * PI * (east / (2.0 * PI)).floor() - PI
}

/// The inverse of the hyperbolic sine, as the C library has it; the standard library's differs in the last bits.
fn arsinh(x: f64) -> f64 {
    let square = x * x;
    (x.abs() + square / (1.0 + (1.0 + square).sqrt())).ln_1p().copysign(x)
}

/// A latitude and the sum of a series of sines of its multiples, by Clenshaw.
fn latitude(series: &Series, lat: f64, cos_twice: f64, sin_twice: f64) -> f64 {
    let [lower @ .., last] = series;
    let (mut sum, mut before) = (*last, 0.0);
    for factor in lower.iter().rev() {
        (sum, before) = (-before + 2.0 * cos_twice * sum + factor, sum);
    }
    lat + sum * sin_twice
}

/// The sum of a series of complex sines, by Clenshaw: from sine and cosine of the real part and those, hyperbolic, of the
/// imaginary one.
fn complex(series: &Series, [sin, cos, sinh, cosh]: [f64; 4]) -> [f64; 2] {
    let [lower @ .., last] = series;
    let (r, i) = (2.0 * cos * cosh, -2.0 * sin * sinh);
    let ([mut real, mut imaginary], mut before) = ([*last, 0.0], [0.0; 2]);
    for factor in lower.iter().rev() {
        let next = [-before[0] + r * real - i * imaginary + factor, -before[1] + i * real + r * imaginary];
        before = [real, imaginary];
        [real, imaginary] = next;
    }
    let (r, i) = (sin * cosh, cos * sinh);
    [r * real - i * imaginary, r * imaginary + i * real]
}

#[cfg(test)]
mod tests {
    use proj::Proj;

    use super::*;

    /// Our planes, each with PROJ's definition and its central meridian, degrees.
    fn planes() -> [(Mercator, &'static str, f64); 3] {
        [
            (Mercator::utm(54), "+proj=utm +zone=54", 141.0),
            (Mercator::utm(60), "+proj=utm +zone=60", 177.0),
            (Mercator::around(8.4, 0.9996), "+proj=tmerc +lon_0=8.4 +lat_0=0 +k=0.9996", 8.4),
        ]
    }

    #[test]
    fn there_and_back_is_the_way_of_proj() {
        for (plane, definition, lon) in planes() {
            let steps = format!(
                "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step {definition} +ellps=WGS84"
            );
            let proj = Proj::new(&steps).unwrap();
            let spread = |i: u32, prime: u32| f64::from(i.wrapping_mul(prime) % 20_011) / 20_011.0 - 0.5;
            for i in 0..5000 {
                let place = LonLat { lon: lon + 20.0 * spread(i, 7919), lat: 178.0 * spread(i, 104_729) };
                let own = plane.forward(place).unwrap();
                let (x, y) = proj.project((place.lon, place.lat), false).unwrap();
                assert!((own.x - x).abs() < 1e-8 && (own.y - y).abs() < 1e-8, "{place:?}: {own} {x} {y}");
                let own = plane.inverse(own).unwrap();
                let (lon, lat) = proj.project((x, y), true).unwrap();
                assert!(
                    (own.lon - lon).abs() < 1e-13 && (own.lat - lat).abs() < 1e-13,
                    "{place:?}: {own:?} {lon} {lat}"
                );
            }
        }
    }

    #[test]
    fn what_lies_beyond_has_no_place() {
        let plane = Mercator::utm(32);
        assert_eq!(plane.forward(LonLat { lon: 9.0, lat: 90.1 }), None);
        assert_eq!(plane.forward(LonLat { lon: f64::NAN, lat: 50.0 }), None);
        assert_eq!(plane.inverse(Point::new(1e9, 0.0)), None);
        assert_eq!(plane.inverse(Point::new(0.0, f64::NAN)), None);
    }
}
