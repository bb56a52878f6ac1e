//! Merge decisions in words.

use std::fmt;

use super::{MergeNote, MergeReason};

impl MergeReason {
    /// The reason as a clause about the road.
    pub fn words(self) -> &'static str {
        match self {
            Self::Wish => "lanewright.toml says so",
            Self::Tagged => "it is tagged junction=intersection",
            Self::Short => "no vehicle has room to wait on it",
            Self::BetweenSignals => "it lies between two signals with room for less than two cars",
            Self::AcrossMedian => "it crosses a median with room for less than three cars",
            Self::Overrun => "what passes an end of it runs over it",
            Self::OwnStopLine => "a stop line of its own stands on it",
            Self::Roundabout => "the whole roundabout would collapse",
            Self::Island => "traffic drives around an island inside",
            Self::Reach => "the intersection would reach too far",
            Self::Row => "it divides a long row of intersections without room between them",
            Self::Crowded => "too many roads would meet at the intersection",
            Self::Enclosed => "another road would be enclosed by the intersection",
            Self::Edge => "it ends at no intersection, or where the data ends",
        }
    }
}

impl fmt::Display for MergeNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.merged { "merged    " } else { "kept apart" };
        let Self { key, reason, left, .. } = self;
        write!(f, "{what} way {}, nodes {} to {}: {} ({left:.1} m left)", key.way, key.first, key.last, reason.words())
    }
}
