//! Single values of features in the units of a network.

use crate::builder::ids::{Ids, Key};
use crate::builder::network::End;
use crate::builder::tags::cross_section::{CrossSection, Strip};
use crate::geometry::{Point, Vector, polygon};

use super::id::{FeatureId, FeaturePlace};
use super::parse::Spanned;
use super::schema::{EndShape, Feature, Geometry, IntersectionShape, RoadShape, StripShape};

/// Per road and per intersection of the network, what the file says of its outline.
pub struct Rings<'a> {
    pub roads: Vec<&'a RoadShape>,
    pub intersections: Vec<Option<&'a Feature<IntersectionShape>>>,
}

/// An intersection before its roads are known.
pub struct Node<'a> {
    pub id: FeatureId,
    pub nodes: Vec<i64>,
    pub feature: Option<&'a Spanned<Feature<IntersectionShape>>>,
}

pub fn point(place: &FeaturePlace) -> Point {
    Point::new(place.0[0], place.0[1])
}

/// The vertices of a road's centre line: the property, else the geometry if that is a line.
pub fn points_of(road: &Feature<RoadShape>) -> Vec<Point> {
    let own = &road.properties.centerline;
    let line = match &road.geometry {
        Some(Geometry::LineString(line)) if own.is_empty() => line,
        _ => own,
    };
    line.iter().map(point).collect()
}

/// The outer ring of a polygon, clockwise and not closed; of several the largest.
pub fn ring(geometry: Option<&Geometry>) -> Vec<Point> {
    let outer = |rings: &Vec<Vec<FeaturePlace>>| {
        let mut ring: Vec<Point> = rings.first().into_iter().flatten().map(point).collect();
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        if polygon::signed_area(&ring) > 0.0 {
            ring.reverse();
        }
        ring
    };
    match geometry {
        Some(Geometry::Polygon(rings)) => outer(rings),
        Some(Geometry::MultiPolygon(parts)) => {
            let rings = parts.iter().map(outer);
            rings
                .max_by(|a, b| polygon::signed_area(a).abs().total_cmp(&polygon::signed_area(b).abs()))
                .unwrap_or_default()
        }
        Some(Geometry::LineString(_)) | None => Vec::new(),
    }
}

/// The place of an intersection: as it says, else the middle of its corners.
pub fn centre(intersection: &Feature<IntersectionShape>) -> Option<Point> {
    let own = intersection.properties.position.as_ref().map(point);
    own.or_else(|| mean(&ring(intersection.geometry.as_ref())))
}

pub fn mean(points: &[Point]) -> Option<Point> {
    let sum = points.iter().fold(Vector::zeros(), |sum, p| sum + p.coords);
    (!points.is_empty()).then(|| Point::from(sum / points.len() as f64))
}

/// A number for something that OpenStreetMap does not know, the same in every build.
pub fn number(part: &str, name: &str) -> i64 {
    Ids::default().claim(Key::new(part).word(name), |_| false)
}

/// The cut that the file gives for one end of a road: its ends, in the order of the file.
pub fn cut_of(shape: &RoadShape, end: End, at: Option<&FeatureId>) -> Option<[Point; 2]> {
    let pair = |end: &EndShape| match end.pts.as_slice() {
        [a, b] => Some([point(a), point(b)]),
        _ => None,
    };
    let own = match (shape.ends.as_slice(), end) {
        ([start, end_], _) if start.int == shape.src && end_.int == shape.dst => {
            Some(if end == End::Start { start } else { end_ })
        }
        (ends, _) => ends.iter().find(|e| e.int.is_some() && e.int.as_ref() == at),
    };
    own.and_then(pair)
}

/// The cross-section of lanes that are no features of their own.
pub fn section_of(lanes: &[StripShape]) -> CrossSection {
    let strip = |lane: &StripShape| Strip {
        kind: lane.used,
        travel: lane.travel,
        width: lane.width,
        arrows: lane.arrows,
        change: lane.change,
        width_guessed: lane.width_guessed,
    };
    CrossSection { strips: lanes.iter().map(strip).collect() }
}
