//! The height of the ground at every place beside a road or inside an intersection.

use nalgebra::Matrix2;

use crate::builder::network::Road;
use crate::geometry::{Point, Polyline, Vector};

use super::terrain_profile::TerrainProfile;

/// Largest difference of equal heights, metres.
const LEVEL: f64 = 1e-6;
/// A place this close to a known one, metres, has its height.
const THERE: f64 = 1e-3;
/// Places that deviate from a line by less than this share of its length are collinear.
const ROW: f64 = 1e-3;
/// Heights are rounded to a millimetre.
const PER_METRE: f64 = 1e3;
/// Steepest bound, metres per metre: half as much again as the steepest road, for lanes across an intersection on a slope.
const STEEPEST: f64 = 0.45;

/// Heights of the ground, metres.
#[derive(Clone, Debug)]
pub enum Ground {
    /// The same everywhere.
    Level(f64),
    /// The height of the nearest place of a line.
    Along(Polyline, TerrainProfile),
    /// A plane through places of known height, their heights above it, interpolated by distance, and the lowest and highest of
    /// them as limits.
    Between(Slope, Vec<(Point, f64)>, [f64; 2]),
}

impl Default for Ground {
    fn default() -> Self {
        Self::Level(0.0)
    }
}

impl Ground {
    /// The ground under a road.
    pub fn under(road: &Road) -> Self {
        match level(road.heights.iter().copied()) {
            Some(height) => Self::Level(height),
            None if road.heights.len() != road.line.points().len() => Self::default(),
            None => Self::Along(road.line.clone(), TerrainProfile::under(road)),
        }
    }

    /// The ground between places of known height; level at 0 m if there are none.
    pub fn between(known: Vec<(Point, f64)>) -> Self {
        match level(known.iter().map(|(_, height)| *height)) {
            Some(height) => Self::Level(height),
            None => {
                let slope = Slope::through(&known);
                let heights = || known.iter().map(|(_, height)| *height);
                let range = [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)];
                let above = known.into_iter().map(|(place, height)| (place, height - slope.at(place))).collect();
                Self::Between(slope, above, range)
            }
        }
    }

    /// The height at a place, metres.
    pub fn at(&self, place: Point) -> f64 {
        self.near(place, &mut 0)
    }

    /// As [`Self::at`] for places along a line; `segment` is the segment of the last one.
    fn near(&self, place: Point, segment: &mut usize) -> f64 {
        let height = match self {
            Self::Level(height) => return *height,
            Self::Along(line, profile) => profile.at(line.station_of(place, profile.stations(), segment)),
            Self::Between(slope, above, [low, high]) => (slope.at(place) + between(above, place)).clamp(*low, *high),
        };
        rounded(height)
    }

    /// The heights along a line whose ends have known heights, metres.
    pub fn along(&self, line: &[Point], ends: impl FnOnce() -> [f64; 2]) -> Vec<f64> {
        if let Self::Level(height) = self {
            return vec![*height; line.len()];
        }
        let [first, last] = ends();
        let mut stations = Vec::with_capacity(line.len());
        let mut station = 0.0;
        for (i, place) in line.iter().enumerate() {
            station += if i > 0 { (place - line[i - 1]).norm() } else { 0.0 };
            stations.push(station);
        }
        let last_ix = line.len().saturating_sub(1);
        let mut segment = 0;
        let height = |(i, place): (usize, &Point)| match i {
            0 => first,
            i if i == last_ix => last,
            _ => self.near(*place, &mut segment),
        };
        eased(&stations, line.iter().enumerate().map(height).collect())
    }
}

/// Heights along a line by station, metres, limited to the grade [`STEEPEST`] or that between the ends. The inner side of a bend
/// is much shorter than the middle of the road, and beside a ramp the ground may have a step. The ends stay.
pub fn eased(stations: &[f64], mut heights: Vec<f64>) -> Vec<f64> {
    let [Some(&first), Some(&last)] = [heights.first(), heights.last()] else { return heights };
    let [Some(&from), Some(&to)] = [stations.first(), stations.last()] else { return heights };
    let grade = if to > from { ((last - first).abs() / (to - from)).max(STEEPEST) } else { STEEPEST };
    let climb = |i: usize| grade * (stations[i] - stations[i - 1]);
    let (mut high, mut low) = (heights.clone(), heights.clone());
    for i in 1..heights.len() {
        high[i] = high[i].max(high[i - 1] - climb(i));
        low[i] = low[i].min(low[i - 1] + climb(i));
    }
    for i in (1..heights.len()).rev() {
        high[i - 1] = high[i - 1].max(high[i] - climb(i));
        low[i - 1] = low[i - 1].min(low[i] + climb(i));
    }
    for (i, height) in heights.iter_mut().enumerate() {
        let reach = [(first, stations[i] - from), (last, to - stations[i])].map(|(end, far)| (end, grade * far));
        let least = reach.iter().map(|(end, climb)| end - climb).fold(f64::NEG_INFINITY, f64::max);
        let most = reach.iter().map(|(end, climb)| end + climb).fold(f64::INFINITY, f64::min);
        *height = rounded(f64::midpoint(high[i], low[i]).min(most).max(least));
    }
    heights
}

/// A height rounded to a millimetre.
pub fn rounded(height: f64) -> f64 {
    (height * PER_METRE).round() / PER_METRE
}

/// A plane in space.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    /// A point of it, and its height there, metres.
    middle: Point,
    height: f64,
    /// Metres up per metre east and north.
    rise: Vector,
}

impl Slope {
    /// The plane nearest to all places by least squares; level across collinear places.
    fn through(known: &[(Point, f64)]) -> Self {
        let count = known.len().max(1) as f64;
        let middle = Point::from(known.iter().map(|(place, _)| place.coords).sum::<Vector>() / count);
        let height = known.iter().map(|(_, height)| height).sum::<f64>() / count;
        let (mut spread, mut moment) = (Matrix2::zeros(), Vector::zeros());
        for (place, h) in known {
            let off = place - middle;
            spread += off * off.transpose();
            moment += off * (h - height);
        }
        // If all places are collinear, the slope across their line is unknown.
        spread += Matrix2::identity() * (spread.trace() * ROW);
        Self { middle, height, rise: spread.try_inverse().map_or_else(Vector::zeros, |inverse| inverse * moment) }
    }

    fn at(&self, place: Point) -> f64 {
        self.height + self.rise.dot(&(place - self.middle))
    }
}

/// The common height, metres; 0 if there are none.
fn level(mut heights: impl Iterator<Item = f64>) -> Option<f64> {
    let first = heights.next().unwrap_or_default();
    heights.all(|height| (height - first).abs() < LEVEL).then_some(first)
}

/// Inverse distance weighting (Shepard) with the square of the distance.
fn between(known: &[(Point, f64)], place: Point) -> f64 {
    let (mut weights, mut sum) = (0.0, 0.0);
    for (known, height) in known {
        let far = (place - known).norm();
        if far < THERE {
            return *height;
        }
        let weight = 1.0 / (far * far);
        weights += weight;
        sum += weight * height;
    }
    sum / weights
}
