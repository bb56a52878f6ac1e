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
    let sample = |ray: usize, doublings: usize| rays[ray].line.at(look * f64::from(1_u32 << doublings));
    let mut order: Vec<usize> = (0..rays.len()).collect();
    // Two have but one order around a node.
    if rays.len() > 2 {
        let near: Vec<Point> = order.iter().map(|ray| sample(*ray, 0)).collect();
        order.sort_by(|&a, &b| {
            // Seen from the west at first, then from behind the direction that the two have in common, lest the
            // seam of the angles part them.
            let behind = node - (near[a] - node);
            let farther = |doublings| turn_order(node, behind, sample(b, doublings), sample(a, doublings));
            let near = turn_order(node, node - Vector::x(), near[b], near[a]);
            let found = (1..DOUBLINGS).fold(near, |found, doublings| found.then_with(|| farther(doublings)));
            found.then_with(|| rays[a].key.cmp(&rays[b].key))
        });
        let next = |i: usize| (i + 1) % rays.len();
        let misplaced =
            |a: usize, b: usize| part_to_the_left(node, |doublings| [sample(a, doublings), sample(b, doublings)]);
        // What has changed places is told apart: each pair does so once.
        for _ in 0..rays.len() * rays.len() {
            let Some(i) = (0..rays.len()).find(|&i| misplaced(order[i], order[next(i)])) else { break };
            order.swap(i, next(i));
        }
    }
    if let Some(first) = (0..order.len()).min_by_key(|&i| &rays[order[i]].key) {
        order.rotate_left(first);
    }
    order
}

/// Whether the second of two rays, which leaves in nearly the same direction on the right of the first, lies on its left
/// where they have come apart. `pair` gives a place of each, after so many doublings of the distance.
fn part_to_the_left(node: Point, pair: impl Fn(usize) -> [Point; 2]) -> bool {
    let aside = |doublings: usize| {
        let [p, q] = pair(doublings).map(|place| place - node);
        (p.dot(&q) > 0.0).then(|| cross(p, q) / p.norm().max(q.norm()))
    };
    let mut aside = (0..DOUBLINGS).map_while(aside).peekable();
    aside.peek().is_some_and(|first| (-UNCLEAR..=0.0).contains(first))
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
