//! Rounds the bends of a line that are too tight, such as the inner bound of a lane in a bend.

use std::borrow::Cow;

use super::pose::MIN_SPACING;
use super::{Point, Polyline, Vector, angle_between, cross, left_of, line_crossing};

/// The largest change of direction of a bend, radians (165 degrees): beyond, the lines before and behind meet too far away.
const REVERSAL: f64 = 165.0 * std::f64::consts::PI / 180.0;
/// The smallest change of direction that is rounded, radians.
const LEAST_ROUNDED_TURN: f64 = 1e-3;
/// The largest change of direction between neighbours, radians (12 degrees): the polyline stays within 7 mm of the arc.
const TURN_STEP: f64 = 12.0 * std::f64::consts::PI / 180.0;
/// A bend may be tighter by this part of the radius: coordinates are rounded.
const TOLERANCE: f64 = 0.02;

/// A vertex is left out if the line moves by no more than this, metres.
const MAX_THINNING: f64 = 0.05;
/// The largest number of rounds. Each rounds the joints between the arcs of the round before.
const ROUNDS: usize = 3;
/// The number of vertices before and behind a corner that an arc may replace: bends are local.
const VERTICES_REPLACED: usize = 32;

/// How tightly a line may bend.
#[derive(Clone, Copy, Debug)]
pub struct Rounding {
    /// The smallest radius of a bend, metres, if the line is long enough.
    pub min_radius: f64,
    /// The radius, metres, to which a tight bend is rounded ...
    pub easy_radius: f64,
    /// ... as long as the line moves by no more than this, metres.
    pub max_shift: f64,
}

impl Rounding {
    /// The radius, metres, for a bend that turns by `turn` radians and has the radius `now`, metres.
    fn radius(&self, turn: f64, now: f64) -> f64 {
        let shift_per_metre = 1.0 / (turn.abs() / 2.0).cos() - 1.0;
        self.easy_radius.min(now + self.max_shift / shift_per_metre).max(self.min_radius)
    }

