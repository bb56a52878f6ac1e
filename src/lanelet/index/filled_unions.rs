//! Unions of lanes with the gaps between them filled, remembered from one version of a map to the next: while a map is mended, most
//! lanes keep their shapes.

use std::sync::Mutex;

use rustc_hash::FxHashMap;

use crate::geometry::{Point, polygon};

/// Gaps between lanes up to twice this width (m) belong to the intersection: a median, a strip of paint.
pub(super) const FILLED: f64 = 2.0;

/// The bits of the coordinates of rings, metres: they tell even the smallest difference.
type Shapes = Vec<Vec<[u64; 2]>>;

/// The unions that were asked for before.
#[derive(Debug, Default)]
pub struct FilledUnions(Mutex<FxHashMap<Shapes, Option<Vec<Point>>>>);

impl FilledUnions {
    /// The outer edge of the union of rings after gaps are filled, clockwise, not closed; `None` if it is empty.
    pub(super) fn of(&self, rings: &[Vec<Point>]) -> Option<Vec<Point>> {
        let shapes: Shapes =
            rings.iter().map(|ring| ring.iter().map(|at| [at.x.to_bits(), at.y.to_bits()]).collect()).collect();
        let known = self.0.lock().ok().and_then(|known| known.get(&shapes).cloned());
        known.unwrap_or_else(|| {
            let edge = polygon::closed(rings, FILLED);
            if let Ok(mut known) = self.0.lock() {
                known.insert(shapes, edge.clone());
            }
            edge
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(west: f64) -> Vec<Point> {
        [[0.0, 0.0], [0.0, 10.0], [10.0, 10.0], [10.0, 0.0]].map(|[x, y]| Point::new(west + x, y)).to_vec()
    }

    #[test]
    fn what_is_remembered_is_what_was_computed() {
        let unions = FilledUnions::default();
        for west in [12.0, 12.0 + f64::EPSILON * 16.0, 30.0, 12.0] {
            let rings = [square(0.0), square(west)];
            assert_eq!(unions.of(&rings), polygon::closed(&rings, FILLED), "{west}");
        }
        assert_eq!(unions.0.lock().unwrap().len(), 3);
    }
}
