//! Points found by where they lie: those closer to each other than the eye can tell are one.

use rustc_hash::FxHashMap;

use crate::geometry::Point;
use crate::lanelet::PointId;

/// Points of an intersection closer than this, metres, are one: where two bounds cross on a point of each.
const SAME: f64 = 2e-3;
/// So many cells of that size along either side are one field of the table: a place has few neighbours, and most lie in its
/// own field.
const FIELD: i64 = 512;

/// Cells of the plane, no more than one point in each.
type Cell = (i64, i64);

/// Points by their places.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// The last point of every field, by its position in `points`.
    fields: FxHashMap<Cell, u32>,
    points: Vec<Placed>,
}

#[derive(Clone, Debug)]
struct Placed {
    place: Point,
    id: PointId,
    /// The one before in its field.
    before: Option<u32>,
}

impl Places {
    /// The point at a place, which `make` makes if there is none yet.
    pub fn at(&mut self, place: Point, make: impl FnOnce() -> PointId) -> PointId {
        if let Some(known) = self.near(place) {
            return known;
        }
        let id = make();
        let at = self.points.len() as u32;
        let before = self.fields.insert(field(cell(place)), at);
        self.points.push(Placed { place, id, before });
        id
    }

    /// The point at a place, in the first of the cells around it that has one so near.
    fn near(&self, place: Point) -> Option<PointId> {
        let (x, y) = cell(place);
        let (low, high) = (field((x - 1, y - 1)), field((x + 1, y + 1)));
        let mut found: Option<&Placed> = None;
        for field in (low.0..=high.0).flat_map(|x| (low.1..=high.1).map(move |y| (x, y))) {
            let mut at = self.fields.get(&field).copied();
            while let Some(placed) = at.map(|at| &self.points[at as usize]) {
                at = placed.before;
                let first = || found.is_none_or(|found| cell(placed.place) < cell(found.place));
                if (placed.place - place).norm() < SAME && first() {
                    found = Some(placed);
                }
            }
        }
        found.map(|placed| placed.id)
    }
}

fn cell(place: Point) -> Cell {
    ((place.x / SAME).round() as i64, (place.y / SAME).round() as i64)
}

fn field((x, y): Cell) -> Cell {
    (x.div_euclid(FIELD), y.div_euclid(FIELD))
}
