//! Explicit centre lines of lanelets, and how their ends meet the lanes before and after.

use crate::diagnostic::Edit;
use crate::geometry::{Point, Polyline, Vector, angle_between};
use crate::lanelet::index::{HEADING_REACH, MapIndex};
use crate::lanelet::{LineStringId, PointId};

/// An explicit centre line.
#[derive(Clone, Debug)]
pub struct OwnCenterline {
    /// Its way.
    pub way: LineStringId,
    /// Its course.
    pub line: Polyline,
    /// Its end points.
    pub ends: [PointId; 2],
}

/// Either end of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Where it begins.
    Start,
    /// Where it stops.
    Stop,
}

impl OwnCenterline {
    /// The centre line of a lane, if it has one that runs from edge to edge; vm-01-10 reports the others. `edge` is the largest
    /// distance (m) of its ends from the edges.
    pub fn of(map: &MapIndex, lane: usize, edge: f64) -> Option<Self> {
        let at = &map.lanes[lane];
        let way = map.map.linestrings.get(at.lanelet.centerline?)?;
        let places = map.map.points.get_each(way.points.iter().copied()).map(|point| point.position);
        let line = Polyline::new(places.filter(|p| p.x.is_finite() && p.y.is_finite()))?;
        let on =
            |p: Point, [a, b]: [Point; 2]| Polyline::new([a, b]).is_some_and(|edge_line| edge_line.distance(p) <= edge);
        let whole = on(line.first(), at.start.points) && on(line.last(), at.end.points);
        let ends = [*way.points.first()?, *way.points.last()?];
        whole.then_some(Self { way: way.id, line, ends })
    }

    /// Where one of its ends lies.
    pub fn place(&self, end: End) -> Point {
        match end {
            End::Start => self.line.first(),
            End::Stop => self.line.last(),
        }
    }

    /// Its heading there.
    pub fn heading(&self, end: End) -> Option<Vector> {
        heading(&self.line, end)
    }
}

/// The edit that puts the end of a centre line into the middle between the two points of an edge.
pub fn centred(point: PointId, edge: [PointId; 2]) -> Edit {
    Edit::PlaceBetween { point: point.0, from: edge[0].0, to: edge[1].0, share: 0.5 }
}

/// The heading of a line over its first or last metres.
pub fn heading(line: &Polyline, end: End) -> Option<Vector> {
    let length = line.length();
    let part = match end {
        End::Start => line.cut(0.0, HEADING_REACH),
        End::Stop => line.cut(length - HEADING_REACH, length),
    }?;
    (part.last() - part.first()).try_normalize(Polyline::MERGE)
}

/// The angle between two headings, degrees.
pub fn bend(a: Option<Vector>, b: Option<Vector>) -> Option<f64> {
    Some(angle_between(a?, b?).abs().to_degrees())
}

/// The bend (deg) between the middles of two consecutive lanes: no centre line can be smoother than its lane.
pub fn lane_bend(map: &MapIndex, first: usize, second: usize) -> f64 {
    let middle = |lane: usize, end| map.lanes[lane].center.as_ref().and_then(|center| heading(center, end));
    bend(middle(first, End::Stop), middle(second, End::Start)).unwrap_or(0.0)
}
