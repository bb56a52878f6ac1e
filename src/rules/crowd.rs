//! How many of the things at one place a rule compares with each other: all of a thousand would be half a million findings.

/// Where more than this number of lanes or nodes lie at one place, only the first are compared, and a finding says so. On no map that
/// people have drawn are there half as many.
pub const MOST: usize = 30;

/// What such a finding says of the lanes, nodes or pairs that it counts.
pub fn too_many(count: usize, what: &str) -> String {
    format!("{count} {what}: too many to compare; the first {MOST} were.")
}
