//! Words that do not lie on each other.

use rstar::primitives::Rectangle;
use rstar::{AABB, RTree};

use super::canvas::Canvas;
use super::lettering;
use crate::geometry::{Point, Vector};

/// The places that words have taken, in pixels of the sheet.
#[derive(Default)]
pub struct Labels(RTree<Rectangle<[f64; 2]>>);

impl Labels {
    /// How many words stand.
    pub fn count(&self) -> usize {
        self.0.size()
    }

    /// Writes words centred on a place in metres and lifted by `lift` pixels, `height` pixels high, if nothing stands there.
    /// Says whether there was room.
    pub fn write(&mut self, canvas: &mut Canvas, class: &str, at: Point, lift: f64, text: &str, height: f64) -> bool {
        // Half a letter stays free above and below each word, a whole one on each side.
        let half = Vector::new(lettering::width(text, height) / 2.0 + height, height);
        let middle = canvas.view.pixel(at) - Vector::new(0.0, lift);
        let [low, high] = [middle - half, middle + half].map(|corner| [corner.x, corner.y]);
        if !low.iter().chain(&high).all(|number| number.is_finite()) {
            return true;
        }
        let free = self.0.locate_in_envelope_intersecting(&AABB::from_corners(low, high)).next().is_none();
        if free {
            canvas.words(class, at, lift, text, height);
            self.0.insert(Rectangle::from_corners(low, high));
        }
        free
    }
}
