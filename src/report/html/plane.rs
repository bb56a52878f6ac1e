//! Where the page's plane lies: its origin, and latitude and longitude as a polynomial of it.

use crate::geometry::Point;
use crate::lanelet::{LaneletMap, Point as MapPoint};
use nalgebra::{DMatrix, DVector};

/// At most this many points make the fit.
const SAMPLE: usize = 400;
/// A fit that misses a point by more than this, in degrees, is none: 1e-7 is a centimetre.
const LARGEST_MISS: f64 = 2e-6;

/// The page's coordinates: metres from an origin, which keeps small numbers small.
#[derive(Clone, Debug)]
pub struct Frame {
    /// In the map's local metres.
    pub origin: Point,
    /// Latitude and longitude in degrees, each as coefficients of 1, x, y, x², xy, y² with x and y in kilometres from
    /// the origin; `None` where the points' longitudes and latitudes do not fit such a surface.
    pub lonlat: Option<[[f64; 6]; 2]>,
}

impl Frame {
    /// From the points of a map, and with the given origin if there is one.
    pub fn of(map: &LaneletMap, origin: Option<Point>) -> Self {
        let finite = |p: &&MapPoint| p.position.coords.iter().all(|c| c.is_finite());
        let points: Vec<&MapPoint> = map.points.iter().filter(finite).collect();
        let middle = || Point::new(median(&points, |p| p.position.x), median(&points, |p| p.position.y));
        let origin = origin.unwrap_or_else(middle);
        Self { origin, lonlat: fit(&points, origin) }
    }
}

/// The middle value, rounded to a metre: one stray point does not move it.
fn median(points: &[&MapPoint], value: impl Fn(&MapPoint) -> f64) -> f64 {
    let mut values: Vec<f64> = points.iter().map(|p| value(p)).collect();
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { values.select_nth_unstable_by(middle, f64::total_cmp).1.round() }
}

fn fit(points: &[&MapPoint], origin: Point) -> Option<[[f64; 6]; 2]> {
    let placed: Vec<_> = points.iter().filter_map(|p| Some((p.position - origin, p.lonlat()?))).collect();
    let step = placed.len().div_ceil(SAMPLE).max(1);
    let sample: Vec<_> = placed.iter().step_by(step).collect();
    if sample.len() < 3 {
        return None;
    }
    let row = |x: f64, y: f64| [1.0, x, y, x * x, x * y, y * y];
    let rows: Vec<[f64; 6]> = sample.iter().map(|(p, _)| row(p.x / 1000.0, p.y / 1000.0)).collect();
    let matrix = DMatrix::from_fn(rows.len(), 6, |i, j| rows[i][j]);
    let svd = matrix.clone().svd(true, true);
    let solve = |values: Vec<f64>| -> Option<[f64; 6]> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let centred = DVector::from_iterator(values.len(), values.iter().map(|v| v - mean));
        let mut solution = svd.solve(&centred, 1e-12).ok()?;
        let miss = (&matrix * &solution - &centred).amax();
        solution[0] += mean;
        (miss < LARGEST_MISS).then(|| std::array::from_fn(|i| solution[i]))
    };
    let lat = solve(sample.iter().map(|(_, at)| at.lat).collect())?;
    let lon = solve(sample.iter().map(|(_, at)| at.lon).collect())?;
    Some([lat, lon])
}

#[cfg(test)]
mod tests {
    use crate::lanelet::PointId;
    use crate::projection::LonLat;

    use super::*;

    fn map(place: impl Fn(f64, f64) -> LonLat) -> LaneletMap {
        let mut map = LaneletMap::default();
        for i in 0..40_i64 {
            let (x, y) = (5000.0 + (i * 37 % 400) as f64, 7000.0 + (i * 91 % 300) as f64);
            map.points.insert(MapPoint::new(PointId(i), Point::new(x, y), None).with_lonlat(Some(place(x, y))));
        }
        map
    }

    #[test]
    fn degrees_follow_metres() {
        let frame = Frame::of(&map(|x, y| LonLat { lon: 139.0 + x / 91_000.0, lat: 35.0 + y / 111_000.0 }), None);
        let [lat, lon] = frame.lonlat.unwrap();
        assert!((lat[0] - (35.0 + frame.origin.y / 111_000.0)).abs() < 1e-8);
        assert!((lon[1] - 1000.0 / 91_000.0).abs() < 1e-8);
    }

    #[test]
    fn places_that_do_not_fit_are_none() {
        let frame = Frame::of(&map(|x, _| LonLat { lon: if x > 5200.0 { 139.0 } else { 140.0 }, lat: 35.0 }), None);
        assert!(frame.lonlat.is_none());
        assert!(Frame::of(&LaneletMap::default(), None).lonlat.is_none());
    }
}
