//! Whether the ground inside an outline is that of an intersection.

use geo::Area;

use super::types::MapIndex;
use crate::geometry::{Point, polygon};

/// Of an area so small a share at least lies under its lanes: where they run around a block of ground, they are no intersection.
const LEAST_DRAWN: f64 = 0.9;

/// Why no area is drawn around lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Undrawn {
    /// No simple outline covers all of them.
    Tangled,
    /// Too small a share of its ground would lie under them.
    Bare(f64),
}

/// How much of the ground of an outline lies under its lanes, where that is too little.
pub fn too_bare(map: &MapIndex, lanes: &[usize], ring: &[Point]) -> Option<Undrawn> {
    let outlines: Vec<Vec<Point>> = lanes.iter().map(|&lane| map.lanes[lane].outline.clone()).collect();
    let under = polygon::ground(&outlines).unsigned_area();
    let whole = polygon::signed_area(ring).abs();
    (under < LEAST_DRAWN * whole).then(|| Undrawn::Bare(under / whole))
}
