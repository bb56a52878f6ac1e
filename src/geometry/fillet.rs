//! Rounds what bends too tightly in a line: the inner edge of a bend, where little is left of its radius.

use std::borrow::Cow;

use super::pose::MIN_SPACING;
use super::{Point, Polyline, Vector, angle_between, left_of, line_crossing};

/// Above this change of direction (150 degrees) the lines before and behind a bend meet too far away.
const REVERSAL: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// Below this change of direction, radians, nothing is left to round.
const STRAIGHT: f64 = 1e-3;
/// Largest change of direction between neighbours, radians (12 degrees): the arc leaves its circle by at most 7 mm.
const TURN_STEP: f64 = 12.0 * std::f64::consts::PI / 180.0;
/// A bend this much tighter than it may be, as a part of its radius, is let be: coordinates are rounded.
const TOLERANCE: f64 = 0.02;

/// Where two arcs meet, their joint is rounded in its turn, so often at most.
const ROUNDS: usize = 3;
/// So many places before and behind a corner are looked at for room: bends are local.
const REACH: usize = 32;

/// How tightly a line may bend.
#[derive(Clone, Copy, Debug)]
pub struct Rounding {
    /// No bend is tighter than this radius, metres, where the line is long enough beside it.
    pub least: f64,
    /// The radius, metres, to which a tight bend is rounded ...
    pub easy: f64,
    /// ... as far as the line moves by no more than this, metres.
    pub cut: f64,
}

impl Rounding {
    /// The radius for a bend that turns so much in all, radians, and now has some radius.
    fn radius(&self, turn: f64, now: f64) -> f64 {
        let off_corner = 1.0 / (turn.abs() / 2.0).cos() - 1.0;
        self.easy.min(now + self.cut / off_corner).max(self.least)
    }

