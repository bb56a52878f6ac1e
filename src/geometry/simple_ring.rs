//! Whether a ring is simple, and where not.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, Envelope, RTree};

use super::{Point, Vector, cross, orientation};

/// One way in which a ring is no simple polygon. Indices are positions in the ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RingFault {
    /// Fewer than three distinct places.
    TooFew(usize),
    /// A coordinate that is no number.
    NotFinite(usize),
    /// The outline turns back on itself at this vertex.
    Spike(usize),
    /// The edges that start at these vertices meet though they are no neighbours.
    Crossing(usize, usize, Point),
}

/// The faults of a ring (not closed), at most `limit` of them. A vertex where the outline turns by more than
/// 180 degrees less `spike` degrees is a spike. Neighbours at the same place count as one.
pub fn faults(ring: &[Point], spike: f64, limit: usize) -> Vec<RingFault> {
    if let Some(bad) = ring.iter().position(|p| !(p.x.is_finite() && p.y.is_finite())) {
        return vec![RingFault::NotFinite(bad)];
    }
    let mut kept: Vec<usize> = Vec::with_capacity(ring.len());
    for (i, p) in ring.iter().enumerate() {
        if kept.last().is_none_or(|&last| ring[last] != *p) {
            kept.push(i);
        }
    }
    while kept.len() > 1 && ring[kept[0]] == ring[kept[kept.len() - 1]] {
        kept.pop();
    }
    let count = kept.len();
    if count < 3 {
        return vec![RingFault::TooFew(count)];
    }
    let at = |i: usize| ring[kept[i % count]];
    let mut found: Vec<RingFault> = (0..count)
        .filter(|&i| {
            let here = at(i);
            let [before, behind] = [at(i + count - 1) - here, at(i + 1) - here];
            // Few turn back at all; the angle is dear.
            (before.dot(&behind) > 0.0 || spike > 90.0)
                && super::angle_between(before, behind).abs().to_degrees() < spike
        })
        .map(|i| RingFault::Spike(kept[i]))
        .take(limit)
        .collect();
    if found.len() == limit || goes_around(kept.iter().map(|&i| ring[i])) {
        return found;
    }
    let apart = |i: usize, j: usize| j > i + 1 && !(i == 0 && j == count - 1);
    let mut meet = |i: usize, j: usize| {
        if found.len() < limit
            && let Some(place) = meeting(at(i), at(i + 1), at(j), at(j + 1))
        {
            found.push(RingFault::Crossing(kept[i], kept[j], place));
        }
        found.len() < limit
    };
    let boxes: Vec<Aabb> = (0..count).map(|i| (at(i), at(i + 1))).map(|(a, b)| aabb(a, b)).collect();
    if count <= FEW {
        let near = |i: usize, j: usize| apart(i, j) && boxes[i].intersects(&boxes[j]);
        (0..count).all(|i| (i + 2..count).filter(|&j| near(i, j)).all(|j| meet(i, j)));
    } else if count <= MANY {
        touching(&boxes, apart).into_iter().all(|(i, j)| meet(i, j));
    } else {
        let of_box = |(i, reach): (usize, &Aabb)| GeomWithData::new(Rectangle::from_aabb(*reach), i);
        let tree = RTree::bulk_load(boxes.iter().enumerate().map(of_box).collect());
        (0..count).all(|i| {
            let near = tree.locate_in_envelope_intersecting(&boxes[i]).map(|edge| edge.data);
            let mut near: Vec<usize> = near.filter(|&j| apart(i, j)).collect();
            near.sort_unstable();
            near.into_iter().all(|j| meet(i, j))
        });
    }
    found
}

/// An edge and a place beside it span at least twice this, square metres, if it passes the place on one side for sure.
const SURE: f64 = 1e-6;

