//! Finds boxes by place with a hashed grid, for many small boxes of similar size. It finds all touching pairs of 100 000 boxes
//! in 46 ms; an `rstar` tree takes 80 ms (of 20 000: 5 ms and 14 ms).

use rayon::prelude::*;

use crate::parallel::InSmallParts;

use super::Point;

/// A box: its lowest and its highest corner.
pub type Bounds = [Point; 2];

/// A box that covers more cells than this is kept in a list and compared with every query.
const MAX_CELLS: i64 = 64;

/// Boxes by the cells that they cover.
#[derive(Clone, Debug)]
pub struct SpatialHash {
    /// Cells per metre.
    per_metre: f64,
    boxes: Vec<Bounds>,
    /// For each bucket the start of its boxes in `indices`, and the end of the last. The number of buckets is a power of two.
    starts: Vec<u32>,
    indices: Vec<u32>,
    large: Vec<u32>,
}

impl SpatialHash {
    /// Sorts boxes into cells of this side, metres; best a little larger than a box.
    pub fn new(boxes: Vec<Bounds>, side: f64) -> Self {
        let mut hash =
            Self { per_metre: 1.0 / side, starts: Vec::new(), indices: Vec::new(), large: Vec::new(), boxes };
        let buckets = hash.boxes.len().next_power_of_two();
        let mut starts = vec![0_u32; buckets + 1];
        for (i, bounds) in hash.boxes.iter().enumerate() {
            match hash.range(bounds) {
                Some(range) => range.each(|x, y| starts[bucket(x, y, buckets) + 1] += 1),
                None => hash.large.push(i as u32),
            }
        }
        for bucket in 0..buckets {
            starts[bucket + 1] += starts[bucket];
        }
        let mut next = starts.clone();
        let mut indices = vec![0; starts[buckets] as usize];
        for (i, bounds) in hash.boxes.iter().enumerate() {
            let Some(range) = hash.range(bounds) else { continue };
            range.each(|x, y| {
                let next = &mut next[bucket(x, y, buckets)];
                indices[*next as usize] = i as u32;
                *next += 1;
            });
        }
        Self { starts, indices, ..hash }
    }

