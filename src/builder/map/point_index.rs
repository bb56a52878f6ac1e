//! Finds points by their places: points that are nearly at the same place become one.

use crate::geometry::Point;
use crate::lanelet::PointId;

/// Points of an intersection closer than this, metres, are one, such as points of two bounds where these cross.
const SAME_POINT: f64 = 2e-3;
/// A field of the table is a square of two to the power of this number of cells along either side (13 cm): few points share a
/// field, and most places have all their neighbours in their own.
const FIELD: u32 = 6;

/// Cells of the plane.
type Cell = (i64, i64);

/// Points by field.
#[derive(Clone, Debug, Default)]
pub struct PointIndex {
    /// For each slot, the last point of the fields with this slot, by its position in `points`. Their number is a power of two.
    fields: Vec<Option<u32>>,
    points: Vec<Placed>,
}

#[derive(Clone, Debug)]
struct Placed {
    place: Point,
    id: PointId,
    /// The point before it in the same slot.
    before: Option<u32>,
}

impl PointIndex {
    /// The point at a place, and its exact place. `make` makes the point if there is none.
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

    /// The point at a place: that in the first cell around it; of two in one cell, the later.
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
                // A root is expensive, and few points are so near.
                if apart.norm_squared() < 2.0 * SAME_POINT * SAME_POINT && apart.norm() < SAME_POINT {
                    let order = |at: u32| (cell(self.points[at as usize].place), std::cmp::Reverse(at));
                    found = Some(found.map_or(at, |found| if order(at) < order(found) { at } else { found }));
                }
            }
        }
        found.map(|at| &self.points[at as usize])
    }

    /// Doubles the table.
    fn spread(&mut self) {
        /// Most intersections have at least this number of points.
        const FEW: usize = 256;
        let count = (2 * self.fields.len()).max(FEW);
        self.fields = vec![None; count];
        self.points.reserve_exact(count - self.points.len());
        for at in 0..self.points.len() {
            let slot = self.slot(field(cell(self.points[at].place)));
            self.points[at].before = self.fields[slot].replace(at as u32);
        }
    }

    /// The slot of a field.
    fn slot(&self, (x, y): Cell) -> usize {
        /// Odd numbers without a pattern, so that neighbours get slots far apart.
        const SPREAD: [u64; 2] = [0x9e37_79b9_7f4a_7c15, 0xc2b2_ae3d_27d4_eb4f];
        let mixed = (x as u64).wrapping_mul(SPREAD[0]) ^ (y as u64).wrapping_mul(SPREAD[1]);
        (mixed >> 32) as usize & (self.fields.len() - 1)
    }
}

fn cell(place: Point) -> Cell {
    // Faster than `round`, which is a function call on processors without an instruction for it.
    let rounded = |cells: f64| (cells + 0.5_f64.copysign(cells)) as i64;
    (rounded(place.x / SAME_POINT), rounded(place.y / SAME_POINT))
}

fn field((x, y): Cell) -> Cell {
    (x >> FIELD, y >> FIELD)
}
