//! A lane before it is woven: where it runs and how wide it is, where its ends hang, what is painted along it.

use crate::geometry::{Point, Polyline, Vector};

use super::paint::Marking;

/// Names a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaneId {
    /// The road that it belongs to.
    pub road: i64,
    /// Which of that road's lanes it is.
    pub lane: u32,
}

/// One of the two ends of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LaneEnd {
    /// Where traffic comes in.
    Start,
    /// Where it leaves.
    End,
}

impl LaneEnd {
    /// Both, in order of travel.
    pub const BOTH: [Self; 2] = [Self::Start, Self::End];

    pub(super) fn index(self) -> usize {
        match self {
            Self::Start => 0,
            Self::End => 1,
        }
    }
}

/// Why something is no lane.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LaneError {
    /// A coordinate that no place on earth has.
    #[error("a point lies at {0}, {1}: no place within {LARGEST:e} m of the origin")]
    Place(f64, f64),
    /// All points of a line lie on each other.
    #[error("all points of a line lie on each other")]
    NoLength,
    /// A width that no lane has.
    #[error(
        "the lane reaches {left} m to the left of its middle and {right} m to its right at station {station} m: both must be numbers from 0 on, not both 0, and below {WIDEST} m"
    )]
    Width {
        /// Metres along the middle.
        station: f64,
        /// Metres.
        left: f64,
        /// Metres.
        right: f64,
    },
    /// No width at all.
    #[error("the lane has no width")]
    NoWidth,
    /// Stations that do not ascend.
    #[error("station {1} m follows station {0} m: stations must be numbers and ascend")]
    Order(f64, f64),
}

/// Coordinates are smaller than this, metres: projections to the plane reach some 10 000 km.
const LARGEST: f64 = 1e8;
/// No lane reaches farther to either side of its middle, metres.
const WIDEST: f64 = 100.0;

/// How far a lane reaches to both sides of its middle line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WidthAt {
    /// Metres along the middle line.
    pub station: f64,
    /// Metres to the left of it.
    pub left: f64,
    /// Metres to the right of it.
    pub right: f64,
}

/// How wide a lane is all along: evenly changing between stations, and as at the nearest of them beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Widths(Vec<WidthAt>);

impl Widths {
    /// Half of so many metres to either side.
    pub fn even(width: f64) -> Result<Self, LaneError> {
        Self::new(vec![WidthAt { station: 0.0, left: width / 2.0, right: width / 2.0 }])
    }

    /// Widths by station.
    pub fn new(widths: Vec<WidthAt>) -> Result<Self, LaneError> {
        let holds = |half: f64| (0.0..WIDEST).contains(&half);
        if let Some(&WidthAt { station, left, right }) =
            widths.iter().find(|w| !holds(w.left) || !holds(w.right) || w.left + w.right == 0.0)
        {
            return Err(LaneError::Width { station, left, right });
        }
        ascending(widths.iter().map(|w| w.station))?;
        if widths.is_empty() { Err(LaneError::NoWidth) } else { Ok(Self(widths)) }
    }

    /// The stations between the ends where the width begins or ceases to change.
    pub(super) fn stations(&self) -> impl Iterator<Item = f64> + '_ {
        let changing = if self.0.len() > 1 { &self.0[..] } else { &[] };
        changing.iter().map(|w| w.station)
    }

    /// Metres to the left and to the right.
    pub(super) fn at(&self, station: f64) -> [f64; 2] {
        let next = self.0.partition_point(|w| w.station <= station);
        let [before, after] = [&self.0[next.max(1) - 1], &self.0[next.min(self.0.len() - 1)]];
        let span = after.station - before.station;
        let t = if span > 0.0 { ((station - before.station) / span).clamp(0.0, 1.0) } else { 0.0 };
        [before.left + (after.left - before.left) * t, before.right + (after.right - before.right) * t]
    }
}