    /// The boxes of a bucket.
    fn bucket(&self, bucket: usize) -> &[u32] {
        &self.indices[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }

    /// Calls `each` with the index of every box that touches this one, rarely more than once.
    pub fn touching(&self, bounds: Bounds, mut each: impl FnMut(usize)) {
        let buckets = self.starts.len() - 1;
        let touches = |i: usize| touch(&self.boxes[i], &bounds);
        let Some(range) = self.range(&bounds) else {
            return (0..self.boxes.len()).filter(|&i| touches(i)).for_each(each);
        };
        range.each(|x, y| {
            for &i in self.bucket(bucket(x, y, buckets)) {
                let i = i as usize;
                // Both boxes may share several cells: the first one counts.
                let low = self.boxes[i][0];
                let first = self.cell(low.x).max(range.west) == x && self.cell(low.y).max(range.south) == y;
                if first && touches(i) {
                    each(i);
                }
            }
        });
        self.large.iter().map(|&i| i as usize).filter(|&i| touches(i)).for_each(each);
    }

    /// The results of `map` for the pairs of boxes that touch, lower index first, rarely more than once for a pair. Their order
    /// depends on the boxes only.
    pub fn pairs<T: Send>(&self, map: impl Fn(usize, usize) -> Option<T> + Sync) -> Vec<T> {
        let buckets = 0..self.starts.len() - 1;
        let small = buckets.into_par_iter().in_small_parts().flat_map_iter(|bucket| self.small_pairs(bucket));
        let large = self.large.par_iter().in_small_parts().flat_map_iter(|&i| self.large_pairs(i as usize));
        small.chain(large).filter_map(|(i, j)| map(i, j)).collect()
    }

    /// The touching pairs of boxes of which the first shared cell lies in a bucket.
    fn small_pairs(&self, index: usize) -> impl Iterator<Item = (usize, usize)> {
        let boxes = self.bucket(index);
        let pairs = boxes.iter().enumerate().flat_map(move |(k, i)| boxes[k + 1..].iter().map(move |j| (*i, *j)));
        pairs.map(|(i, j)| (i.min(j) as usize, i.max(j) as usize)).filter(move |&(i, j)| {
            let [a, b] = [&self.boxes[i], &self.boxes[j]];
            let first = |buckets| bucket(self.cell(a[0].x.max(b[0].x)), self.cell(a[0].y.max(b[0].y)), buckets);
            i != j && touch(a, b) && first(self.starts.len() - 1) == index
        })
    }

    /// The touching pairs of a large box. Of two large boxes only the first finds the second.
    fn large_pairs(&self, large: usize) -> impl Iterator<Item = (usize, usize)> {
        let others = (0..self.boxes.len()).filter(move |&i| {
            let touches = i != large && touch(&self.boxes[i], &self.boxes[large]);
            touches && (i > large || self.range(&self.boxes[i]).is_some())
        });
        others.map(move |i| (i.min(large), i.max(large)))
    }

    /// The column or row of a coordinate.
    fn cell(&self, v: f64) -> i64 {
        let cells = v * self.per_metre;
        // Faster than `floor`, which is a function call on processors without an instruction for it.
        let whole = cells as i64;
        whole.saturating_sub(i64::from(whole as f64 > cells))
    }

    /// The cells that a box covers; `None` if they are more than [`MAX_CELLS`].
    fn range(&self, [low, high]: &Bounds) -> Option<Range> {
        let [west, south, east, north] = [low.x, low.y, high.x, high.y].map(|v| self.cell(v));
        let [wide, high] = [east.saturating_sub(west), north.saturating_sub(south)].map(|n| n.saturating_add(1));
        (wide.saturating_mul(high) <= MAX_CELLS).then_some(Range { west, south, east, north })
    }
}

/// A rectangle of cells, its borders included.
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

/// The bucket of a cell. `buckets` is a power of two.
fn bucket(x: i64, y: i64, buckets: usize) -> usize {
    /// Odd numbers without a pattern: the golden ratio and a prime of xxHash.
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
        fn finds_touching_boxes(
            boxes in prop::collection::vec((-50.0..50.0, -50.0..50.0, 0.0..20.0, 0.0..200.0), 0..60),
            (x, y, size) in (-60.0..60.0, -60.0..60.0, 0.0..300.0),
        ) {
            let of = |(x, y, w, h): (f64, f64, f64, f64)| [Point::new(x, y), Point::new(x + w, y + h)];
            let boxes: Vec<Bounds> = boxes.into_iter().map(of).collect();
            let query = of((x, y, size, size));
            let mut found: Vec<usize> = Vec::new();
            SpatialHash::new(boxes.clone(), 8.0).touching(query, |i| found.push(i));
            found.sort_unstable();
            found.dedup();
            let expected: Vec<usize> = (0..boxes.len()).filter(|&i| touch(&boxes[i], &query)).collect();
            prop_assert_eq!(found, expected);
        }

        #[test]
        fn finds_touching_pairs(
            boxes in prop::collection::vec((-50.0..50.0, -50.0..50.0, 0.0..20.0, 0.0..200.0), 0..60),
        ) {
            let of = |(x, y, w, h): (f64, f64, f64, f64)| [Point::new(x, y), Point::new(x + w, y + h)];
            let boxes: Vec<Bounds> = boxes.into_iter().map(of).collect();
            let mut found = SpatialHash::new(boxes.clone(), 8.0).pairs(|i, j| Some((i, j)));
            found.sort_unstable();
            found.dedup();
            let all = (0..boxes.len()).flat_map(|i| (i + 1..boxes.len()).map(move |j| (i, j)));
            let expected: Vec<(usize, usize)> = all.filter(|&(i, j)| touch(&boxes[i], &boxes[j])).collect();
            prop_assert_eq!(found, expected);
        }
    }
}
