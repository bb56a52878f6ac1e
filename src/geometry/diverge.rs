//! Lines that leave one point side by side: they part without one running over the other.

use super::{Point, Polyline, angle_between, cross};

/// Lines whose first steps differ by more, degrees, part at once.
const ALONG: f64 = 20.0;
/// Metres between two lines beyond which they have parted.
const PARTED: f64 = 0.3;
/// By how much, metres, a line is taken to have been meant beside another although it runs over it.
const OVER_MOST: f64 = 0.1;
/// Metres between places where two lines are compared.
const STEP: f64 = 0.25;
/// Metres of the line that may be left out where it leaves the other.
const SKIPPED_MOST: f64 = 0.5;
/// Radius, metres, below which it does not bend where it leaves the other, if a place left out helps.
const SHARPEST: f64 = 1.5;
/// Change of direction, degrees, that it may take to leave the other.
const BENT_MOST: f64 = 10.0;
/// Metres by which a line may lie over another: less than a coordinate's last digit.
const EXACT: f64 = 1e-6;

/// A line with the stations of its points.
#[derive(Clone, Debug)]
pub struct Measured {
    line: Polyline,
    stations: Vec<f64>,
}

impl Measured {
    /// A line through these points; `None` if fewer than two distinct ones are left.
    pub fn new(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        Polyline::new(points).map(|line| Self { stations: line.stations(), line })
    }

    fn length(&self) -> f64 {
        self.stations[self.stations.len() - 1]
    }
}

/// The line, which starts where the other one does, kept on the side of it on which it goes on: where it runs over the
/// other by less than a hand's breadth before the two part, it follows the other, vertex by vertex. `None` where it is to
/// stay as it is.
pub fn diverge(line: &Measured, other: &Measured) -> Option<Vec<Point>> {
    let steps = [line, other].map(|l| l.line.at(STEP.min(l.length())) - l.line.first());
    if steps[0].dot(&steps[1]) < ALONG.to_radians().cos() * steps[0].norm() * steps[1].norm() {
        return None;
    }
    let [length, other_length] = [line, other].map(Measured::length);
    let (Measured { line, stations: own }, Measured { line: other, stations: others }) = (line, other);
    // Where it ran over the other last, were it to go on to the left of that or to the right: the station on the other, and its
    // own behind that.
    let mut over: [Option<(f64, Option<f64>)>; 2] = [None; 2];
    // How far to the left of the other it ran at least and at most.
    let [mut least, mut most] = [0.0_f64; 2];
    let (mut walked, mut foot) = (0, Foot::default());
    for station in merged(&own[1..], length.min(other_length)) {
        while walked + 2 < own.len() && own[walked + 1] < station {
            walked += 1;
        }
        let [a, b] = [line.points()[walked], line.points()[walked + 1]];
        let place = a + (b - a) * ((station - own[walked]) / (own[walked + 1] - own[walked])).min(1.0);
        foot = foot.on(other, others, place);
        if foot.station >= other_length - EXACT {
            return None;
        }
        (least, most) = (least.min(foot.offset), most.max(foot.offset));
        for (over, left) in over.iter_mut().zip([foot.offset, -foot.offset]) {
            match over {
                _ if left < -EXACT => *over = Some((foot.station, None)),
                Some((_, behind)) => *behind = behind.or(Some(station)),
                None => {}
            }
        }
        if foot.offset.abs() > PARTED {
            break;
        }
    }
    if foot.offset.abs() <= PARTED {
        return None;
    }
    let side = foot.offset.signum();
    let (over, farthest) = if side > 0.0 { (over[0], -least) } else { (over[1], most) };
    let (leaves, rejoined) = over.and_then(|(leaves, behind)| Some((leaves, behind?)))?;
    if farthest > OVER_MOST {
        return None;
    }
    let followed = other.points().iter().zip(others);
    let followed: Vec<Point> = followed.take_while(|(_, s)| **s <= leaves).map(|(p, _)| *p).collect();
    let mut own = line.points().iter().zip(own).filter(|(_, s)| **s >= rejoined - EXACT).peekable();
    let leaving = other.at(leaves);
    let mut points = followed;
    if points.last().is_some_and(|p| (p - leaving).norm() > STEP) {
        points.push(leaving);
    }
    // The way from the last place on the other line to the first beside it must not cut across a bend of the other.
    let across = |p: &Point| {
        let at = [0.25, 0.5, 0.75].map(|t| other.project(leaving + (p - leaving) * t).offset * side);
        at.iter().any(|&offset| offset < -EXACT)
    };
    let sharp = |p: &Point, station: f64| {
        let way = p - leaving;
        let bends = [(other.direction(leaves), way), (way, line.direction(station))];
        bends.map(|(a, b)| angle_between(a, b).abs()).iter().sum::<f64>() * SHARPEST > way.norm()
    };
    while own.next_if(|(p, s)| **s < rejoined + SKIPPED_MOST && (across(p) || sharp(p, **s))).is_some() {}
    let (next, _) = own.peek()?;
    let turn = angle_between(other.direction(leaves), *next - leaving).abs();
    if across(next) || turn > BENT_MOST.to_radians() {
        return None;
    }
    points.extend(own.map(|(p, _)| *p));
    (points.last() == Some(&line.last())).then_some(points)
}

