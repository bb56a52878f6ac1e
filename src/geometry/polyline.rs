//! A line of points. A station is a distance along it from its first point, metres.

use super::separation::are_apart;
use super::spatial_hash::Bounds;
use super::{Point, Vector, left_of};

/// Two or more points. Neighbours are farther apart than [`Polyline::MERGE`].
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    points: Vec<Point>,
}

/// The nearest place on a line to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Distance along the line, metres.
    pub station: f64,
    /// Signed distance, metres: positive to the left of the line.
    pub offset: f64,
    /// The place on the line.
    pub point: Point,
    /// The index of its segment.
    pub segment: usize,
}

impl Polyline {
    /// Points closer together than this, metres, become one.
    pub const MERGE: f64 = 1e-6;

    /// The largest number of pieces into which a line is cut: a line with more has a wrong coordinate.
    pub const MOST_PIECES: f64 = 10_000.0;

    /// A line through these points; `None` if fewer than two distinct points are left.
    pub fn new(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        let mut points: Vec<Point> = points.into_iter().collect();
        let distinct = |p: &Point, last: &Point| (p - last).norm_squared() > Self::MERGE * Self::MERGE;
        points.dedup_by(|p, last| !distinct(p, last));
        (points.len() >= 2).then_some(Self { points })
    }

    /// Takes the points out.
    pub fn into_points(self) -> Vec<Point> {
        self.points
    }

    /// The points.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The first point.
    pub fn first(&self) -> Point {
        self.points[0]
    }

    /// The last point.
    pub fn last(&self) -> Point {
        self.points[self.points.len() - 1]
    }

    /// The bounding box.
    pub fn bounds(&self) -> Bounds {
        self.points.iter().fold([self.points[0]; 2], |[low, high], p| [low.inf(p), high.sup(p)])
    }

    /// Its length in metres.
    pub fn length(&self) -> f64 {
        self.segments().map(|(a, b)| (b - a).norm()).sum()
    }

