//! Finds where a ring is not simple.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, Envelope, RTree};

use super::{Point, Vector, angle_between, cross, orientation};

/// A reason why a ring is no simple polygon. Numbers are indices of the ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RingFault {
    /// Fewer than three distinct vertices; their number.
    TooFew(usize),
    /// A coordinate that is no number.
    NotFinite(usize),
    /// The outline turns back on itself at this vertex.
    Spike(usize),
    /// The edges that start at these vertices are no neighbours and meet at this point.
    Crossing(usize, usize, Point),
}

/// The faults of a ring (not closed), at most `limit` of them. A vertex is a spike if the outline turns there by more than 180
/// degrees minus `spike` degrees. Equal neighbours count as one vertex.
pub fn faults(ring: &[Point], spike: f64, limit: usize) -> Vec<RingFault> {
    if let Some(i) = ring.iter().position(|p| !(p.x.is_finite() && p.y.is_finite())) {
        return vec![RingFault::NotFinite(i)];
    }
    let ring = DistinctRing::new(ring);
    if ring.count() < 3 {
        return vec![RingFault::TooFew(ring.count())];
    }
    let spikes = (0..ring.count()).filter(|&i| ring.is_spike(i, spike));
    let mut found: Vec<RingFault> = spikes.map(|i| RingFault::Spike(ring.indices[i])).take(limit).collect();
    if found.len() < limit && !goes_around(ring.indices.iter().map(|&i| ring.points[i])) {
        found.extend(ring.crossings(limit - found.len()));
    }
    found
}

/// Whether a ring without faults stays so with this vertex, which has been inserted between its neighbours; see [`faults`].
pub fn stays_simple(ring: &[Point], spike: f64, inserted: usize) -> bool {
    let around = [ring.len() - 1, 0, 1].map(|i| ring[(inserted + i) % ring.len()]);
    if around[0] == around[1] || around[1] == around[2] || !around[1].coords.iter().all(|v| v.is_finite()) {
        return faults(ring, spike, 1).is_empty();
    }
    let ring = DistinctRing::new(ring);
    let count = ring.count();
    let Ok(own) = ring.indices.binary_search(&inserted) else { return faults(ring.points, spike, 1).is_empty() };
    if [count - 1, 0, 1].into_iter().any(|i| ring.is_spike((own + i) % count, spike)) {
        return false;
    }
    let new = [(own + count - 1) % count, own];
    let boxes = new.map(|edge| aabb(ring.vertex(edge), ring.vertex(edge + 1)));
    let meets = |(new, of_new): (usize, &Aabb), edge: usize| {
        let (i, j) = (new.min(edge), new.max(edge));
        ring.are_apart(i, j)
            && of_new.intersects(&aabb(ring.vertex(edge), ring.vertex(edge + 1)))
            && ring.crossing(i, j).is_some()
    };
    !(0..count).any(|edge| new.into_iter().zip(&boxes).any(|new| meets(new, edge)))
}

/// The vertices of a ring, by index, without those by which it turns back on itself or crosses itself: of two loops the smaller
/// is left out. Fixed vertices stay.
pub fn without_faults(ring: &[Point], spike: f64, is_fixed: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..ring.len()).collect();
    for _ in 0..ring.len() {
        let places: Vec<Point> = kept.iter().map(|&i| ring[i]).collect();
        let count = kept.len();
        let is_loose = |i: &usize| !is_fixed(kept[*i]);
        let loose: Vec<usize> = match faults(&places, spike, 1).first() {
            Some(RingFault::Spike(i)) => {
                [*i, (i + count - 1) % count, (i + 1) % count].into_iter().find(is_loose).into_iter().collect()
            }
            Some(RingFault::Crossing(i, j, _)) => {
                let inner = i + 1..j + 1;
                let outer: Vec<usize> = (0..count).filter(|k| !inner.contains(k)).collect();
                let smaller = if inner.len() <= outer.len() { inner.collect() } else { outer };
                smaller.into_iter().filter(is_loose).collect()
            }
            _ => break,
        };
        if loose.is_empty() || count < loose.len() + 3 {
            break;
        }
        let mut i = 0..;
        kept.retain(|_| i.next().is_none_or(|i| !loose.contains(&i)));
    }
    kept
}

