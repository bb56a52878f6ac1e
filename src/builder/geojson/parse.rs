//! Reads GeoJSON into features in metres. Each feature is read by itself, so that an error is shown at its place.

use rayon::prelude::*;
use serde::Deserialize;
use serde_json::value::RawValue;

use crate::builder::streets::snap_grid::snap;
use crate::geometry::Point;
use crate::osm::Text;
use crate::parallel::InSmallParts;
use crate::projection::{Extent, LonLat, Projector};

use super::ReadError;
use super::header::{FORMAT, Header, ProjectorShape};
use super::id::FeaturePlace;
use super::schema::{Feature, IntersectionShape, LaneShape, Placed, RoadShape};

/// A value of the file, with the byte at which its feature begins.
#[derive(Debug)]
pub struct Spanned<T> {
    pub offset: usize,
    pub value: T,
}

/// The features of a file. Positions are metres.
#[derive(Debug)]
pub struct Parsed {
    pub header: Option<Header>,
    pub projector: Projector,
    pub roads: Vec<Spanned<Feature<RoadShape>>>,
    pub lanes: Vec<Spanned<LaneShape>>,
    pub intersections: Vec<Spanned<Feature<IntersectionShape>>>,
    /// The number of features of other types.
    pub others: usize,
}

/// Reads a file. `projector` goes before the projector that the file names.
///
/// # Errors
///
/// The text is no GeoJSON, a feature does not follow the schema, or a position lies outside the projection.
pub fn parse(text: &str, projector: Option<Projector>) -> Result<Parsed, ReadError> {
    let Collection { lanewright, features, .. } = collection(text)?;
    let features = features.unwrap_or_default();
    let offset = |feature: &RawValue| feature.get().as_ptr().addr() - text.as_ptr().addr();
    let read: Vec<_> =
        features.par_iter().in_small_parts().map(|feature| read_feature(feature.get(), offset(feature))).collect();
    let mut parsed = Parsed {
        header: lanewright,
        projector: Projector::Local,
        roads: Vec::new(),
        lanes: Vec::new(),
        intersections: Vec::new(),
        others: 0,
    };
    for (feature, raw) in read.into_iter().zip(&features) {
        let offset = offset(raw);
        match feature? {
            AnyFeature::Road(value) => parsed.roads.push(Spanned { offset, value }),
            AnyFeature::Lane(value) => parsed.lanes.push(Spanned { offset, value }),
            AnyFeature::Intersection(value) => parsed.intersections.push(Spanned { offset, value }),
            AnyFeature::Other => parsed.others += 1,
        }
    }
    parsed.roads.retain(|road| road.value.properties.drive);
    if parsed.roads.is_empty() {
        let message = format!("none of the {} features is a road for motor traffic", features.len());
        let help = "roads are features with the property \"type\": \"road\"";
        return Err(ReadError::new(features.first().map_or(0, |feature| offset(feature)), message, help));
    }
    parsed.project(projector)
}

/// The members of the collection. The features are not read yet.
#[derive(Deserialize)]
struct Collection<'a> {
    #[serde(rename = "type", default)]
    kind: Option<Text>,
    lanewright: Option<Header>,
    units: Option<Text>,
    #[serde(borrow, default)]
    features: Option<Vec<&'a RawValue>>,
}

/// Reads the collection and checks that the features are in degrees and in a known format.
fn collection(text: &str) -> Result<Collection<'_>, ReadError> {
    let collection = serde_json::from_str::<Collection>(text).map_err(|error| match error.is_data() {
        true if text.trim_start().starts_with('[') => not_a_collection(),
        true => ReadError::json(text, 0, &error),
        false => {
            ReadError { help: "the file is damaged or cut off; export it again", ..ReadError::json(text, 0, &error) }
        }
    })?;
    if collection.kind.as_deref() != Some("FeatureCollection") || collection.features.is_none() {
        return Err(not_a_collection());
    }
    if collection.units.as_deref() == Some("m") {
        let message = "the file is in metres of no known place (\"units\": \"m\")".to_owned();
        return Err(ReadError::new(0, message, "give positions as longitude and latitude in degrees"));
    }
    if let Some(header) = collection.lanewright.as_ref().filter(|header| header.format > FORMAT) {
        let message = format!("the file has format {}; this version of lanewright reads {FORMAT}", header.format);
        return Err(ReadError::new(0, message, "use the version of lanewright that wrote it, or a later one"));
    }
    Ok(collection)
}

