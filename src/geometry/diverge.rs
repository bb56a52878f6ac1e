//! Lines that leave one point in nearly the same direction: one is changed so that it does not run over the other before both
//! diverge.

use super::{Point, Polyline, Vector, angle_between, cross};

/// Lines whose first steps differ by a larger angle, degrees, diverge at once.
const MAX_START_ANGLE: f64 = 20.0;
/// How much of an overlap is removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// The distance between two lines, metres, from which on they have diverged.
    diverged: f64,
    /// The largest overlap, metres, that is removed. A line with a larger one crosses the other on purpose.
    overlap: f64,
    /// The length, metres, within which vertices may be left out behind the place where the line leaves the other.
    skip: f64,
    /// The largest change of direction, degrees, where the line leaves the other.
    bend: f64,
    /// The side of the other line on which the line belongs, 1 left, -1 right; `None` where only the lines themselves tell.
    side: Option<f64>,
}

impl Room {
    /// For any two lines.
    pub const USUAL: Self = Self { diverged: 0.3, overlap: 0.1, skip: 0.5, bend: 10.0, side: None };

    /// For the lines between two lanes that part, of which this one belongs to the left or the right lane: neither lane may lie on
    /// the other, though it becomes narrower.
    pub const fn parting(left: bool) -> Self {
        Self { diverged: 1.2, overlap: 1.0, skip: 5.0, bend: 30.0, side: Some(if left { 1.0 } else { -1.0 }) }
    }
}
/// The distance between places where two lines are compared, metres.
const COMPARED_EVERY: f64 = 0.25;
/// The smallest radius, metres, of the bends where the line leaves the other, if leaving out a vertex helps.
const MIN_RADIUS: f64 = 1.5;
/// An overlap below this, metres, is none: it is less than the last digit of a coordinate.
const EXACT: f64 = 1e-6;

/// A line with the stations of its vertices.
#[derive(Clone, Debug)]
pub struct Measured {
    line: Polyline,
    stations: Vec<f64>,
}

impl Measured {
    /// A line through these points; `None` if fewer than two distinct points are left.
    pub fn new(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        Polyline::new(points).map(|line| Self { stations: line.stations(), line })
    }

    fn length(&self) -> f64 {
        self.stations[self.stations.len() - 1]
    }

    /// The point at a station. `segment` is the segment of an earlier station and becomes that of this one.
    fn at(&self, station: f64, segment: &mut usize) -> Point {
        while *segment + 2 < self.stations.len() && self.stations[*segment + 1] < station {
            *segment += 1;
        }
        let [a, b] = [self.line.points()[*segment], self.line.points()[*segment + 1]];
        let [from, to] = [self.stations[*segment], self.stations[*segment + 1]];
        a + (b - a) * ((station - from) / (to - from)).min(1.0)
    }

    /// The vertices with their stations.
    fn vertices(&self) -> impl Iterator<Item = (Point, f64)> {
        self.line.points().iter().copied().zip(self.stations.iter().copied())
    }
}

/// The line, which starts where `other` starts, changed so that it stays on the side of it to which it diverges: where it
/// overlaps the other slightly, it follows the vertices of the other. `None` if the line stays as it is.
pub fn diverge(line: &Measured, other: &Measured, room: Room) -> Option<Vec<Point>> {
    let steps = [line, other].map(|l| l.line.at(COMPARED_EVERY.min(l.length())) - l.line.first());
    if steps[0].dot(&steps[1]) < MAX_START_ANGLE.to_radians().cos() * steps[0].norm() * steps[1].norm() {
        return None;
    }
    let overlap = Walk::new(line, other, room)?.overlap(room)?;
    overlap.removed(line, other, room)
}

/// A comparison of two lines from their common start to where they have diverged.
#[derive(Default)]
struct Walk {
    foot: Foot,
    /// For a line that diverges to the left and to the right: the last station of the other line at which it overlaps it, and
    /// the first station of its own behind that.
    overlaps: [Option<(f64, Option<f64>)>; 2],
    /// The smallest and the largest offset of the line from the other, metres, left positive.
    offsets: [f64; 2],
}

impl Walk {
    /// `None` if one line ends before both have diverged and it is not known on which side of the other the line belongs.
    fn new(line: &Measured, other: &Measured, room: Room) -> Option<Self> {
        let mut walk = Self::default();
        let mut segment = 0;
        for station in merged(&line.stations[1..], line.length().min(other.length())) {
            walk.foot = walk.foot.next(other, line.at(station, &mut segment));
            if walk.foot.station >= other.length() - EXACT {
                return room.side.map(|_| walk);
            }
            walk.record(station);
            let offset = walk.foot.offset;
            if room.side.map_or(offset.abs(), |side| offset * side) > room.diverged {
                return Some(walk);
            }
        }
        room.side.map(|_| walk)
    }