/// A ring without equal neighbours. Edge `i` begins at vertex `i`.
struct DistinctRing<'a> {
    points: &'a [Point],
    /// The vertices, as indices of `points`.
    indices: Vec<usize>,
}

impl<'a> DistinctRing<'a> {
    fn new(points: &'a [Point]) -> Self {
        let mut indices: Vec<usize> = Vec::with_capacity(points.len());
        for (i, p) in points.iter().enumerate() {
            if indices.last().is_none_or(|&last| points[last] != *p) {
                indices.push(i);
            }
        }
        while indices.len() > 1 && points[indices[0]] == points[indices[indices.len() - 1]] {
            indices.pop();
        }
        Self { points, indices }
    }

    fn count(&self) -> usize {
        self.indices.len()
    }

    fn vertex(&self, i: usize) -> Point {
        self.points[self.indices[i % self.count()]]
    }

    fn is_spike(&self, i: usize, spike: f64) -> bool {
        let here = self.vertex(i);
        let [before, after] = [self.vertex(i + self.count() - 1) - here, self.vertex(i + 1) - here];
        // Few vertices turn back at all, and the angle is expensive.
        (before.dot(&after) > 0.0 || spike > 90.0) && angle_between(before, after).abs().to_degrees() < spike
    }

    /// The first crossings of edges, at most `limit`.
    fn crossings(&self, limit: usize) -> Vec<RingFault> {
        let count = self.count();
        let boxes: Vec<Aabb> = (0..count).map(|i| aabb(self.vertex(i), self.vertex(i + 1))).collect();
        let crossing = |(i, j): (usize, usize)| self.crossing(i, j);
        if count <= FEW {
            let pairs = (0..count).flat_map(|i| (i + 2..count).map(move |j| (i, j)));
            let near = pairs.filter(|&(i, j)| self.are_apart(i, j) && boxes[i].intersects(&boxes[j]));
            return near.filter_map(crossing).take(limit).collect();
        }
        if count <= MANY {
            return self.touching(&boxes).into_iter().filter_map(crossing).take(limit).collect();
        }
        let of_box = |(i, bounds): (usize, &Aabb)| GeomWithData::new(Rectangle::from_aabb(*bounds), i);
        let tree = RTree::bulk_load(boxes.iter().enumerate().map(of_box).collect());
        let near = (0..count).flat_map(|i| {
            let near = tree.locate_in_envelope_intersecting(&boxes[i]).map(|edge| (i, edge.data));
            let mut near: Vec<_> = near.filter(|&(i, j)| self.are_apart(i, j)).collect();
            near.sort_unstable();
            near
        });
        near.filter_map(crossing).take(limit).collect()
    }

    /// Whether edge `j` comes after edge `i` and is no neighbour of it.
    fn are_apart(&self, i: usize, j: usize) -> bool {
        j > i + 1 && !(i == 0 && j == self.count() - 1)
    }

    fn crossing(&self, i: usize, j: usize) -> Option<RingFault> {
        let place = meeting(self.vertex(i), self.vertex(i + 1), self.vertex(j), self.vertex(j + 1))?;
        Some(RingFault::Crossing(self.indices[i], self.indices[j], place))
    }

    /// The pairs of edges that are no neighbours and of which the boxes touch, ascending: a sweep along the axis of the larger
    /// extent.
    fn touching(&self, boxes: &[Aabb]) -> Vec<(usize, usize)> {
        let all = boxes.iter().fold(Aabb::new_empty(), |all, one| all.merged(one));
        let extent = |axis: usize| all.upper()[axis] - all.lower()[axis];
        let axis = usize::from(extent(1) > extent(0));
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        order.sort_unstable_by(|&i, &j| boxes[i].lower()[axis].total_cmp(&boxes[j].lower()[axis]));
        let mut pairs = Vec::new();
        for (k, &i) in order.iter().enumerate() {
            let end = boxes[i].upper()[axis];
            let ahead = order[k + 1..].iter().take_while(|&&j| boxes[j].lower()[axis] <= end);
            let ahead = ahead.map(|&j| (i.min(j), i.max(j))).filter(|&(a, b)| self.are_apart(a, b));
            pairs.extend(ahead.filter(|&(a, b)| boxes[a].intersects(&boxes[b])));
        }
        pairs.sort_unstable();
        pairs
    }
}

