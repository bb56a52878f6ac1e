//! `[loose_ends]` of `lanewright.toml`: lanelets that the streets themselves leave without a way on.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

/// Lanelets at whose start or end the streets lead nowhere, as where a one-way street begins that no other street leads to. `build` writes
/// them, and `check` tells of them as a note.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LooseEnds {
    /// Ids of lanelets to which nothing leads.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub starts: BTreeSet<i64>,
    /// Ids of lanelets from which nothing leads on.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub ends: BTreeSet<i64>,
}

impl LooseEnds {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.starts.is_empty() && self.ends.is_empty()
    }

    /// Adds others.
    pub fn extend(&mut self, other: Self) {
        self.starts.extend(other.starts);
        self.ends.extend(other.ends);
    }

    /// Keeps the lanelets for which this holds.
    pub fn retain(&mut self, kept: impl Fn(&i64) -> bool) {
        self.starts.retain(&kept);
        self.ends.retain(&kept);
    }
}