    /// The line with every bend that is too tight replaced by an arc that cuts its corner, tangent to the line before and
    /// behind; where the line ends too soon, by the widest arc that there is room for. Its ends stay.
    pub fn of<'a>(&self, line: &'a [Point]) -> Cow<'a, [Point]> {
        if line.windows(3).all(|w| tighter([w[0], w[1], w[2]], self.easy * (1.0 - TOLERANCE)).is_none()) {
            return Cow::Borrowed(line);
        }
        let before = line;
        let mut line = self.once(before);
        if line == before {
            return Cow::Borrowed(before);
        }
        let rest = Self { easy: self.least, cut: 0.0, ..*self };
        for _ in 1..ROUNDS {
            let round = rest.once(&line);
            if tightest(&round) <= tightest(&line) {
                break;
            }
            line = round;
        }
        Cow::Owned(line)
    }

    fn once(&self, line: &[Point]) -> Vec<Point> {
        let mut rest = line.to_vec();
        let mut done: Vec<Point> = Vec::with_capacity(line.len());
        // What lies before the bend at hand is `done`, which an arc may shorten.
        rest.reverse();
        done.extend(rest.pop());
        while let Some(corner) = rest.pop() {
            let tight = match (done.last(), rest.last()) {
                (Some(&before), Some(&behind)) => tighter([before, corner, behind], self.easy * (1.0 - TOLERANCE)),
                _ => None,
            };
            let bend = tight.and_then(|now| self.bend(&done, corner, &rest).filter(|bend| bend.radius > now));
            match bend {
                Some(Bend { before, behind, arc, .. }) => {
                    done.truncate(before);
                    rest.truncate(behind);
                    let far =
                        |p: &Point, other: Option<&Point>| other.is_none_or(|other| (p - other).norm() >= MIN_SPACING);
                    let (last, next) = (done.last().copied(), rest.last().copied());
                    done.extend(arc.into_iter().filter(|p| far(p, last.as_ref()) && far(p, next.as_ref())));
                }
                None => done.push(corner),
            }
        }
        done
    }

    /// The wanted arc around a corner, else the widest: from the line before it, of which so many places remain, to the
    /// line behind, given backwards.
    fn bend(&self, before: &[Point], corner: Point, behind: &[Point]) -> Option<Bend> {
        let (mut i, mut j) = (before.len(), behind.len());
        let mut widest: Option<Bend> = None;
        // The bend reaches from the segment that ends at `first` to the one that begins at `last`.
        let (mut first, mut last) = (corner, corner);
        for _ in 0..2 * REACH {
            let (Some(start), Some(end)) = (i.checked_sub(1), j.checked_sub(1)) else { break };
            let (Some(&start), Some(&end)) = (before.get(start), behind.get(end)) else { break };
            let Some(fillet) = Fillet::between([start, first], [last, end]) else { break };
            let half = (fillet.turn.abs() / 2.0).tan();
            let taken = fillet.taken[0].max(fillet.taken[1]);
            let (wanted, most) =
                ((self.radius(fillet.turn, taken / half) * half).max(taken), fillet.room[0].min(fillet.room[1]));
            let bend = |arc: Vec<Point>, radius: f64| {
                let beside = self.tightest_beside(&before[..i], &arc, &behind[..j]);
                Bend { before: i, behind: j, radius: beside.map_or(radius, |beside| beside.min(radius)), arc }
            };
            let mut found: Vec<Bend> = Vec::new();
            if wanted <= most {
                let bend = bend(fillet.arc(wanted), wanted / half);
                if bend.radius >= self.least * (1.0 - TOLERANCE) {
                    return Some(bend);
                }
                found.push(bend);
            } else {
                if most >= taken {
                    found.push(bend(fillet.arc(most), most / half));
                }
                // At its ends the line may head elsewhere.
                if i == 1 && self.least * half > fillet.room[0] {
                    let arc = arc_to(start, [last, end], self.least);
                    found.extend(arc.map(|arc| bend(arc, self.least)));
                }
                if j == 1 && self.least * half > fillet.room[1] {
                    let arc = arc_to(end, [first, start], self.least);
                    found.extend(arc.map(|arc| bend(arc.into_iter().rev().collect(), self.least)));
                }
            }
            widest = widest.into_iter().chain(found).reduce(|a, b| if b.radius > a.radius { b } else { a });
            // The shorter side gives way first; the ends of the line stay.
            let (back, on) = (i > 1, j > 1);
            if back && (fillet.room[0] <= fillet.room[1] || !on) {
                first = start;
                i -= 1;
            } else if on {
                last = end;
                j -= 1;
            } else {
                break;
            }
        }
        widest
    }

    /// The radius of the tightest bend where the line goes on beside an arc, if that is too tight: an arc takes from the
    /// segments that it touches, and what is left of them may be too short for the bends at their other ends.
    fn tightest_beside(&self, before: &[Point], arc: &[Point], behind: &[Point]) -> Option<f64> {
        let beside = |line: &[Point], end: Option<&Point>| match (line, end) {
            ([.., a, b], Some(&end)) if (b - end).norm() >= MIN_SPACING => {
                tighter([*a, *b, end], self.least * (1.0 - TOLERANCE))
            }
            _ => None,
        };
        let sides = [beside(before, arc.first()), beside(behind, arc.last())];
        sides.into_iter().flatten().reduce(f64::min)
    }
}

/// Part of a line that is replaced.
struct Bend {
    /// So many places before it stay.
    before: usize,
    /// So many behind.
    behind: usize,
    arc: Vec<Point>,
    /// Metres.
    radius: f64,
}

/// The corner of two segments, and how far arcs in it may reach.
struct Fillet {
    corner: Point,
    /// Unit directions before and behind.
    along: [Vector; 2],
    /// Change of direction, radians, left positive.
    turn: f64,
    /// How far, metres, the inner ends of the segments lie from the corner, ...
    taken: [f64; 2],
    /// ... and how far the outer ends.
    room: [f64; 2],
}