/// Stations of vertices, and between them those of every step below `last`, ascending.
fn merged(vertices: &[f64], last: f64) -> impl Iterator<Item = f64> {
    let mut vertices = vertices.iter().copied().peekable();
    let mut steps = (1..).map(|i| STEP * f64::from(i)).take_while(move |&s| s < last).peekable();
    std::iter::from_fn(move || match (vertices.peek(), steps.peek()) {
        (Some(vertex), Some(step)) if step < vertex => steps.next(),
        (Some(_), _) => vertices.next(),
        _ => steps.next(),
    })
}

/// Where a line comes nearest to the last place of another that runs beside it.
#[derive(Clone, Copy, Default)]
struct Foot {
    segment: usize,
    station: f64,
    /// Left positive, metres.
    offset: f64,
}

impl Foot {
    /// The foot of the next place, not before this one. What lies so far ahead that it comes near only if the line turns
    /// back is not looked at.
    fn on(self, line: &Polyline, stations: &[f64], place: Point) -> Self {
        let mut best = (f64::INFINITY, self);
        for (segment, pair) in line.points().windows(2).enumerate().skip(self.segment) {
            let (a, along) = (pair[0], pair[1] - pair[0]);
            if stations[segment] > best.1.station + 2.0 * best.1.offset.abs() + STEP {
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
        super::diverge(&line, &other)
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

    /// How far a line lies to the right of another at most, up to where they have parted.
    fn over(line: &[Point], other: &Polyline) -> f64 {
        let line = Polyline::new(line.iter().copied()).unwrap();
        let offsets = line.resampled(0.05).into_points().into_iter().map(|p| other.project(p).offset);
        -offsets.take_while(|o| *o < PARTED).fold(0.0, f64::min)
    }

    #[test]
    fn a_line_that_dips_over_its_neighbour_follows_it() {
        // Straight on, but a little to the left, where the turn to the left begins straight on.
        let straight = line(&[(0.0, 0.0), (30.0, 2.7)]);
        let bent = diverge(&turn(8.0), &straight).unwrap();
        assert!(over(&bent, &straight) < 1e-6);
        assert!(over(turn(8.0).points(), &straight) > 1e-3, "as it was");
        assert_eq!(bent.last(), Some(&turn(8.0).last()));
        let other_hand = diverge(&mirrored(&turn(8.0)), &mirrored(&straight)).unwrap();
        assert_eq!(other_hand, bent.iter().map(|p| Point::new(p.x, -p.y)).collect::<Vec<_>>());
        // The other way round.
        let bent = diverge(&straight, &turn(8.0)).unwrap();
        let turn = mirrored(&turn(8.0));
        let bent: Vec<Point> = bent.iter().map(|p| Point::new(p.x, -p.y)).collect();
        assert!(over(&bent, &turn) < 1e-6);
    }

    #[test]
    fn lines_that_part_at_once_or_swing_out_stay() {
        let straight = line(&[(0.0, 0.0), (30.0, 0.0)]);
        assert_eq!(diverge(&turn(8.0), &straight), None);
        let swings = line(&[(0.0, 0.0), (2.0, -0.3), (4.0, -0.4), (8.0, 2.0)]);
        assert_eq!(diverge(&swings, &straight), None);
        assert_eq!(diverge(&line(&[(0.0, 0.0), (0.0, 9.0)]), &straight), None);
    }
}