fn not_a_collection() -> ReadError {
    let message = "this JSON is no GeoJSON FeatureCollection with a list of features".to_owned();
    ReadError::new(0, message, "docs/geometry.md shows what `build` reads")
}

enum AnyFeature {
    Road(Feature<RoadShape>),
    Lane(LaneShape),
    Intersection(Feature<IntersectionShape>),
    Other,
}

/// Reads one feature, which begins at byte `offset` of the file.
fn read_feature(text: &str, offset: usize) -> Result<AnyFeature, ReadError> {
    #[derive(Deserialize)]
    struct Properties<P> {
        properties: Option<P>,
    }
    #[derive(Deserialize)]
    struct KindOnly {
        #[serde(rename = "type", default)]
        kind: Option<Text>,
    }
    let failed = |error: serde_json::Error| ReadError::json(text, offset, &error);
    let kind = serde_json::from_str::<Properties<KindOnly>>(text).map_err(failed)?.properties.and_then(|p| p.kind);
    let mut feature = match kind.as_deref() {
        Some("road") => AnyFeature::Road(serde_json::from_str(text).map_err(failed)?),
        // The geometry of a lane is not read: it follows from the road and the width.
        Some("lane") => {
            let lane: Properties<LaneShape> = serde_json::from_str(text).map_err(failed)?;
            lane.properties.map_or(AnyFeature::Other, AnyFeature::Lane)
        }
        Some("intersection") => AnyFeature::Intersection(serde_json::from_str(text).map_err(failed)?),
        _ => AnyFeature::Other,
    };
    let mut outside = None;
    feature.each_place(&mut |place| {
        let [lon, lat] = place.0;
        if !((-180.0..=180.0).contains(&lon) && (-90.0..=90.0).contains(&lat)) {
            outside = outside.or(Some([lon, lat]));
        }
    });
    let Some([lon, lat]) = outside else { return Ok(feature) };
    let message = format!("the position [{lon}, {lat}] of this feature is not on Earth");
    let help =
        "positions are [longitude, latitude] in degrees; metres of a projection must be turned into degrees first";
    Err(ReadError::new(offset, message, help))
}

impl AnyFeature {
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut FeaturePlace)) {
        match self {
            Self::Road(road) => road.each_place(visit),
            Self::Intersection(intersection) => intersection.each_place(visit),
            Self::Lane(_) | Self::Other => {}
        }
    }
}

impl Parsed {
    /// Turns degrees into metres by the user's projector, else by that of the file, else by one that suits the place.
    fn project(mut self, projector: Option<Projector>) -> Result<Self, ReadError> {
        let in_file = self.header.as_ref().and_then(|header| header.projector.as_ref());
        let in_file = in_file.map(ProjectorShape::projector).transpose().map_err(|message| {
            ReadError::new(0, message, "leave `projector` out to let lanewright choose, or use --projector")
        })?;
        let mut places: Vec<&mut FeaturePlace> = Vec::new();
        self.roads.iter_mut().for_each(|road| road.value.each_place(&mut |p| places.push(p)));
        self.intersections.iter_mut().for_each(|i| i.value.each_place(&mut |p| places.push(p)));
        let degrees: Vec<LonLat> =
            places.iter().map(|FeaturePlace([lon, lat])| LonLat { lon: *lon, lat: *lat }).collect();
        let chosen = || Extent::of(degrees.iter().copied()).map(|extent| Projector::for_extent(&extent));
        let projector = projector.or(in_file).or_else(chosen).unwrap_or(Projector::Local);
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
