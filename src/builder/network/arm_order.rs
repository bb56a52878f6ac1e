//! The cyclic order of road ends around a node.

use std::cmp::Ordering;

use crate::geometry::{Point, Polyline, Vector, cross, orientation};

/// Distance from the node at which directions are compared, metres: beyond a mapper's inaccuracy, before the roads bend.
const LOOK: f64 = 4.0;

/// How often the distance is doubled where two roads leave in nearly the same direction.
const DOUBLINGS: usize = 6;

/// Roads closer together than this, metres, may lie on either side of each other: it is a mapper's accuracy.
const UNCLEAR: f64 = 1.0;

/// A road end at a node.
pub(crate) struct Ray<K> {
    /// From the node outwards.
    pub line: Polyline,
    /// Breaks ties; distinct for every ray.
    pub key: K,
}

/// The rays around a node with the distance, metres, at which they are compared first.
struct RayOrder<'a, K> {
    node: Point,
    rays: &'a [Ray<K>],
    look: f64,
}

/// The order of `rays` clockwise around the node, beginning at the smallest key.
pub(crate) fn clockwise<K: Ord>(node: Point, rays: &[Ray<K>]) -> Vec<usize> {
    let shortest = rays.iter().map(|ray| ray.line.length()).fold(f64::INFINITY, f64::min);
    let mut order: Vec<usize> = (0..rays.len()).collect();
    // Two rays have only one cyclic order.
    if rays.len() > 2 {
        let compared = RayOrder { node, rays, look: LOOK.min(shortest / 2.0) };
        order.sort_by(|&a, &b| compared.compare(a, b));
        compared.swap_misplaced(&mut order);
    }
    if let Some(first) = (0..order.len()).min_by_key(|&i| &rays[order[i]].key) {
        order.rotate_left(first);
    }
    order
}

impl<K: Ord> RayOrder<'_, K> {
    /// The point of a ray at the comparison distance after a number of doublings.
    fn sample(&self, ray: usize, doublings: usize) -> Point {
        self.rays[ray].line.at(self.look * f64::from(1_u32 << doublings))
    }

    /// Compares two rays clockwise from the west.
    fn compare(&self, a: usize, b: usize) -> Ordering {
        let [near_a, near_b] = [a, b].map(|ray| self.sample(ray, 0));
        let near = turn_order(self.node, self.node - Vector::x(), near_b, near_a);
        // Farther out from behind the common direction, so that the seam of the angles does not separate the two.
        let behind = self.node - (near_a - self.node);
        let farther = |doublings| turn_order(self.node, behind, self.sample(b, doublings), self.sample(a, doublings));
        let found = (1..DOUBLINGS).fold(near, |found, doublings| found.then_with(|| farther(doublings)));
        found.then_with(|| self.rays[a].key.cmp(&self.rays[b].key))
    }

    /// Swaps neighbours whose order is clear only farther out; each pair at most once.
    fn swap_misplaced(&self, order: &mut [usize]) {
        let count = order.len();
        for _ in 0..count * count {
            let misplaced = (0..count).find(|&i| self.diverge_to_the_left(order[i], order[(i + 1) % count]));
            let Some(i) = misplaced else { break };
            order.swap(i, (i + 1) % count);
        }
    }

    /// Whether ray `b`, which leaves in nearly the same direction on the right of `a`, lies on its left where the two have
    /// diverged.
    fn diverge_to_the_left(&self, a: usize, b: usize) -> bool {
        let aside = |doublings: usize| {
            let [p, q] = [a, b].map(|ray| self.sample(ray, doublings) - self.node);
            (p.dot(&q) > 0.0).then(|| cross(p, q) / p.norm().max(q.norm()))
        };
        let mut aside = (0..DOUBLINGS).map_while(aside).peekable();
        aside.peek().is_some_and(|first| (-UNCLEAR..=0.0).contains(first))
            && aside.find(|aside| aside.abs() >= UNCLEAR).is_some_and(|aside| aside > 0.0)
    }
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
    fn distinguishes_a_fraction_of_a_degree() {
        let a = &[(100.0, 0.001)][..];
        let b = &[(100.0, 0.0)][..];
        let c = &[(-50.0, 1.0)][..];
        assert_eq!(order(&[a, b, c]), [0, 1, 2]);
        assert_eq!(order(&[b, a, c]), [0, 2, 1]);
    }

    #[test]
    fn looks_farther_out_if_roads_leave_together() {
        let left = &[(20.0, 0.0), (40.0, 10.0)][..];
        let right = &[(20.0, 0.0), (40.0, -10.0)][..];
        let back = &[(-50.0, 0.0)][..];
        assert_eq!(order(&[left, right, back]), [0, 1, 2]);
        assert_eq!(order(&[right, left, back]), [0, 2, 1]);
    }

    #[test]
    fn looks_farther_out_if_roads_leave_closer_than_a_mapper_draws() {
        let ramp = &[(6.0, 0.2), (30.0, -1.5), (90.0, -8.0)][..];
        let road = &[(90.0, 0.0)][..];
        let back = &[(-50.0, 0.0)][..];
        assert_eq!(order(&[road, ramp, back]), [0, 1, 2]);
        assert_eq!(order(&[ramp, road, back]), [0, 2, 1]);
        // With a third road beside them, and no other at the node.
        let other = &[(6.0, -0.3), (90.0, -20.0)][..];
        assert_eq!(order(&[road, ramp, other]), [0, 1, 2]);
        assert_eq!(order(&[other, ramp, road]), [0, 2, 1]);
    }
}
