//! A lane before stitching: its middle line and widths, the nodes of its ends, its markings.

use crate::geometry::{Point, Polyline, Vector};

use super::paint::Marking;

/// The id of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaneId {
    /// Its road.
    pub road: i64,
    /// Its number among the lanes of the road.
    pub lane: u32,
}

/// One of the two ends of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LaneEnd {
    /// Where traffic enters.
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

/// Why a lane is not valid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LaneError {
    /// A coordinate that is too large.
    #[error("a point lies at {0}, {1}: no place within {LARGEST:e} m of the origin")]
    Place(f64, f64),
    /// A line without length.
    #[error("all points of a line lie on each other")]
    NoLength,
    /// A width that is too small or too large.
    #[error(
        "the lane reaches {left} m to the left of its middle and {right} m to its right at station {station} m: both must be numbers from 0 on, not both 0, and below {WIDEST} m"
    )]
    Width {
        /// The station on the middle line, metres.
        station: f64,
        /// The width to the left, metres.
        left: f64,
        /// The width to the right, metres.
        right: f64,
    },
    /// No widths.
    #[error("the lane has no width")]
    NoWidth,
    /// Stations that do not ascend.
    #[error("station {1} m follows station {0} m: stations must be numbers and ascend")]
    Order(f64, f64),
}

/// Coordinates are smaller than this, metres: projections reach some 10 000 km.
const LARGEST: f64 = 1e8;
/// The largest width on one side of the middle line, metres.
const WIDEST: f64 = 100.0;

/// The width of a lane on both sides of its middle line, at a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WidthAt {
    /// The station on the middle line, metres.
    pub station: f64,
    /// The width to the left, metres.
    pub left: f64,
    /// The width to the right, metres.
    pub right: f64,
}

/// The widths of a lane: linear between stations, constant before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Widths(Vec<WidthAt>);

impl Widths {
    /// A constant width, metres, half of it on each side.
    ///
    /// # Errors
    ///
    /// The width is too small or too large.
    pub fn even(width: f64) -> Result<Self, LaneError> {
        Self::new(vec![WidthAt { station: 0.0, left: width / 2.0, right: width / 2.0 }])
    }

    /// Widths by station.
    ///
    /// # Errors
    ///
    /// There are no widths, a width is too small or too large, or stations do not ascend.
    pub fn new(widths: Vec<WidthAt>) -> Result<Self, LaneError> {
        let is_valid = |half: f64| (0.0..WIDEST).contains(&half);
        if let Some(&WidthAt { station, left, right }) =
            widths.iter().find(|w| !is_valid(w.left) || !is_valid(w.right) || w.left + w.right == 0.0)
        {
            return Err(LaneError::Width { station, left, right });
        }
        ascending(widths.iter().map(|w| w.station))?;
        if widths.is_empty() { Err(LaneError::NoWidth) } else { Ok(Self(widths)) }
    }

    /// The stations at which the width starts or stops changing.
    pub(super) fn stations(&self) -> impl Iterator<Item = f64> + '_ {
        let changing = if self.0.len() > 1 { &self.0[..] } else { &[] };
        changing.iter().map(|w| w.station)
    }

    /// The widths to the left and to the right at a station, metres.
    pub(super) fn at(&self, station: f64) -> [f64; 2] {
        let next = self.0.partition_point(|w| w.station <= station);
        let [before, after] = [&self.0[next.max(1) - 1], &self.0[next.min(self.0.len() - 1)]];
        let span = after.station - before.station;
        let t = if span > 0.0 { ((station - before.station) / span).clamp(0.0, 1.0) } else { 0.0 };
        [before.left + (after.left - before.left) * t, before.right + (after.right - before.right) * t]
    }
}

/// Checks that stations are numbers and ascend.
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

/// The shape of a lane.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    /// Along a middle line.
    Along(Polyline, Widths),
    /// Between a given left and right bound, in the direction of travel.
    Between([Polyline; 2]),
}

/// The node of a lane end. Ends on the same node meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Node {
    /// A node of the user's graph.
    Known(i64),
    /// A place, in centimetres.
    Place(i64, i64),
}

/// A lane before stitching.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    pub(super) shape: Shape,
    pub(super) nodes: [Option<i64>; 2],
    pub(super) markings: [Vec<Marking>; 2],
}

impl Lane {
    /// A lane along a middle line, in the direction of travel.
    ///
    /// # Errors
    ///
    /// The line has no length or a coordinate that is too large.
    pub fn along(middle: Polyline, widths: Widths) -> Result<Self, LaneError> {
        Ok(Self::of(Shape::Along(checked(middle)?, widths)))
    }

    /// A lane between a left and a right bound, in the direction of travel. The bounds stay as they are: the lane is neither
    /// stitched nor painted.
    ///
    /// # Errors
    ///
    /// A bound has no length or a coordinate that is too large.
    pub fn between([left, right]: [Polyline; 2]) -> Result<Self, LaneError> {
        Ok(Self::of(Shape::Between([checked(left)?, checked(right)?])))
    }

    fn of(shape: Shape) -> Self {
        Self { shape, nodes: [None, None], markings: [Vec::new(), Vec::new()] }
    }

    /// Sets the nodes at the start and the end. An end without a node meets the other ends without a node that lie on the same
    /// centimetre.
    #[must_use]
    pub fn on_nodes(mut self, nodes: [Option<i64>; 2]) -> Self {
        self.nodes = nodes;
        self
    }

    /// Sets the markings along the left and the right bound. Each ends at the station of the next.
    ///
    /// # Errors
    ///
    /// Stations do not ascend.
    pub fn painted(mut self, markings: [Vec<Marking>; 2]) -> Result<Self, LaneError> {
        markings.iter().try_for_each(|side| ascending(side.iter().map(|m| m.station)))?;
        self.markings = markings;
        Ok(self)
    }

    /// Whether its bounds are given.
    pub fn is_explicit(&self) -> bool {
        matches!(self.shape, Shape::Between(_))
    }

    /// The middle of an end.
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

    /// The unit direction of travel at an end; zero for a lane with given bounds.
    pub(super) fn heading(&self, end: LaneEnd) -> Vector {
        let Shape::Along(middle, _) = &self.shape else { return Vector::zeros() };
        let mut segments = middle.segments();
        let segment = if end == LaneEnd::Start { segments.next() } else { segments.next_back() };
        segment.and_then(|(a, b)| (b - a).try_normalize(0.0)).unwrap_or_default()
    }

    pub(super) fn node(&self, end: LaneEnd) -> Node {
        /// Nodes at places are centimetres.
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

/// Checks a line, and merges neighbours that coincide, as in a resampled line that turns back.
fn checked(line: Polyline) -> Result<Polyline, LaneError> {
    let too_large = |p: &&Point| !(p.x.abs() < LARGEST && p.y.abs() < LARGEST);
    match line.points().iter().find(too_large) {
        Some(p) => Err(LaneError::Place(p.x, p.y)),
        None => Polyline::new(line.into_points()).ok_or(LaneError::NoLength),
    }
}