/// Margin for rounding, square metres: twice the area of the triangle between an edge and a point.
const MARGIN: f64 = 1e-6;

/// Whether a ring certainly goes around the mean of its vertices once without turning back, so that it does not meet itself.
fn goes_around(ring: impl ExactSizeIterator<Item = Point> + DoubleEndedIterator + Clone) -> bool {
    let middle = ring.clone().map(|p| p.coords).sum::<Vector>() / ring.len() as f64;
    let mut spokes = ring.map(|p| p.coords - middle);
    let Some(mut before) = spokes.clone().next_back() else { return false };
    let side = spokes.clone().next().map_or(0.0, |first| cross(before, first).signum());
    // Going around once, it crosses the horizontal through the middle twice.
    let mut crossings = 0;
    let onward = spokes.all(|next| {
        crossings += usize::from((before.y < 0.0) != (next.y < 0.0));
        let onward = cross(before, next) * side > MARGIN;
        before = next;
        onward
    });
    onward && crossings == 2
}

type Aabb = AABB<[f64; 2]>;

fn aabb(a: Point, b: Point) -> Aabb {
    AABB::from_corners([a.x, a.y], [b.x, b.y])
}

/// Up to this number of edges, each edge is compared with every other; ...
const FEW: usize = 48;
/// ... up to this number, a sweep finds the edges that are near each other; beyond, a tree.
const MANY: usize = 512;

/// Whether a ring is a simple polygon; see [`faults`].
pub fn is_simple(ring: &[Point]) -> bool {
    faults(ring, 0.0, 1).is_empty()
}

/// Whether edges of a ring cross, each with its ends on both sides of the other. A ring that only touches itself does not. Of one that
/// touches itself at more than four times as many places as it has edges, those are looked at.
pub fn crosses_itself(ring: &[Point]) -> bool {
    const FOR_EACH_EDGE: usize = 4;
    const ANYWAY: usize = 1_000;
    let mut places = ring.to_vec();
    places.dedup();
    faults(&places, 0.0, ANYWAY + FOR_EACH_EDGE * places.len()).iter().any(|fault| {
        let RingFault::Crossing(i, j, _) = *fault else { return false };
        let [a, b, c, d] = [i, i + 1, j, j + 1].map(|at| places[at % places.len()]);
        orientation(a, b, c) * orientation(a, b, d) < 0.0 && orientation(c, d, a) * orientation(c, d, b) < 0.0
    })
}

/// The point at which two segments meet, ends included.
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
    fn a_ring_with_one_more_vertex_is_judged_by_its_new_edges() {
        let star: Vec<Point> = (0..24)
            .map(|i| {
                let (angle, radius) = (f64::from(i) * std::f64::consts::TAU / 24.0, if i % 2 == 0 { 9.0 } else { 4.0 });
                Point::new(radius * angle.cos(), radius * angle.sin())
            })
            .collect();
        let mut judged = [0; 2];
        for (at, x, y) in (1..=24).flat_map(|at| (-10..=10).flat_map(move |x| (-10..=10).map(move |y| (at, x, y)))) {
            let mut ring = star.clone();
            ring.insert(at, Point::new(f64::from(x), f64::from(y)));
            let stays = stays_simple(&ring, 1.5, at);
            assert_eq!(stays, faults(&ring, 1.5, 1).is_empty(), "{at}: {x}, {y}");
            judged[usize::from(stays)] += 1;
        }
        assert!(judged.iter().all(|count| *count > 100), "{judged:?}");
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
    fn a_ring_that_touches_itself_does_not_cross_itself() {
        let corners = [(0.0, 0.0), (2.0, 2.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)];
        assert!(crosses_itself(&ring(&corners)));
        assert!(!crosses_itself(&ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 0.0), (0.0, 4.0)])));
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
