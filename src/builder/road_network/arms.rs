//! The cyclic order of road ends around a node.

use std::cmp::Ordering;

use crate::geometry::{Point, Polyline, Vector, cross, orientation};

/// Distance from the node, metres, at which directions are compared: beyond the jitter of a mapper's hand, before
/// the roads bend toward elsewhere.
const LOOK: f64 = 4.0;

/// How often the distance is doubled where two roads leave in nearly the same direction.
const DOUBLINGS: usize = 6;

/// Roads drawn closer together than this, metres, may lie on either side of each other: a mapper's accuracy.
const UNCLEAR: f64 = 1.0;

/// One road end at a node: its line as seen from the node, and what breaks ties.
pub(crate) struct Ray<K> {
    /// From the node outwards.
    pub line: Polyline,
    /// Distinct for every ray.
    pub key: K,
}

/// The order of `rays` clockwise around the node, beginning at the smallest key.
pub(crate) fn clockwise<K: Ord>(node: Point, rays: &[Ray<K>]) -> Vec<usize> {
    let shortest = rays.iter().map(|ray| ray.line.length()).fold(f64::INFINITY, f64::min);
    let look = LOOK.min(shortest / 2.0);
    let samples: Vec<Vec<Point>> =
        rays.iter().map(|ray| (0..DOUBLINGS).map(|n| ray.line.at(look * f64::from(1_u32 << n))).collect()).collect();
    let mut order: Vec<usize> = (0..rays.len()).collect();
    order.sort_by(|&a, &b| {
        // Seen from the west at first, then from behind the direction that the two have in common, lest the
        // seam of the angles part them.
        let mut behind = node - Vector::x();
        let mut found = Ordering::Equal;
        for (p, q) in samples[a].iter().zip(&samples[b]) {
            found = found.then_with(|| turn_order(node, behind, *q, *p));
            behind = node - (samples[a][0] - node);
        }
        found.then_with(|| rays[a].key.cmp(&rays[b].key))
    });
    let misplaced = |order: &[usize], i: usize| {
        let (a, b) = (order[i], order[(i + 1) % order.len()]);
        part_to_the_left(node, &samples[a], &samples[b])
    };
    // What has changed places is told apart: each pair does so once.
    for _ in 0..order.len() * order.len() {
        let Some(i) = (0..order.len()).find(|&i| misplaced(&order, i)) else { break };
        let next = (i + 1) % order.len();
        order.swap(i, next);
    }
    if let Some(first) = (0..order.len()).min_by_key(|&i| &rays[order[i]].key) {
        order.rotate_left(first);
    }
    order
}

/// Whether the second of two rays, which leaves in nearly the same direction on the right of the first, lies on its left
/// where they have come apart.
fn part_to_the_left(node: Point, a: &[Point], b: &[Point]) -> bool {
    let aside = |(p, q): (&Point, &Point)| {
        let (p, q) = (p - node, q - node);
        (p.dot(&q) > 0.0).then(|| cross(p, q) / p.norm().max(q.norm()))
    };
    let mut aside = a.iter().zip(b).map_while(aside).peekable();
    aside.peek().is_some_and(|first| *first <= 0.0)
        && aside.find(|aside| aside.abs() >= UNCLEAR).is_some_and(|aside| aside > 0.0)
}

/// Compares the directions from `node` to `p` and `q` counter-clockwise from that to `seam`, exactly.
fn turn_order(node: Point, seam: Point, p: Point, q: Point) -> Ordering {
    let second_half = |p: Point| {
        let side = orientation(node, seam, p);
        side < 0.0 || (side == 0.0 && (p - node).dot(&(seam - node)) < 0.0)
    };
    second_half(p).cmp(&second_half(q)).then_with(|| 0.0_f64.total_cmp(&orientation(node, p, q)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(ends: &[&[(f64, f64)]]) -> Vec<usize> {
        let rays: Vec<Ray<usize>> = ends
            .iter()
            .enumerate()
            .map(|(key, points)| {
                let start = std::iter::once(Point::new(0.0, 0.0));
                let line = Polyline::new(start.chain(points.iter().map(|(x, y)| Point::new(*x, *y)))).unwrap();
                Ray { line, key }
            })
            .collect();
        clockwise(Point::new(0.0, 0.0), &rays)
    }

    #[test]
    fn goes_clockwise_from_the_smallest_key() {
        let (n, e, s, w) = (&[(0.0, 9.0)][..], &[(9.0, 0.0)][..], &[(0.0, -9.0)][..], &[(-9.0, 0.0)][..]);
        assert_eq!(order(&[n, e, s, w]), [0, 1, 2, 3]);
        assert_eq!(order(&[w, s, e, n]), [0, 3, 2, 1]);
        assert_eq!(order(&[e, n]), [0, 1]);
    }

    #[test]
    fn tells_a_fraction_of_a_degree() {
        let a = &[(100.0, 0.001)][..];
        let b = &[(100.0, 0.0)][..];
        let c = &[(-50.0, 1.0)][..];
        assert_eq!(order(&[a, b, c]), [0, 1, 2]);
        assert_eq!(order(&[b, a, c]), [0, 2, 1]);
    }

    #[test]
    fn looks_further_where_roads_leave_together() {
        let left = &[(20.0, 0.0), (40.0, 10.0)][..];
        let right = &[(20.0, 0.0), (40.0, -10.0)][..];
        let back = &[(-50.0, 0.0)][..];
        assert_eq!(order(&[left, right, back]), [0, 1, 2]);
        assert_eq!(order(&[right, left, back]), [0, 2, 1]);
    }

    #[test]
    fn hears_what_is_farther_where_roads_leave_closer_than_one_can_draw() {
        let ramp = &[(6.0, 0.2), (30.0, -1.5), (90.0, -8.0)][..];
        let road = &[(90.0, 0.0)][..];
        let back = &[(-50.0, 0.0)][..];
        assert_eq!(order(&[road, ramp, back]), [0, 1, 2]);
        assert_eq!(order(&[ramp, road, back]), [0, 2, 1]);
        // Both beside a third, and none else at the node.
        let other = &[(6.0, -0.3), (90.0, -20.0)][..];
        assert_eq!(order(&[road, ramp, other]), [0, 1, 2]);
        assert_eq!(order(&[other, ramp, road]), [0, 2, 1]);
    }
}
