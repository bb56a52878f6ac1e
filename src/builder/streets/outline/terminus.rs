//! Where one road ends: a dead end, or the edge of the map.

use super::OutlineOptions;
use super::thicken::ThickenedArm;

/// The largest share of a road that a dead end takes.
const SHARE: f64 = 0.4;

/// How far the road is cut back for the square at its dead end.
pub fn dead_end(arm: &ThickenedArm, options: &OutlineOptions) -> f64 {
    arm.half.min(arm.length * SHARE).max(options.least_trim)
}
