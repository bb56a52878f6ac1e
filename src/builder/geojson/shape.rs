//! The features of the file, as they are written and read. `docs/geometry.md` says what each property means.

use serde::de::{self, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize, Serialize};

use crate::builder::cross_section::{Arrows, StripKind, Travel};
use crate::builder::outline::Case;
use crate::builder::road_network::{End, RoadClass, RoadKey};
use crate::osm::{Tags, Text};

/// Longitude and latitude in degrees; metres until the file is written and after it is read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place(pub [f64; 2]);

/// A feature of one type.
#[derive(Debug, Serialize, Deserialize)]
pub struct Feature<P> {
    #[serde(rename = "type")]
    pub kind: FeatureTag,
    pub properties: P,
    pub geometry: Option<Geometry>,
}

impl<P> Feature<P> {
    pub fn new(properties: P, geometry: Option<Geometry>) -> Self {
        Self { kind: FeatureTag::Feature, properties, geometry }
    }
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub enum FeatureTag {
    Feature,
}

/// The geometries that a street can have.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "type", content = "coordinates")]
pub enum Geometry {
    LineString(Vec<Place>),
    Polygon(Vec<Vec<Place>>),
    MultiPolygon(Vec<Vec<Vec<Place>>>),
}

/// The type of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Type {
    Road,
    Lane,
    Intersection,
}

/// The id of a feature: text, or a number that is read as text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Id(pub Text);

/// A number, or a list of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Levels {
    One(f64),
    Several(Vec<f64>),
}

impl Levels {
    pub fn first(&self) -> Option<f64> {
        match self {
            Self::One(level) => Some(*level),
            Self::Several(levels) => levels.first().copied(),
        }
    }
}

fn yes() -> bool {
    true
}

#[derive(Debug, Serialize, Deserialize)]
pub struct RoadShape {
    #[serde(rename = "type")]
    pub kind: Type,
    pub id: Id,
    #[serde(default)]
    pub src: Option<Id>,
    #[serde(default)]
    pub dst: Option<Id>,
    #[serde(default)]
    pub osm_ids: Vec<i64>,
    #[serde(default = "yes")]
    pub drive: bool,
    #[serde(default)]
    pub layer: Option<Levels>,
    #[serde(default)]
    pub width: Option<f64>,
    #[serde(default)]
    pub length: Option<f64>,
    #[serde(default)]
    pub trim_start: Option<f64>,
    #[serde(default)]
    pub trim_end: Option<f64>,
    #[serde(default)]
    pub oblivion: bool,
    #[serde(default)]
    pub ends: Vec<EndShape>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<Text>,
    #[serde(default)]
    pub class: Option<RoadClass>,
    #[serde(default)]
    pub link: bool,
    #[serde(default)]
    pub roundabout: bool,
    #[serde(default = "yes")]
    pub public: bool,
    #[serde(default)]
    pub speed: Option<[f64; 2]>,
    #[serde(default)]
    pub key: Option<KeyShape>,
    #[serde(default)]
    pub centerline: Vec<Place>,
    #[serde(default)]
    pub kept: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub furniture: Vec<FurnitureShape>,
    #[serde(default, with = "tag_map", skip_serializing_if = "Tags::is_empty")]
    pub tags: Tags,
}

/// The cut across one end of a road.
#[derive(Debug, Serialize, Deserialize)]
pub struct EndShape {
    pub int: Option<Id>,
    pub pts: Vec<Place>,
}

/// What tells a road from every other, whatever else the input says.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct KeyShape {
    pub way: i64,
    pub first: i64,
    pub last: i64,
    #[serde(default)]
    pub turn: u32,
}

impl From<RoadKey> for KeyShape {
    fn from(RoadKey { way, first, last, turn }: RoadKey) -> Self {
        Self { way, first, last, turn }
    }
}

