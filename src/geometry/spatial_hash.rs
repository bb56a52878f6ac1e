//! Boxes found by place: a grid of cells, hashed. For many small boxes of like size, which a tree sorts at more cost.

use rayon::prelude::*;

use crate::parallel::Finely;

use super::Point;

/// A box: its lowest and highest coordinates.
pub type Bounds = [Point; 2];

/// A box that covers more cells than this is kept apart and held against every question.
const MOST: i64 = 64;

/// Boxes by the cells that they cover.
#[derive(Clone, Debug)]
pub struct SpatialHash {
    /// Cells in one metre.
    per_metre: f64,
    boxes: Vec<Bounds>,
    /// Per bucket where its boxes begin in `covered`; a power of two of buckets, and the end.
    begins: Vec<u32>,
    covered: Vec<u32>,
    large: Vec<u32>,
}

impl SpatialHash {
    /// Sorts boxes into cells of this side, metres: best a little more than a box has.
    pub fn new(boxes: Vec<Bounds>, side: f64) -> Self {
        let mut cells =
            Self { per_metre: 1.0 / side, begins: Vec::new(), covered: Vec::new(), large: Vec::new(), boxes };
        let buckets = cells.boxes.len().next_power_of_two();
        let mut begins = vec![0_u32; buckets + 1];
        for (i, reach) in cells.boxes.iter().enumerate() {
            match cells.range(reach) {
                Some(range) => range.each(|x, y| begins[bucket(x, y, buckets) + 1] += 1),
                None => cells.large.push(i as u32),
            }
        }
        for bucket in 0..buckets {
            begins[bucket + 1] += begins[bucket];
        }
        let mut next = begins.clone();
        let mut covered = vec![0; begins[buckets] as usize];
        for (i, reach) in cells.boxes.iter().enumerate() {
            let Some(range) = cells.range(reach) else { continue };
            range.each(|x, y| {
                let next = &mut next[bucket(x, y, buckets)];
                covered[*next as usize] = i as u32;
                *next += 1;
            });
        }
        Self { begins, covered, ..cells }
    }

    /// Goes through the indices of the boxes that touch this one, seldom through one of them more than once.
    pub fn touching(&self, reach: Bounds, mut each: impl FnMut(usize)) {
        let buckets = self.begins.len() - 1;
        let touches = |i: usize| touch(&self.boxes[i], &reach);
        let Some(range) = self.range(&reach) else {
            return (0..self.boxes.len()).filter(|&i| touches(i)).for_each(each);
        };
        range.each(|x, y| {
            let bucket = bucket(x, y, buckets);
            for &i in &self.covered[self.begins[bucket] as usize..self.begins[bucket + 1] as usize] {
                let i = i as usize;
                // Both boxes may cover several cells: the first of these counts.
                let low = self.boxes[i][0];
                let first = self.cell(low.x).max(range.west) == x && self.cell(low.y).max(range.south) == y;
                if first && touches(i) {
                    each(i);
                }
            }
        });
        self.large.iter().map(|&i| i as usize).filter(|&i| touches(i)).for_each(each);
    }

    /// What is said of the pairs of boxes that touch, the lower index first; seldom of one of them more than once. In an order
    /// that depends on the boxes alone.
    pub fn pairs<T: Send>(&self, say: impl Fn(usize, usize) -> Option<T> + Sync) -> Vec<T> {
        let buckets = self.begins.len() - 1;
        let of_bucket = |at: usize| {
            let held = &self.covered[self.begins[at] as usize..self.begins[at + 1] as usize];
            let pairs = held.iter().enumerate().flat_map(move |(k, i)| held[k + 1..].iter().map(move |j| (*i, *j)));
            pairs.filter_map(move |(i, j)| {
                let (i, j) = (i.min(j) as usize, i.max(j) as usize);
                let [a, b] = [&self.boxes[i], &self.boxes[j]];
                // Both boxes may cover several cells: the first of these counts.
                let first = || bucket(self.cell(a[0].x.max(b[0].x)), self.cell(a[0].y.max(b[0].y)), buckets);
                let here = i != j && touch(a, b) && first() == at;
                here.then_some((i, j))
            })
        };
        let large = self.large.par_iter().finely().flat_map_iter(|&l| {
            let l = l as usize;
            let others = (0..self.boxes.len()).filter(move |&i| i != l && touch(&self.boxes[i], &self.boxes[l]));
            // Of two that are large, only the lower one finds the other.
            let others = others.filter(move |&i| i > l || self.range(&self.boxes[i]).is_some());
            others.map(move |i| (i.min(l), i.max(l)))
        });
        let small = (0..buckets).into_par_iter().finely().flat_map_iter(of_bucket);
        small.chain(large).filter_map(|(i, j)| say(i, j)).collect()
    }

