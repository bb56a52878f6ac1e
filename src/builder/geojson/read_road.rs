//! Reads one road of the file: its centre line, its lanes, its crossings, lights and signs.

use crate::builder::network::{Feature as Furniture, FeatureKind, IntersectionIx, Road, RoadKey, class_of};
use crate::builder::tags::cross_section::{
    CrossSection, Customs, Defaults, Strip, StripKind, Travel, WayFacts, layout,
};
use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::builder::tags::speed;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Polyline;
use crate::osm::{Tags, Text};

use super::ReadError;
use super::parse::Spanned;
use super::schema::{Feature, FurnitureKind, FurnitureShape, LaneShape, Levels, RoadShape};
use super::values::{number, points_of};

/// The widest strip, metres. A larger number has a wrong unit.
const WIDEST: f64 = 100.0;
/// The highest speed limit, km/h.
const FASTEST: f64 = 300.0;

/// The road of a feature between two intersections, and notes of what is assumed.
///
/// # Errors
///
/// The road has no centre line, or an invalid height, speed or width.
pub fn road(
    feature: &Spanned<Feature<RoadShape>>,
    key: RoadKey,
    [from, to]: [IntersectionIx; 2],
    lanes: &[&Spanned<LaneShape>],
    customs: &Customs<'_>,
    notes: &mut Vec<Finding>,
) -> Result<Road, ReadError> {
    let shape = &feature.value.properties;
    let line = Polyline::new(points_of(&feature.value)).ok_or_else(|| {
        let message = format!("road {} has no centre line of two places or more", shape.id.0);
        ReadError::new(feature.offset, message, "give it the property `centerline`, or a LineString as geometry")
    })?;
    let heights = heights(feature, line.points().len())?;
    let tagged = shape.tags.get("highway").and_then(class_of);
    let class = shape.class.or(tagged.map(|(class, _)| class)).unwrap_or_else(|| {
        notes.push(note(key, "class-guessed", "has no class; unclassified is assumed"));
        RoadClass::Unclassified
    });
    let link = shape.link || tagged.is_some_and(|(_, link)| link);
    let section = match lanes {
        [] => section_of_tags(shape, key, (class, link), customs, notes),
        lanes => section_of_lanes(lanes, key, customs.defaults(class, link), customs.side, notes)?,
    };
    let speed = shape.speed.unwrap_or_else(|| {
        if !["maxspeed", "maxspeed:forward", "maxspeed:backward"].iter().any(|key| shape.tags.has(key)) {
            notes.push(note(key, "speed-guessed", "has no speed; the usual limit of its class is assumed"));
        }
        speed::limit(&shape.tags, class, link, customs)
    });
    if speed.iter().any(|v| !(*v > 0.0 && *v <= FASTEST)) {
        let message = format!("road {} has the speed {speed:?}", shape.id.0);
        let help = "speeds are km/h, forward and backward, above 0 and at most 300";
        return Err(ReadError::new(feature.offset, message, help));
    }
    Ok(Road {
        key,
        ways: if shape.osm_ids.is_empty() { vec![key.way] } else { shape.osm_ids.clone() },
        from,
        to,
        line,
        heights,
        section,
        class,
        link,
        level: shape.layer.as_ref().and_then(Levels::first).unwrap_or_default(),
        roundabout: shape.roundabout,
        public: shape.public,
        name: shape.name.clone(),
        speed,
        features: shape.furniture.iter().enumerate().map(|(i, f)| furniture(shape, i, f)).collect(),
        tags: shape.tags.clone(),
    })
}

/// The heights of the vertices of a road, metres: none, or one for each vertex.
fn heights(feature: &Spanned<Feature<RoadShape>>, vertices: usize) -> Result<Vec<f64>, ReadError> {
    let RoadShape { heights, id, .. } = &feature.value.properties;
    if heights.is_empty() || heights.len() == vertices && heights.iter().all(|h| h.is_finite()) {
        return Ok(heights.clone());
    }
    let count = heights.len();
    let message = format!("road {} has {count} heights, and its centre line has {vertices} different places", id.0);
    Err(ReadError::new(feature.offset, message, "give one height for each place of `centerline`, or none"))
}

