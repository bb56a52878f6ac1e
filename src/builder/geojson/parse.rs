//! GeoJSON to features in metres: each is read by itself, so that a fault is shown where it stands.

use rayon::prelude::*;
use serde::Deserialize;

use crate::builder::streets::snap_grid::snap;
use crate::geometry::Point;
use crate::osm::Text;
use crate::parallel::Finely;
use crate::projection::{Extent, LonLat, Projector};

use super::ReadError;
use super::header::{FORMAT, Header};
use super::id::FeaturePlace;
use super::schema::{Feature, IntersectionShape, LaneShape, Placed, RoadShape};
use super::split_features::{FeatureSpans, scan};

/// Something of the file, with the byte where it begins.
#[derive(Debug)]
pub struct Spanned<T> {
    pub offset: usize,
    pub it: T,
}

/// What the file says, in metres.
#[derive(Debug)]
pub struct Parsed {
    pub head: Option<Header>,
    pub projector: Projector,
    pub roads: Vec<Spanned<Feature<RoadShape>>>,
    pub lanes: Vec<Spanned<LaneShape>>,
    pub intersections: Vec<Spanned<Feature<IntersectionShape>>>,
    /// Features of other types.
    pub others: usize,
}

/// Reads a file; `wanted` is the plane to put it in, whatever the file says of its own.
pub fn parse(text: &str, wanted: Option<Projector>) -> Result<Parsed, ReadError> {
    let layout = scan(text).ok_or_else(|| no_collection(text))?;
    let head = head(text, &layout)?;
    let read = |range: &std::ops::Range<usize>| one(&text[range.clone()], range.start);
    let features: Vec<Result<Any, ReadError>> = layout.features.par_iter().finely().map(read).collect();
    let mut parsed = Parsed {
        head,
        projector: Projector::Local,
        roads: Vec::new(),
        lanes: Vec::new(),
        intersections: Vec::new(),
        others: 0,
    };
    for (feature, offset) in features.into_iter().zip(layout.features.iter().map(|range| range.start)) {
        match feature? {
            Any::Road(it) => parsed.roads.push(Spanned { offset, it }),
            Any::Lane(it) => parsed.lanes.push(Spanned { offset, it }),
            Any::Intersection(it) => parsed.intersections.push(Spanned { offset, it }),
            Any::Other => parsed.others += 1,
        }
    }
    parsed.roads.retain(|road| road.it.properties.drive);
    if parsed.roads.is_empty() {
        let message = format!("none of the {} features is a road for motor traffic", layout.features.len());
        return Err(ReadError::new(
            layout.list.start,
            message,
            "roads are features with the property \"type\": \"road\"",
        ));
    }
    parsed.into_plane(wanted)
}

enum Any {
    Road(Feature<RoadShape>),
    Lane(LaneShape),
    Intersection(Feature<IntersectionShape>),
    Other,
}

/// Reads one feature that begins at a byte of the file.
fn one(text: &str, offset: usize) -> Result<Any, ReadError> {
    #[derive(Deserialize)]
    struct Only<P> {
        properties: Option<P>,
    }
    #[derive(Deserialize)]
    struct Type {
        #[serde(rename = "type", default)]
        kind: Option<Text>,
    }
    let failed = |error: serde_json::Error| ReadError::json(text, offset, &error);
    let kind = serde_json::from_str::<Only<Type>>(text).map_err(failed)?.properties.and_then(|p| p.kind);
    let mut any = match kind.as_deref() {
        Some("road") => Any::Road(serde_json::from_str(text).map_err(failed)?),
        // The shape of a lane follows from its road and its width.
        Some("lane") => {
            let lane: Only<LaneShape> = serde_json::from_str(text).map_err(failed)?;
            lane.properties.map_or(Any::Other, Any::Lane)
        }
        Some("intersection") => Any::Intersection(serde_json::from_str(text).map_err(failed)?),
        _ => Any::Other,
    };
    let mut wrong = None;
    let mut visit = |place: &mut FeaturePlace| {
        let [lon, lat] = place.0;
        if !((-180.0..=180.0).contains(&lon) && (-90.0..=90.0).contains(&lat)) {
            wrong = wrong.or(Some([lon, lat]));
        }
    };
    any.each_place(&mut visit);
    match wrong {
        None => Ok(any),
        Some([lon, lat]) => Err(ReadError::new(
            offset,
            format!("the position [{lon}, {lat}] of this feature is not on Earth"),
            "positions are [longitude, latitude] in degrees; metres of a projection must be turned into degrees first",
        )),
    }
}