impl From<KeyShape> for RoadKey {
    fn from(KeyShape { way, first, last, turn }: KeyShape) -> Self {
        Self { way, first, last, turn }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FurnitureKind {
    Crossing,
    Signals,
    Stop,
    GiveWay,
}

/// A crossing, light or sign.
#[derive(Debug, Serialize, Deserialize)]
pub struct FurnitureShape {
    pub kind: FurnitureKind,
    pub station: f64,
    #[serde(default)]
    pub node: i64,
    /// Of lights and signs: whom they face.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel: Option<Travel>,
    /// Of crossings: lights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signals: Option<bool>,
    /// Of crossings: paint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marked: Option<bool>,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct LaneShape {
    #[serde(rename = "type")]
    pub kind: Type,
    #[serde(default)]
    pub id: Option<Id>,
    pub road: Id,
    #[serde(default)]
    pub index: Option<u32>,
    #[serde(default = "yes")]
    pub drive: bool,
    #[serde(default)]
    pub layer: Option<Levels>,
    #[serde(rename = "kind", default = "drive")]
    pub used: StripKind,
    #[serde(default)]
    pub travel: Option<Travel>,
    #[serde(default)]
    pub width: Option<f64>,
    #[serde(default)]
    pub width_guessed: bool,
    #[serde(default, with = "arrow_names", skip_serializing_if = "no_arrows")]
    pub arrows: Arrows,
    #[serde(default, skip_serializing_if = "is_silent")]
    pub change: [Option<bool>; 2],
}

/// A lane of a road that is no feature of its own.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StripShape {
    #[serde(rename = "kind", default = "drive")]
    pub used: StripKind,
    pub travel: Travel,
    pub width: f64,
    #[serde(default)]
    pub width_guessed: bool,
    #[serde(default, with = "arrow_names", skip_serializing_if = "no_arrows")]
    pub arrows: Arrows,
    #[serde(default, skip_serializing_if = "is_silent")]
    pub change: [Option<bool>; 2],
}

fn drive() -> StripKind {
    StripKind::Drive
}

fn no_arrows(arrows: &Arrows) -> bool {
    arrows.is_none()
}

fn is_silent(change: &[Option<bool>; 2]) -> bool {
    *change == [None, None]
}

#[derive(Debug, Serialize, Deserialize)]
pub struct IntersectionShape {
    #[serde(rename = "type")]
    pub kind: Type,
    pub id: Id,
    #[serde(default)]
    pub roads: Vec<Id>,
    #[serde(default = "yes")]
    pub drive: bool,
    #[serde(default)]
    pub layer: Option<Levels>,
    #[serde(default)]
    pub case: Option<Case>,
    #[serde(default)]
    pub terminal: bool,
    #[serde(default)]
    pub fallback: bool,
    #[serde(default)]
    pub merged_from: Vec<i64>,
    #[serde(default)]
    pub map_edge: Option<bool>,
    #[serde(default)]
    pub signals: bool,
    #[serde(default)]
    pub all_way_stop: bool,
    #[serde(default)]
    pub crossing: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub circle: Option<Text>,
    #[serde(default)]
    pub position: Option<Place>,
    #[serde(default)]
    pub arms: Vec<ArmShape>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passages: Option<Vec<[usize; 2]>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inner: Vec<InnerShape>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub restrictions: Vec<RestrictionShape>,
}

/// One end of a road.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmShape {
    pub road: Id,
    pub end: End,
}

/// A road that became part of a merged intersection.
#[derive(Debug, Serialize, Deserialize)]
pub struct InnerShape {
    pub key: KeyShape,
    pub osm_ids: Vec<i64>,
    pub centerline: Vec<Place>,
    pub lanes: Vec<StripShape>,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct RestrictionShape {
    #[serde(default)]
    pub relation: i64,
    pub from: ArmShape,
    #[serde(default)]
    pub via: Vec<Id>,
    pub to: ArmShape,
    pub only: bool,
}

/// Everything that holds places, so that all of a file can be moved to another plane at once.
pub trait Placed {
    /// Hands out every place.
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut Place));
}