fn note(key: RoadKey, slug: &'static str, what: &str) -> Finding {
    Finding::new(slug, Subject::Way(key.way), format!("way {}: {what}", key.way)).graded(Severity::Info)
}

/// The cross-section of a road without lanes: by its tags and width, else the default of its class.
fn section_of_tags(
    shape: &RoadShape,
    key: RoadKey,
    (class, link): (RoadClass, bool),
    customs: &Customs<'_>,
    notes: &mut Vec<Finding>,
) -> CrossSection {
    let mut tags: Tags = shape.tags.clone();
    if let Some(width) = shape.width
        && !["width", "width:carriageway", "est_width"].iter().any(|key| tags.has(key))
    {
        tags.push("width", Text::from(width.to_string()));
    }
    let (side, usual) = (customs.side, customs.defaults(class, link));
    let facts = WayFacts { way: key.way, tags: &tags, class, link, bus_road: false, side, usual, continued: None };
    layout(&facts, notes).section
}

/// The cross-section of the lanes of a road.
fn section_of_lanes(
    lanes: &[&Spanned<LaneShape>],
    key: RoadKey,
    usual: Defaults,
    side: DrivingSide,
    notes: &mut Vec<Finding>,
) -> Result<CrossSection, ReadError> {
    let mut ordered: Vec<&Spanned<LaneShape>> = lanes.to_vec();
    ordered.sort_by_key(|lane| lane.value.index);
    let is_driven = |lane: &LaneShape| matches!(lane.strip, StripKind::Drive | StripKind::Bus);
    let count = ordered.iter().filter(|lane| is_driven(&lane.value)).count();
    let mut index = 0;
    let mut strips = Vec::with_capacity(ordered.len());
    for Spanned { offset, value: lane } in ordered {
        let driven = is_driven(lane);
        let default = if driven { default_travel(index, count, side) } else { Travel::Both };
        index += usize::from(driven);
        if lane.travel.is_none() && driven {
            let what = "a lane has no direction of travel; the usual one is assumed";
            notes.push(note(key, "travel-guessed", what));
        }
        let width = lane.width.unwrap_or_else(|| {
            notes.push(note(key, "width-guessed", "a lane has no width; the usual one is assumed"));
            usual.lane
        });
        if !(width > 0.0 && width <= WIDEST) {
            let message = format!("a lane of road {} is {width} m wide", lane.road.0);
            return Err(ReadError::new(*offset, message, "widths are metres, above 0 and at most 100"));
        }
        strips.push(Strip {
            kind: lane.strip,
            travel: lane.travel.unwrap_or(default),
            width,
            arrows: lane.arrows,
            change: lane.change,
            width_guessed: lane.width_guessed || lane.width.is_none(),
            speed: lane.speed,
            bicycles: lane.bicycles,
        });
    }
    Ok(CrossSection { strips })
}

/// The default direction of lane `index` of `count`, from left to right. The half of the lanes at the near side, or one more
/// of an odd count, runs forward. A single lane runs both ways.
fn default_travel(index: usize, count: usize, side: DrivingSide) -> Travel {
    let from_near = if side == DrivingSide::Left { index } else { count - 1 - index };
    match count {
        1 => Travel::Both,
        _ if from_near < count.div_ceil(2) => Travel::Forward,
        _ => Travel::Backward,
    }
}

fn furniture(road: &RoadShape, index: usize, shape: &FurnitureShape) -> Furniture {
    let travel = shape.travel.unwrap_or(Travel::Both);
    let kind = match shape.kind {
        FurnitureKind::Crossing => FeatureKind::Crossing {
            signals: shape.signals.unwrap_or_default(),
            marked: shape.marked.unwrap_or_default(),
        },
        FurnitureKind::Signals => FeatureKind::Signals(travel),
        FurnitureKind::MidBlockSignals => FeatureKind::MidBlockSignals(travel),
        FurnitureKind::Stop => FeatureKind::Stop(travel),
        FurnitureKind::GiveWay => FeatureKind::GiveWay(travel),
        FurnitureKind::StopLine => FeatureKind::StopLine(travel),
        FurnitureKind::Sidewalk => FeatureKind::Sidewalk,
    };
    let node = if shape.node == 0 { number("furniture", &format!("{} {index}", road.id.0)) } else { shape.node };
    Furniture { station: shape.station, node, kind }
}
