//! The tagged one-way carriageways of main roads, by place: a carriageway without tagged lanes takes those of its twin, or of the same
//! street nearby.

use rustc_hash::FxHashMap;

use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::geometry::{Point, Polyline, Vector};

/// The two carriageways of a street lie at most this far apart, metres: medians of streets are up to some 30 m wide.
const TWINS: f64 = 40.0;
/// Cosine of the angle, 135 degrees, beyond which two carriageways lead in opposite directions.
const OPPOSITE: f64 = -0.7;
/// The same street nearby lies within this distance, metres, of the middle of a carriageway.
const NEARBY: f64 = 250.0;

/// The one-way carriageways of main roads, by place.
pub(super) struct Carriageways {
    hash: SpatialHash,
    lines: Vec<Polyline>,
}

impl Carriageways {
    /// Sorts them. Lines lead in the direction of travel.
    pub fn new(lines: Vec<Polyline>) -> Self {
        Self { hash: SpatialHash::new(lines.iter().map(Polyline::bounds).collect(), TWINS), lines }
    }

    /// Whether one leads the other way within a distance, metres, of a place where vehicles drive in `direction`.
    pub fn opposite_within(&self, distance: f64, place: Point, direction: Vector) -> bool {
        let around: Bounds = [place - Vector::repeat(distance), place + Vector::repeat(distance)];
        let mut found = false;
        self.hash.touching(around, |i| {
            let Some(line) = self.lines.get(i).filter(|_| !found) else { return };
            let foot = line.project(place);
            found = (foot.point - place).norm() < distance && line.direction(foot.station).dot(&direction) < OPPOSITE;
        });
        found
    }
}

/// A one-way carriageway with tagged lanes.
pub(super) struct Carriageway<'a> {
    /// The index of its way.
    pub way: usize,
    /// The name of its street.
    pub street: &'a str,
    /// Its line, in the direction of travel.
    pub line: Polyline,
}

/// How a carriageway is found beside another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beside {
    /// It leads the other way beside it.
    Twin,
    /// It is another part of the street.
    Nearby,
}

/// All of them, by street and place.
pub(super) struct StreetsNearby<'a> {
    streets: FxHashMap<&'a str, (SpatialHash, Vec<Carriageway<'a>>)>,
}

impl<'a> StreetsNearby<'a> {
    /// Sorts them.
    pub fn new(all: impl Iterator<Item = Carriageway<'a>>) -> Self {
        let mut by_street: FxHashMap<&str, Vec<Carriageway>> = FxHashMap::default();
        all.for_each(|one| by_street.entry(one.street).or_default().push(one));
        let hashed = |(street, all): (&'a str, Vec<Carriageway<'a>>)| {
            let boxes = all.iter().map(|one| one.line.bounds()).collect();
            (street, (SpatialHash::new(boxes, NEARBY), all))
        };
        Self { streets: by_street.into_iter().map(hashed).collect() }
    }

    /// The carriageway from which another of this street takes its lanes, by the index of its way: the nearest twin, else the nearest
    /// one. `middle` and `direction` are those of the other.
    pub fn beside(&self, street: &str, middle: Point, direction: Vector) -> Option<(usize, Beside)> {
        let (hash, all) = self.streets.get(street)?;
        let around: Bounds = [middle - Vector::repeat(NEARBY), middle + Vector::repeat(NEARBY)];
        let mut found: Vec<(Beside, f64, usize)> = Vec::new();
        hash.touching(around, |i| {
            let Some(one) = all.get(i) else { return };
            let foot = one.line.project(middle);
            let distance = (foot.point - middle).norm();
            let opposite = one.line.direction(foot.station).dot(&direction) < OPPOSITE;
            let how = if distance <= TWINS && opposite { Beside::Twin } else { Beside::Nearby };
            if distance <= NEARBY {
                found.push((how, distance, one.way));
            }
        });
        let rank = |it: &(Beside, f64, usize)| (it.0 == Beside::Nearby, it.1);
        found.sort_by(|a, b| {
            let ((a_far, a_by), (b_far, b_by)) = (rank(a), rank(b));
            a_far.cmp(&b_far).then(a_by.total_cmp(&b_by)).then(a.2.cmp(&b.2))
        });
        found.first().map(|(how, _, way)| (*way, *how))
    }
}