    /// The line with every tight bend replaced by an arc that cuts the corner and is tangent to the line before and behind. If
    /// the line is too short for the arc, the widest possible one is used. The ends of the line stay.
    pub fn of<'a>(&self, line: &'a [Point]) -> Cow<'a, [Point]> {
        if line.windows(3).all(|w| radius_below([w[0], w[1], w[2]], self.easy_radius * (1.0 - TOLERANCE)).is_none()) {
            return Cow::Borrowed(line);
        }
        let mut rounded = self.rounded_once(line);
        if rounded == line {
            return Cow::Borrowed(line);
        }
        let joints = Self { easy_radius: self.min_radius, max_shift: 0.0, ..*self };
        for _ in 1..ROUNDS {
            let next = joints.rounded_once(&rounded);
            if tightest(&next) <= tightest(&rounded) {
                break;
            }
            rounded = next;
        }
        thin_tight_bends(&mut rounded, self.min_radius * (1.0 - TOLERANCE));
        Cow::Owned(rounded)
    }

    fn rounded_once(&self, line: &[Point]) -> Vec<Point> {
        // Vertices move from `rest`, in reverse order, to `rounded`. An arc may shorten both.
        let mut rest: Vec<Point> = line.iter().rev().copied().collect();
        let mut rounded: Vec<Point> = Vec::with_capacity(line.len());
        rounded.extend(rest.pop());
        while let Some(corner) = rest.pop() {
            let Some(arc) = self.arc(&rounded, corner, &rest) else {
                rounded.push(corner);
                continue;
            };
            rounded.truncate(arc.before);
            rest.truncate(arc.behind);
            let ends = [rounded.last().copied(), rest.last().copied()];
            let is_near = |p: &Point| ends.iter().flatten().any(|end| (p - end).norm() < MIN_SPACING);
            rounded.extend(arc.points.into_iter().filter(|p| !is_near(p)));
        }
        rounded
    }

    /// The arc that replaces a corner, if the corner is too tight and the arc is wider.
    fn arc(&self, before: &[Point], corner: Point, behind: &[Point]) -> Option<Arc> {
        let neighbours = [*before.last()?, corner, *behind.last()?];
        let radius = radius_below(neighbours, self.easy_radius * (1.0 - TOLERANCE))?;
        self.widest_arc(before, corner, behind).filter(|arc| arc.radius > radius)
    }

    /// The arc of the wanted radius around a corner, else the widest. `behind` is in reverse order.
    fn widest_arc(&self, mut before: &[Point], corner: Point, mut behind: &[Point]) -> Option<Arc> {
        let mut widest: Option<Arc> = None;
        // The arc touches the segment that ends at `first` and the segment that begins at `last`.
        let (mut first, mut last) = (corner, corner);
        for _ in 0..2 * VERTICES_REPLACED {
            let (Some(&start), Some(&end)) = (before.last(), behind.last()) else { break };
            let Some(fillet) = Fillet::between([start, first], [last, end]) else { break };
            let taken = fillet.taken[0].max(fillet.taken[1]);
            let tangent =
                (self.radius(fillet.turn, taken / fillet.tangent_ratio()) * fillet.tangent_ratio()).max(taken);
            let fits = tangent <= fillet.room[0].min(fillet.room[1]);
            let arcs = if fits { vec![fillet.arc(tangent)] } else { self.tight_arcs(&fillet, before, behind) };
            let arcs = arcs.into_iter().map(|arc| self.between(before, arc, behind));
            let found = arcs.reduce(|a, b| if b.radius > a.radius { b } else { a });
            if fits && found.as_ref().is_some_and(|arc| arc.radius >= self.min_radius * (1.0 - TOLERANCE)) {
                return found;
            }
            widest = widest.into_iter().chain(found).reduce(|a, b| if b.radius > a.radius { b } else { a });
            // The arc is extended over the shorter segment. The ends of the line stay.
            match (before.len() > 1, behind.len() > 1) {
                (true, more) if fillet.room[0] <= fillet.room[1] || !more => {
                    first = start;
                    before = &before[..before.len() - 1];
                }
                (_, true) => {
                    last = end;
                    behind = &behind[..behind.len() - 1];
                }
                _ => break,
            }
        }
        widest
    }

    /// The arcs that are possible where the wanted one does not fit, with their radii, metres.
    fn tight_arcs(&self, fillet: &Fillet, before: &[Point], behind: &[Point]) -> Vec<(Vec<Point>, f64)> {
        let most = fillet.room[0].min(fillet.room[1]);
        let mut arcs = Vec::new();
        if most >= fillet.taken[0].max(fillet.taken[1]) {
            arcs.push(fillet.arc(most));
        }
        // At its ends the line may change its direction.
        let [[start, first], [last, end]] = fillet.segments;
        let tangent = self.min_radius * fillet.tangent_ratio();
        if before.len() == 1 && tangent > fillet.room[0] {
            arcs.extend(arc_to(start, [last, end], self.min_radius).map(|arc| (arc, self.min_radius)));
        }
        if behind.len() == 1 && tangent > fillet.room[1] {
            let arc = arc_to(end, [first, start], self.min_radius);
            arcs.extend(arc.map(|arc| (arc.into_iter().rev().collect(), self.min_radius)));
        }
        arcs
    }

    /// The arc between the rest of the line. It shortens the segments that it touches, which may make the bends at their other
    /// ends too tight: the tightest of them counts.
    fn between(&self, before: &[Point], (points, radius): (Vec<Point>, f64), behind: &[Point]) -> Arc {
        let bend = |line: &[Point], end: Option<&Point>| match (line, end) {
            ([.., a, b], Some(&end)) if (b - end).norm() >= MIN_SPACING => {
                radius_below([*a, *b, end], self.min_radius * (1.0 - TOLERANCE))
            }
            _ => None,
        };
        let bends = [bend(before, points.first()), bend(behind, points.last())];
        let radius = bends.into_iter().flatten().fold(radius, f64::min);
        Arc { before: before.len(), behind: behind.len(), points, radius }
    }
}