impl Any {
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut FeaturePlace)) {
        match self {
            Self::Road(road) => road.each_place(visit),
            Self::Intersection(intersection) => intersection.each_place(visit),
            Self::Lane(_) | Self::Other => {}
        }
    }
}

/// What the collection says beside its features.
fn head(text: &str, layout: &FeatureSpans) -> Result<Option<Header>, ReadError> {
    #[derive(Deserialize)]
    struct Collection {
        #[serde(rename = "type")]
        kind: Text,
        #[serde(default)]
        lanewright: Option<Header>,
        #[serde(default)]
        units: Option<Text>,
    }
    let (before, behind) = (&text[..layout.list.start], &text[layout.list.end..]);
    let rest = format!("{before}{behind}");
    let collection: Collection = serde_json::from_str(&rest).map_err(|error| {
        let mut error = ReadError::json(&rest, 0, &error);
        if error.offset >= before.len() {
            error.offset += layout.list.len();
        }
        error
    })?;
    if collection.kind != "FeatureCollection" {
        return Err(no_collection(text));
    }
    if collection.units.is_some_and(|units| units == "m") {
        let message = "the file is in metres of no known place (\"units\": \"m\")".to_owned();
        return Err(ReadError::new(0, message, "give positions as longitude and latitude in degrees"));
    }
    match &collection.lanewright {
        Some(head) if head.format > FORMAT => Err(ReadError::new(
            0,
            format!("the file has format {}; this version of lanewright reads {FORMAT}", head.format),
            "use the version of lanewright that wrote it, or a later one",
        )),
        _ => Ok(collection.lanewright),
    }
}

/// Why a text is no feature collection.
fn no_collection(text: &str) -> ReadError {
    let help = "the file is damaged or cut off; export it again";
    match serde_json::from_str::<serde::de::IgnoredAny>(text) {
        Err(error) => ReadError { help, ..ReadError::json(text, 0, &error) },
        Ok(_) => ReadError::new(
            0,
            "this JSON is no GeoJSON FeatureCollection with a list of features".to_owned(),
            "docs/geometry.md shows what `build` reads",
        ),
    }
}

impl Parsed {
    /// Turns degrees into metres: those of the user's plane, the file's, or one that suits the place.
    fn into_plane(mut self, wanted: Option<Projector>) -> Result<Self, ReadError> {
        let own = self.head.as_ref().and_then(|head| head.projector.as_ref());
        let own = own.map(super::header::ProjectorShape::projector).transpose().map_err(|message| {
            ReadError::new(0, message, "leave `projector` out to let lanewright choose, or use --projector")
        })?;
        let mut places: Vec<&mut FeaturePlace> = Vec::new();
        self.roads.iter_mut().for_each(|road| road.it.each_place(&mut |p| places.push(p)));
        self.intersections.iter_mut().for_each(|i| i.it.each_place(&mut |p| places.push(p)));
        let degrees: Vec<LonLat> =
            places.iter().map(|FeaturePlace([lon, lat])| LonLat { lon: *lon, lat: *lat }).collect();
        let chosen = || Extent::of(degrees.iter().copied()).map(|extent| Projector::for_extent(&extent));
        let projector = wanted.or(own).or_else(chosen).unwrap_or(Projector::Local);
        for (place, metres) in places.into_iter().zip(projector.forward_each(&degrees, |_| 0.0)) {
            let metres: Point = snap(metres.ok_or_else(|| {
                let message = format!("the projection {} does not reach all places of the file", projector.name());
                ReadError::new(0, message, "choose another with --projector")
            })?);
            *place = FeaturePlace([metres.x, metres.y]);
        }
        self.projector = projector;
        Ok(self)
    }
}
