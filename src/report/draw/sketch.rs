//! A drawing of plain shapes: whatever is no Lanelet2 map and is to be looked at.

use super::canvas::{Canvas, View, bounding_box};
use super::{DrawError, Focus, MARGIN, SURROUNDINGS, layer, legend, scaled, style, widen};
use crate::geometry::Point;

/// One thing to draw. Its class is one of the style sheet's.
#[derive(Clone, Debug)]
pub enum Mark {
    /// A filled area.
    Area {
        /// How it looks.
        class: &'static str,
        /// Its corners, not closed.
        ring: Vec<Point>,
        /// What a pointer over it shows.
        title: String,
    },
    /// A line.
    Line {
        /// How it looks.
        class: &'static str,
        /// Its vertices.
        points: Vec<Point>,
        /// What a pointer over it shows.
        title: String,
    },
    /// A dot.
    Spot {
        /// How it looks.
        class: &'static str,
        /// Where.
        at: Point,
        /// What a pointer over it shows.
        title: String,
    },
    /// Words.
    Words {
        /// Where their middle is.
        at: Point,
        /// What they say.
        text: String,
    },
}

impl Mark {
    fn points(&self) -> &[Point] {
        match self {
            Self::Area { ring: points, .. } | Self::Line { points, .. } => points,
            Self::Spot { at, .. } | Self::Words { at, .. } => std::slice::from_ref(at),
        }
    }
}

/// Layers of marks, the lowest first.
#[derive(Clone, Debug, Default)]
pub struct Sketch {
    /// Named layers.
    pub layers: Vec<(&'static str, Vec<Mark>)>,
    /// What stands in the title, and what the classes mean: class and word.
    pub key: Vec<(&'static str, &'static str)>,
}

/// Radius of a spot, pixels.
const SPOT: f64 = 3.2;
/// Height of words, pixels.
const LETTER: f64 = 8.0;

impl Sketch {
    /// Adds a layer.
    pub fn push(&mut self, name: &'static str, marks: Vec<Mark>) {
        self.layers.push((name, marks));
    }

    fn points(&self) -> impl Iterator<Item = &Point> {
        self.layers.iter().flat_map(|(_, marks)| marks).flat_map(Mark::points)
    }

    /// The box around everything; `None` if there is nothing.
    pub fn extent(&self) -> Option<(Point, Point)> {
        bounding_box(self.points())
    }

    /// The part of the plane that a focus shows.
    ///
    /// # Errors
    ///
    /// If there is nothing to draw, or the scale is not positive.
    pub fn view(&self, focus: Focus, scale: Option<f64>) -> Result<View, DrawError> {
        let (min, max) = match focus {
            Focus::Whole => widen(self.extent().ok_or(DrawError::Empty)?, MARGIN),
            Focus::Around(place, radius) => widen((place, place), super::positive("the radius", radius)?),
            Focus::Primitive(id) => return Err(DrawError::NoSuchId(id)),
        };
        scaled(min, max, scale)
    }

    /// The drawing as an SVG document.
    pub fn svg(&self, view: View, title: &str) -> String {
        let mut canvas = Canvas::new(view);
        for (name, marks) in &self.layers {
            layer(&mut canvas, name, |canvas| marks.iter().for_each(|mark| draw(canvas, mark)));
        }
        let key = self.key.iter().map(|(class, word)| (format!("swatch {class}"), (*word).to_owned())).collect();
        layer(&mut canvas, "legend", |canvas| legend::card(canvas, key));
        canvas.finish(&style::sheet(view.scale), title)
    }
}

/// The box around a thing, with what lies around it.
pub fn around(points: &[Point]) -> Option<Focus> {
    let (min, max) = bounding_box(points)?;
    let radius = (max.x - min.x).max(max.y - min.y) / 2.0 + SURROUNDINGS;
    Some(Focus::Around(nalgebra::center(&min, &max), radius))
}

fn draw(canvas: &mut Canvas, mark: &Mark) {
    match mark {
        Mark::Area { class, ring, title } => canvas.area(class, ring, title),
        Mark::Line { class, points, title } => canvas.line(class, points, title),
        Mark::Spot { class, at, title } => canvas.disc(class, *at, SPOT, title),
        Mark::Words { at, text } => canvas.words("id-lane", *at, 0.0, text, LETTER),
    }
}

/// Two pictures of the same view, side by side, as one SVG document.
pub fn beside(left: &str, right: &str, view: View) -> String {
    const GAP: f64 = 12.0;
    let (w, h) = (view.width(), view.height());
    let width = 2.0 * w + GAP;
    let right = right.replacen("<svg ", &format!("<svg x=\"{}\" ", w + GAP), 1);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{h}\" viewBox=\"0 0 {width} {h}\">\n{left}{right}</svg>\n"
    )
}
