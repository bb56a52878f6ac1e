//! The trim of a dead end.

use super::OutlineOptions;
use super::thicken::ThickenedArm;

/// Largest share of a road that a dead end takes.
const SHARE: f64 = 0.4;

/// How far a road is cut back for the square at its dead end, metres.
pub fn dead_end(arm: &ThickenedArm, options: &OutlineOptions) -> f64 {
    arm.half.min(arm.length * SHARE).max(options.least_trim)
}
