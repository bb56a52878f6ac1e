//! Signals and objects beside and on roads.

use crate::text::Text;

/// The lanes and the direction for which a signal counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Validity {
    /// The direction of travel it faces: 1 along the road, -1 against it, 0 both.
    pub facing: i8,
    /// Ranges of lane ids; none: all lanes.
    pub lanes: Vec<[i64; 2]>,
}

impl Validity {
    /// Whether a lane id lies in the ranges, or there are none.
    pub fn names(&self, lane: i64) -> bool {
        let within = |[a, b]: &[i64; 2]| (*a.min(b)..=*a.max(b)).contains(&lane);
        self.lanes.is_empty() || self.lanes.iter().any(within)
    }
}

/// A sign, a light, or a line on the ground.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    /// Its id: any text.
    pub id: Text,
    /// The line on which it stands, from 1.
    pub line: usize,
    /// Station and offset to the left, metres.
    pub at: [f64; 2],
    /// Height above the road, metres.
    pub lift: f64,
    /// Its turn against the road, or against the other direction where it faces that, radians.
    pub turn: f64,
    /// Width and height, metres; 0 where not said.
    pub size: [f64; 2],
    /// Words about it.
    pub name: Text,
    /// The number of the sign in its country.
    pub kind: Text,
    /// Its variant.
    pub subkind: Text,
    /// The country whose numbers these are.
    pub country: Text,
    /// Whether it changes, as a light does.
    pub dynamic: bool,
    /// What it says, with the unit.
    pub value: Option<f64>,
    /// Of `value`.
    pub unit: Text,
    /// For whom it counts.
    pub validity: Validity,
    /// Signals that depend on it.
    pub dependencies: Vec<Text>,
}

/// That a signal of another road counts here, too.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignalReference {
    /// The signal.
    pub id: Text,
    /// The line on which it stands, from 1.
    pub line: usize,
    /// Station and offset to the left, metres.
    pub at: [f64; 2],
    /// For whom it counts here.
    pub validity: Validity,
}

/// A corner of an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Corner {
    /// By station, offset to the left, and height above the road.
    Road([f64; 3]),
    /// In the object's own axes.
    Local([f64; 3]),
}

/// An object: a crosswalk, a stop line, a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Object {
    /// Its id: any text.
    pub id: Text,
    /// The line on which it stands, from 1.
    pub line: usize,
    /// Station and offset to the left, metres.
    pub at: [f64; 2],
    /// Height above the road, metres.
    pub lift: f64,
    /// Its turn against the road, radians.
    pub turn: f64,
    /// Length along its own axis, and width, metres; 0 where not said.
    pub size: [f64; 2],
    /// Words about it.
    pub name: Text,
    /// `crosswalk`, `roadMark`, ...
    pub kind: Text,
    /// Its variant.
    pub subkind: Text,
    /// For whom it counts.
    pub validity: Validity,
    /// Its outlines.
    pub outlines: Vec<Vec<Corner>>,
}

impl Object {
    /// Its name and subtype as one lower-case word of letters and digits.
    pub fn words(&self) -> String {
        flat(&format!("{} {}", self.name, self.subkind))
    }
}

impl Signal {
    /// Its name as one lower-case word of letters and digits.
    pub fn words(&self) -> String {
        flat(&self.name)
    }
}

fn flat(words: &str) -> String {
    words.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}
