//! The trim of a dead end.

use super::sizes::LEAST_TRIM;
use super::thicken::ThickenedArm;

/// Largest share of a road that a dead end takes.
const SHARE: f64 = 0.4;

/// How far a road is cut back for the square at its dead end, metres.
pub fn dead_end(arm: &ThickenedArm) -> f64 {
    arm.half.min(arm.length * SHARE).max(LEAST_TRIM)
}
