//! Signals and objects beside and on roads.

use crate::text::Text;

use super::road::{Place, Road};

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

/// The least breadth of an object that has none, metres.
const THIN: f64 = 0.1;

impl Object {
    /// Where it stands.
    pub fn place(&self, road: &Road) -> Place {
        let [x, y, z] = road.place(self.at[0], self.at[1]);
        [x, y, z + self.lift]
    }

    /// The corners of its first outline, else of the rectangle of its size; `None` where it has neither.
    pub fn ring(&self, road: &Road) -> Option<Vec<Place>> {
        let [x, y, z] = self.place(road);
        let (sin, cos) = (road.angle(self.at[0]) + self.turn).sin_cos();
        let local = |[u, v, w]: [f64; 3]| [x + cos * u - sin * v, y + sin * u + cos * v, z + w];
        let corner = |corner: &Corner| match *corner {
            Corner::Local(at) => local(at),
            Corner::Road([s, t, lift]) => {
                let [x, y, z] = road.place(s, t);
                [x, y, z + lift]
            }
        };
        if let Some(outline) = self.outlines.iter().find(|outline| outline.len() > 2) {
            let mut ring: Vec<Place> = outline.iter().map(corner).collect();
            let closes = |a: &Place, b: &Place| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
            if ring.len() > 3 && ring.first().zip(ring.last()).is_some_and(|(a, b)| closes(a, b)) {
                ring.pop();
            }
            return Some(ring);
        }
        let [length, width] = self.size;
        let (along, across) = (length / 2.0, width.max(THIN) / 2.0);
        let ring = [[-along, -across], [along, -across], [along, across], [-along, across]];
        (length > 0.0).then(|| ring.map(|[u, v]| local([u, v, 0.0])).to_vec())
    }

    /// Its name and subtype as one lower-case word of letters and digits.
    pub fn words(&self) -> String {
        flat(&format!("{} {}", self.name, self.subkind))
    }
}

impl Signal {
    /// Where it stands.
    pub fn place(&self, road: &Road) -> Place {
        let [x, y, z] = road.place(self.at[0], self.at[1]);
        [x, y, z + self.lift]
    }

    /// Its name as one lower-case word of letters and digits.
    pub fn words(&self) -> String {
        flat(&self.name)
    }
}

fn flat(words: &str) -> String {
    words.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}
