//! The lines of a map as they are drawn, and the outlines of its lanelets, as GeoJSON (RFC 7946) for any map viewer.

use std::io::{self, Write};

use serde_json::{Value, json};

use crate::diagnostic::Subject;
use crate::geometry::Point;
use crate::lane_stitching::{Colour, Strokes};
use crate::lanelet::{LaneletMap, LineString};
use crate::projection::Projector;
use crate::report::geojson::{line_of, of_subject};

use super::lanes::positions;
use super::style::Stroke;
use super::{View, style};

/// Writes the outline of each lanelet that is in view, then each stroke of each linestring: a feature a line, in the map's
/// order. What has no longitude and latitude is left out.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn geojson(map: &LaneletMap, projector: &Projector, view: &View, out: &mut dyn Write) -> io::Result<()> {
    write!(out, "{{\"type\":\"FeatureCollection\",\"features\":[")?;
    let mut first = true;
    let mut put = |geometry: Value, properties: Value| {
        let between = if std::mem::take(&mut first) { "\n" } else { ",\n" };
        write!(out, "{between}{}", json!({ "type": "Feature", "geometry": geometry, "properties": properties }))
    };
    for lanelet in map.lanelets.iter().filter(|lanelet| view.sees(&map.outline(lanelet))) {
        let properties = json!({
            "lanelet": lanelet.id.0,
            "subtype": lanelet.attributes.get("subtype"),
            "turn_direction": lanelet.attributes.get("turn_direction"),
        });
        if let Some(outline) = of_subject(map, Subject::Lanelet(lanelet.id.0)) {
            put(outline, properties)?;
        }
    }
    for line in &map.linestrings {
        let painted = Painted::of(map, line);
        let ele = line.points.iter().find_map(|&id| map.points.get(id)?.ele()).unwrap_or_default();
        let places = view.sees(&painted.points).then(|| projector.inverse_each(&painted.points, |_| ele));
        let Some(places) = places.and_then(|places| places.into_iter().collect::<Option<Vec<_>>>()) else { continue };
        let properties = json!({
            "linestring": line.id.0,
            "type": line.attributes.get("type"),
            "subtype": line.attributes.get("subtype"),
            "color": painted.colour,
            "breadth": painted.breadth,
        });
        let mut rest = &places[..];
        for length in painted.lengths {
            let (stroke, others) = rest.split_at(length);
            rest = others;
            if let Some(geometry) = line_of(stroke) {
                put(geometry, properties.clone())?;
            }
        }
    }
    writeln!(out, "\n]}}")
}

/// The strokes of one linestring.
#[derive(Default)]
struct Painted {
    colour: &'static str,
    /// Metres.
    breadth: f64,
    /// Of all strokes, one after the other.
    points: Vec<Point>,
    /// How many of them each stroke has.
    lengths: Vec<usize>,
}

impl Painted {
    /// None of what nobody sees on the ground.
    fn of(map: &LaneletMap, line: &LineString) -> Self {
        let points = positions(map, &line.points);
        let single = |colour, class, points: Vec<Point>| {
            let lengths = vec![points.len()];
            Self { colour: word(colour), breadth: style::breadth(class), points, lengths }
        };
        match style::stroke(&line.attributes) {
            Stroke::True(kind, class) => {
                let strokes = Strokes::along(&points, kind);
                Self {
                    colour: strokes.iter().next().map_or("", |stroke| word(stroke.colour)),
                    breadth: style::breadth(class),
                    points: strokes.iter().flat_map(|stroke| stroke.line).copied().collect(),
                    lengths: strokes.iter().map(|stroke| stroke.line.len()).collect(),
                }
            }
            Stroke::Single(class @ ("stop" | "zebra-edge")) => single(Colour::White, class, points),
            Stroke::Single(class @ "barrier") => single(Colour::Grey, class, points),
            Stroke::Single(_) | Stroke::Elsewhere => Self::default(),
        }
    }
}

fn word(colour: Colour) -> &'static str {
    match colour {
        Colour::White => "white",
        Colour::Yellow => "yellow",
        Colour::Grey => "grey",
        Colour::Magenta => "magenta",
    }
}
