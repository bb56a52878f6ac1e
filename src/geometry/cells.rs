//! Boxes found by place: a grid of cells, hashed. For many small boxes of like size, which a tree sorts at more cost.

use super::Point;

/// A box: its lowest and highest coordinates.
pub type Bounds = [Point; 2];

/// A box that covers more cells than this is kept apart and held against every question.
const MOST: i64 = 64;

/// Boxes by the cells that they cover.
#[derive(Clone, Debug)]
pub struct Cells {
    side: f64,
    boxes: Vec<Bounds>,
    /// Per bucket where its boxes begin in `covered`; a power of two of buckets, and the end.
    begins: Vec<u32>,
    covered: Vec<u32>,
    large: Vec<u32>,
}

impl Cells {
    /// Sorts boxes into cells of this side, metres: best a little more than a box has.
    pub fn new(boxes: Vec<Bounds>, side: f64) -> Self {
        let mut cells = Self { side, begins: Vec::new(), covered: Vec::new(), large: Vec::new(), boxes };
        let buckets = cells.boxes.len().next_power_of_two();
        let mut begins = vec![0_u32; buckets + 1];
        for (i, reach) in cells.boxes.iter().enumerate() {
            match cells.buckets(reach, buckets) {
                Some(covered) => covered.for_each(|bucket| begins[bucket + 1] += 1),
                None => cells.large.push(i as u32),
            }
        }
        for bucket in 0..buckets {
            begins[bucket + 1] += begins[bucket];
        }
        let mut next = begins.clone();
        let mut covered = vec![0; begins[buckets] as usize];
        for (i, reach) in cells.boxes.iter().enumerate() {
            for bucket in cells.buckets(reach, buckets).into_iter().flatten() {
                covered[next[bucket] as usize] = i as u32;
                next[bucket] += 1;
            }
        }
        Self { begins, covered, ..cells }
    }

    /// The indices of the boxes that touch this one, some of them more than once.
    pub fn touching(&self, reach: Bounds) -> impl Iterator<Item = usize> + '_ {
        let buckets = self.begins.len() - 1;
        let few = self.buckets(&reach, buckets);
        let all = few.is_none().then_some(0..self.boxes.len() as u32);
        let in_cells = few.into_iter().flatten().flat_map(move |bucket| {
            let covered = &self.covered[self.begins[bucket] as usize..self.begins[bucket + 1] as usize];
            covered.iter().copied()
        });
        let large = self.large.iter().copied();
        let found = in_cells.chain(large).chain(all.into_iter().flatten()).map(|i| i as usize);
        found.filter(move |&i| touch(&self.boxes[i], &reach))
    }

    /// The buckets of the cells that a box covers; `None` if they are many.
    fn buckets(&self, [low, high]: &Bounds, buckets: usize) -> Option<impl Iterator<Item = usize> + use<>> {
        let cell = |v: f64| (v / self.side).floor() as i64;
        let (west, south, east, north) = (cell(low.x), cell(low.y), cell(high.x), cell(high.y));
        let [wide, high] = [east.saturating_sub(west), north.saturating_sub(south)].map(|n| n.saturating_add(1));
        let few = wide.saturating_mul(high) <= MOST;
        few.then(|| (west..=east).flat_map(move |x| (south..=north).map(move |y| bucket(x, y, buckets))))
    }
}

/// The bucket of a cell among a power of two of them.
fn bucket(x: i64, y: i64, buckets: usize) -> usize {
    /// Odd numbers without a pattern: neighbours come to lie far apart.
    const SPREAD: [u64; 2] = [0x9e37_79b9_7f4a_7c15, 0xc2b2_ae3d_27d4_eb4f];
    let mixed = (x as u64).wrapping_mul(SPREAD[0]) ^ (y as u64).wrapping_mul(SPREAD[1]);
    (mixed >> 32) as usize & (buckets - 1)
}

fn touch(a: &Bounds, b: &Bounds) -> bool {
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
            let mut found: Vec<usize> = Cells::new(boxes.clone(), 8.0).touching(reach).collect();
            found.sort_unstable();
            found.dedup();
            let wanted: Vec<usize> = (0..boxes.len()).filter(|&i| touch(&boxes[i], &reach)).collect();
            prop_assert_eq!(found, wanted);
        }
    }
}