    /// Records the foot of a station of the line.
    fn record(&mut self, station: f64) {
        let foot = self.foot;
        self.offsets = [self.offsets[0].min(foot.offset), self.offsets[1].max(foot.offset)];
        for (overlap, left) in self.overlaps.iter_mut().zip([foot.offset, -foot.offset]) {
            match overlap {
                _ if left < -EXACT => *overlap = Some((foot.station, None)),
                Some((_, behind)) => *behind = behind.or(Some(station)),
                None => {}
            }
        }
    }

    /// The overlap to remove.
    fn overlap(&self, room: Room) -> Option<Overlap> {
        let side = room.side.unwrap_or(self.foot.offset.signum());
        let (overlap, depth) = match side > 0.0 {
            true => (self.overlaps[0], -self.offsets[0]),
            false => (self.overlaps[1], self.offsets[1]),
        };
        let (leaves, behind) = overlap?;
        let rejoins = behind.filter(|_| depth <= room.overlap)?;
        Some(Overlap { side, leaves, rejoins })
    }
}

/// The part of a line that overlaps another line.
struct Overlap {
    /// The side of the other line to which the line diverges: 1 left, -1 right.
    side: f64,
    /// The station of the other line at which the overlap ends.
    leaves: f64,
    /// The first station of the line behind the overlap.
    rejoins: f64,
}

impl Overlap {
    /// The line without the overlap; `None` if it would cross the other line, or bend too much.
    fn removed(&self, line: &Measured, other: &Measured, room: Room) -> Option<Vec<Point>> {
        // A step past a bend of the other line so near ahead would cut the bend off.
        let near = |s: &f64| (self.leaves..self.leaves + COMPARED_EVERY).contains(s);
        let leaves = other.stations.iter().copied().find(near).unwrap_or(self.leaves);
        let leaving = other.line.at(leaves);
        let mut points: Vec<Point> = other.vertices().take_while(|(_, s)| *s <= leaves).map(|(p, _)| p).collect();
        if points.last().is_some_and(|p| (p - leaving).norm() > COMPARED_EVERY) {
            points.push(leaving);
        }
        let direction = other.line.direction(leaves);
        let sharp = |p: Point, station: f64| {
            let bends = [(direction, p - leaving), (p - leaving, line.line.direction(station))];
            bends.map(|(a, b)| angle_between(a, b).abs()).iter().sum::<f64>() * MIN_RADIUS > (p - leaving).norm()
        };
        let mut rest = line.vertices().filter(|(_, s)| *s >= self.rejoins - EXACT).peekable();
        let turns_off = |step: Vector| angle_between(direction, step).abs() > room.bend.to_radians();
        let skipped = |&(p, s): &(Point, f64)| {
            let step = p - leaving;
            s < self.rejoins + room.skip && (self.crosses(other, leaving, step) || turns_off(step) || sharp(p, s))
        };
        while rest.next_if(skipped).is_some() {}
        let step = rest.peek()?.0 - leaving;
        if self.crosses(other, leaving, step) || turns_off(step) {
            return None;
        }
        points.extend(rest.map(|(p, _)| p));
        (points.last() == Some(&line.line.last())).then_some(points)
    }

    /// Whether a straight step from a point of the other line crosses a bend of it.
    fn crosses(&self, other: &Measured, from: Point, step: Vector) -> bool {
        [0.25, 0.5, 0.75].iter().any(|t| other.line.project(from + step * *t).offset * self.side < -EXACT)
    }
}

/// The stations of vertices and of every step below `last`, ascending.
fn merged(vertices: &[f64], last: f64) -> impl Iterator<Item = f64> {
    let mut vertices = vertices.iter().copied().peekable();
    let mut steps = (1..).map(|i| COMPARED_EVERY * f64::from(i)).take_while(move |&s| s < last).peekable();
    std::iter::from_fn(move || match (vertices.peek(), steps.peek()) {
        (Some(vertex), Some(step)) if step < vertex => steps.next(),
        (Some(_), _) => vertices.next(),
        _ => steps.next(),
    })
}

/// The nearest place on a line to a place of another line.
#[derive(Clone, Copy, Default)]
struct Foot {
    segment: usize,
    station: f64,
    /// Metres, left positive.
    offset: f64,
}

