//! Findings on the map: their subjects glow, and a pin shows where to look.

use rustc_hash::FxHashMap;

use super::canvas::{Canvas, View};
use super::labels::Labels;
use super::lanes::positions;
use crate::diagnostic::{Diagnostic, Place, Subject};
use crate::geometry::{Point, Vector};
use crate::lanelet::{AreaId, LaneletId, LaneletMap, LineStringId, PointId, PolygonId, RegulatoryElementId, Target};

/// What a finding is about, as shapes.
enum Shape {
    Spot(Point),
    Line(Vec<Point>),
    Area(Vec<Point>),
}

/// Height of the words at a pin, pixels.
const LETTER: f64 = 8.0;
/// How far they are above the pin's tip, pixels.
const LIFT: f64 = 28.0;
/// More words than this nobody reads.
const MAX_WORDED: usize = 60;

/// Draws the glows of all findings, then all pins, the worst on top.
pub fn findings(canvas: &mut Canvas, map: &LaneletMap, diagnostics: &[Diagnostic], labels: &mut Labels) {
    let mut sorted: Vec<&Diagnostic> = diagnostics.iter().collect();
    sorted.sort_by_key(|d| d.severity);
    // A subject with many findings glows once, in the hue of the worst.
    let mut glowing: FxHashMap<Subject, &Diagnostic> = FxHashMap::default();
    for diagnostic in &sorted {
        glowing.insert(diagnostic.finding.subject, diagnostic);
    }
    for diagnostic in &sorted {
        if glowing.get(&diagnostic.finding.subject).is_some_and(|worst| std::ptr::eq(*worst, *diagnostic)) {
            for shape in of_subject(map, diagnostic.finding.subject) {
                glow(canvas, &shape, diagnostic);
            }
        }
    }
    for diagnostic in &sorted {
        if let Some(shape) = place(diagnostic) {
            glow(canvas, &shape, diagnostic);
        }
    }
    let pins = pins(&canvas.view, map, diagnostics);
    for (at, diagnostic) in &pins {
        pin(canvas, *at, diagnostic);
    }
    words(canvas, &pins, labels);
}

/// The findings that are on the sheet, each with the place of its pin, the worst last.
pub fn pins<'a>(view: &View, map: &LaneletMap, diagnostics: &'a [Diagnostic]) -> Vec<(Point, &'a Diagnostic)> {
    let mut pins: Vec<(Point, &Diagnostic)> =
        diagnostics.iter().filter_map(|d| Some((spot(map, d)?, d))).filter(|(p, _)| view.sees([p])).collect();
    pins.sort_by_key(|(_, d)| d.severity);
    pins
}

/// Writes what the pins are about, the worst first, wherever there is room.
fn words(canvas: &mut Canvas, pins: &[(Point, &Diagnostic)], labels: &mut Labels) {
    for (at, diagnostic) in pins.iter().rev() {
        let text = match diagnostic.finding.subject.id() {
            Some(id) => format!("{} {id}", diagnostic.code),
            None => diagnostic.code.clone(),
        };
        let taken = labels.count();
        labels.write(canvas, "found", *at, LIFT, &text, LETTER);
        if taken >= MAX_WORDED {
            break;
        }
    }
}

fn glow(canvas: &mut Canvas, shape: &Shape, diagnostic: &Diagnostic) {
    let (class, title) = (diagnostic.severity.to_string(), title(diagnostic));
    match shape {
        Shape::Spot(p) => canvas.disc(&format!("spot {class}"), *p, 6.0, &title),
        Shape::Line(points) => canvas.line(&format!("glow {class}"), points, &title),
        Shape::Area(ring) => canvas.area(&format!("veil {class}"), ring, &title),
    }
}

/// A drop whose tip touches the place.
fn pin(canvas: &mut Canvas, at: Point, diagnostic: &Diagnostic) {
    const DROP: [(f64, f64); 9] = [
        (0.0, 0.0),
        (-5.2, -9.5),
        (-6.0, -13.0),
        (-4.3, -17.3),
        (0.0, -19.0),
        (4.3, -17.3),
        (6.0, -13.0),
        (5.2, -9.5),
        (0.0, 0.0),
    ];
    let east = Vector::new(1.0, 0.0);
    canvas.stamp(&format!("pin {}", diagnostic.severity), at, east, &DROP, &title(diagnostic));
}

fn title(diagnostic: &Diagnostic) -> String {
    format!("{} {}: {}", diagnostic.severity, diagnostic.code, diagnostic.finding.message)
}

/// Where the pin is.
fn spot(map: &LaneletMap, diagnostic: &Diagnostic) -> Option<Point> {
    let middle = |points: &[Point]| points.get(points.len() / 2).copied();
    let shapes = place(diagnostic).into_iter().chain(of_subject(map, diagnostic.finding.subject));
    let mut spots = shapes.filter_map(|shape| match shape {
        Shape::Spot(p) => Some(p),
        Shape::Line(points) => middle(&points),
        Shape::Area(ring) => mean(&ring),
    });
    spots.next().or(diagnostic.local)
}

fn mean(points: &[Point]) -> Option<Point> {
    let sum = points.iter().fold(nalgebra::Vector2::zeros(), |sum, p| sum + p.coords);
    (!points.is_empty()).then(|| Point::from(sum / points.len() as f64))
}

/// The finding's own place.
fn place(diagnostic: &Diagnostic) -> Option<Shape> {
    match &diagnostic.finding.place {
        Place::Unknown => None,
        Place::Point(p) => Some(Shape::Spot(*p)),
        Place::Line(points) => Some(Shape::Line(points.clone())),
        Place::Polygon(ring) => Some(Shape::Area(ring.clone())),
    }
}

fn of_subject(map: &LaneletMap, subject: Subject) -> Vec<Shape> {
    let point = |id| map.points.get(PointId(id)).map(|p| Shape::Spot(p.position));
    let line = |id| map.linestrings.get(LineStringId(id)).map(|l| Shape::Line(positions(map, &l.points)));
    let polygon = |id| map.polygons.get(PolygonId(id)).map(|p| Shape::Area(positions(map, &p.points)));
    let lanelet = |id| map.lanelets.get(LaneletId(id)).map(|l| Shape::Area(map.outline(l)));
    let area = |id| map.areas.get(AreaId(id)).map(|a| Shape::Area(positions(map, &a.points)));
    match subject {
        Subject::Map => Vec::new(),
        Subject::Point(id) | Subject::Node(id) => point(id).into_iter().collect(),
        Subject::LineString(id) => line(id).into_iter().collect(),
        Subject::Polygon(id) => polygon(id).into_iter().collect(),
        Subject::Way(id) => line(id).or_else(|| polygon(id)).into_iter().collect(),
        Subject::Lanelet(id) => lanelet(id).into_iter().collect(),
        Subject::Relation(id) if map.lanelets.contains(LaneletId(id)) => lanelet(id).into_iter().collect(),
        Subject::Relation(id) if map.areas.contains(AreaId(id)) => area(id).into_iter().collect(),
        Subject::RegulatoryElement(id) | Subject::Relation(id) => map
            .regulatory_elements
            .get(RegulatoryElementId(id))
            .into_iter()
            .flat_map(|element| &element.members)
            .filter_map(|member| match member.target {
                Target::Point(id) => point(id.0),
                Target::LineString(id) => line(id.0),
                Target::Polygon(id) => polygon(id.0),
                Target::Lanelet(id) => lanelet(id.0),
            })
            .collect(),
    }
}
