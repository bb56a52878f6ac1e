//! The way back from a plane to degrees by polynomials, each for one square of the plane: PROJ's own takes a series of
//! sines for every point.

use crate::geometry::Point;

use super::LonLat;

/// Side of a square, metres: the terms beyond the last grow with it, and small maps should need few squares.
const SIDE: f64 = 8192.0;
/// Places along either side at which PROJ is asked, and terms in either direction.
const TERMS: usize = 7;
/// The polynomial may differ from PROJ by so much, degrees: a hundredth of the last digit that is written.
const ERROR_MOST: f64 = 1e-13;

/// Which square.
pub(super) type Square = (i64, i64);

/// One square's polynomial: a sum of products of Chebyshev polynomials.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    middle: Point,
    /// Where the middle lies.
    zero: LonLat,
    /// Degrees east and north of that place, by the orders in east and north.
    terms: [[[f64; 2]; TERMS]; TERMS],
}

/// The square that holds a point; `None` where it is no number or beyond any plane.
pub(super) fn square_of(point: Point) -> Option<Square> {
    /// Metres: twice around the earth.
    const FARTHEST: f64 = 8e7;
    let known = point.x.abs() < FARTHEST && point.y.abs() < FARTHEST;
    known.then(|| ((point.x / SIDE).floor() as i64, (point.y / SIDE).floor() as i64))
}

impl Patch {
    /// The polynomial of a square through what `inverse` says of some points of it; `None` where it does not fit.
    pub(super) fn new((x, y): Square, inverse: impl Fn(&[Point]) -> Vec<Option<LonLat>>) -> Option<Self> {
        let middle = Point::new((x as f64 + 0.5) * SIDE, (y as f64 + 0.5) * SIDE);
        let angle = |k: usize| (k as f64 + 0.5) * std::f64::consts::PI / TERMS as f64;
        let place = |u: f64, v: f64| Point::new(middle.x + u * SIDE / 2.0, middle.y + v * SIDE / 2.0);
        let nodes: Vec<Point> = pairs().map(|(k, l)| place(angle(k).cos(), angle(l).cos())).collect();
        let zero = inverse(&[middle]).pop()??;
        let known: Vec<LonLat> = inverse(&nodes).into_iter().collect::<Option<_>>()?;
        let mut terms = [[[0.0; 2]; TERMS]; TERMS];
        for (i, j) in pairs() {
            let scale = [i, j].map(|order| if order == 0 { 1.0 } else { 2.0 } / TERMS as f64);
            for ((k, l), known) in pairs().zip(&known) {
                let weight = scale[0] * scale[1] * (i as f64 * angle(k)).cos() * (j as f64 * angle(l)).cos();
                terms[i][j][0] += weight * (known.lon - zero.lon);
                terms[i][j][1] += weight * (known.lat - zero.lat);
            }
        }
        let patch = Self { middle, zero, terms };
        // Between the nodes a polynomial errs most at the rim.
        let rim: Vec<Point> = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (0.4, 1.0), (1.0, -0.4), (0.2, 0.3)]
            .map(|(u, v)| place(u, v))
            .to_vec();
        let fits = |(at, told): (&Point, Option<LonLat>)| {
            let (told, own) = (told?, patch.inverse(*at));
            Some((told.lon - own.lon).abs() <= ERROR_MOST && (told.lat - own.lat).abs() <= ERROR_MOST)
        };
        let told = inverse(&rim);
        rim.iter().zip(told).all(|pair| fits(pair) == Some(true)).then_some(patch)
    }

    /// The place of a point of the square.
    pub(super) fn inverse(&self, point: Point) -> LonLat {
        let [u, v] = [point.x - self.middle.x, point.y - self.middle.y].map(|metres| chebyshev(metres * 2.0 / SIDE));
        let (mut lon, mut lat) = (0.0, 0.0);
        for (row, u) in self.terms.iter().zip(u) {
            let (mut east, mut north) = (0.0, 0.0);
            for ([a, b], v) in row.iter().zip(v) {
                east += a * v;
                north += b * v;
            }
            lon += u * east;
            lat += u * north;
        }
        LonLat { lon: self.zero.lon + lon, lat: self.zero.lat + lat }
    }
}

fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..TERMS).flat_map(|i| (0..TERMS).map(move |j| (i, j)))
}

/// The Chebyshev polynomials of a number.
fn chebyshev(x: f64) -> [f64; TERMS] {
    let mut values = [1.0, x, 0.0, 0.0, 0.0, 0.0, 0.0];
    for i in 2..TERMS {
        values[i] = 2.0 * x * values[i - 1] - values[i - 2];
    }
    values
}
