//! Which OpenStreetMap nodes are one intersection on the ground, where the user knows better than the program.

use serde::{Deserialize, Serialize};

use super::Origin;

/// One `[[merge]]` or `[[keep_apart]]` of `lanewright.toml`: roads that lie inside an intersection, or do not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MergeSettings {
    /// Which roads: those between any two of these OpenStreetMap nodes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<i64>,
    /// Which roads: those made from this OpenStreetMap way.
    pub way: Option<i64>,
    /// Which road: the one at this place, latitude and longitude.
    pub at: Option<[f64; 2]>,
    /// Why.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// Its position in the file; `None` unless read from a document.
    #[serde(skip)]
    pub origin: Option<Origin>,
}

impl MergeSettings {
    /// What is wrong with it: it must name roads in one way.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let ways = [!self.nodes.is_empty(), self.way.is_some(), self.at.is_some()];
        match ways.iter().filter(|said| **said).count() {
            0 => Some("it names no road"),
            1 if self.nodes.len() == 1 => Some("a road lies between two nodes, and only one is given"),
            1 => None,
            _ => Some("it names roads in more than one way"),
        }
    }
}