    /// The segments in order.
    pub fn segments(&self) -> impl DoubleEndedIterator<Item = (Point, Point)> + ExactSizeIterator + '_ {
        self.points.windows(2).map(|w| (w[0], w[1]))
    }

    /// The same line from its last point to its first.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { points: self.points.iter().rev().copied().collect() }
    }

    /// The point at `station`, metres, clamped to the ends.
    pub fn at(&self, station: f64) -> Point {
        self.locate(station).0
    }

    /// The unit direction at `station`, metres; at a vertex, that of the segment after it.
    pub fn direction(&self, station: f64) -> Vector {
        let segment = self.locate(station).1;
        (self.points[segment + 1] - self.points[segment]).normalize()
    }

    /// Point and segment index at `station`.
    fn locate(&self, station: f64) -> (Point, usize) {
        let mut rest = station.max(0.0);
        let last = self.points.len() - 2;
        for (i, (a, b)) in self.segments().enumerate() {
            let length = (b - a).norm();
            if rest < length || i == last {
                let t = (rest / length).min(1.0);
                return (a + (b - a) * t, i);
            }
            rest -= length;
        }
        (self.last(), last)
    }

    /// The stations of all points, metres.
    pub fn stations(&self) -> Vec<f64> {
        stations(&self.points)
    }

    /// The part between two stations, metres, clamped to the ends; `None` if it is empty.
    pub fn cut(&self, from: f64, to: f64) -> Option<Self> {
        let from = from.max(0.0);
        let mut points = vec![self.at(from)];
        let mut station = 0.0;
        for (a, b) in self.segments() {
            station += (b - a).norm();
            if station >= to {
                break;
            }
            if station > from {
                points.push(b);
            }
        }
        if station < to {
            // The line ends before `to`: the end is added below.
            points.pop();
        }
        let to = to.min(station);
        if to - from <= Self::MERGE {
            return None;
        }
        points.push(self.at(to));
        Self::new(points)
    }

    /// The nearest place on the line to `p`.
    pub fn project(&self, p: Point) -> Projection {
        let (segment, t, square) = self.nearest(p);
        let (a, b) = (self.points[segment], self.points[segment + 1]);
        let before: f64 = self.segments().take(segment).map(|(a, b)| (b - a).norm()).sum();
        let side = super::cross(b - a, p - a);
        let offset = if side < 0.0 { -square.sqrt() } else { square.sqrt() };
        Projection { station: before + t * (b - a).norm(), offset, point: a + (b - a) * t, segment }
    }

    /// The station of [`Polyline::project`], metres. `stations` are those of the points. `hint` is a segment near `p` and
    /// becomes the nearest segment.
    pub fn station_of(&self, p: Point, stations: &[f64], hint: &mut usize) -> f64 {
        self.station_and_distance(p, stations, hint).0
    }

    /// The station of [`Polyline::station_of`], and how far the line is from `p`, metres.
    pub fn station_and_distance(&self, p: Point, stations: &[f64], hint: &mut usize) -> (f64, f64) {
        let on = |i: usize| {
            let (a, b) = (self.points[i], self.points[i + 1]);
            let d = b - a;
            let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
            (stations[i] + t * d.norm(), (p - (a + d * t)).norm_squared())
        };
        let near = on((*hint).min(self.points.len() - 2)).1.sqrt() + Self::MERGE;
        let mut best = (0.0, f64::INFINITY);
        let mut i = 0;
        while i + 1 < self.points.len() {
            // A vertex at this distance from `p` cannot reach it with segments that end before this station.
            let far = stations[i] + (p - self.points[i]).norm() - near;
            if stations[i + 1] > far {
                let (station, square) = on(i);
                if square < best.1 {
                    (best, *hint) = ((station, square), i);
                }
            }
            i += 1;
            if stations.get(i + 1).is_some_and(|end| *end <= far) {
                i += stations[i + 1..].partition_point(|end| *end <= far);
            }
        }
        (best.0, best.1.sqrt())
    }

    /// The nearest segment to `p`, the parameter on it (0 to 1), and the square of the distance.
    fn nearest(&self, p: Point) -> (usize, f64, f64) {
        let mut best = (0, 0.0, f64::INFINITY);
        for (segment, (a, b)) in self.segments().enumerate() {
            let d = b - a;
            let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
            let square = (p - (a + d * t)).norm_squared();
            if square < best.2 {
                best = (segment, t, square);
            }
        }
        best
    }

    /// Distance to `p` in metres.
    pub fn distance(&self, p: Point) -> f64 {
        self.nearest(p).2.sqrt()
    }

    /// See [`reaches()`].
    pub fn reaches(&self, p: Point, distance: f64, hint: &mut usize) -> bool {
        reaches(&self.points, p, distance, hint)
    }

    /// The line moved sideways by `offset` metres, left positive. Corners are mitred up to `miter_limit` times the offset, and
    /// bevelled beyond. It may cross itself in bends tighter than the offset.
    pub fn offset(&self, offset: f64, miter_limit: f64) -> Option<Self> {
        let mut normals = self.segments().map(|(a, b)| left_of((b - a).normalize()));
        let mut before = normals.next()?;
        let mut points = Vec::with_capacity(self.points.len() + 1);
        points.push(self.first() + before * offset);
        for (normal, corner) in normals.zip(&self.points[1..]) {
            // The miter point lies on the bisector of the normals, at the offset divided by the cosine of half the turn.
            let bisector = before + normal;
            let cosine = bisector.norm() / 2.0;
            if cosine * miter_limit >= 1.0 {
                points.push(corner + bisector * (offset / (2.0 * cosine * cosine)));
            } else {
                points.extend([corner + before * offset, corner + normal * offset]);
            }
            before = normal;
        }
        points.push(self.last() + before * offset);
        Self::new(points)
    }

    /// The line simplified to within `distance` metres (Douglas and Peucker). A ring smaller than that stays as it is.
    #[must_use]
    pub fn straightened(&self, distance: f64) -> Self {
        let points = &self.points;
        let mut keep = vec![false; points.len()];
        // A list instead of recursion, which wrong data could nest too deep.
        let mut open = vec![(0, points.len() - 1)];
        while let Some((a, b)) = open.pop() {
            keep[a] = true;
            keep[b] = true;
            let farthest = (a + 1..b)
                .map(|i| (i, distance_to_segment(points[i], points[a], points[b])))
                .max_by(|x, y| x.1.total_cmp(&y.1));
            if let Some((i, from)) = farthest
                && from > distance
            {
                open.extend([(a, i), (i, b)]);
            }
        }
        let kept = points.iter().zip(keep).filter_map(|(p, keep)| keep.then_some(*p));
        Self::new(kept).unwrap_or_else(|| self.clone())
    }

    /// Points at most `step` metres apart, evenly spread from end to end; vertices need not stay. There are at most
    /// [`Polyline::MOST_PIECES`] pieces.
    #[must_use]
    pub fn resampled(&self, step: f64) -> Self {
        Self { points: self.places(step).collect() }
    }

    /// The points of [`Polyline::resampled`], each found when it is asked for.
    pub fn places(&self, step: f64) -> impl ExactSizeIterator<Item = Point> + '_ {
        let length = self.length();
        let pieces = (length / step).ceil().clamp(1.0, Self::MOST_PIECES) as usize;
        let end_of = |segment: usize, start: f64| start + (self.points[segment + 1] - self.points[segment]).norm();
        let (mut segment, mut start, mut end) = (0, 0.0, end_of(0, 0.0));
        (0..pieces + 1).map(move |i| {
            if i == 0 || i == pieces {
                return if i == 0 { self.first() } else { self.last() };
            }
            let station = length * i as f64 / pieces as f64;
            while segment + 2 < self.points.len() && end < station {
                segment += 1;
                (start, end) = (end, end_of(segment, end));
            }
            let (a, b) = (self.points[segment], self.points[segment + 1]);
            a + (b - a) * ((station - start) / (end - start)).clamp(0.0, 1.0)
        })
    }

    /// The points at ascending stations, metres, clamped to the ends.
    pub fn at_each(&self, stations: impl IntoIterator<Item = f64>) -> Vec<Point> {
        self.walk(&self.stations(), stations.into_iter())
    }

    /// The points at ascending `stations`. `marks` are the stations of the vertices.
    fn walk(&self, marks: &[f64], stations: impl Iterator<Item = f64>) -> Vec<Point> {
        let mut segment = 0;
        let point = |s: f64| {
            while segment + 2 < marks.len() && marks[segment + 1] < s {
                segment += 1;
            }
            let (a, b) = (self.points[segment], self.points[segment + 1]);
            let t = ((s - marks[segment]) / (marks[segment + 1] - marks[segment])).clamp(0.0, 1.0);
            a + (b - a) * t
        };
        stations.map(point).collect()
    }

    /// `count` points (at least two), evenly spread from end to end; vertices need not stay.
    #[must_use]
    pub fn resampled_to(&self, count: usize) -> Self {
        self.spread(&self.stations(), count)
    }

    /// [`Polyline::resampled_to`]. `stations` are those of the points.
    #[must_use]
    pub fn spread(&self, stations: &[f64], count: usize) -> Self {
        let pieces = count.max(2) - 1;
        let length = stations[stations.len() - 1];
        let mut points = self.walk(stations, (0..=pieces).map(|i| length * i as f64 / pieces as f64));
        points[0] = self.first();
        points[pieces] = self.last();
        Self { points }
    }
}

