//! The common area of two rings, column by column of the plane: columns that the rings do not share are skipped, and the
//! search stops once the area is large enough.

use super::Point;
use super::polygon::Strips;

/// Width of a column, metres.
const WIDTH: f64 = 4.0;
/// The number of columns. The first and the last reach to infinity.
const COUNT: usize = 64;

/// A simple ring in columns, for comparison with many others.
pub struct StripIndex {
    strips: Strips,
    base: Point,
    /// The first column of the ring.
    west: usize,
    /// The lowest and the highest coordinate of the ring in each column from `west` on.
    heights: Vec<[f64; 2]>,
}

impl StripIndex {
    /// The index of a ring; `None` if it has no points. `base` must be the same for all rings that are compared.
    pub fn new(ring: &[Point], base: Point) -> Option<Self> {
        let column = |p: &Point| (((p.x - base.x) / WIDTH + COUNT as f64 / 2.0) as usize).min(COUNT - 1);
        let (mut before, strips) = (*ring.last()?, Strips::new(ring, base)?);
        let reached = ring.iter().map(column);
        let (west, east) = reached.fold((COUNT, 0), |(west, east), column| (west.min(column), east.max(column)));
        let mut heights = vec![[f64::INFINITY, f64::NEG_INFINITY]; east + 1 - west];
        let mut from = column(&before);
        for p in ring {
            let to = column(p);
            for [low, high] in &mut heights[from.min(to) - west..=from.max(to) - west] {
                (*low, *high) = (low.min(before.y).min(p.y), high.max(before.y).max(p.y));
            }
            (before, from) = (*p, to);
        }
        Some(Self { strips, base, west, heights })
    }

    /// The strips of the ring.
    pub fn strips(&self) -> &Strips {
        &self.strips
    }

    /// [`Strips::common_area`], square metres. If it is larger than `enough`, any area larger than that.
    pub fn common_area(&self, other: &Self, enough: f64) -> f64 {
        if !self.strips.may_touch(&other.strips) {
            return 0.0;
        }
        let first = self.west.max(other.west);
        let border = |column: usize| self.base.x + (column as f64 - COUNT as f64 / 2.0) * WIDTH;
        let heights = self.heights[(first - self.west).min(self.heights.len())..].iter();
        let others = other.heights[(first - other.west).min(other.heights.len())..].iter();
        let depths = heights.zip(others).map(|(a, b)| a[1].min(b[1]) - a[0].max(b[0]));
        let shared = (first..).zip(depths).filter(|(_, depth)| *depth > 0.0);
        // The column with the deepest overlap comes first: it shares the most.
        let Some((deepest, _)) = shared.clone().max_by(|a, b| a.1.total_cmp(&b.1)) else { return 0.0 };
        let mut sum = 0.0_f64;
        let rest = shared.map(|(column, _)| column).filter(|column| *column != deepest);
        for column in std::iter::once(deepest).chain(rest) {
            let from = if column == 0 { f64::NEG_INFINITY } else { border(column) };
            let to = if column + 1 == COUNT { f64::INFINITY } else { border(column + 1) };
            sum += self.strips.common_area_between(&other.strips, [from, to]);
            if sum.abs() > enough {
                break;
            }
        }
        sum.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn columns_add_up_to_the_whole(
            a in prop::collection::vec(1.0..40.0, 3..9),
            b in prop::collection::vec(1.0..400.0, 3..9),
            aside in (-90.0..90.0, -90.0..90.0),
            enough in 0.0..900.0,
        ) {
            // Stars around a centre are simple rings.
            let ring = |reach: &[f64], (x, y): (f64, f64)| -> Vec<Point> {
                let angle = |i: usize| std::f64::consts::TAU * i as f64 / reach.len() as f64;
                reach.iter().enumerate().map(|(i, r)| Point::new(x + r * angle(i).cos(), y + r * angle(i).sin())).collect()
            };
            let (a, b) = (ring(&a, (0.0, 0.0)), ring(&b, aside));
            let [a, b] = [a.clone(), b].map(|ring| StripIndex::new(&ring, a[0]).unwrap());
            let whole = a.strips().common_area(b.strips());
            prop_assert!((a.common_area(&b, f64::INFINITY) - whole).abs() < 1e-6);
            let some = a.common_area(&b, enough);
            prop_assert!(some <= whole + 1e-6 && (some > enough || (some - whole).abs() < 1e-6));
        }
    }
}
