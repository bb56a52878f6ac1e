//! Explicit centre lines of lanelets, and how their ends meet the lanes before and after.

use crate::diagnostic::Edit;
use crate::geometry::{Point, Polyline, Vector, angle_between};
use crate::lanelet::index::{HEADING_REACH, MapIndex};
use crate::lanelet::{LaneletMap, LineStringId, PointId};

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

/// An end of a centre line moves no farther (m) than this: a line that ends elsewhere was drawn so.
const FARTHEST: f64 = 0.5;
/// A line may bend more than before by this angle (deg) where its end is moved: so much is within what is measured.
const MORE_BEND: f64 = 1.0;

/// The edit that puts the end of a centre line onto an edge of its lanelet, at the nearest place: where across the lane the line runs is
/// its drawer's matter. `None` if that moves it far or bends it more.
pub fn moved_onto(map: &LaneletMap, line: LineStringId, end: PointId, edge: [PointId; 2]) -> Option<Edit> {
    let place = |id| map.points.get(id).map(|point| point.position);
    let (left, right, at) = (place(edge[0])?, place(edge[1])?, place(end)?);
    let along = right - left;
    let share = ((at - left).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    put(map, line, end, edge, share)
}

/// The edit that puts the end of a centre line into the middle of an edge; `None` if that moves it far or bends it more.
pub fn centred(map: &LaneletMap, line: LineStringId, end: PointId, edge: [PointId; 2]) -> Option<Edit> {
    put(map, line, end, edge, 0.5)
}

fn put(map: &LaneletMap, line: LineStringId, end: PointId, edge: [PointId; 2], share: f64) -> Option<Edit> {
    let place = |id| map.points.get(id).map(|point| point.position);
    let (left, right) = (place(edge[0])?, place(edge[1])?);
    let to = left + (right - left) * share;
    let points: Vec<PointId> = map.linestrings.get(line)?.points.clone();
    let before: Vec<Point> = points.iter().filter_map(|&id| place(id)).collect();
    let after: Vec<Point> = points.iter().filter_map(|&id| if id == end { Some(to) } else { place(id) }).collect();
    let is_smooth = sharpest(&after) <= sharpest(&before) + MORE_BEND;
    let edit = Edit::PlaceBetween { point: end.0, from: edge[0].0, to: edge[1].0, share };
    ((to - place(end)?).norm() <= FARTHEST && is_smooth).then_some(edit)
}

/// The sharpest bend at a vertex, degrees.
fn sharpest(points: &[Point]) -> f64 {
    let bends = points.windows(3).filter_map(|three| match three {
        [a, b, c] => Some(angle_between(b - a, c - b).abs().to_degrees()).filter(|bend| bend.is_finite()),
        _ => None,
    });
    bends.fold(0.0, f64::max)
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