/// Distance of a point from a segment, metres.
pub fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let part = if along.norm() > Polyline::MERGE { (p - a).dot(&along) / along.norm_squared() } else { 0.0 };
    (p - (a + along * part.clamp(0.0, 1.0))).norm()
}

/// The stations of all points, metres.
fn stations(line: &[Point]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut stations = Vec::with_capacity(line.len());
    stations.push(sum);
    for w in line.windows(2) {
        sum += (w[1] - w[0]).norm();
        stations.push(sum);
    }
    stations
}

/// Whether all vertices of each line are at least this far, metres, from the other line.
pub fn clear(a: &[Point], b: &[Point], distance: f64) -> bool {
    are_apart(a, b, distance) || all_clear(a, b, distance) && all_clear(b, a, distance)
}

/// Whether a line is at least this far, metres, from all places.
pub fn clears(line: &[Point], places: &[Point], distance: f64) -> bool {
    are_apart(places, line, distance) || all_clear(line, places, distance)
}

/// [`clears`] without the quick test of [`are_apart`].
pub fn all_clear(line: &[Point], places: &[Point], distance: f64) -> bool {
    let stations = stations(line);
    places.iter().all(|&p| {
        let mut i = 0;
        while i + 1 < stations.len() {
            let segment = (line[i], line[i + 1]);
            if within(segment, p, distance).is_some_and(|from| from < distance) {
                return false;
            }
            i += 1;
            // Segments that end before this station are too far from the place.
            let clear = stations[i] + (p - segment.1).norm() - distance - Polyline::MERGE;
            while stations.get(i + 1).is_some_and(|end| *end <= clear) {
                i += 1;
            }
        }
        true
    })
}