impl Fillet {
    /// `None` where the segments do not meet in a corner ahead of both.
    fn between([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Self> {
        let along = [(b - a).try_normalize(Polyline::MERGE)?, (d - c).try_normalize(Polyline::MERGE)?];
        let turn = angle_between(along[0], along[1]);
        if turn.abs() > REVERSAL || turn.abs() < STRAIGHT {
            return None;
        }
        let (on, back, corner) = line_crossing(b, along[0], c, along[1])?;
        let ahead = on >= -Polyline::MERGE && back <= Polyline::MERGE;
        let room = [(corner - a).norm(), (d - corner).norm()];
        ahead.then_some(Self { corner, along, turn, taken: [on, -back], room })
    }

    /// The arc that begins so far before the corner, both its ends among the places.
    fn arc(&self, tangent: f64) -> Vec<Point> {
        let start = self.corner - self.along[0] * tangent;
        let radius = tangent / (self.turn.abs() / 2.0).tan();
        around(start + left_of(self.along[0]) * (radius * self.turn.signum()), start, self.turn)
    }
}

/// Places on the arc around a centre that begins at a place and turns so much, radians, both its ends among them.
fn around(centre: Point, start: Point, turn: f64) -> Vec<Point> {
    let pieces = (turn.abs() / TURN_STEP).ceil().max(1.0);
    let at = |i: usize| centre + nalgebra::Rotation2::new(turn * i as f64 / pieces) * (start - centre);
    (0..=pieces as usize).map(at).collect()
}

/// The arc of a radius from a place to where it touches a segment, whose direction it takes; `None` where it touches the
/// line through the segment elsewhere.
fn arc_to(place: Point, [a, b]: [Point; 2], radius: f64) -> Option<Vec<Point>> {
    let along = (b - a).try_normalize(Polyline::MERGE)?;
    let (on, aside) = ((place - a).dot(&along), super::cross(along, place - a));
    let reach = 2.0 * radius * aside.abs() - aside * aside;
    let touches = on + reach.sqrt();
    if !(0.0..=(b - a).norm()).contains(&touches) {
        return None;
    }
    let end = a + along * touches;
    let centre = end + left_of(along) * (radius * aside.signum());
    let turn = angle_between(place - centre, end - centre);
    // The short way around.
    (turn * aside > 0.0).then(|| around(centre, place, turn))
}

/// Radius, metres, of the bend at the middle one of three places, if it is tighter than some radius. Of what lies farther
/// than a metre away, nothing counts: a corner between two long segments is tight.
fn tighter([a, b, c]: [Point; 3], than: f64) -> Option<f64> {
    const LOOK: f64 = 1.0;
    let (before, behind) = (b - a, c - b);
    let length = f64::midpoint(before.norm().min(LOOK), behind.norm().min(LOOK));
    // An angle is smaller than its tangent, which is had for less.
    if super::cross(before, behind).abs() * than < before.dot(&behind) * length {
        return None;
    }
    Some(length / angle_between(before, behind).abs()).filter(|radius| *radius < than)
}

/// The least radius of all bends of a line, metres.
fn tightest(line: &[Point]) -> f64 {
    line.windows(3).fold(f64::INFINITY, |least, w| tighter([w[0], w[1], w[2]], least).unwrap_or(least))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAST: Rounding = Rounding { least: 1.25, easy: 1.25, cut: 0.0 };

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
    fn a_wider_arc_is_taken_where_it_cuts_off_little() {
        let rounding = Rounding { least: 1.25, easy: 2.0, cut: 0.6 };
        for side in [1.0, -1.0] {
            let slight = rounding.of(&line(&[(0.0, 0.0), (5.0, 0.0), (9.0, 4.0)], side)).into_owned();
            assert!(tightest(&slight) > 1.95, "{}", tightest(&slight));
            let sharp = rounding.of(&line(&[(0.0, 0.0), (5.0, 0.0), (5.0, 6.0)], side)).into_owned();
            assert!((1.4..1.5).contains(&tightest(&sharp)), "{}", tightest(&sharp));
        }
    }

    #[test]
    fn where_the_line_ends_too_soon_the_arc_is_as_wide_as_there_is_room() {
        for side in [1.0, -1.0] {
            let round = LEAST.of(&line(&[(0.0, 0.0), (0.8, 0.0), (0.8, 0.9)], side)).into_owned();
            assert!((0.75..0.81).contains(&tightest(&round)), "{}", tightest(&round));
        }
    }

    #[test]
    fn where_the_line_ends_before_a_sharp_bend_it_may_head_elsewhere_at_its_end() {
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
    fn what_bends_gently_or_turns_back_stays() {
        for side in [1.0, -1.0] {
            let gentle = quarter(3.0, side);
            assert_eq!(LEAST.of(&gentle), gentle);
            let back = line(&[(0.0, 0.0), (5.0, 0.0), (0.0, 0.1)], side);
            assert_eq!(LEAST.of(&back), back);
        }
        assert!(LEAST.of(&[]).is_empty());
    }
}
