//! Conversion of feature properties to the types of a network.

use crate::builder::ids::Key;
use crate::builder::network::End;
use crate::builder::tags::cross_section::{CrossSection, Strip};
use crate::geometry::{Point, Vector, polygon};

use super::id::{FeatureId, FeaturePlace};
use super::parse::Spanned;
use super::schema::{EndShape, Feature, Geometry, IntersectionShape, RoadShape, StripShape};

/// The features of the roads and intersections of a network, in its order.
pub struct Rings<'a> {
    pub roads: Vec<&'a RoadShape>,
    pub intersections: Vec<Option<&'a Feature<IntersectionShape>>>,
}

/// An intersection of which the roads are not read yet.
pub struct Node<'a> {
    pub id: FeatureId,
    pub nodes: Vec<i64>,
    pub feature: Option<&'a Spanned<Feature<IntersectionShape>>>,
}

pub fn point(place: &FeaturePlace) -> Point {
    Point::new(place.0[0], place.0[1])
}

/// The vertices of the centre line: the property `centerline`, else the geometry if it is a LineString.
pub fn points_of(road: &Feature<RoadShape>) -> Vec<Point> {
    let property = &road.properties.centerline;
    let line = match &road.geometry {
        Some(Geometry::LineString(line)) if property.is_empty() => line,
        _ => property,
    };
    line.iter().map(point).collect()
}

/// The outer ring of the largest polygon, clockwise and not closed.
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
            let area = |ring: &[Point]| polygon::signed_area(ring).abs();
            parts.iter().map(outer).max_by(|a, b| area(a).total_cmp(&area(b))).unwrap_or_default()
        }
        Some(Geometry::LineString(_)) | None => Vec::new(),
    }
}

/// The position of an intersection: the property, else the mean of its corners.
pub fn centre(intersection: &Feature<IntersectionShape>) -> Option<Point> {
    let property = intersection.properties.position.as_ref().map(point);
    property.or_else(|| mean(&ring(intersection.geometry.as_ref())))
}

pub fn mean(points: &[Point]) -> Option<Point> {
    let sum = points.iter().fold(Vector::zeros(), |sum, p| sum + p.coords);
    (!points.is_empty()).then(|| Point::from(sum / points.len() as f64))
}

/// A number for an element without an OpenStreetMap id. It is the same in every build.
pub fn number(part: &str, name: &str) -> i64 {
    Key::new(part).word(name).id(|_| false)
}

/// The end points of the cut at one end of a road, in the order of the file.
pub fn cut_of(shape: &RoadShape, end: End, intersection: Option<&FeatureId>) -> Option<[Point; 2]> {
    let pair = |end: &EndShape| match end.pts.as_slice() {
        [a, b] => Some([point(a), point(b)]),
        _ => None,
    };
    let found = match (shape.ends.as_slice(), end) {
        ([start, end_], _) if start.int == shape.src && end_.int == shape.dst => {
            Some(if end == End::Start { start } else { end_ })
        }
        (ends, _) => ends.iter().find(|e| e.int.is_some() && e.int.as_ref() == intersection),
    };
    found.and_then(pair)
}

/// The cross-section of an inner road.
pub fn section_of(lanes: &[StripShape]) -> CrossSection {
    let strip = |lane: &StripShape| Strip {
        kind: lane.strip,
        travel: lane.travel,
        width: lane.width,
        arrows: lane.arrows,
        change: lane.change,
        width_guessed: lane.width_guessed,
        speed: lane.speed,
        bicycles: lane.bicycles,
    };
    CrossSection { strips: lanes.iter().map(strip).collect() }
}
