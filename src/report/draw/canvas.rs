//! A sheet to draw on: metres in, SVG out. Knows no lanelet.

use std::fmt::Write;

use crate::geometry::{Point, Vector};

use super::lettering;

/// A vertex nearer than this (pixels) to the one before it adds nothing to see.
const VERTEX_SPACING: f64 = 0.2;

/// Which part of the plane is shown, and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// South-west corner, metres.
    pub min: Point,
    /// North-east corner, metres.
    pub max: Point,
    /// Pixels per metre.
    pub scale: f64,
}

impl View {
    /// Width of the sheet in pixels.
    pub fn width(&self) -> f64 {
        ((self.max.x - self.min.x) * self.scale).ceil().max(1.0)
    }

    /// Height of the sheet in pixels.
    pub fn height(&self) -> f64 {
        ((self.max.y - self.min.y) * self.scale).ceil().max(1.0)
    }

    /// Where a place lies on the sheet, in pixels from its upper left corner.
    pub fn pixel(&self, p: Point) -> Point {
        Point::new((p.x - self.min.x) * self.scale, (self.max.y - p.y) * self.scale)
    }

    /// Whether the box around these points touches the sheet.
    pub fn sees<'a>(&self, points: impl IntoIterator<Item = &'a Point>) -> bool {
        bounding_box(points).is_some_and(|(min, max)| {
            min.x <= self.max.x && max.x >= self.min.x && min.y <= self.max.y && max.y >= self.min.y
        })
    }
}

/// The smallest upright box around the finite ones of these points; `None` if there is none.
pub fn bounding_box<'a>(points: impl IntoIterator<Item = &'a Point>) -> Option<(Point, Point)> {
    points.into_iter().filter(|p| p.x.is_finite() && p.y.is_finite()).fold(None, |found, p| {
        let (min, max) = found.unwrap_or((*p, *p));
        Some((Point::new(min.x.min(p.x), min.y.min(p.y)), Point::new(max.x.max(p.x), max.y.max(p.y))))
    })
}

/// SVG under construction. Styles are classes of the sheet's style block; places are metres unless said otherwise.
pub struct Canvas {
    /// What is shown.
    pub view: View,
    body: String,
}

impl Canvas {
    /// An empty sheet.
    pub fn new(view: View) -> Self {
        Self { view, body: String::new() }
    }

    /// A filled area.
    pub fn area(&mut self, class: &str, ring: &[Point], title: &str) {
        if ring.len() >= 3 && self.view.sees(ring) {
            let path = self.path(ring, true);
            self.element("path", class, &format!("d=\"{path}\""), title);
        }
    }

    /// A line.
    pub fn line(&mut self, class: &str, points: &[Point], title: &str) {
        self.lines(class, std::iter::once(points), title);
    }

    /// Whether something of a class was drawn.
    pub fn shows(&self, class: &str) -> bool {
        self.body.contains(class)
    }

