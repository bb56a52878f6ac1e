//! Rings that cross themselves so often that nobody can say what they enclose.

use std::borrow::Cow;

use super::{Point, polygon, simple_ring};

/// A ring with more points than this may be tangled.
const LONG: usize = 400;
/// So many crossings for each point are too many.
const MOST_CROSSINGS: usize = 4;

/// The ring, or its hull if it is tangled: to cut such a ring at all its crossings takes as much time as there are pairs of points.
pub fn untangled(ring: &[Point]) -> Cow<'_, [Point]> {
    let most = MOST_CROSSINGS * ring.len();
    let is_tangled = ring.len() > LONG && simple_ring::faults(ring, 0.0, most).len() >= most;
    if is_tangled { Cow::Owned(polygon::convex_hull(ring.iter().copied())) } else { Cow::Borrowed(ring) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_tangled_ring_the_hull_counts_and_of_a_ring_with_few_crossings_the_ring() {
        // Golden angles spread points over a disc; each edge crosses most others.
        let at = |i: usize, angle: f64| 50.0 * Point::new((i as f64 * angle).cos(), (i as f64 * angle).sin());
        let tangled: Vec<Point> = (0..500).map(|i| at(i, 2.399_963)).collect();
        let hull = polygon::signed_area(&untangled(&tangled)).abs();
        assert!(hull > 7_800.0, "a circle of 50 m has 7,854 m2: {hull}");
        assert!(polygon::overlap(&tangled, &tangled) > 7_800.0);
        let mut circle: Vec<Point> = (0..500).map(|i| at(i, std::f64::consts::TAU / 500.0)).collect();
        circle.swap(10, 40);
        assert_eq!(untangled(&circle), circle);
    }
}