    /// The column or row of a coordinate.
    fn cell(&self, v: f64) -> i64 {
        let cells = v * self.per_metre;
        // Cheaper than `floor`, for which processors without an instruction call a function.
        let whole = cells as i64;
        whole.saturating_sub(i64::from(whole as f64 > cells))
    }

    /// The cells that a box covers; `None` if they are many.
    fn range(&self, [low, high]: &Bounds) -> Option<Range> {
        let [west, south, east, north] = [low.x, low.y, high.x, high.y].map(|v| self.cell(v));
        let [wide, high] = [east.saturating_sub(west), north.saturating_sub(south)].map(|n| n.saturating_add(1));
        (wide.saturating_mul(high) <= MOST).then_some(Range { west, south, east, north })
    }
}

/// Cells from one to another, both among them.
struct Range {
    west: i64,
    south: i64,
    east: i64,
    north: i64,
}

impl Range {
    fn each(&self, mut visit: impl FnMut(i64, i64)) {
        for x in self.west..=self.east {
            for y in self.south..=self.north {
                visit(x, y);
            }
        }
    }
}

/// The bucket of a cell among a power of two of them.
fn bucket(x: i64, y: i64, buckets: usize) -> usize {
    /// Odd numbers without a pattern: neighbours come to lie far apart.
    const SPREAD: [u64; 2] = [0x9e37_79b9_7f4a_7c15, 0xc2b2_ae3d_27d4_eb4f];
    let mixed = (x as u64).wrapping_mul(SPREAD[0]) ^ (y as u64).wrapping_mul(SPREAD[1]);
    (mixed >> 32) as usize & (buckets - 1)
}

/// Whether two boxes share a point.
pub fn touch(a: &Bounds, b: &Bounds) -> bool {
    a[0].x <= b[1].x && b[0].x <= a[1].x && a[0].y <= b[1].y && b[0].y <= a[1].y
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_touches(
            boxes in prop::collection::vec((-50.0..50.0, -50.0..50.0, 0.0..20.0, 0.0..200.0), 0..60),
            (x, y, size) in (-60.0..60.0, -60.0..60.0, 0.0..300.0),
        ) {
            let of = |(x, y, w, h): (f64, f64, f64, f64)| [Point::new(x, y), Point::new(x + w, y + h)];
            let boxes: Vec<Bounds> = boxes.into_iter().map(of).collect();
            let reach = of((x, y, size, size));
            let mut found: Vec<usize> = Vec::new();
            SpatialHash::new(boxes.clone(), 8.0).touching(reach, |i| found.push(i));
            found.sort_unstable();
            found.dedup();
            let wanted: Vec<usize> = (0..boxes.len()).filter(|&i| touch(&boxes[i], &reach)).collect();
            prop_assert_eq!(found, wanted);
        }

        #[test]
        fn finds_the_pairs_that_touch(
            boxes in prop::collection::vec((-50.0..50.0, -50.0..50.0, 0.0..20.0, 0.0..200.0), 0..60),
        ) {
            let of = |(x, y, w, h): (f64, f64, f64, f64)| [Point::new(x, y), Point::new(x + w, y + h)];
            let boxes: Vec<Bounds> = boxes.into_iter().map(of).collect();
            let mut found = SpatialHash::new(boxes.clone(), 8.0).pairs(|i, j| Some((i, j)));
            found.sort_unstable();
            found.dedup();
            let all = (0..boxes.len()).flat_map(|i| (i + 1..boxes.len()).map(move |j| (i, j)));
            let wanted: Vec<(usize, usize)> = all.filter(|&(i, j)| touch(&boxes[i], &boxes[j])).collect();
            prop_assert_eq!(found, wanted);
        }
    }
}
