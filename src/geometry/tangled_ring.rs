//! Rings that cross themselves so often that nobody can say what they enclose.

use std::borrow::Cow;

use super::convex_hull::convex_hull;
use super::{Point, simple_ring};

/// A ring with more points than this may be tangled.
const LONG: usize = 400;
/// So many crossings for each point are too many.
const MOST_CROSSINGS: usize = 4;

/// The ring, or its hull if it is tangled: to cut such a ring at all its crossings takes as much time as there are pairs of points.
pub fn untangled(ring: &[Point]) -> Cow<'_, [Point]> {
    let most = MOST_CROSSINGS * ring.len();
    let is_tangled = ring.len() > LONG && simple_ring::faults(ring, 0.0, most).len() >= most;
    if is_tangled { Cow::Owned(convex_hull(ring.iter().copied())) } else { Cow::Borrowed(ring) }
}