impl Foot {
    /// The foot of the next place, not before this one. Segments so far ahead that the line would have to turn back to come
    /// near are not searched.
    fn next(self, line: &Measured, place: Point) -> Self {
        let stations = &line.stations;
        let mut best = (f64::INFINITY, self);
        for (segment, pair) in line.line.points().windows(2).enumerate().skip(self.segment) {
            let (a, along) = (pair[0], pair[1] - pair[0]);
            if stations[segment] > best.1.station + 2.0 * best.1.offset.abs() + COMPARED_EVERY {
                break;
            }
            let t = ((place - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            let square = (place - (a + along * t)).norm_squared();
            if square < best.0 {
                let offset = square.sqrt().copysign(cross(along, place - a));
                let station = stations[segment] + t * (stations[segment + 1] - stations[segment]);
                best = (square, Self { segment, station, offset });
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[(f64, f64)]) -> Polyline {
        Polyline::new(points.iter().map(|&(x, y)| Point::new(x, y))).unwrap()
    }

    fn diverge(line: &Polyline, other: &Polyline) -> Option<Vec<Point>> {
        let [line, other] = [line, other].map(|line| Measured::new(line.points().iter().copied()).unwrap());
        super::diverge(&line, &other, Room::USUAL)
    }

    /// A quarter of a circle to the left.
    fn turn(radius: f64) -> Polyline {
        let at = |i: i32| {
            let angle = f64::from(i * 5).to_radians();
            Point::new(radius * angle.sin(), radius * (1.0 - angle.cos()))
        };
        Polyline::new((0..=18).map(at)).unwrap()
    }

    fn mirrored(line: &Polyline) -> Polyline {
        Polyline::new(line.points().iter().map(|p| Point::new(p.x, -p.y))).unwrap()
    }

    /// The largest distance, metres, of a line to the right of another before they diverge.
    fn overlap(line: &[Point], other: &Polyline) -> f64 {
        let line = Polyline::new(line.iter().copied()).unwrap();
        let offsets = line.resampled(0.05).into_points().into_iter().map(|p| other.project(p).offset);
        -offsets.take_while(|o| *o < Room::USUAL.diverged).fold(0.0, f64::min)
    }

    #[test]
    fn a_line_that_overlaps_its_neighbour_slightly_follows_it() {
        // The other line bends slightly to the left; the left turn begins straight on.
        let straight = line(&[(0.0, 0.0), (30.0, 2.7)]);
        let bent = diverge(&turn(8.0), &straight).unwrap();
        assert!(overlap(&bent, &straight) < 1e-6);
        assert!(overlap(turn(8.0).points(), &straight) > 1e-3, "as it was");
        assert_eq!(bent.last(), Some(&turn(8.0).last()));
        let mirror_image = diverge(&mirrored(&turn(8.0)), &mirrored(&straight)).unwrap();
        assert_eq!(mirror_image, bent.iter().map(|p| Point::new(p.x, -p.y)).collect::<Vec<_>>());
        // The same with the roles exchanged.
        let bent = diverge(&straight, &turn(8.0)).unwrap();
        let turn = mirrored(&turn(8.0));
        let bent: Vec<Point> = bent.iter().map(|p| Point::new(p.x, -p.y)).collect();
        assert!(overlap(&bent, &turn) < 1e-6);
    }

    #[test]
    fn lines_that_diverge_at_once_or_swing_out_stay() {
        let straight = line(&[(0.0, 0.0), (30.0, 0.0)]);
        assert_eq!(diverge(&turn(8.0), &straight), None);
        let swings = line(&[(0.0, 0.0), (2.0, -0.3), (4.0, -0.4), (8.0, 2.0)]);
        assert_eq!(diverge(&swings, &straight), None);
        // Two lanes that part may not lie on each other.
        let swings = line(&[(0.0, 0.0), (3.0, -0.15), (6.0, -0.25), (9.0, -0.05), (12.0, 0.4), (15.0, 1.2)]);
        assert_eq!(diverge(&swings, &straight), None);
        let [own, other] = [&swings, &straight].map(|line| Measured::new(line.points().iter().copied()).unwrap());
        assert!(overlap(&super::diverge(&own, &other, Room::parting(true)).unwrap(), &straight) < 1e-6);
        assert_eq!(diverge(&line(&[(0.0, 0.0), (0.0, 9.0)]), &straight), None);
    }

    #[test]
    fn a_line_leaves_another_behind_the_bend_that_is_next() {
        // The overlap ends a few centimetres before a bend to the right.
        for bend in [5.02, 5.1, 5.2] {
            let other = line(&[(0.0, 0.0), (bend, 0.0), (25.0, -1.6)]);
            let own = line(&[(0.0, 0.0), (4.9, -0.05), (5.0, 0.0), (30.0, -0.5)]);
            let bent = diverge(&own, &other).unwrap();
            assert!(overlap(&bent, &other) < 1e-6, "{bend}: {bent:?}");
        }
    }
}