    /// Lines that are one thing.
    pub fn lines<'a>(&mut self, class: &str, lines: impl Iterator<Item = &'a [Point]>, title: &str) {
        let seen = lines.filter(|points| points.len() >= 2 && self.view.sees(*points));
        let path: String = seen.map(|points| self.path(points, false)).collect();
        if !path.is_empty() {
            self.element("path", class, &format!("d=\"{path}\""), title);
        }
    }

    /// A disc of a radius in pixels.
    pub fn disc(&mut self, class: &str, centre: Point, radius: f64, title: &str) {
        if self.view.sees([&centre]) {
            let p = self.view.pixel(centre);
            self.element("circle", class, &format!("cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\"", p.x, p.y), title);
        }
    }

    /// A shape of pixel offsets (x right, y down) around a place, turned so that its x axis points along `heading`.
    pub fn stamp(&mut self, class: &str, at: Point, heading: Vector, shape: &[(f64, f64)], title: &str) {
        if !self.view.sees([&at]) {
            return;
        }
        let p = self.view.pixel(at);
        let along = if heading.norm() > 0.0 { heading.normalize() } else { Vector::new(1.0, 0.0) };
        // The sheet's y axis points down.
        let (cos, sin) = (along.x, -along.y);
        let corners: Vec<Point> =
            shape.iter().map(|&(x, y)| Point::new(p.x + x * cos - y * sin, p.y + x * sin + y * cos)).collect();
        let path = pixel_path(&corners, true);
        self.element("path", class, &format!("d=\"{path}\""), title);
    }

    /// Words, centred on a place and lifted by `lift` pixels, `height` pixels high, with a halo.
    pub fn words(&mut self, class: &str, at: Point, lift: f64, text: &str, height: f64) {
        if self.view.sees([&at]) {
            let p = self.view.pixel(at);
            let left = p.x - lettering::width(text, height) / 2.0;
            self.words_at(class, left, p.y - lift + height / 2.0, text, height);
        }
    }

    /// Words that begin at a pixel of the sheet, `height` pixels high, with a halo.
    pub fn words_at(&mut self, class: &str, left: f64, base: f64, text: &str, height: f64) {
        let path = lettering::path(text, left, base, height);
        let thin = (height * 0.13).max(0.9);
        let _ = writeln!(
            self.body,
            "<g class=\"{class}\"><title>{}</title><path class=\"halo\" stroke-width=\"{:.2}\" d=\"{path}\"/>\
             <path class=\"pen\" stroke-width=\"{thin:.2}\" d=\"{path}\"/></g>",
            escape(text),
            thin * 3.6,
        );
    }

    /// A path of pixels.
    pub fn pixels(&mut self, class: &str, corners: &[Point], closed: bool) {
        let path = pixel_path(corners, closed);
        self.element("path", class, &format!("d=\"{path}\""), "");
    }

    /// Marks the begin of a group that an editor or a style sheet can address.
    pub fn open(&mut self, name: &str) {
        let _ = writeln!(self.body, "<g id=\"{name}\">");
    }

    /// Closes the group opened last.
    pub fn close(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// The whole document.
    pub fn finish(self, style: &str, title: &str) -> String {
        let (w, h) = (self.view.width(), self.view.height());
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\">\n\
             <title>{}</title>\n<style>\n{style}</style>\n<rect class=\"ground\" width=\"{w}\" height=\"{h}\"/>\n{}</svg>\n",
            escape(title),
            self.body
        )
    }

    fn element(&mut self, name: &str, class: &str, attributes: &str, title: &str) {
        let _ = if title.is_empty() {
            writeln!(self.body, "<{name} class=\"{class}\" {attributes}/>")
        } else {
            writeln!(self.body, "<{name} class=\"{class}\" {attributes}><title>{}</title></{name}>", escape(title))
        };
    }

    fn path(&self, points: &[Point], closed: bool) -> String {
        let pixels: Vec<Point> = points.iter().map(|&p| self.view.pixel(p)).collect();
        pixel_path(&pixels, closed)
    }
}

/// The `d` of a path; vertices too near to the one before are left out, except the last.
fn pixel_path(pixels: &[Point], closed: bool) -> String {
    let mut path = String::new();
    let mut last: Option<Point> = None;
    let end = pixels.len().saturating_sub(1);
    for (i, p) in pixels.iter().enumerate().filter(|(_, p)| p.x.is_finite() && p.y.is_finite()) {
        if i < end && last.is_some_and(|l| (p - l).norm() < VERTEX_SPACING) {
            continue;
        }
        let _ = write!(path, "{}{:.1} {:.1}", if last.is_none() { 'M' } else { 'L' }, p.x, p.y);
        last = Some(*p);
    }
    if closed && last.is_some() {
        path.push('Z');
    }
    path
}

/// Text as XML wants it.
fn escape(text: &str) -> String {
    // Control characters are not allowed in XML 1.0, escaped or not.
    let printable: String = text.chars().filter(|c| !c.is_control()).collect();
    printable.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View { min: Point::new(0.0, 0.0), max: Point::new(10.0, 5.0), scale: 2.0 }
    }

    #[test]
    fn north_is_up() {
        assert_eq!(view().pixel(Point::new(0.0, 5.0)), Point::new(0.0, 0.0));
        assert_eq!(view().pixel(Point::new(10.0, 0.0)), Point::new(20.0, 10.0));
    }

    #[test]
    fn what_lies_outside_is_left_out() {
        let mut canvas = Canvas::new(view());
        canvas.line("x", &[Point::new(20.0, 20.0), Point::new(30.0, 20.0)], "");
        assert!(!canvas.finish("", "t").contains("class=\"x\""));
    }

    #[test]
    fn text_cannot_break_the_document() {
        let mut canvas = Canvas::new(view());
        canvas.disc("x", Point::new(1.0, 1.0), 2.0, "a<b & \"c\"\u{1}");
        assert!(canvas.finish("", "t").contains("<title>a&lt;b &amp; &quot;c&quot;</title>"));
    }

    #[test]
    fn places_that_are_no_numbers_are_left_out() {
        let path = pixel_path(&[Point::new(f64::NAN, 0.0), Point::new(1.0, 2.0), Point::new(3.0, 4.0)], false);
        assert_eq!(path, "M1.0 2.0L3.0 4.0");
    }
}