/// Whether stations are numbers that ascend.
pub(super) fn ascending(stations: impl Iterator<Item = f64>) -> Result<(), LaneError> {
    let mut last = f64::NEG_INFINITY;
    for station in stations {
        if !station.is_finite() || station <= last {
            return Err(LaneError::Order(last, station));
        }
        last = station;
    }
    Ok(())
}

/// Where a lane runs.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    /// Along a middle line.
    Along(Polyline, Widths),
    /// Between bounds that are as they shall be, left and right in its direction of travel.
    Between([Polyline; 2]),
}

/// What an end of a lane hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Node {
    /// A node of the graph that the lane comes from.
    Known(i64),
    /// A place, in centimetres.
    Place(i64, i64),
}

/// A lane as it is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    pub(super) shape: Shape,
    pub(super) nodes: [Option<i64>; 2],
    pub(super) markings: [Vec<Marking>; 2],
}

impl Lane {
    /// A lane along a middle line, in its direction of travel.
    pub fn along(middle: Polyline, widths: Widths) -> Result<Self, LaneError> {
        Ok(Self::of(Shape::Along(on_earth(middle)?, widths)))
    }

    /// A lane between a left and a right bound, in its direction of travel, which shall stay as they are: its ends are
    /// not stitched, and nothing is painted along it.
    pub fn between([left, right]: [Polyline; 2]) -> Result<Self, LaneError> {
        Ok(Self::of(Shape::Between([on_earth(left)?, on_earth(right)?])))
    }

    fn of(shape: Shape) -> Self {
        Self { shape, nodes: [None, None], markings: [Vec::new(), Vec::new()] }
    }

    /// The nodes of a graph that the lane runs from and to. An end without one meets the ends that lie on the same
    /// centimetre and have none either.
    #[must_use]
    pub fn hung_on(mut self, nodes: [Option<i64>; 2]) -> Self {
        self.nodes = nodes;
        self
    }

    /// What is painted along the left and the right bound; each marking holds up to the next one's station.
    pub fn painted(mut self, markings: [Vec<Marking>; 2]) -> Result<Self, LaneError> {
        markings.iter().try_for_each(|side| ascending(side.iter().map(|m| m.station)))?;
        self.markings = markings;
        Ok(self)
    }

    /// Whether its bounds were given.
    pub fn is_explicit(&self) -> bool {
        matches!(self.shape, Shape::Between(_))
    }

    /// Where the middle of an end lies.
    pub(super) fn place(&self, end: LaneEnd) -> Point {
        let of = |line: &Polyline| match end {
            LaneEnd::Start => line.first(),
            LaneEnd::End => line.last(),
        };
        match &self.shape {
            Shape::Along(middle, _) => of(middle),
            Shape::Between([left, right]) => nalgebra::center(&of(left), &of(right)),
        }
    }

    /// The direction of travel at an end; none of a lane whose bounds were given.
    pub(super) fn heading(&self, end: LaneEnd) -> Vector {
        let Shape::Along(middle, _) = &self.shape else { return Vector::zeros() };
        let mut segments = middle.segments();
        let segment = if end == LaneEnd::Start { segments.next() } else { segments.next_back() };
        segment.and_then(|(a, b)| (b - a).try_normalize(0.0)).unwrap_or_default()
    }

    pub(super) fn node(&self, end: LaneEnd) -> Node {
        /// Places to the metre.
        const PER_METRE: f64 = 100.0;
        self.nodes[end.index()].map_or_else(
            || {
                let place = self.place(end) * PER_METRE;
                Node::Place(place.x.round() as i64, place.y.round() as i64)
            },
            Node::Known,
        )
    }
}

/// The line, with no two neighbours on each other, as they can be where it was cut anew at its turn.
fn on_earth(line: Polyline) -> Result<Polyline, LaneError> {
    let beyond = |p: &&Point| !(p.x.abs() < LARGEST && p.y.abs() < LARGEST);
    match line.points().iter().find(beyond) {
        Some(p) => Err(LaneError::Place(p.x, p.y)),
        None => Polyline::new(line.into_points()).ok_or(LaneError::NoLength),
    }
}