/// Whether a ring surely goes around the middle of its vertices once, without ever turning back: so it does not meet itself.
fn goes_around(ring: impl ExactSizeIterator<Item = Point> + DoubleEndedIterator + Clone) -> bool {
    let middle = ring.clone().map(|p| p.coords).sum::<Vector>() / ring.len() as f64;
    let mut spokes = ring.map(|p| p.coords - middle);
    let Some(mut before) = spokes.clone().next_back() else { return false };
    let side = spokes.clone().next().map_or(0.0, |first| cross(before, first).signum());
    // It passes what lies to the east of the middle and what lies to the west once each.
    let mut passed = 0;
    let onward = spokes.all(|next| {
        passed += usize::from((before.y < 0.0) != (next.y < 0.0));
        let onward = cross(before, next) * side > SURE;
        before = next;
        onward
    });
    onward && passed == 2
}

type Aabb = AABB<[f64; 2]>;

fn aabb(a: Point, b: Point) -> Aabb {
    AABB::from_corners([a.x, a.y], [b.x, b.y])
}

/// Up to so many edges each is held against every other, ...
const FEW: usize = 48;
/// ... up to so many a sweep finds those that come near each other; beyond, a tree.
const MANY: usize = 512;

/// The pairs of boxes that touch and count, lower index first, ascending: by a sweep along the axis on which they spread
/// most.
fn touching(boxes: &[Aabb], counts: impl Fn(usize, usize) -> bool) -> Vec<(usize, usize)> {
    let all = boxes.iter().fold(Aabb::new_empty(), |all, one| all.merged(one));
    let spread = |axis: usize| all.upper()[axis] - all.lower()[axis];
    let axis = usize::from(spread(1) > spread(0));
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_unstable_by(|&i, &j| boxes[i].lower()[axis].total_cmp(&boxes[j].lower()[axis]));
    let mut pairs = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        let end = boxes[i].upper()[axis];
        let ahead = order[k + 1..].iter().take_while(|&&j| boxes[j].lower()[axis] <= end);
        let ahead = ahead.map(|&j| (i.min(j), i.max(j))).filter(|&(a, b)| counts(a, b));
        pairs.extend(ahead.filter(|&(a, b)| boxes[a].intersects(&boxes[b])));
    }
    pairs.sort_unstable();
    pairs
}

/// Whether a ring is a simple polygon; see [`faults`].
pub fn is_simple(ring: &[Point]) -> bool {
    faults(ring, 0.0, 1).is_empty()
}

/// Where two segments meet, ends included.
fn meeting(a: Point, b: Point, c: Point, d: Point) -> Option<Point> {
    let sides = [orientation(a, b, c), orientation(a, b, d), orientation(c, d, a), orientation(c, d, b)];
    if sides[0] * sides[1] < 0.0 && sides[2] * sides[3] < 0.0 {
        return super::line_crossing(a, b - a, c, d - c).map(|(_, _, p)| p).or(Some(a));
    }
    let on = |p: Point, q: Point, r: Point| (r - p).dot(&(r - q)) <= 0.0;
    [(c, a, b), (d, a, b), (a, c, d), (b, c, d)]
        .into_iter()
        .zip(sides)
        .find(|&((r, p, q), side)| side == 0.0 && on(p, q, r))
        .map(|((r, _, _), _)| r)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn a_square_is_simple_either_way_round() {
        let mut square = ring(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        assert!(is_simple(&square));
        square.reverse();
        assert!(is_simple(&square));
    }

    #[test]
    fn a_bow_tie_crosses_in_the_middle() {
        let bow = ring(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)]);
        assert_eq!(faults(&bow, 1.0, 9), [RingFault::Crossing(0, 2, Point::new(1.0, 1.0))]);
    }

    #[test]
    fn a_touch_a_spike_and_a_line_are_found() {
        let touch = ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 0.0), (0.0, 4.0)]);
        assert!(matches!(faults(&touch, 1.0, 1)[0], RingFault::Crossing(0, ..)));
        let spike = ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (8.0, 4.01), (3.9, 4.0)]);
        assert_eq!(faults(&spike, 1.0, 9), [RingFault::Spike(3)]);
        assert_eq!(faults(&ring(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)]), 1.0, 9), [RingFault::TooFew(2)]);
        assert_eq!(faults(&ring(&[(0.0, f64::NAN)]), 1.0, 9), [RingFault::NotFinite(0)]);
    }
}