/// An arc that replaces a part of a line.
struct Arc {
    /// The number of vertices before it that stay.
    before: usize,
    /// The number of vertices behind it that stay.
    behind: usize,
    points: Vec<Point>,
    /// Metres.
    radius: f64,
}

/// The corner of two segments, and how far an arc in it may reach.
struct Fillet {
    segments: [[Point; 2]; 2],
    corner: Point,
    /// The unit directions before and behind.
    along: [Vector; 2],
    /// The change of direction, radians, left positive.
    turn: f64,
    /// The distances, metres, of the inner ends of the segments from the corner, ...
    taken: [f64; 2],
    /// ... and of the outer ends.
    room: [f64; 2],
}

impl Fillet {
    /// `None` if the segments do not meet in a corner ahead of both.
    fn between([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Self> {
        let along = [(b - a).try_normalize(Polyline::MERGE)?, (d - c).try_normalize(Polyline::MERGE)?];
        let turn = angle_between(along[0], along[1]);
        if turn.abs() > REVERSAL || turn.abs() < LEAST_ROUNDED_TURN {
            return None;
        }
        let (on, back, corner) = line_crossing(b, along[0], c, along[1])?;
        let ahead = on >= -Polyline::MERGE && back <= Polyline::MERGE;
        let room = [(corner - a).norm(), (d - corner).norm()];
        ahead.then_some(Self { segments: [[a, b], [c, d]], corner, along, turn, taken: [on, -back], room })
    }

    /// The length of the tangents of an arc divided by its radius.
    fn tangent_ratio(&self) -> f64 {
        (self.turn.abs() / 2.0).tan()
    }

    /// The arc whose tangents have this length, metres, both ends included, and its radius, metres.
    fn arc(&self, tangent: f64) -> (Vec<Point>, f64) {
        let start = self.corner - self.along[0] * tangent;
        let radius = tangent / self.tangent_ratio();
        (around(start + left_of(self.along[0]) * (radius * self.turn.signum()), start, self.turn), radius)
    }
}

/// Points on an arc around a centre from `start`, both ends included; `turn` is in radians.
fn around(centre: Point, start: Point, turn: f64) -> Vec<Point> {
    let pieces = (turn.abs() / TURN_STEP).ceil().max(1.0);
    let point = |i: usize| centre + nalgebra::Rotation2::new(turn * i as f64 / pieces) * (start - centre);
    (0..=pieces as usize).map(point).collect()
}

/// The arc of a radius, metres, from a point to where it is tangent to a segment; `None` if that is outside the segment.
fn arc_to(point: Point, [a, b]: [Point; 2], radius: f64) -> Option<Vec<Point>> {
    let along = (b - a).try_normalize(Polyline::MERGE)?;
    let (on, aside) = ((point - a).dot(&along), cross(along, point - a));
    let reach = 2.0 * radius * aside.abs() - aside * aside;
    let touches = on + reach.sqrt();
    if !(0.0..=(b - a).norm()).contains(&touches) {
        return None;
    }
    let end = a + along * touches;
    let centre = end + left_of(along) * (radius * aside.signum());
    let turn = angle_between(point - centre, end - centre);
    // The short way around the centre.
    (turn * aside > 0.0).then(|| around(centre, point, turn))
}

/// The radius, metres, of the bend at the middle one of three points, if it is smaller than `limit`. At most one metre of each
/// segment counts, so that a corner between long segments is tight.
fn radius_below([a, b, c]: [Point; 3], limit: f64) -> Option<f64> {
    const MAX_LENGTH: f64 = 1.0;
    let (before, after) = (b - a, c - b);
    let length = f64::midpoint(before.norm().min(MAX_LENGTH), after.norm().min(MAX_LENGTH));
    // An angle is smaller than its tangent, which is cheaper to compute.
    if cross(before, after).abs() * limit < before.dot(&after) * length {
        return None;
    }
    Some(length / angle_between(before, after).abs()).filter(|radius| *radius < limit)
}

/// The smallest radius of the bends of a line, metres.
fn tightest(line: &[Point]) -> f64 {
    line.windows(3).fold(f64::INFINITY, |least, w| radius_below([w[0], w[1], w[2]], least).unwrap_or(least))
}

/// Leaves out vertices at bends tighter than `least` metres where the line becomes wider without them: where arcs meet, some lie close
/// together and bend more than the line around them.
fn thin_tight_bends(line: &mut Vec<Point>, least: f64) {
    let mut at = 1;
    while at + 1 < line.len() {
        let Some(radius) = radius_below([line[at - 1], line[at], line[at + 1]], least) else {
            at += 1;
            continue;
        };
        let inner = (at - 1).max(1)..(at + 2).min(line.len() - 1);
        let without = inner.filter_map(|leave| Some((radius_without(line, leave, least)?, leave)));
        match without.max_by(|(a, _), (b, _)| a.total_cmp(b)) {
            Some((wider, leave)) if wider > radius => {
                line.remove(leave);
                at = at.saturating_sub(2).max(1);
            }
            _ => at += 1,
        }
    }
}

/// The smallest radius, metres, at most `least`, of the bends beside an inner vertex if it is left out; `None` if that moves the line
/// too far.
fn radius_without(line: &[Point], leave: usize, least: f64) -> Option<f64> {
    let chord = Polyline::new([line[leave - 1], line[leave + 1]])?;
    if chord.distance(line[leave]) > MAX_THINNING {
        return None;
    }
    let around = leave.saturating_sub(3)..(leave + 4).min(line.len());
    let left: Vec<Point> = around.filter(|&i| i != leave).map(|i| line[i]).collect();
    Some(left.windows(3).filter_map(|w| radius_below([w[0], w[1], w[2]], least)).fold(least, f64::min))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAST: Rounding = Rounding { min_radius: 1.25, easy_radius: 1.25, max_shift: 0.0 };

    fn line(points: &[(f64, f64)], side: f64) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, side * y)).collect()
    }

    /// A quarter of a small circle between two straights.
    fn quarter(small: f64, side: f64) -> Vec<Point> {
        let mut places = vec![(0.0, 0.0)];
        places.extend((0..=9).map(|i| {
            let turned = (10.0 * f64::from(i)).to_radians();
            (5.0 + small * turned.sin(), small * (1.0 - turned.cos()))
        }));
        places.push((5.0 + small, 6.0));
        line(&places, side)
    }

    #[test]
    fn a_tight_bend_becomes_an_arc_within_its_corner() {
        for side in [1.0, -1.0] {
            for bend in [quarter(0.2, side), quarter(0.9, side), line(&[(0.0, 0.0), (5.0, 0.0), (5.0, 6.0)], side)] {
                let round = LEAST.of(&bend).into_owned();
                assert!(tightest(&round) > 1.2, "{}", tightest(&round));
                assert_eq!((round.first(), round.last()), (bend.first(), bend.last()));
                let (old, new) = (Polyline::new(bend).unwrap(), Polyline::new(round.clone()).unwrap());
                let off = round.iter().map(|&p| old.distance(p)).fold(0.0, f64::max);
                assert!(off < 0.53 && new.length() < old.length(), "{off}");
                let inside = round.iter().all(|p| p.x < 5.91 && side * p.y > -1e-9);
                assert!(inside, "{round:?}");
            }
        }
    }

    #[test]
    fn a_hairpin_becomes_an_arc() {
        // Changes of direction of 152 and 163 degrees.
        for (side, back) in [1.0, -1.0].into_iter().flat_map(|side| [8.0, 4.6].map(|back| (side, back))) {
            let hairpin = line(&[(0.0, 0.0), (20.0, 0.0), (5.0, back)], side);
            let round = LEAST.of(&hairpin).into_owned();
            assert!(tightest(&round) > 1.2, "{back}: {}", tightest(&round));
            assert_eq!((round.first(), round.last()), (hairpin.first(), hairpin.last()));
        }
    }

    #[test]
    fn an_arc_is_wider_where_it_moves_the_line_little() {
        let rounding = Rounding { min_radius: 1.25, easy_radius: 2.0, max_shift: 0.6 };
        for side in [1.0, -1.0] {
            let slight = rounding.of(&line(&[(0.0, 0.0), (5.0, 0.0), (9.0, 4.0)], side)).into_owned();
            assert!(tightest(&slight) > 1.95, "{}", tightest(&slight));
            let sharp = rounding.of(&line(&[(0.0, 0.0), (5.0, 0.0), (5.0, 6.0)], side)).into_owned();
            assert!((1.4..1.5).contains(&tightest(&sharp)), "{}", tightest(&sharp));
        }
    }

    #[test]
    fn vertices_close_together_are_left_out_of_a_bend() {
        for side in [1.0, -1.0] {
            // A quarter of a circle of 1.25 m with a vertex that stands out by 1 cm.
            let mut bend = quarter(1.25, side);
            let outward = (bend[5] - Point::new(5.0, 1.25 * side)).normalize();
            bend[5] += outward * 0.01;
            assert!(tightest(&bend) < 0.9, "{}", tightest(&bend));
            let ends = [bend.first().copied(), bend.last().copied()];
            thin_tight_bends(&mut bend, 1.2);
            assert!(tightest(&bend) > 1.1 && bend.len() > 8, "{} {}", tightest(&bend), bend.len());
            assert_eq!([bend.first().copied(), bend.last().copied()], ends);
        }
    }

    #[test]
    fn near_its_ends_a_line_gets_the_widest_possible_arc() {
        for side in [1.0, -1.0] {
            let round = LEAST.of(&line(&[(0.0, 0.0), (0.8, 0.0), (0.8, 0.9)], side)).into_owned();
            assert!((0.75..0.81).contains(&tightest(&round)), "{}", tightest(&round));
        }
    }

    #[test]
    fn near_a_sharp_bend_a_line_may_change_direction_at_its_end() {
        for side in [1.0, -1.0] {
            let bend = line(&[(0.0, 0.0), (0.8, 0.0), (1.8, 1.0), (1.8, 6.0)], side);
            for bend in [bend.clone(), bend.into_iter().rev().collect()] {
                let round = LEAST.of(&bend).into_owned();
                assert!(tightest(&round) > 1.2, "{}", tightest(&round));
                assert_eq!((round.first(), round.last()), (bend.first(), bend.last()));
            }
        }
    }

    #[test]
    fn an_arc_leaves_room_for_the_bends_beside_it() {
        let places = [(0.0, 0.0), (8.0, 0.0), (8.2, 0.1), (8.4, 0.3), (8.6, 0.6), (8.7, 0.9), (8.7, 1.1), (8.0, 9.1)];
        for side in [1.0, -1.0] {
            let round = LEAST.of(&line(&places, side)).into_owned();
            assert!(tightest(&round) > 1.2, "{}", tightest(&round));
        }
    }

    #[test]
    fn gentle_bends_and_reversals_stay() {
        for side in [1.0, -1.0] {
            let gentle = quarter(3.0, side);
            assert_eq!(LEAST.of(&gentle), gentle);
            let back = line(&[(0.0, 0.0), (5.0, 0.0), (0.0, 0.1)], side);
            assert_eq!(LEAST.of(&back), back);
        }
        assert!(LEAST.of(&[]).is_empty());
    }
}
