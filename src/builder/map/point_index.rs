//! Points found by where they lie: those closer to each other than the eye can tell are one.

use crate::geometry::Point;
use crate::lanelet::PointId;

/// Points of an intersection closer than this, metres, are one: where two bounds cross on a point of each.
const SAME: f64 = 2e-3;
/// Two to the power of this many cells of that size along either side are one field of the table, a hand's breadth: few points
/// share one, and most places have all their neighbours in their own.
const FIELD: u32 = 6;

/// Cells of the plane.
type Cell = (i64, i64);

/// Points by their places.
#[derive(Clone, Debug, Default)]
pub struct PointIndex {
    /// The last point of the fields that fall together here, by its position in `points`; a power of two of them.
    fields: Vec<Option<u32>>,
    points: Vec<Placed>,
}

#[derive(Clone, Debug)]
struct Placed {
    place: Point,
    id: PointId,
    /// The one before in its field, or in one that falls together with it.
    before: Option<u32>,
}

impl PointIndex {
    /// The point at a place, which `make` makes if there is none yet, and where it lies.
    pub fn at(&mut self, place: Point, make: impl FnOnce() -> PointId) -> (PointId, Point) {
        let home = cell(place);
        if let Some(known) = self.near(place, home) {
            return (known.id, known.place);
        }
        if self.points.len() == self.fields.len() {
            self.spread();
        }
        let id = make();
        let slot = self.slot(field(home));
        let before = self.fields[slot].replace(self.points.len() as u32);
        self.points.push(Placed { place, id, before });
        (id, place)
    }

    /// The point at a place, in the first of the cells around it that has one so near; of two there, the later.
    fn near(&self, place: Point, (x, y): Cell) -> Option<&Placed> {
        if self.points.is_empty() {
            return None;
        }
        let (low, high) = (field((x - 1, y - 1)), field((x + 1, y + 1)));
        let mut found: Option<u32> = None;
        for field in (low.0..=high.0).flat_map(|x| (low.1..=high.1).map(move |y| (x, y))) {
            let mut next = self.fields[self.slot(field)];
            while let Some(at) = next {
                let placed = &self.points[at as usize];
                next = placed.before;
                let apart = placed.place - place;
                // Few come so near that the root is worth its time.
                if apart.norm_squared() < 2.0 * SAME * SAME && apart.norm() < SAME {
                    let order = |at: u32| (cell(self.points[at as usize].place), std::cmp::Reverse(at));
                    found = Some(found.map_or(at, |found| if order(at) < order(found) { at } else { found }));
                }
            }
        }
        found.map(|at| &self.points[at as usize])
    }

    /// Makes room for as many points again.
    fn spread(&mut self) {
        /// What most intersections have at least.
        const FEW: usize = 256;
        let count = (2 * self.fields.len()).max(FEW);
        self.fields = vec![None; count];
        self.points.reserve_exact(count - self.points.len());
        for at in 0..self.points.len() {
            let slot = self.slot(field(cell(self.points[at].place)));
            self.points[at].before = self.fields[slot].replace(at as u32);
        }
    }

    /// Where a field stands in the table.
    fn slot(&self, (x, y): Cell) -> usize {
        /// Odd numbers without a pattern: neighbours come to lie far apart.
        const SPREAD: [u64; 2] = [0x9e37_79b9_7f4a_7c15, 0xc2b2_ae3d_27d4_eb4f];
        let mixed = (x as u64).wrapping_mul(SPREAD[0]) ^ (y as u64).wrapping_mul(SPREAD[1]);
        (mixed >> 32) as usize & (self.fields.len() - 1)
    }
}

fn cell(place: Point) -> Cell {
    // Rounded without `round`, which is a function call where processors may be old.
    let rounded = |cells: f64| (cells + 0.5_f64.copysign(cells)) as i64;
    (rounded(place.x / SAME), rounded(place.y / SAME))
}

fn field((x, y): Cell) -> Cell {
    (x >> FIELD, y >> FIELD)
}