impl<P: Placed> Placed for Feature<P> {
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut Place)) {
        self.properties.each_place(visit);
        match &mut self.geometry {
            None => {}
            Some(Geometry::LineString(line)) => line.iter_mut().for_each(visit),
            Some(Geometry::Polygon(rings)) => rings.iter_mut().flatten().for_each(visit),
            Some(Geometry::MultiPolygon(parts)) => parts.iter_mut().flatten().flatten().for_each(visit),
        }
    }
}

impl Placed for RoadShape {
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut Place)) {
        self.centerline.iter_mut().for_each(&mut *visit);
        self.ends.iter_mut().flat_map(|end| &mut end.pts).for_each(visit);
    }
}

impl Placed for LaneShape {
    fn each_place<'a>(&'a mut self, _: &mut dyn FnMut(&'a mut Place)) {}
}

impl Placed for IntersectionShape {
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut Place)) {
        self.position.iter_mut().for_each(&mut *visit);
        self.inner.iter_mut().flat_map(|inner| &mut inner.centerline).for_each(visit);
    }
}

impl<'de> Deserialize<'de> for Place {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Position;
        impl<'de> Visitor<'de> for Position {
            type Value = Place;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a position: [longitude, latitude]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Place, A::Error> {
                let mut number = |i| seq.next_element::<f64>()?.ok_or_else(|| de::Error::invalid_length(i, &self));
                let place = Place([number(0)?, number(1)?]);
                // A height, which streets do not have.
                while seq.next_element::<IgnoredAny>()?.is_some() {}
                Ok(place)
            }
        }
        deserializer.deserialize_seq(Position)
    }
}

impl<'de> Deserialize<'de> for Id {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TextOrNumber;
        impl Visitor<'_> for TextOrNumber {
            type Value = Id;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an id: text or a whole number")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Id, E> {
                Ok(Id(text.into()))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Id, E> {
                Ok(Id(number.to_string().into()))
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<Id, E> {
                Ok(Id(number.to_string().into()))
            }
        }
        deserializer.deserialize_any(TextOrNumber)
    }
}

/// Tags as an object, in their order.
mod tag_map {
    use super::*;

    pub fn serialize<S: Serializer>(tags: &Tags, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (key, value) in tags.iter().filter(|(key, value)| tags.is(key, value)) {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Tags, D::Error> {
        struct Pairs;
        impl<'de> Visitor<'de> for Pairs {
            type Value = Tags;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("tags: an object of texts")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Tags, A::Error> {
                let mut tags = Tags::new();
                while let Some((key, value)) = map.next_entry::<Text, Text>()? {
                    tags.push(key, value);
                }
                Ok(tags)
            }
        }
        deserializer.deserialize_map(Pairs)
    }
}

/// Arrows as a list of the words of `turn:lanes`.
mod arrow_names {
    use super::*;

    const NAMES: [(&str, Arrows); 10] = [
        ("left", Arrows::LEFT),
        ("slight_left", Arrows::SLIGHT_LEFT),
        ("sharp_left", Arrows::SHARP_LEFT),
        ("through", Arrows::THROUGH),
        ("right", Arrows::RIGHT),
        ("slight_right", Arrows::SLIGHT_RIGHT),
        ("sharp_right", Arrows::SHARP_RIGHT),
        ("reverse", Arrows::REVERSE),
        ("merge_to_left", Arrows::MERGE_TO_LEFT),
        ("merge_to_right", Arrows::MERGE_TO_RIGHT),
    ];

    pub fn serialize<S: Serializer>(arrows: &Arrows, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(NAMES.iter().filter(|(_, arrow)| arrows.has(*arrow)).map(|(name, _)| name))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arrows, D::Error> {
        let names = Vec::<Text>::deserialize(deserializer)?;
        let known = NAMES.map(|(name, _)| name);
        names.iter().try_fold(Arrows::NONE, |arrows, name| {
            let named = NAMES.iter().find(|(known, _)| known == name);
            Ok(arrows.and(
                named
                    .ok_or_else(|| {
                        de::Error::custom(format!("unknown arrow `{name}`, expected one of {}", known.join(", ")))
                    })?
                    .1,
            ))
        })
    }
}