/// Whether a line comes within `distance` metres of `p`. The segments around `hint` are tried first; it becomes the one found.
pub fn reaches(line: &[Point], p: Point, distance: f64, hint: &mut usize) -> bool {
    let close = |i: &usize| within((line[*i], line[i + 1]), p, distance).is_some_and(|from| from <= distance);
    let count = line.len().max(1) - 1;
    let around = [*hint, *hint + 1, hint.wrapping_sub(1)].into_iter().filter(|i| *i < count);
    let found = around.chain(0..count).find(close);
    *hint = found.unwrap_or(*hint);
    found.is_some()
}

/// The distance of `p` from a segment, metres; `None` if it is farther than `distance` from the bounding box.
pub fn within((a, b): (Point, Point), p: Point, distance: f64) -> Option<f64> {
    let beyond = |p: f64, a: f64, b: f64| p < a.min(b) - distance || p > a.max(b) + distance;
    if beyond(p.x, a.x, b.x) || beyond(p.y, a.y, b.y) {
        return None;
    }
    let d = b - a;
    let nearest = a + d * ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
    Some((p - nearest).norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straightened_drops_points_near_the_chord() {
        let line = |points: &[(f64, f64)]| Polyline::new(points.iter().map(|(x, y)| Point::new(*x, *y))).unwrap();
        let drawn = line(&[(0.0, 0.0), (4.0, 0.0009), (8.0, 0.0), (12.0, 0.01), (16.0, 0.0), (16.0, 4.0)]);
        let expected = line(&[(0.0, 0.0), (8.0, 0.0), (12.0, 0.01), (16.0, 0.0), (16.0, 4.0)]);
        assert_eq!(drawn.straightened(0.001), expected);
        assert_eq!(expected.straightened(0.001), expected);
        let there_and_back = line(&[(0.0, 0.0), (8.0, 0.0), (4.0, 0.0)]);
        assert_eq!(there_and_back.straightened(0.001), there_and_back);
        let ring = line(&[(0.0, 0.0), (0.01, 0.0), (0.0, 0.01), (0.0, 0.0)]);
        assert_eq!(ring.straightened(0.03), ring);
    }

    #[test]
    fn a_line_around_the_world_costs_no_memory() {
        let line = Polyline::new([Point::new(0.0, 0.0), Point::new(1e300, 0.0)]).unwrap();
        assert_eq!(line.resampled(1.0).points().len(), 10_001);
        let short = Polyline::new([Point::new(0.0, 0.0), Point::new(2.0, 0.0), Point::new(2.0, 2.0)]).unwrap();
        let places = [-1.0, 0.5, 2.0, 2.0, 3.0, 9.0];
        assert_eq!(short.at_each(places), places.map(|at| short.at(at)).to_vec());
    }
}
