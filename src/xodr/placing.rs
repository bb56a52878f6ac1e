//! Where signals and objects stand: their places along the road in the file's own metres.

use super::furniture::{Corner, Object, Signal};
use super::road::{Place, Road};

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
}

impl Signal {
    /// Where it stands.
    pub fn place(&self, road: &Road) -> Place {
        let [x, y, z] = road.place(self.at[0], self.at[1]);
        [x, y, z + self.lift]
    }
}
